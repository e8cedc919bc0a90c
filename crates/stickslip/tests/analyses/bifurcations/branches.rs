//! Branches of periodic orbits through folds and changes of their phases.

use std::f64::consts::{LN_10, PI};
use std::ops::ControlFlow;

use stickslip::analysis::{
    Branch, ContinuationSettings, CycleBifurcation, Monodromy, PartialBranch, SequenceBifurcation,
    Stability, Stop, continue_periodic_orbit,
};
use stickslip::nalgebra::Matrix3;
use stickslip::{Error, Filippov, Method, Mode, Options, Side, State, math, solve};

use super::sweeps::{landing, touching};
use super::systems::{
    Area, BeatFamily, Belt, DrivenFamily, DrivenIsland, Island, Pitchfork, Resonant, Rhythm, Rough,
    Softening, Twisted,
};
use crate::attractors::systems::Rings;
use crate::compiled::Compiled;
use crate::smooth::Smooth;

const BELOW: Mode = Mode::Slip(Side::Below);

fn expected(is_stable: bool) -> Stability {
    if is_stable {
        Stability::Stable
    } else {
        Stability::Unstable
    }
}

fn branch<S: Compiled<3>>(
    system: &S,
    x: [f64; 3],
    way: (f64, bool),
    settings: &ContinuationSettings,
) -> Branch {
    branch_by(system, x, way, settings, &Options::tol(1e-13))
}

fn branch_by<S: Compiled<3>>(
    system: &S,
    x: [f64; 3],
    (period, upwards): (f64, bool),
    settings: &ContinuationSettings,
    options: &Options,
) -> Branch {
    continue_periodic_orbit(&system.dynamics(), x, period, upwards, settings, options).unwrap()
}

/// r² of the outer or the inner cycle of `r' = r (p + 2 r² - r⁴)`.
pub fn square_of_radius(is_outer: bool, p: f64) -> f64 {
    let root = (1.0 + p).max(0.0).sqrt();
    if is_outer { 1.0 + root } else { 1.0 - root }
}

/// Asserts that a branch ends where the inner cycle shrinks to the focus, at θ' = 1.
pub fn is_hopf_at_zero(stop: Stop) {
    let Stop::Equilibrium {
        parameter,
        frequency,
    } = stop
    else {
        panic!("{stop:?}");
    };
    // Of the equilibrium, which does not depend on the integration.
    assert!(parameter.abs() < 1e-12, "{parameter}");
    assert!((frequency - 1.0).abs() < 1e-12, "{frequency}");
}

#[test]
fn a_fold_of_cycles_and_the_focus_that_the_inner_one_shrinks_to() {
    // A boundary that is never met, and one that is crossed without effect.
    let both = [50.0, 0.3].into_iter();
    for (place, (tolerance, options)) in both.flat_map(|one| accuracies().map(move |at| (one, at)))
    {
        let settings = ContinuationSettings::over(-1.5, 0.5);
        let start = [(1.0 + 0.5_f64.sqrt()).sqrt(), 0.0, -0.5];
        let found = branch_by(
            &Rings { place },
            start,
            (2.0 * PI, false),
            &settings,
            &options,
        );
        let (fold, others) = found.special.split_first().expect("a fold");
        assert_eq!(fold.what, CycleBifurcation::Fold);
        is_within(fold.parameter + 1.0, fold.uncertainty, tolerance);
        assert!((fold.x.rows(0, 2).norm() - 1.0).abs() < 1e-6);
        // The orbit leaves the boundary where r = 0.3 and does not meet it afterwards.
        let exact = -(2.0 * 0.09 - 0.09 * 0.09);
        match others {
            [] => assert_eq!(place, 50.0),
            [left] => {
                is_within(left.parameter - exact, left.uncertainty, tolerance);
                let CycleBifurcation::Sequence(change) = &left.what else {
                    panic!("{left:?}");
                };
                assert_eq!(change.bifurcation, SequenceBifurcation::Grazing);
                assert_eq!(change.after, [BELOW]);
                assert_eq!(place, 0.3);
            }
            more => panic!("{more:?}"),
        }
        for (k, point) in found.points.iter().enumerate() {
            let square = point.x.rows(0, 2).norm_squared();
            let exact = square_of_radius(k < fold.behind, point.parameter);
            assert!(
                (square - exact).abs() < 1e4 * tolerance,
                "{k}: {square} {exact}"
            );
            assert_eq!(point.stability(), expected(k < fold.behind), "{k}");
            // d(r g)/dr over a turn.
            let rate = 4.0 * square - 4.0 * square * square;
            let multiplier = math::exp(2.0 * PI * rate);
            let off = (point.multipliers[0].re - multiplier).abs();
            assert!(off < 1e5 * tolerance * multiplier.max(1.0), "{k}: {off:e}");
        }
        is_hopf_at_zero(found.stop);
        assert!(found.points.len() < 300, "{}", found.points.len());
    }
}

