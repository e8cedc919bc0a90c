//! Special orbits: one place wherever a branch begins, curves in two parameters along closed forms,
//! and the branches that begin there.

use std::f64::consts::PI;
use std::num::NonZeroUsize;

use stickslip::analysis::{
    Branch, ContinuationSettings, Curve, CurveStop, CycleBifurcation, PeriodicOrbit, SpecialPoint,
    Stop, SwitchedBranch,
};
use stickslip::{Error, Options, math};
use stickslip_model::file::System;
use stickslip_model::study::{ParameterLine, PeriodicSearch};

use crate::run::{SEARCH, branch, branch_through, options, orbit, orbit_from, system, with};

pub type Range<'a> = (&'a str, f64, f64);

/// All that an analysis finds from the special orbits of a branch, in both directions, until there
/// is no further one.
fn of_each<T>(find: impl Fn(bool, usize) -> Result<T, Error>) -> Vec<T> {
    let way = |upwards| {
        let next = |number| match find(upwards, number) {
            Err(Error::NotFound { .. }) => None,
            found => Some(found.unwrap()),
        };
        (0..).map_while(next).collect::<Vec<_>>()
    };
    [way(false), way(true)].into_iter().flatten().collect()
}

fn over(low: f64, high: f64, step: f64) -> ContinuationSettings {
    ContinuationSettings {
        step,
        ..ContinuationSettings::over(low, high)
    }
}

/// The curves in two parameters of the special orbits on a branch.
pub fn curves(
    system: &System,
    (name, low, high): Range,
    (other, other_low, other_high): Range,
    options: &Options,
) -> Vec<Curve> {
    let orbit = orbit(system, options);
    let along = ParameterLine::new(system, name, (low, high)).unwrap();
    let second = system.file.parameter(other).unwrap();
    let value = Some(system.values[second]);
    let settings = over(low, high, 0.02);
    let (settings, x) = along.start(&orbit, &settings, options, value).unwrap();
    let both = system.with_states_of(&[second, along.number]).unwrap();
    of_each(|upwards, number| {
        let way = (orbit.period, upwards, number);
        let ranges = (&settings, (other_low, other_high));
        Curve::of_special(&both, &x, way, ranges, options)
    })
}

/// The branches that begin at special orbits of the branch of an orbit.
pub fn side_branches(
    system: &System,
    orbit: &PeriodicOrbit,
    (name, low, high): Range,
    step: f64,
) -> Vec<(SpecialPoint, Vec<Branch>)> {
    let options = options("taylor");
    let along = ParameterLine::new(system, name, (low, high)).unwrap();
    let settings = over(low, high, step);
    let (settings, x) = along.start(orbit, &settings, &options, None).unwrap();
    of_each(|upwards, number| {
        let way = (orbit.period, upwards, number);
        let switched = SwitchedBranch::of_special(
            &along.dynamics,
            &x,
            way,
            (&settings, NonZeroUsize::MIN),
            &options,
        )?;
        Ok((switched.at, switched.branches))
    })
}

/// Den Hartog's oscillator with a wall that it does not reach at small amplitudes of the force.
const WALL: &str = r#"
name = "wall"
[time]
period = "2*pi/w"
[states]
x = ""
v = ""
[parameters]
A = 0.4
w = 0.6
[contacts.floor]
boundary = "v"
friction = "0.1"
[field]
x = "v"
v = "-x + A*cos(w*t) - friction(floor)"
[jumps.wall]
when = "0.8 - x"
direction = "falling"
set = { v = "-0.8*v" }
[start]
x = 0
v = 0
"#;

/// The force at which the oscillator's amplitude is the distance of the wall (Den Hartog 1931).
fn at_wall(frequency: f64) -> f64 {
    let half = PI / frequency;
    let v = 1.0 / (1.0 - frequency * frequency);
    let u = math::sin(half) / (frequency * (1.0 + math::cos(half)));
    (0.8 * 0.8 + 0.1 * 0.1 * u * u).sqrt() / v
}

#[test]
fn the_graze_of_a_wall_is_followed_in_two_parameters_along_its_closed_form() {
    for method in ["dop853", "taylor"] {
        let (along, also) = (("A", 0.2, 0.9), ("w", 0.55, 0.7));
        let found = curves(&system(WALL), along, also, &options(method));
        let [curve] = found.as_slice() else {
            panic!("{method}: {found:?}");
        };
        assert_eq!(curve.at.what.to_string(), "grazing of a jump");
        assert!(curve.points.len() > 5);
        for point in &curve.points {
            let [frequency, force] = point.parameters;
            let off = (force - at_wall(frequency)).abs();
            assert!(off < 1e-7, "{method} at {frequency}: {off:e}");
        }
        let ends = [curve.points.first(), curve.points.last()];
        let [first, last] = ends.map(|point| point.unwrap().parameters[0]);
        assert!((first - 0.55).abs() < 1e-9 && (last - 0.7).abs() < 1e-9);
    }
}

