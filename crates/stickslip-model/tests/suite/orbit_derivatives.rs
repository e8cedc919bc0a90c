//! Derivatives of periodic orbits, against closed forms and differences of orbits.

use stickslip::analysis::{PeriodicOrbit, multipliers};
use stickslip::dynamics::Moment;
use stickslip::math::{exp, ln};
use stickslip::nalgebra::Complex;
use stickslip::scalar::Dual;
use stickslip::{Error, Mode, Options, Scalar, Side};
use stickslip_model::file::System;
use stickslip_model::study::{
    DerivativeError, NoMultiplierDerivatives, OrbitSlopes, OrbitVariables, PeriodicSearch, extremes,
};

use super::recorded::{methods, open};
use super::run::{METHODS, SEARCH, options, orbit, orbit_from, system};

fn slopes(
    system: &System,
    names: &[&str],
    orbit: &PeriodicOrbit,
    options: &Options,
) -> OrbitSlopes {
    let variables = OrbitVariables::named(system, names.iter().copied()).unwrap();
    let found = variables.of_orbit(system, (orbit, system.built.t_start), options);
    found.unwrap_or_else(|error| panic!("{error}"))
}

/// Values and derivatives of functions of parameters, on dual numbers.
fn closed<const P: usize, const V: usize>(
    values: [f64; P],
    of: impl Fn([Dual<f64>; P]) -> [Dual<f64>; V],
) -> [[f64; V]; P] {
    std::array::from_fn(|k| {
        let seeded = std::array::from_fn(|i| Dual::new(values[i], f64::from(u8::from(i == k))));
        of(seeded).map(|value| value.eps)
    })
}

fn close(own: f64, wanted: f64, within: f64, what: &str) {
    let off = (own - wanted).abs();
    assert!(
        off <= within * wanted.abs().max(1.0),
        "{what}: {own} and {wanted}"
    );
}

#[test]
fn a_forced_linear_oscillator_has_the_derivatives_of_its_closed_form() {
    let system = system(
        "name = \"case\"\n[time]\nperiod = \"2*pi/O\"\n[states]\nx = \"\"\nv = \"\"\n\
         [parameters]\nk = 2\nc = 0.3\na = 0.7\nO = 1.2\n[field]\nx = \"v\"\n\
         v = \"-k*x - c*v + a*cos(O*t)\"\n[start]\nx = 0\nv = 0\n",
    );
    let wanted = closed([2.0, 0.3, 0.7, 1.2], |[k, c, a, o]| {
        let off = k - o * o;
        let square = off * off + c * c * o * o;
        let amplitude = a / square.sqrt();
        let period = Dual::constant(2.0 * std::f64::consts::PI) / o;
        let decay = (-(c * period) * 0.5).exp();
        let angle = (k - c * c * 0.25).sqrt() * period;
        let (x, v) = (a * off / square, a * c * o * o / square);
        let (re, im) = (decay * angle.cos(), decay * angle.sin());
        [period, x, v, amplitude, amplitude * o, re, im]
    });
    for method in METHODS {
        let options = options(method);
        let orbit = orbit(&system, &options);
        let found = slopes(&system, &["k", "c", "a", "O"], &orbit, &options);
        for (k, [period, x, v, of_x, of_v, re, im]) in wanted.into_iter().enumerate() {
            let what = format!("{method}, {}", found.names[k]);
            let of = &found.orbit;
            close(of.period[k], period, 1e-12, &what);
            close(of.x[(0, k)], x, 1e-9, &what);
            close(of.x[(1, k)], v, 1e-9, &what);
            for (state, wanted) in [of_x, of_v].into_iter().enumerate() {
                close(of.extremes[state][1].by[k], wanted, 1e-9, &what);
                close(of.extremes[state][0].by[k], -wanted, 1e-9, &what);
            }
            assert_eq!(found.missing[k], None);
            // The pair is complex: either comes first.
            let first = found.multipliers[k][0];
            close(first.re, re, 1e-6, &what);
            close(first.im.abs(), im.abs(), 1e-6, &what);
        }
    }
}