#[test]
fn a_branch_that_leaves_its_range_ends_there() {
    let settings = ContinuationSettings::over(-0.7, 0.3);
    let start = [1.3, 0.0, -0.5];
    for (upwards, end) in [(true, 0.3), (false, -0.7)] {
        let found = branch(&Rings { place: 50.0 }, start, (6.3, upwards), &settings);
        assert_eq!((found.stop, found.special.len()), (Stop::Range, 0));
        assert!((found.points.last().unwrap().parameter - end).abs() < 1e-12);
    }
    // From an end of the range there is no other orbit in that direction.
    for (upwards, p) in [(false, -0.7), (true, 0.3)] {
        let found = branch(
            &Rings { place: 50.0 },
            [1.4, 0.0, p],
            (6.3, upwards),
            &settings,
        );
        assert_eq!((found.stop, found.points.len()), (Stop::Range, 1));
    }
    let few = ContinuationSettings {
        most_points: 5,
        ..settings
    };
    let found = branch(&Rings { place: 50.0 }, start, (6.3, true), &few);
    assert_eq!((found.stop, found.points.len()), (Stop::Points, 5));
}

/// Both methods, each at tolerances from loose to tight.
pub fn accuracies() -> impl Iterator<Item = (f64, Options)> {
    let methods = [Method::Dop853, Method::Taylor].into_iter();
    methods.flat_map(|method| {
        [1e-8, 1e-10, 1e-12].map(|tolerance| (tolerance, Options::tol(tolerance).method(method)))
    })
}

/// For each rhythm: the change of phases, its name and its location. Both directions lead to it.
#[test]
fn every_change_of_the_phases_is_located_and_named_on_a_branch() {
    let rises = math::atan(0.7 / 0.51_f64.sqrt());
    let changes = [
        (Rhythm::Touch, SequenceBifurcation::GrazingSliding, 1.0),
        (Rhythm::Part, SequenceBifurcation::AddingSliding, 1.0),
        (
            Rhythm::Meet,
            SequenceBifurcation::CrossingSliding,
            landing() - rises,
        ),
        (
            Rhythm::Meet,
            SequenceBifurcation::SwitchingSliding,
            landing() - (PI - rises),
        ),
        (Rhythm::Lift, SequenceBifurcation::ContactGrazing, 1.0),
    ];
    for (rhythm, name, exact) in changes {
        for upwards in [false, true] {
            let settings = ContinuationSettings::over(exact - 0.11, exact + 0.1).forced(2.0 * PI);
            let begin = if upwards { exact - 0.1 } else { exact + 0.09 };
            let family = BeatFamily(rhythm);
            let (system, start) = (family.dynamics(), find(&family, begin));
            for (tolerance, options) in accuracies() {
                let found =
                    continue_periodic_orbit(&system, start, 6.3, upwards, &settings, &options);
                let found = found.unwrap();
                assert_eq!(found.stop, Stop::Range, "{rhythm:?}: {:?}", found.special);
                let [special] = found.special.as_slice() else {
                    panic!("{rhythm:?}: {:?}", found.special);
                };
                let CycleBifurcation::Sequence(change) = &special.what else {
                    panic!("{special:?}");
                };
                assert_eq!(change.bifurcation, name);
                is_within(change.parameter - exact, change.uncertainty, tolerance);
            }
        }
    }
}

/// Asserts that an error is within an uncertainty, and that within tens of tolerances.
pub fn is_within(error: f64, uncertainty: f64, tolerance: f64) {
    let allowed = 50.0 * tolerance + 1e-12;
    assert!(
        error.abs() <= uncertainty && uncertainty < allowed,
        "at {tolerance:e}: {error:e} of {uncertainty:e}"
    );
}