/// The block turns back at its amplitude. So the wall's function and the velocity of the contact
/// are zero at once, and rounding decides on which side of that moment the least distance lies.
#[test]
fn a_graze_of_a_wall_where_the_velocity_is_zero_has_one_name() {
    let exact = at_wall(0.6);
    for start in [0.3, 0.33, 0.35, 0.38, 0.4, 0.42] {
        let system = with(WALL, &[("A", start)]);
        let branch = branch(&system, ("A", 0.2, 0.9), &options("taylor"));
        let [graze] = branch.special.as_slice() else {
            panic!("{start}: {:?}", branch.special);
        };
        assert_eq!(graze.what.to_string(), "grazing of a jump", "{start}");
        let (off, uncertainty) = ((graze.parameter - exact).abs(), graze.uncertainty);
        assert!(
            off <= uncertainty && uncertainty < 1e-8,
            "{start}: {off:e} {uncertainty:e}"
        );
    }
}

/// Begun at the lower friction or the higher frequency, the orbit grazes the edge of stick between
/// two samples of a step. At the switching a multiplier is 1. That leaves the tangent undetermined,
/// and orbits next to it.
#[test]
fn a_branch_has_the_same_places_wherever_it_is_begun() {
    const DEN_HARTOG: &str = include_str!("../../systems/den-hartog.toml");
    let branches = [
        (("S", 0.3), ("O", 0.35, 0.9), [0.4, 0.7]),
        (("S", 0.305), ("O", 0.35, 0.9), [0.4, 0.7]),
        (("S", 0.28), ("O", 0.35, 0.9), [0.7, 0.4]),
        (("O", 0.4), ("S", 0.02, 1.2), [0.3, 0.1]),
        (("O", 0.45), ("S", 0.02, 1.2), [0.3, 0.1]),
    ];
    for (set, range, starts) in branches {
        let [one, other] = starts.map(|start| {
            let system = with(DEN_HARTOG, &[set, (range.0, start)]);
            branch(&system, range, &options("taylor")).special
        });
        assert_eq!((one.len(), other.len()), (2, 2), "{set:?}");
        for (a, b) in one.iter().zip(&other) {
            assert_eq!(a.what.to_string(), b.what.to_string(), "{set:?}");
            let apart = (a.parameter - b.parameter).abs();
            let (by, or) = (a.uncertainty, b.uncertainty);
            assert!(
                apart <= by + or && by.max(or) < 1e-6,
                "{set:?}: {apart:e}, ± {by:e} and ± {or:e}"
            );
        }
    }
}

/// A heater warms a room towards 1 and goes off at p. The warming takes `ln(0.8/(1 - p))`.
const THERMOSTAT: &str = r#"
name = "thermostat"
[states]
T = ""
[discrete]
heater = 1
[parameters]
p = 0.5
[field]
T = "heater - T"
[jumps.off]
when = "T - p"
direction = "rising"
set = { heater = "0" }
[jumps.on]
when = "T - 0.2"
direction = "falling"
set = { heater = "1" }
[start]
T = 0.3
"#;

#[test]
fn a_threshold_at_an_equilibrium_ends_the_branch_by_name() {
    let branch = branch(&system(THERMOSTAT), ("p", 0.3, 1.2), &options("taylor"));
    let Stop::BoundaryEquilibrium { parameter } = branch.stops[1] else {
        panic!("{:?}", branch.stops);
    };
    assert!((parameter - 1.0).abs() < 1e-9, "{parameter}");
}

/// `y' = cos t - c y` touches the roof `y = p`, above which the field points down, at `p √(1 + c²)
/// = 1`.
const LAG: &str = include_str!("../data/lag.toml");

#[test]
fn a_change_is_followed_in_two_parameters_along_its_closed_form() {
    let (along, also) = (("p", 0.5, 1.2), ("c", 0.2, 2.5));
    let found = curves(&system(LAG), along, also, &options("taylor"));
    let [curve] = found.as_slice() else {
        panic!("{found:?}");
    };
    assert_eq!(curve.at.what.to_string(), "grazing-sliding");
    assert_eq!(curve.stops, [CurveStop::Range; 2]);
    assert!(curve.points.len() > 10);
    for point in &curve.points {
        let [c, p] = point.parameters;
        assert!((p * (1.0 + c * c).sqrt() - 1.0).abs() < 1e-9, "{c} {p}");
    }
    // From one end of the range of c to the lower end of that of p.
    let ends = [curve.points.first(), curve.points.last()];
    let [first, last] = ends.map(|point| point.unwrap().parameters);
    assert!((first[0] - 0.2).abs() < 1e-9 && (last[1] - 0.5).abs() < 1e-9);
}

