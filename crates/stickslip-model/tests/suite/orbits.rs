//! Periodic orbits of systems from files, and branches of them.

use std::f64::consts::{PI, TAU};

use stickslip::analysis::{
    Branch, ContinuationSettings, CycleBifurcation, PeriodicOrbit, SequenceBifurcation,
    SpecialPoint, Stop, continue_periodic_orbit, multipliers,
};
use stickslip::math;
use stickslip::{Method, Options};
use stickslip_model::file::System;
use stickslip_model::study::{ParameterLine, PeriodicSearch};

use crate::run::{SEARCH, options, orbit_from, system, with};

/// The orbit that the run from the start of the file approaches after a transient.
fn orbit(system: &System, transient: f64, options: &Options) -> PeriodicOrbit {
    let search = PeriodicSearch {
        transient: Some(transient),
        ..SEARCH
    };
    orbit_from(system, 0.0, &search, options)
}

/// The branch through an orbit, in one direction.
fn branch(
    system: &System,
    (name, low, high): (&str, f64, f64),
    (orbit, upwards): (&PeriodicOrbit, bool),
    options: &Options,
) -> Branch {
    let along = ParameterLine::new(system, name, (low, high)).unwrap();
    let settings = ContinuationSettings::over(low, high);
    let (settings, x) = along.start(orbit, &settings, options, None).unwrap();
    let period = orbit.period;
    continue_periodic_orbit(&along.dynamics, x, period, upwards, &settings, options).unwrap()
}

/// The only special orbit of a branch.
fn only(branch: &Branch) -> &SpecialPoint {
    let [at] = branch.special.as_slice() else {
        panic!("{:?}", branch.special)
    };
    at
}

/// One state with a drive of a period.
fn driven(rate: &str, period: f64) -> System {
    system(&format!(
        "name = \"drive\"\n[time]\nend = 1\nperiod = {period:e}\n[states]\nx = \"\"\n\
         [parameters]\nb = 1\n[inputs.ramp]\nshape = \"sawtooth\"\nperiod = {period:e}\n\
         [field]\nx = \"{rate}\"\n[start]\nx = 0\n"
    ))
}

#[test]
fn a_forced_orbit_has_the_period_of_its_drive_and_is_isolated_in_any_unit_of_time() {
    for period in [1e-9, 1e-7, 4e-6, 1.0, 1e6] {
        for decay in [1e-4, 4e-3, 1.0] {
            let strength = f64::min(100.0, 1.0 / period);
            let rate = format!("-{:e}*x + {strength:e}*(ramp - 0.5)", decay / period);
            let system = driven(&rate, period);
            for tol in [1e-5, 1e-7, 1e-10, 1e-12] {
                for method in [Method::Taylor, Method::Dop853] {
                    let options = Options::tol(tol).method(method);
                    let found = orbit(&system, 0.0, &options);
                    let what = format!("{period:e}, {decay}, {options:?}");
                    assert_eq!((found.period, found.family), (period, 0), "{what}");
                    let value = multipliers(&found.monodromy)[0].re;
                    let of = found.multiplier_uncertainties(system.dynamics(), true, &options);
                    let off = (value - math::exp(-decay)).abs();
                    assert!(off <= of[0], "{what}: {off:e} beyond {:e}", of[0]);
                }
            }
        }
    }
}

#[test]
fn an_integral_of_a_drive_is_a_family_in_any_unit_of_time() {
    for period in [1e-9, 4e-6, 1.0, 1e6] {
        let system = driven("100*(ramp - 0.5)", period);
        for tol in [1e-5, 1e-10] {
            let found = orbit(&system, 0.0, &Options::tol(tol));
            assert_eq!(
                (found.period, found.family),
                (period, 1),
                "{period:e}, {tol:e}"
            );
        }
    }
}

#[test]
fn every_orbit_of_a_forced_branch_has_the_period_of_the_drive() {
    let system = driven("-1000*b*x + 100*ramp", 4e-6);
    let options = Options::tol(1e-5).method(Method::Taylor);
    let first = orbit(&system, 0.1, &options);
    let branch = branch(&system, ("b", 0.5, 2.0), (&first, true), &options);
    assert_eq!(branch.stop, Stop::Range);
    assert!(branch.points.iter().all(|at| at.period == 4e-6));
    // Each multiplier differs by less than its uncertainty from that of the decay in a period.
    assert!(branch.points.len() > 3);
    for at in &branch.points {
        let b = at.parameter;
        let here = system.with_values(&[("b", b)]).unwrap();
        let of = at.multiplier_uncertainties(here.dynamics(), true, &options);
        let off = (at.multipliers[0].re - math::exp(-1000.0 * b * 4e-6)).abs();
        assert_eq!(of.len(), at.multipliers.len());
        assert!(
            off <= of[0] && of[0] < 1e-4,
            "{b}: {off:e} beyond {:e}",
            of[0]
        );
    }
}