/// A fold, a flip, a torus and a branch point.
#[test]
fn critical_multipliers_are_located_within_their_uncertainty_at_any_tolerance() {
    let driven = ContinuationSettings::over(-0.35, 0.25).forced(2.0 * PI);
    let free = ContinuationSettings::over(-0.25, 0.2);
    let [flip, torus] = [true, false].map(|half_turn| Twisted { half_turn }.any().dynamics());
    let (pitchfork, rings) = (Pitchfork.dynamics(), Rings { place: 50.0 }.dynamics());
    for (tolerance, options) in accuracies() {
        let fold = {
            let start = [(1.0 + 0.5_f64.sqrt()).sqrt(), 0.0, -0.5];
            let settings = ContinuationSettings::over(-1.5, -0.4);
            continue_periodic_orbit(&rings, start, 2.0 * PI, false, &settings, &options)
        };
        let [flip, torus] = [&flip, &torus].map(|system| {
            let start = [1.0, 0.0, -0.3];
            continue_periodic_orbit(system, start, 2.0 * PI, true, &driven, &options)
        });
        let branch_point = {
            let start = [1.0, 0.0, 0.0, -0.2];
            continue_periodic_orbit(&pitchfork, start, 2.0 * PI, true, &free, &options)
        };
        let exact = [-1.0, 0.0, 0.0, 0.0];
        for (branch, exact) in [fold, flip, torus, branch_point].into_iter().zip(exact) {
            let branch = branch.unwrap();
            let [at] = branch.special.as_slice() else {
                panic!("{:?}", branch.special);
            };
            is_within(at.parameter - exact, at.uncertainty, tolerance);
        }
    }
}

/// `y = sin t` touches `y = p` at p = 1. A branch may begin there, or where the orbit crosses by
/// less than the tolerances resolve.
#[test]
fn a_branch_that_begins_at_a_change_reports_it() {
    let family = BeatFamily(Rhythm::Touch);
    let options = Options::tol(1e-12);
    for beyond in [0.0, 1e-12, 1e-11] {
        let p = 1.0 - beyond;
        let settings = ContinuationSettings::over(0.89, 1.1).forced(2.0 * PI);
        let start = [0.0, p];
        let found =
            continue_periodic_orbit(&family.dynamics(), start, 6.3, false, &settings, &options);
        let found = found.unwrap();
        let [special] = found.special.as_slice() else {
            panic!("{beyond:e}: {:?} {:?}", found.special, found.stop);
        };
        assert!((special.parameter - 1.0).abs() < 1e-9, "{special:?}");
        assert_eq!(found.stop, Stop::Range);
    }
}

/// The uncertainty of a location is reported at any tolerance, by both methods. A run with a tenth
/// of the tolerance finds the location within it.
#[test]
fn a_change_is_within_its_uncertainty_at_any_tolerance() {
    let family = BeatFamily(Rhythm::Touch);
    let settings = ContinuationSettings::over(0.89, 1.1).forced(2.0 * PI);
    for method in [Method::Dop853, Method::Taylor] {
        for tolerance in [1e-8, 1e-10, 1e-12] {
            let place = |tolerance: f64| {
                let options = Options::tol(tolerance).method(method);
                let system = family.dynamics();
                let start = find(&family, 0.9);
                let found = continue_periodic_orbit(&system, start, 6.3, true, &settings, &options);
                let found = found.unwrap();
                assert_eq!((found.stop, found.special.len()), (Stop::Range, 1));
                (found.special[0].parameter, found.special[0].uncertainty)
            };
            let ((reported, uncertainty), (finer, _)) = (place(tolerance), place(0.1 * tolerance));
            let off = [1.0, finer].map(|exact| (reported - exact).abs());
            assert!(
                off[0].max(off[1]) <= uncertainty && uncertainty < 10.0 * tolerance + 1e-13,
                "{method:?} {tolerance:e}: {off:?} of {uncertainty:e}"
            );
        }
    }
}

/// A state of the attracting orbit, at a multiple of the period.
fn find(family: &BeatFamily, p: f64) -> [f64; 2] {
    let options = Options::tol(1e-12);
    let run = solve(&family.any(), 0.0, [-0.5, p], 40.0 * PI, &options).unwrap();
    [run.x_end[0], p]
}

/// A step of the series may be so long that a contraction by e⁻⁷ in it overflows the stages that
/// carry the vectors.
#[test]
fn what_contracts_fast_is_carried_by_long_steps_too() {
    for p in [-0.5_f64, -0.316, 0.0, 0.5, 2.0] {
        let square = 1.0 + (1.0 + p).sqrt();
        let radius = square.sqrt();
        let by_parameter = 0.25 / (radius * (square - 1.0));
        for method in [Method::Dop853, Method::Taylor] {
            let options = Options::tol(1e-12).method(method);
            for k in 0..8 {
                let (sin, cos) = (math::sin(f64::from(k)), math::cos(f64::from(k)));
                let start = [radius * cos, radius * sin, p];
                let rings = Rings { place: 50.0 };
                let turn =
                    Monodromy::of(&rings.dynamics(), 0.0, start, 2.0 * PI, &options).unwrap();
                let wanted = Matrix3::new(
                    sin * sin,
                    -sin * cos,
                    by_parameter * cos,
                    -sin * cos,
                    cos * cos,
                    by_parameter * sin,
                    0.0,
                    0.0,
                    1.0,
                );
                let error = (turn.matrix - wanted).amax();
                assert!(error < 1e-11, "{method:?}, p = {p}, {k}: {error:e}");
            }
        }
    }
}