/// A block on a belt with constant friction, and more of it at rest.
const BELT: &str = r#"
name = "case"
[states]
x = ""
v = ""
[parameters]
at_rest = 0.9
sliding = 0.5
speed = 0.3
[contacts.belt]
boundary = "v - speed"
friction = "sliding"
static = "at_rest"
[field]
x = "v"
v = "-x - friction(belt)"
[start]
x = 0.1
v = 0
"#;

#[test]
fn a_belt_has_the_derivatives_of_its_period_and_amplitude() {
    // With A = at_rest - sliding it sticks for 2 A/V, and slips for 2 (π - atan(A/V)).
    let system = system(BELT);
    let wanted = closed([0.9, 0.5, 0.3], |[at_rest, sliding, speed]| {
        let way = at_rest - sliding;
        let slips = (Dual::constant(std::f64::consts::PI) - (way / speed).atan()) * 2.0;
        let radius = (way * way + speed * speed).sqrt();
        let period = way * 2.0 / speed + slips;
        [period, sliding - radius, sliding + radius, -radius, speed]
    });
    for method in METHODS {
        let options = options(method);
        let orbit = orbit(&system, &options);
        let found = slopes(&system, &["at_rest", "sliding", "speed"], &orbit, &options);
        let (t, x) = (orbit.t, orbit.x.clone());
        let at = Moment { t, x };
        let flow = system.dynamics().flow(Mode::Slip(Side::Below).into(), &at);
        for (k, [period, least, most, slowest, fastest]) in wanted.into_iter().enumerate() {
            let what = format!("{method}, {}", found.names[k]);
            let of = &found.orbit;
            close(of.period[k], period, 1e-9, &what);
            close(of.extremes[0][0].by[k], least, 1e-9, &what);
            close(of.extremes[0][1].by[k], most, 1e-9, &what);
            close(of.extremes[1][0].by[k], slowest, 1e-9, &what);
            close(of.extremes[1][1].by[k], fastest, 1e-9, &what);
            // The state moves across the flow, in which it slips below the belt's speed.
            let velocity = flow.velocity(&at);
            assert!(of.x.column(k).dot(&velocity).abs() < 1e-12);
            // One is trivial, and a stick leaves no other.
            assert_eq!(found.missing[k], None);
            for multiplier in &found.multipliers[k] {
                assert!(multiplier.norm() < 1e-6, "{what}: {multiplier}");
            }
        }
    }
}

#[test]
fn an_extreme_at_the_kink_of_an_input_moves_with_it() {
    // x′ = -k x ± 1 in halves of a period: the extremes are ±tanh(k T/4)/k, at the kinks.
    let system = system(
        "name = \"case\"\n[time]\nperiod = \"T\"\n[states]\nx = \"\"\n[parameters]\nk = 0.8\n\
         T = 3.1\n[inputs.force]\nshape = \"square\"\nperiod = \"T\"\n[field]\n\
         x = \"-k*x + force\"\n[start]\nx = 0\n",
    );
    let wanted = closed([0.8, 3.1], |[k, period]| {
        let twice = (k * period * 0.5).exp();
        let one = Dual::constant(1.0);
        [(twice - one) / (twice + one) / k, (-(k * period)).exp()]
    });
    for method in METHODS {
        let options = options(method);
        let orbit = orbit(&system, &options);
        let found = slopes(&system, &["k", "T"], &orbit, &options);
        for (k, [most, multiplier]) in wanted.into_iter().enumerate() {
            let what = format!("{method}, {}", found.names[k]);
            let of = &found.orbit;
            close(of.x[(0, k)], -most, 1e-9, &what);
            close(of.extremes[0][1].by[k], most, 1e-9, &what);
            close(of.extremes[0][0].by[k], -most, 1e-9, &what);
            close(found.multipliers[k][0].re, multiplier, 1e-6, &what);
        }
        assert_eq!(found.orbit.period, [0.0, 1.0]);
    }
}