/// The buck converter of Fossas & Olivar (1996), with its times in a unit.
fn buck(unit: f64) -> System {
    let [capacity, inductance, period] = [47e-6, 20e-3, 400e-6].map(|time| time * unit);
    system(&format!(
        "name = \"buck\"\n[time]\nend = 1\nperiod = \"T\"\n[states]\nv = \"\"\ni = \"\"\n\
         [parameters]\nE = 20\nR = 22\nC = {capacity:e}\nL = {inductance:e}\nT = {period:e}\n\
         [discrete]\non = 0\n[inputs.ramp]\nshape = \"sawtooth\"\nperiod = \"T\"\n\
         [definitions]\ncon = \"8.4*(v - 11.3) - (3.8 + 4.4*ramp)\"\n\
         [jumps.open]\nwhen = \"con\"\ndirection = \"rising\"\nset = {{ on = \"0\" }}\n\
         [jumps.close]\nwhen = \"con\"\ndirection = \"falling\"\nset = {{ on = \"1\" }}\n\
         [field]\nv = \"(i - v/R)/C\"\ni = \"(E*on - v)/L\"\n[start]\nv = 12\ni = 0.55\n"
    ))
}

#[test]
fn a_buck_converter_flips_at_the_same_voltage_in_any_unit_of_time() {
    for (unit, tol) in [(1.0, 1e-7), (1e-3, 1e-9), (1e-3, 1e-10), (1.0, 1e-12)] {
        let (system, options) = (buck(unit), Options::tol(tol).method(Method::Taylor));
        let first = orbit(&system, 0.1 * unit, &options);
        let branch = branch(&system, ("E", 15.0, 26.0), (&first, true), &options);
        let at = only(&branch);
        assert_eq!(at.what, CycleBifurcation::Flip, "{unit:e}, {tol:e}");
        let off = (at.parameter - 24.516572828563).abs();
        assert!(
            off <= at.uncertainty + 1e-12,
            "{unit:e}, {tol:e}: {off:e}, {at:?}"
        );
        assert!(branch.points.iter().all(|one| one.period == first.period));
    }
}

/// A slip above `x = 0` or a stick on it, which the end of a pulse begins or its start releases.
const RELEASED: &str = "
name = \"released\"
[time]
end = 10
period = 1
[states]
x = \"\"
v = \"\"
[parameters]
R = 20
[inputs.u]
shape = \"pulse\"
period = 1
width = 0.3
[contacts.c]
boundary = \"x\"
[field]
x = \"by_side(c, 1, 1 - (1 - u)*v)\"
v = \"x - v/R\"
[start]
x = 0
v = 2
";

#[test]
fn a_stick_that_the_kink_of_an_input_releases_lasts_along_a_branch() {
    let system = system(RELEASED);
    for method in [Method::Taylor, Method::Dop853] {
        let options = Options::tol(1e-10).method(method);
        let first = orbit(&system, 50.0, &options);
        for upwards in [true, false] {
            let branch = branch(&system, ("R", 15.0, 25.0), (&first, upwards), &options);
            assert_eq!(branch.special, []);
            assert_eq!(branch.stop, Stop::Range);
            let sequences = branch.points.iter().map(|at| system.sequence(&at.sequence));
            assert!(
                sequences.clone().all(|one| one == "+ S"),
                "{:?}",
                sequences.collect::<Vec<_>>()
            );
        }
    }
}

/// [`RELEASED`], released where `a - t` falls to 1 or, before that, by the pulse at t = 1.
const RELEASED_EARLIER: &str = "
name = \"released earlier\"
[time]
end = 10
period = 1
[states]
x = \"\"
[parameters]
a = 2.5
[inputs.u]
shape = \"pulse\"
period = 1
width = 0.1
[inputs.ramp]
shape = \"sawtooth\"
period = 1
[contacts.c]
boundary = \"x\"
[field]
x = \"by_side(c, 1, 1 - (1 - u)*(a - ramp))\"
[start]
x = 0
";

#[test]
fn a_release_that_comes_before_the_kink_is_a_coincidence() {
    let system = system(RELEASED_EARLIER);
    for method in [Method::Taylor, Method::Dop853] {
        let options = Options::tol(1e-10).method(method);
        let first = orbit(&system, 50.0, &options);
        let branch = branch(&system, ("a", 1.8, 3.0), (&first, false), &options);
        let at = only(&branch);
        let CycleBifurcation::Sequence(change) = &at.what else {
            panic!("{at:?}")
        };
        assert_eq!(change.bifurcation, SequenceBifurcation::Coincidence);
        assert_eq!(system.contact_names(&change.contacts), "c and u");
        let off = (at.parameter - 2.0).abs();
        assert!(off <= at.uncertainty, "{off:e} beyond {:e}", at.uncertainty);
        assert_eq!(branch.stop, Stop::Range);
    }
}