/// Over a wide range a step past a change of phases may end on an orbit before the change.
#[test]
fn a_branch_does_not_turn_back_behind_a_change_of_phases() {
    let options = Options::tol(1e-10);
    let start = [0.5, 0.0, 0.8];
    let settled = stickslip::run(&Rough.any(), 0.0, start, 400.0 * PI, &options, &mut ()).unwrap();
    for step in [0.01, 0.02, 0.05] {
        let settings = ContinuationSettings {
            step,
            ..ContinuationSettings::over(0.1, 3.0).forced(2.0 * PI)
        };
        let found = branch(&Rough, settled.x.into(), (2.0 * PI, false), &settings);
        assert_eq!(found.stop, Stop::Range);
        assert_eq!(found.special.len(), 3, "{:?}", found.special);
        let mut pairs = found.points.windows(2);
        assert!(pairs.all(|pair| pair[1].parameter < pair[0].parameter));
    }
}

#[test]
fn a_closed_branch_of_driven_orbits_is_followed_once() {
    let settings = ContinuationSettings::over(-1.0, 1.0).forced(2.0 * PI);
    let start = [(0.25_f64 - 0.01).sqrt(), 0.0, 0.1];
    for upwards in [true, false] {
        let found = branch(&DrivenIsland, start, (2.0 * PI, upwards), &settings);
        assert_eq!(found.stop, Stop::Closed);
        let folds = found.special.iter();
        let folds: Vec<_> = folds.map(|at| (&at.what, at.parameter)).collect();
        let [(CycleBifurcation::Fold, one), (CycleBifurcation::Fold, two)] = folds.as_slice()
        else {
            panic!("{folds:?}");
        };
        let sign = if upwards { 1.0 } else { -1.0 };
        assert!((one - 0.5 * sign).abs() < 1e-9 && (two + 0.5 * sign).abs() < 1e-9);
    }
}

#[test]
fn a_closed_branch_is_followed_once() {
    let settings = ContinuationSettings::over(-1.0, 1.0);
    for (p, upwards) in [(0.1, true), (0.1, false), (-0.3, true)] {
        let radius = (1.0 + (0.25_f64 - p * p).sqrt()).sqrt();
        let found = branch(&Island, [radius, 0.0, p], (2.0 * PI, upwards), &settings);
        assert_eq!(found.stop, Stop::Closed);
        let [one, two] = found.special.as_slice() else {
            panic!("{:?}", found.special);
        };
        let ends = if upwards { [0.5, -0.5] } else { [-0.5, 0.5] };
        for (fold, end) in [one, two].into_iter().zip(ends) {
            assert_eq!(fold.what, CycleBifurcation::Fold);
            let off = (fold.parameter - end).abs();
            assert!(
                off <= fold.uncertainty && fold.uncertainty < 1e-9,
                "{off:e}"
            );
        }
        let (first, last) = (&found.points[0], found.points.last().unwrap());
        assert!((last.parameter - p).abs() < 1e-12 && (first.parameter - p).abs() < 1e-12);
        assert!((last.x.rows(0, 2).norm() - radius).abs() < 1e-9);
        for point in &found.points {
            let square = point.x.rows(0, 2).norm_squared();
            let off = (square - 1.0) * (square - 1.0) + point.parameter * point.parameter - 0.25;
            assert!(off.abs() < 1e-9, "{off}");
        }
    }
}