/// A pulse of the width w from the phase on: the largest value is `(1 - e^(-wT))/(1 - e^(-T))`,
/// where the pulse ends. The phase only shifts the time.
#[test]
fn an_extreme_at_a_kink_behind_the_start_moves_with_it() {
    let period = 1.1;
    for method in METHODS {
        for phase in (0..30).map(|k| 0.01 * f64::from(k)) {
            let system = system(&format!(
                "name = \"case\"\n[time]\nperiod = {period}\n[states]\nx = \"\"\n[parameters]\n\
                 w = 0.3\nph = {phase}\n[inputs.p]\nshape = \"pulse\"\nperiod = {period}\n\
                 width = \"w\"\nphase = \"ph\"\n[field]\nx = \"-x + p\"\n[start]\nx = 0.1\n"
            ));
            let options = options(method);
            let orbit = orbit(&system, &options);
            let found = slopes(&system, &["w", "ph"], &orbit, &options);
            let largest = &found.orbit.extremes[0][1];
            let slope = period * exp(-0.3 * period) / (1.0 - exp(-period));
            let what = format!("{method}, {phase}");
            close(largest.by[0], slope, 1e-9, &what);
            close(largest.by[1], 0.0, 1e-9, &what);
        }
    }
}

/// Period, state and extremes of the orbit with one parameter changed.
fn changed(
    system: &System,
    (name, by): (&str, f64),
    orbit: &PeriodicOrbit,
    options: &Options,
) -> Vec<f64> {
    let number = system.file.parameter(name).unwrap();
    let value = system.values[number] + by;
    let other = system.with_values(&[(name, value)]).unwrap();
    let dynamics = other.dynamics();
    let x = orbit.x.clone();
    let found = match (other.built.depends_on_time, other.built.period) {
        (true, Some(drive)) => {
            let periods = (orbit.period / system.built.period.unwrap()).round();
            PeriodicOrbit::near_forced(dynamics, system.built.t_start, x, periods * drive, options)
        }
        _ => PeriodicOrbit::near(dynamics, x, orbit.period, options),
    };
    let found = found.unwrap();
    let (start, t_end) = ((found.t, found.x.as_slice()), found.t + found.period);
    let (ranges, _) = extremes(dynamics, start, t_end, options).unwrap();
    let mut all = vec![found.period];
    all.extend(&found.x);
    all.extend(ranges.into_iter().flat_map(|(low, high)| [low, high]));
    all
}

/// Compares with differences of fourth order.
fn compare(system: &System, names: &[&str], orbit: &PeriodicOrbit, options: &Options) {
    // Chosen: the rounding of a difference is about 1e-9 for well-behaved orbits.
    const STEP: f64 = 1e-4;
    const CLOSE: f64 = 1e-6;
    let found = slopes(system, names, orbit, options);
    for (k, name) in names.iter().enumerate() {
        let at = |by: f64| changed(system, (name, by * STEP), orbit, options);
        let runs = [2.0, 1.0, -1.0, -2.0].map(at);
        let mut own = vec![found.orbit.period[k]];
        own.extend(&found.orbit.x.column(k));
        own.extend(found.orbit.extremes.iter().flatten().map(|one| one.by[k]));
        for (place, own) in own.into_iter().enumerate() {
            let [one, two, three, four] = runs.each_ref().map(|run| run[place]);
            let difference = (8.0 * (two - three) - (one - four)) / (12.0 * STEP);
            close(
                own,
                difference,
                CLOSE,
                &format!("{} {name} {place}", system.file.name),
            );
        }
    }
}

#[test]
fn derivatives_are_differences_of_orbits_on_shipped_systems() {
    for options in methods() {
        for (name, by) in [
            ("belt", &["mu0", "delta", "vp", "k2"][..]),
            ("den-hartog", &["S", "O"]),
        ] {
            let system = open(name);
            compare(&system, by, &orbit(&system, &options), &options);
        }
    }
}