/// `u' = p + q u - u³` about `cos t`, without a contact: folds where `p² = 4 (q/3)³`.
pub const CUSP: &str = include_str!("../data/cusp.toml");

#[test]
fn folds_are_followed_in_two_parameters_round_their_cusp() {
    let (along, also) = (("p", -1.0, 1.0), ("q", -0.5, 1.0));
    let found = curves(&system(CUSP), along, also, &options("taylor"));
    // Both folds of the branch lie on one curve.
    assert_eq!(found.len(), 2);
    for curve in &found {
        assert_eq!(curve.at.what, CycleBifurcation::Fold);
        assert_eq!(curve.stops, [CurveStop::Range; 2]);
        assert!(curve.points.len() > 20);
        for point in &curve.points {
            let [q, p] = point.parameters;
            let third = q / 3.0;
            let off = p * p - 4.0 * third * third * third;
            assert!(off.abs() < 1e-9, "{p} {q}");
        }
    }
}

/// About `(cos t, sin t)`, in a frame that rotates half as fast, deviations have the rates `p u -
/// u³` and `-w`. At p = 0 the period doubles, to orbits at `u² = p`.
pub const DOUBLED: &str = include_str!("../data/doubled.toml");

/// The orbit of one period of the drive.
pub fn of_one_period(system: &System) -> PeriodicOrbit {
    let search = PeriodicSearch {
        periods: Some(1),
        ..SEARCH
    };
    orbit_from(system, system.built.t_start, &search, &options("taylor"))
}

#[test]
fn the_branch_of_twice_the_period_is_followed_along_its_closed_form() {
    let system = system(DOUBLED);
    let orbit = of_one_period(&system);
    let found = side_branches(&system, &orbit, ("p", -0.2, 0.3), 0.02);
    let [(flip, branches)] = found.as_slice() else {
        panic!("{found:?}");
    };
    assert_eq!(flip.what, CycleBifurcation::Flip);
    assert!(flip.parameter.abs() <= flip.uncertainty);
    let [branch] = branches.as_slice() else {
        panic!("{branches:?}");
    };
    assert_eq!(branch.stop, Stop::Range);
    assert!(branch.points.len() > 5);
    for point in &branch.points {
        let (p, t, x) = (point.parameter, point.t, &point.x);
        let (a, b) = (x[0] - math::cos(t), x[1] - math::sin(t));
        assert!((a * a + b * b - p).abs() < 1e-9, "{p}: {a} {b}");
        assert!((point.period - 4.0 * PI).abs() < 1e-9);
    }
}

/// The period doubles at `p = 0` and at `p = 1`, and between them `u = ±√(p (1 - p))`.
#[test]
fn a_branch_of_twice_the_period_ends_in_a_flip_of_its_half() {
    let text = DOUBLED.replace("p*u - u*u*u", "p*(1 - p)*u - u*u*u");
    let ends_in_flip = |stop: &Stop, exact: f64| {
        let Stop::Flip {
            parameter,
            uncertainty,
        } = *stop
        else {
            panic!("{stop:?}");
        };
        let off = parameter - exact;
        assert!(
            off.abs() <= uncertainty && uncertainty < 1e-7,
            "{off:e} {uncertainty:e}"
        );
    };
    let range = ("p", -0.2, 1.2);
    for step in [0.02, 0.005] {
        let system = system(&text);
        let found = side_branches(&system, &of_one_period(&system), range, step);
        assert_eq!(found.len(), 2, "{found:?}");
        for (_, branches) in &found {
            let [branch] = branches.as_slice() else {
                panic!("{branches:?}");
            };
            assert!(branch.special.is_empty());
            // From the one flip to the other.
            let exact = if branch.points[0].parameter < 0.5 {
                1.0
            } else {
                0.0
            };
            ends_in_flip(&branch.stop, exact);
        }
    }
    let between = branch(&with(&text, &[("p", 0.5)]), range, &options("taylor"));
    assert!(between.special.is_empty());
    ends_in_flip(&between.stops[0], 0.0);
    ends_in_flip(&between.stops[1], 1.0);
    let rows = between.special_rows(&system(&text));
    assert_eq!([0, 1].map(|k| rows[k].name.as_str()), ["flip", "flip"]);
}