#[test]
fn the_branch_of_stick_and_slip_turns_back_where_it_grazes_and_ends_in_the_focus() {
    let settings = ContinuationSettings::over(1.0, 2.0);
    let start = [-1.0, -1.2, 1.5];
    for (tolerance, options) in accuracies() {
        let found = branch_by(&DrivenFamily, start, (6.32, true), &settings, &options);
        let [graze] = found.special.as_slice() else {
            panic!("{:?} {:?}", found.special, found.stop);
        };
        let CycleBifurcation::Sequence(change) = &graze.what else {
            panic!("{graze:?}");
        };
        assert_eq!(change.bifurcation, SequenceBifurcation::GrazingSliding);
        is_within(graze.parameter - touching(), graze.uncertainty, tolerance);
        // With stick the orbit is stable and forgets all changes; without, it does not.
        let (with_stick, slipping) = found.points.split_at(graze.behind);
        assert!(
            with_stick
                .iter()
                .all(|point| point.stability() == Stability::Stable && point.sequence.len() == 2)
        );
        assert!(
            slipping
                .iter()
                .all(|point| point.stability() == Stability::Unstable && point.sequence == [BELOW])
        );
        assert!(with_stick.len() > 10 && slipping.len() > 10);
        let Stop::Equilibrium {
            parameter,
            frequency,
        } = found.stop
        else {
            panic!("{:?}", found.stop);
        };
        // The falling friction cancels all damping: 0.1 = e^(-2 vd).
        assert!((parameter - 0.5 * LN_10).abs() < 1e-9, "{parameter}");
        assert!((frequency - 1.0).abs() < 1e-9);
    }
}

#[test]
fn a_flip_and_a_torus_are_located_and_named() {
    let settings = ContinuationSettings::over(-0.35, 0.25).forced(2.0 * PI);
    for half_turn in [true, false] {
        let start = [1.0, 0.0, -0.3];
        let found = branch(&Twisted { half_turn }, start, (2.0 * PI, true), &settings);
        let [special] = found.special.as_slice() else {
            panic!("{:?}", found.special);
        };
        let (off, bound) = (special.parameter.abs(), special.uncertainty);
        assert!(off <= bound && bound < 1e-9, "{off:e} {bound:e}");
        match special.what {
            CycleBifurcation::Flip => assert!(half_turn),
            CycleBifurcation::NeimarkSacker { angle } => {
                assert!(!half_turn && (angle - 0.6 * PI).abs() < 1e-8, "{angle}");
            }
            ref other => panic!("{other:?}"),
        }
        assert_eq!(found.stop, Stop::Range);
        for point in &found.points {
            assert_eq!(point.stability(), expected(point.parameter < 0.0));
            let on_circle = State::from([math::cos(point.t), math::sin(point.t)]);
            assert!((point.x.rows(0, 2) - on_circle).amax() < 1e-9);
        }
    }
}

#[test]
fn where_another_branch_meets_it_the_branch_goes_on_and_the_point_is_named() {
    let (low, high) = (-0.25, 0.2);
    let settings = ContinuationSettings::over(low, high);
    // The second start is on the boundary, where both sides' fields agree.
    let on_boundary = [0.2, 0.96_f64.sqrt()];
    for (upwards, from, to, [x, y]) in [
        (true, -0.2, high, [1.0, 0.0]),
        (false, 0.15, low, on_boundary),
    ] {
        let found = continue_periodic_orbit(
            &Pitchfork.dynamics(),
            [x, y, 0.0, from],
            2.0 * PI,
            upwards,
            &settings,
            &Options::tol(1e-13),
        )
        .unwrap();
        let [special] = found.special.as_slice() else {
            panic!("{:?}", found.special);
        };
        assert_eq!(special.what, CycleBifurcation::BranchPoint);
        assert!(special.parameter.abs() < 1e-9, "{}", special.parameter);
        assert!((special.period - 2.0 * PI).abs() < 1e-9);
        assert_eq!(found.stop, Stop::Range);
        assert!((found.points.last().unwrap().parameter - to).abs() < 1e-12);
        for point in &found.points {
            // The branch stays on the circle and does not switch to the two orbits that meet it.
            assert!((point.x.rows(0, 2).norm() - 1.0).abs() < 1e-9 && point.x[2].abs() < 1e-9);
            let beside = math::exp(2.0 * PI * point.parameter);
            let within = math::exp(-4.0 * PI);
            let [one, other] = [0, 1].map(|k| point.multipliers[k].re);
            assert!((one - beside).abs() < 1e-8 && (other - within).abs() < 1e-8);
            assert_eq!(point.stability(), expected(point.parameter < 0.0));
        }
    }
}