#[test]
fn derivatives_of_an_orbit_with_impacts_are_differences() {
    let text = "name = \"impacts\"\n[time]\nperiod = \"2*pi/O\"\n[states]\nx = \"\"\nv = \"\"\n\
         [parameters]\nwall = 0.6\ne = 0.6\nO = 1.9\n[jumps.stop]\nwhen = \"x - wall\"\n\
         direction = \"rising\"\nset = { v = \"-e*v\" }\n[field]\nx = \"v\"\n\
         v = \"-2*x - 0.3*v + 2*cos(O*t)\"\n[start]\nx = 0\nv = 0.3\n";
    // A condition that each impact fulfils changes nothing.
    let gated = text.replace("[jumps.stop]\n", "[jumps.stop]\nif = \"v > 0.001\"\n");
    let (system, gated) = (system(text), system(&gated));
    for options in methods() {
        let orbit = orbit(&system, &options);
        let same = self::orbit(&gated, &options);
        assert_eq!((&orbit.x, &orbit.monodromy), (&same.x, &same.monodromy));
        compare(&system, &["wall", "e", "O"], &orbit, &options);
        compare(&gated, &["wall"], &same, &options);
        let found = slopes(&system, &["wall"], &orbit, &options);
        // The largest displacement is that of the wall.
        close(found.orbit.extremes[0][1].by[0], 1.0, 1e-12, "wall");
    }
}

#[test]
fn multipliers_of_an_orbit_with_impacts_have_the_derivatives_of_their_product() {
    // Damping and n impacts shrink areas over a period T by exp(-c T) e^(2n).
    let system = system(
        "name = \"impacts\"\n[time]\nperiod = \"2*pi/O\"\n[states]\nx = \"\"\nv = \"\"\n\
         [parameters]\nwall = 0.6\nc = 0.3\ne = 0.6\nO = 1.9\n[jumps.stop]\nwhen = \"x - wall\"\n\
         direction = \"rising\"\nset = { v = \"-e*v\" }\n[field]\nx = \"v\"\n\
         v = \"-2*x - c*v + 2*cos(O*t)\"\n[start]\nx = 0\nv = 0.3\n",
    );
    for options in methods() {
        let orbit = orbit(&system, &options);
        let own = multipliers(&orbit.monodromy);
        let product = own
            .iter()
            .fold(Complex::new(1.0, 0.0), |all, one| all * one);
        let impacts = (ln(product.norm()) + 0.3 * orbit.period) / (2.0 * ln(0.6));
        close(impacts, impacts.round().max(1.0), 1e-9, "impacts");
        let found = slopes(&system, &["wall", "c", "e", "O"], &orbit, &options);
        let wanted = [
            0.0,
            -orbit.period,
            2.0 * impacts / 0.6,
            0.3 * orbit.period / 1.9,
        ];
        for (k, wanted) in wanted.into_iter().enumerate() {
            let of_logarithm = |(slope, own): (&Complex<f64>, &Complex<f64>)| slope / own;
            let parts = found.multipliers[k].iter().zip(&own).map(of_logarithm);
            let sum: Complex<f64> = parts.sum();
            close(sum.re, wanted, 1e-6, &found.names[k]);
            assert!(sum.im.abs() < 1e-6, "{}: {sum}", found.names[k]);
        }
    }
}

#[test]
fn multipliers_of_a_driven_belt_move_with_its_frequency_as_orbits_found_alone_do() {
    // Another step than that of the derivatives, and orbits that are sought from the start of the
    // file.
    const STEP: f64 = 3e-4;
    let system = open("forced");
    let number = system.file.parameter("omega").unwrap();
    let frequency = system.values[number];
    for options in methods() {
        let orbit = orbit(&system, &options);
        let found = slopes(&system, &["omega"], &orbit, &options);
        assert_eq!(found.missing, [None]);
        let runs = [2.0, 1.0, -1.0, -2.0].map(|by| {
            let value = frequency + by * STEP;
            let other = system.with_values(&[("omega", value)]).unwrap();
            multipliers(&self::orbit(&other, &options).monodromy)
        });
        let own = multipliers(&orbit.monodromy);
        assert!(own.iter().any(|one| one.norm() > 1e-3), "{own:?}");
        for (k, slope) in found.multipliers[0].iter().enumerate() {
            let [one, two, three, four] = runs.each_ref().map(|run| run[k]);
            let difference = ((two - three) * 8.0 - (one - four)) / (12.0 * STEP);
            let off = (slope - difference).norm();
            assert!(
                off < 1e-5 * difference.norm().max(1.0),
                "{slope} and {difference}"
            );
        }
    }
}