/// Fixed points of a map by a clock are the lemniscate `(x² + r²)² = 2(r² - x²)`. Its two loops
/// cross at `r = 0`; the map has flips where its slope is −1.
const LEMNISCATE: &str = r#"
name = "lemniscate"
[time]
period = 1
[states]
x = ""
[parameters]
r = 0.8
[jumps.map]
when = "cos(2*pi*t)"
direction = "falling"
set = { x = "x - 0.5*((x*x + r*r)^2 - 2*(r*r - x*x))" }
[field]
x = "0"
[start]
x = 0.5
"#;

#[test]
fn branches_of_a_lemniscate_begin_and_end_where_its_closed_form_says() {
    // The slope is −1 at x = 1/2 and at x = 0.376…, by Newton's method on both equations.
    let flips = [3.0_f64.sqrt() / 2.0, 1.231_879_249_634_290_8];
    let is_flip = |r: f64, uncertainty: f64| {
        let off = |flip: &f64| (r.abs() - flip).abs();
        flips.iter().any(|flip| off(flip) <= uncertainty.max(1e-11))
    };
    for step in [0.02, 0.05, 0.07, 0.1, 0.15, 0.2, 0.3] {
        let system = system(LEMNISCATE);
        let orbit = of_one_period(&system);
        let found = side_branches(&system, &orbit, ("r", -2.0, 2.0), step);
        let mut doubled = 0;
        for (at, branches) in &found {
            match at.what {
                CycleBifurcation::Fold => {
                    assert!((at.parameter.abs() - 2.0_f64.sqrt()).abs() < 1e-6)
                }
                CycleBifurcation::BranchPoint => {
                    assert!(at.parameter.abs() <= at.uncertainty, "{step}: {at:?}");
                }
                CycleBifurcation::Flip => {
                    assert!(is_flip(at.parameter, at.uncertainty), "{step}: {at:?}");
                }
                ref other => panic!("{step}: {other:?}"),
            }
            for branch in branches {
                for special in &branch.special {
                    let is_known = match special.what {
                        CycleBifurcation::Fold => {
                            (special.parameter.abs() - 2.0_f64.sqrt()).abs() < 1e-6
                        }
                        CycleBifurcation::BranchPoint => {
                            special.parameter.abs() <= special.uncertainty
                        }
                        CycleBifurcation::Flip if at.what == CycleBifurcation::Flip => true,
                        CycleBifurcation::Flip => is_flip(special.parameter, special.uncertainty),
                        _ => false,
                    };
                    assert!(is_known, "{step}: {special:?} on the branch from {at:?}");
                }
                if at.what == CycleBifurcation::Flip {
                    let Stop::Flip {
                        parameter,
                        uncertainty,
                    } = branch.stop
                    else {
                        panic!("{step}: {:?} of the branch from {at:?}", branch.stop);
                    };
                    assert!(is_flip(parameter, uncertainty), "{step}: {:?}", branch.stop);
                    doubled += 1;
                }
            }
        }
        assert!(doubled >= 2, "{step}: {found:?}");
    }
}

/// `x → x + p + q x - x³` has folds at `x² = q/3`.
#[test]
fn a_branch_that_begins_at_a_fold_is_none_of_a_family() {
    let map = |set: &str, p: f64, start: f64| {
        format!(
            "name = \"map\"\n[time]\nperiod = 1\n[states]\nx = \"\"\n[parameters]\np = {p:e}\n\
             [jumps.map]\nwhen = \"sin(2*pi*t + 1)\"\ndirection = \"rising\"\n\
             set = {{ x = \"{set}\" }}\n[field]\nx = \"0\"\n[start]\nx = {start:e}\n"
        )
    };
    let found = |text: &str| {
        let (system, options) = (system(text), options("taylor"));
        let search = PeriodicSearch {
            transient: Some(0.0),
            ..SEARCH
        };
        let orbit = orbit_from(&system, 0.0, &search, &options);
        branch_through(&system, &orbit, ("p", -0.3, 0.3), 0.02, &options)
    };
    let turn = 0.1_f64.sqrt();
    let fold = 0.3 * turn - turn * turn * turn;
    let branch = found(&map("x + p + 0.3*x - x^3", fold, -turn));
    assert_eq!(
        (branch.family, &branch.stops),
        (0, &[Stop::Range, Stop::Range])
    );
    let folds = branch.special.iter().map(|at| (at.what.to_string(), at));
    let mut places: Vec<f64> = Vec::new();
    for (name, at) in folds {
        assert_eq!(name, "fold");
        let off = (at.parameter.abs() - fold).abs();
        assert!(off <= at.uncertainty + 1e-12, "{at:?}");
        places.push(at.parameter);
    }
    assert!(
        places.len() == 2 && places[0] * places[1] < 0.0,
        "{places:?}"
    );
}