#[test]
fn what_cannot_be_followed_is_an_error_that_says_why() {
    let options = Options::default();
    let settings = ContinuationSettings::over(-1.0, 0.0);
    let rings = Rings { place: 50.0 };
    let begin = |x: [f64; 3], period, settings: &ContinuationSettings| {
        continue_periodic_orbit(&rings.dynamics(), x, period, true, settings, &options).unwrap_err()
    };
    // From the focus there is no cycle.
    let error = begin([1e-9, 0.0, -0.5], 6.3, &settings);
    assert!(matches!(error, Error::NotFound { .. }), "{error}");
    let error = begin([1.3, 0.0, -0.5], 6.3, &ContinuationSettings::over(1.0, 1.0));
    assert!(
        matches!(error, Error::Option { name: "range", .. }),
        "{error}"
    );
    let error = begin([1.3, 0.0, 0.1], 6.3, &settings);
    assert!(
        matches!(error, Error::Parameter { value: 0.1, .. }),
        "{error}"
    );
    let error = begin([1.3, 0.0, -0.5], 6.3, &settings.forced(-1.0));
    assert!(
        matches!(error, Error::Option { name: "forced", .. }),
        "{error}"
    );
    // The last component is a state, not a parameter.
    let lorenz = crate::smooth::Smooth(crate::smooth::Lorenz);
    let error = continue_periodic_orbit(
        &lorenz.dynamics(),
        [1.0, 1.0, 20.0],
        1.0,
        true,
        &settings,
        &options,
    );
    let error = error.unwrap_err();
    assert!(matches!(error, Error::Parameter { .. }), "{error}");
}

/// The saddle of [`Belt`] on its slow side, where x - x³ is minus the friction at rest, and its
/// eigenvalues: positive, negative.
fn saddle_of_belt(speed: f64) -> (f64, [f64; 2]) {
    let resting = Area::FRICTION / (1.0 + speed);
    let mut x = 0.0;
    for _ in 0..50 {
        x = x * x * x - resting;
    }
    let trace = resting / (1.0 + speed);
    let root = (0.25 * trace * trace + 1.0 - 3.0 * x * x).sqrt();
    (x, [0.5 * trace + root, 0.5 * trace - root])
}

/// Whether the orbit that leaves the saddle to the left returns above the stable manifold and
/// leaves the saddle to the right.
fn comes_back_above(speed: f64) -> bool {
    let (saddle, [leaves, comes]) = saddle_of_belt(speed);
    let start = [saddle - 1e-6, -1e-6 * leaves, speed];
    let orbit = stickslip::solve(&Belt, 0.0, start, 60.0, &Options::tol(1e-13)).unwrap();
    // Along the left eigenvector: the growing component.
    let growing = |t: f64| {
        let x = orbit.at(t).unwrap();
        x[1] - comes * (x[0] - saddle)
    };
    let away = |t: f64| (orbit.at(t).unwrap().xy() - nalgebra::Vector2::new(saddle, 0.0)).norm();
    let times = || (1000..3000).map(|k| f64::from(k) * 0.02);
    // The first departure and the return.
    let left = times().find(|&t| away(t) > 1.0).unwrap();
    let back = times().find(|&t| t > left && away(t) < 0.05).unwrap();
    let leaves = times().find(|&t| t > back && growing(t).abs() > 0.2);
    growing(leaves.unwrap()) > 0.0
}