#[test]
fn where_there_is_none_it_is_said() {
    let den_hartog = open("den-hartog");
    let named = |names: &[&str]| {
        let found = OrbitVariables::named(&den_hartog, names.iter().copied());
        found.map(drop).map_err(|error| error.to_string())
    };
    for (name, said) in [
        ("s", "neither a parameter nor a state"),
        (
            "x",
            "`x` is a state, on which a periodic orbit does not depend",
        ),
        ("t0", "`t0` is the time of the start, on which"),
    ] {
        let words = named(&[name]).unwrap_err();
        assert!(words.contains(said), "{words}");
    }
    // Beyond the range of a parameter there is no orbit.
    let options = options("taylor");
    let search = PeriodicSearch {
        periods: Some(1),
        transient: Some(0.0),
        ..SEARCH
    };
    let damped = system(
        "name = \"case\"\n[time]\nperiod = \"2*pi\"\n[states]\nx = \"\"\n[parameters]\n\
         c = { value = 1, range = [1, 2] }\no = 1\n[field]\nx = \"-c*x + cos(o*t)\"\n\
         [start]\nx = 0\n",
    );
    let at_end = orbit_from(&damped, 0.0, &search, &options);
    let found = slopes(&damped, &["c"], &at_end, &options);
    assert!(found.multipliers[0][0].re.is_nan());
    // x = cos(t - φ)/√(1 + c²), so that x(0) = c/(1 + c²).
    close(found.orbit.x[(0, 0)], 0.0, 1e-9, "c");
    let Some(NoMultiplierDerivatives::Setting { why, .. }) = &found.missing[0] else {
        panic!("{:?}", found.missing);
    };
    assert!(why.contains("range") || why.contains("outside"), "{why}");
    // The period of the file does not follow the frequency.
    let variables = OrbitVariables::named(&damped, ["o"]).unwrap();
    let error = variables
        .of_orbit(&damped, (&at_end, 0.0), &options)
        .unwrap_err();
    assert!(
        matches!(error, DerivativeError::OtherPeriod { .. }),
        "{error}"
    );
    // A square of another period moves its kinks by little, which samples of the field miss.
    let squared = system(
        "name = \"case\"\n[time]\nperiod = 2\n[states]\nx = \"\"\n[parameters]\no = 1\na = 1\n\
         [inputs.u]\nshape = \"square\"\nperiod = \"2/o\"\n[field]\nx = \"-x + a*u\"\n\
         [start]\nx = 0\n",
    );
    let forced = orbit_from(&squared, 0.0, &search, &options);
    let of = |name: &str| {
        let variables = OrbitVariables::named(&squared, [name]).unwrap();
        variables.of_orbit(&squared, (&forced, 0.0), &options)
    };
    let error = of("o").unwrap_err();
    assert!(
        matches!(error, DerivativeError::OtherPeriod { .. }),
        "{error}"
    );
    // The extremes are ±a tanh(1/2).
    let by_strength = of("a").unwrap().orbit.extremes[0][1].by[0];
    close(by_strength, stickslip::math::tanh(0.5), 1e-9, "a");
    // An undamped oscillator has a family of orbits.
    let spring = system(
        "name = \"case\"\n[states]\nx = \"\"\nv = \"\"\n[parameters]\nk = 2\n[field]\nx = \"v\"\n\
         v = \"-k*x\"\n[start]\nx = 0.7\nv = 0\n",
    );
    let one = orbit_from(
        &spring,
        0.0,
        &PeriodicSearch {
            periods: None,
            ..search
        },
        &options,
    );
    assert_eq!(one.family, 1);
    let variables = OrbitVariables::named(&spring, ["k"]).unwrap();
    let error = variables
        .of_orbit(&spring, (&one, 0.0), &options)
        .unwrap_err();
    let is_family = matches!(error, DerivativeError::Run(Error::NotFound { what, .. })
        if what.contains("family"));
    assert!(is_family, "{error}");
}