/// A bilinear oscillator (Shaw & Holmes 1983).
const BILINEAR: &str = "
name = \"bilinear\"
[time]
end = 100
period = \"2*pi/w\"
[states]
x = \"\"
v = \"\"
[parameters]
w = 5.3
[contacts.s]
boundary = \"x\"
[field]
x = \"v\"
v = \"-0.1*v - by_side(s, x, 10*x) + cos(w*t)\"
[start]
x = 0
v = 0
";

#[test]
fn a_place_on_a_branch_lies_within_its_uncertainty_at_any_tolerance() {
    let system = system(BILINEAR);
    let tolerances = [1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12];
    let by_tolerance = tolerances.into_iter().flat_map(|tol| {
        let methods = [Method::Taylor, Method::Dop853];
        methods.map(|method| (Options::tol(tol).method(method), 1e3 * tol))
    });
    let fixed = (Options::tol(1e-9).method(Method::Rk4 { step: 0.05 }), 1e-3);
    for (options, bound) in by_tolerance.chain([fixed]) {
        let first = orbit(&system, 200.0, &options);
        let branch = branch(&system, ("w", 4.85, 5.3), (&first, false), &options);
        let at = only(&branch);
        assert_eq!(at.what, CycleBifurcation::Flip);
        let off = (at.parameter - 4.904122535857564).abs();
        let (method, tol, within) = (options.method, options.rtol, at.uncertainty);
        let what = format!("{method:?}, {tol:e}: {off:e}, stated {within:e}");
        println!("{what}");
        assert!(off <= within, "{what}");
        // It says something, too.
        assert!(within <= bound, "{what}");
    }
}

#[test]
fn a_sampled_loop_at_rest_is_no_family() {
    let system = system(
        "name = \"sampled\"\n[time]\nend = 20\nperiod = 0.1\n[states]\nx = \"\"\nv = \"\"\n\
         [discrete]\nu = -1\n[inputs.clock]\nshape = \"sawtooth\"\nperiod = 0.1\nphase = 0.5\n\
         [jumps.tick]\nwhen = \"clock - 0.5\"\ndirection = \"rising\"\n\
         set = { u = \"-(x + 1.5*v)\" }\n[field]\nx = \"v\"\nv = \"u\"\n[start]\nx = 1\nv = 0\n",
    );
    for transient in [5.0, 20.0, 100.0, 200.0] {
        let options = Options::tol(1e-10).method(Method::Taylor);
        let found = orbit(&system, transient, &options);
        assert_eq!((found.period, found.family), (0.1, 0), "{transient}");
    }
}

/// Without damping every swing has its own period. That of an amplitude follows from the
/// arithmetic-geometric mean.
#[test]
fn a_swing_of_a_pendulum_is_one_of_a_family_with_the_period_of_its_amplitude() {
    let system = system(include_str!("../data/pendulum.toml"));
    let found = crate::run::orbit(&system, &crate::run::options("taylor"));
    assert_eq!(found.family, 1);
    let (mut a, mut b) = (1.0, math::cos(0.5 * 2.0));
    while f64::abs(a - b) > 1e-15 {
        (a, b) = (0.5 * (a + b), f64::sqrt(a * b));
    }
    // The nearest orbit to the end of the run.
    let off = found.period - std::f64::consts::TAU / a;
    assert!(off.abs() < 1e-8, "{off:e}");
}

/// A ball that bounces from a table with a restitution of 1/2.
const BALL: &str = r#"
name = "ball"
[time]
period = "2*pi"
[states]
x = ""
v = ""
[parameters]
A = 1.5
[jumps.hit]
when = "x - A*sin(t)"
direction = "falling"
set = { v = "1.5*A*cos(t) - 0.5*v" }
[field]
x = "v"
v = "-1"
[start]
x = 1.2
v = 3.1
"#;

/// The ball bounces once a period up to `A^2 = (pi (1-r)/(1+r))^2 + (2 (1+r^2)/(1+r)^2)^2`, where
/// the period doubles. Shortly before, the run alternates about that orbit.
#[test]
fn an_orbit_shortly_before_a_flip_has_not_twice_the_period() {
    let [balanced, at_impact] = [PI / 3.0, 10.0 / 9.0];
    let flip = (balanced * balanced + at_impact * at_impact).sqrt();
    for (relative, periods) in [(1.0 - 1e-5, 1.0), (1.0 + 2e-5, 2.0)] {
        let ball = with(BALL, &[("A", flip * relative)]);
        let found = orbit(&ball, 200.0, &options("taylor")).period / TAU;
        assert!((found - periods).abs() < 1e-12, "{found} at {relative}");
    }
}