/// Next to a saddle neighbours separate by e^(2 · 16), and the multiplier is what remains.
/// Liouville's formula gives it from areas, without that cancellation.
#[test]
fn a_cycle_is_followed_to_its_homoclinic_end_with_the_multiplier_of_its_area() {
    let settings = ContinuationSettings {
        step: 0.01,
        ..ContinuationSettings::over(0.1, 1.0)
    };
    let found = branch(&Belt, [-0.27, -0.73, 1.0], (7.7, false), &settings);
    let last = found.points.last().unwrap();
    assert!(last.period > 30.0, "{}", last.period);
    assert!(
        found.points.len() > 20 && found.special.is_empty(),
        "{} {:?}",
        found.points.len(),
        found.special
    );
    let (_, exact_rates) = saddle_of_belt(last.parameter);
    for point in &found.points {
        let start = State::from([point.x[0], point.x[1], point.parameter, 0.0]);
        let t_end = point.t + point.period;
        let options = Options::tol(1e-13);
        let orbit = stickslip::solve(&Area.any(), point.t, start, t_end, &options).unwrap();
        let mut log_area = orbit.x_end[3];
        for at in &orbit.transitions {
            let rate = |side: Side| Area.field(side, at.t, &at.x.into())[1];
            let (Mode::Slip(from), Mode::Slip(to)) = (at.from, at.to) else {
                panic!("sticks at {}", point.parameter);
            };
            log_area += math::ln(rate(to) / rate(from));
        }
        let exact = math::exp(log_area);
        let error = (point.multipliers[0].re / exact - 1.0).abs();
        // A hundred tolerances of the orbit, separated over the half of the period next to the
        // saddle. Further on, the saddle's neighbourhood is smaller than the square root of a
        // tolerance.
        if point.period > 33.0 {
            continue;
        }
        let allowed = 1e-11 * math::exp(exact_rates[0] * 0.5 * point.period);
        assert!(
            error < allowed,
            "{}: {} for {exact}, {error:e} of {allowed:e}",
            point.period,
            point.multipliers[0]
        );
        assert_eq!(point.stability(), Stability::Stable);
    }
    let Stop::Homoclinic {
        parameter,
        uncertainty,
        saddles,
        leaves,
        comes,
    } = found.stop
    else {
        panic!("{:?}", found.stop);
    };
    assert_eq!(saddles.get(), 1);
    assert!((parameter - last.parameter).abs() < 1e-9, "{parameter}");
    assert!(uncertainty < 1e-10, "{uncertainty:e}");
    assert!((leaves - exact_rates[0]).abs() < 1e-9, "{leaves}");
    assert!((comes - exact_rates[1]).abs() < 1e-9, "{comes}");
    let (mut low, mut high) = (0.7735, 0.7745);
    let at_low = comes_back_above(low);
    assert_ne!(at_low, comes_back_above(high));
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if comes_back_above(middle) == at_low {
            low = middle;
        } else {
            high = middle;
        }
    }
    assert!((parameter - low).abs() < 1e-10, "{parameter}, known {low}");
    for (tolerance, options) in accuracies() {
        let (start, way) = ([-0.27, -0.73, 1.0], (7.7, false));
        let found = branch_by(&Belt, start, way, &settings, &options);
        let [off, uncertainty] = homoclinic_end(&found.stop, low);
        assert!(
            off < tolerance && off <= uncertainty && uncertainty < 10.0 * tolerance + 1e-11,
            "{tolerance:e}: {off:e} of {uncertainty:e}"
        );
    }
}

/// The error of the parameter of a homoclinic end, and its uncertainty.
fn homoclinic_end(stop: &Stop, exact: f64) -> [f64; 2] {
    let Stop::Homoclinic {
        parameter,
        uncertainty,
        ..
    } = stop
    else {
        panic!("{stop:?}");
    };
    [(parameter - exact).abs(), *uncertainty]
}

#[test]
fn a_branch_left_anywhere_goes_on_with_the_same_bits() {
    let system = Rings { place: 50.0 };
    let (system, options) = (system.dynamics(), Options::tol(1e-13));
    let start = [(1.0 + 0.5_f64.sqrt()).sqrt(), 0.0, -0.5];
    let begin = |settings: &ContinuationSettings| {
        PartialBranch::begin(&system, start, 2.0 * PI, false, settings, &options).unwrap()
    };
    // Around the fold to an equilibrium and to an end of the range, where the branch stops.
    for (low, stops_at_end) in [(-1.5, false), (-0.8, true), (-0.5, true)] {
        let settings = ContinuationSettings::over(low, 0.5);
        let mut seen: Vec<PartialBranch> = Vec::new();
        let all = |branch: &PartialBranch| {
            seen.push(branch.clone());
            ControlFlow::Continue(())
        };
        let whole = begin(&settings).follow(&system, &settings, &options, all);
        let whole = whole.unwrap();
        assert_eq!(whole.stop == Stop::Range, stops_at_end, "{:?}", whole.stop);
        assert_eq!(seen.is_empty(), low == -0.5);
        for part in seen {
            let points = part.points().to_vec();
            assert_eq!(whole.points[..points.len()], points);
            let none = |_: &PartialBranch| ControlFlow::Break(());
            let left = part.clone().follow(&system, &settings, &options, none);
            let left = left.unwrap();
            assert_eq!((left.stop, left.points), (Stop::Points, points));
            let again = |_: &PartialBranch| ControlFlow::Continue(());
            let again = part.follow(&system, &settings, &options, again);
            assert_eq!(again.unwrap(), whole);
        }
    }
}

/// Whether the orbit that leaves the saddle at -1 passes the one at 1.
fn passes(parameter: f64) -> bool {
    let half_trace = 0.5 * Softening::PULL * (parameter - 1.0);
    let leaves = half_trace + (half_trace * half_trace + 2.0).sqrt();
    let start = [-1.0 + 1e-8, 1e-8 * leaves, parameter];
    let options = Options::tol(1e-13).escape(1.5);
    let Err(failure) = stickslip::solve(&Smooth(Softening), 0.0, start, 60.0, &options) else {
        return false;
    };
    assert!(matches!(failure.error, Error::Escaped { .. }), "{failure}");
    true
}

/// Along v = (1 - x²)/√2, from saddle to saddle, forcing and damping do the same work where p ∫v dx
/// = ∫x² v dx. That is at p = 1/5 up to the square of the forcing (Melnikov). Bisection gives the
/// exact location.
#[test]
fn a_cycle_is_followed_to_two_saddles() {
    let settings = ContinuationSettings {
        step: 0.05,
        ..ContinuationSettings::over(0.02, 0.5)
    };
    let near = [0.63, 0.0, 0.1];
    let settled = stickslip::solve(&Smooth(Softening), 0.0, near, 3000.0, &Options::tol(1e-12));
    let start = settled.unwrap().x_end;
    // From too short a period Newton's iteration leads to orbits that escape, in ever shorter
    // steps.
    let options = Options::tol(1e-13);
    let system = Smooth(Softening);
    let lost = continue_periodic_orbit(&system.dynamics(), start, 7.4, true, &settings, &options);
    assert!(matches!(lost, Err(Error::NotFound { .. })), "{lost:?}");
    let found = branch(&system, start.into(), (7.6, true), &settings);
    let Stop::Homoclinic {
        parameter,
        uncertainty,
        saddles,
        leaves,
        comes,
    } = found.stop
    else {
        panic!("{:?}", found.stop);
    };
    assert_eq!(saddles.get(), 2);
    let (mut low, mut high) = (0.19, 0.21);
    assert!(!passes(low) && passes(high));
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if passes(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    assert!((low - 0.2).abs() < Softening::PULL * Softening::PULL);
    let last = found.points.last().unwrap().parameter;
    let [off, before] = [parameter, last].map(|value| (value - low).abs());
    assert!(off < 0.2 * before && off < uncertainty, "{off:e}");
    assert!(uncertainty < 2.0 * before && before < 1e-4, "{before:e}");
    // Each saddle, at the last orbit's parameter, has the trace pull (p - 1) and the determinant
    // -2.
    let half_trace = 0.5 * Softening::PULL * (last - 1.0);
    let root = (half_trace * half_trace + 2.0).sqrt();
    assert!((leaves - (half_trace + root)).abs() < 1e-9, "{leaves}");
    assert!((comes - (half_trace - root)).abs() < 1e-9, "{comes}");
    for (tolerance, options) in accuracies() {
        let found = branch_by(&system, start.into(), (7.6, true), &settings, &options);
        let [off, uncertainty] = homoclinic_end(&found.stop, low);
        // Each saddle amplifies rounding by the inverse of the distance, which therefore remains
        // above the root of what it is with one saddle.
        assert!(
            off < 1e-7 && off <= uncertainty && uncertainty < 2e-6,
            "{tolerance:e}: {off:e} of {uncertainty:e}"
        );
    }
}

/// The half of a symmetric orbit, from one exit of stick to that of the other sign, has the
/// multiplier -1 there. The values are from matrix exponentials with 22 digits. Newton's matrix is
/// singular at these points, and short steps next to the first must not end the branch.
#[test]
fn points_at_which_symmetry_breaks_are_found_with_any_step() {
    const POINTS: [f64; 2] = [1.955_032_552_903_879, 2.046_729_920_873_024];
    let options = Options::tol(1e-12);
    let begin = [0.0, 1.0, 3.0, 1.9];
    let settled = solve(&Resonant.any(), 0.0, begin, 400.0, &options).unwrap();
    let (start, period) = (settled.x_end, 2.5408);
    for step in [0.005, 0.02, 0.05] {
        let settings = ContinuationSettings {
            step,
            ..ContinuationSettings::over(1.5, 2.2)
        };
        let found = continue_periodic_orbit(
            &Resonant.dynamics(),
            start,
            period,
            false,
            &settings,
            &options,
        );
        let found = found.unwrap();
        let points = found
            .special
            .iter()
            .filter(|at| at.what == CycleBifurcation::BranchPoint);
        let places: Vec<_> = points.collect();
        assert_eq!(places.len(), POINTS.len(), "{step}: {:?}", found.special);
        // The branch reaches them from its fold at 2.047.
        for (at, exact) in places.iter().zip(POINTS.into_iter().rev()) {
            let off = (at.parameter - exact).abs();
            let bound = at.uncertainty;
            assert!(off < bound && bound < 1e-9, "{step}: {off:e} for {bound:e}");
        }
    }
}
