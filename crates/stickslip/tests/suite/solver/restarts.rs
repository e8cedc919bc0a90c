//! Starts on Σ: at tangent points, at two-folds, where Σ repels, and at every transition of another
//! run.

use std::f64::consts::{FRAC_PI_2, PI};

use stickslip::{AtRepelling, Ending, Fate, Mode, Side, State, fate, math};

use super::check::{TIGHT, assert_consistent, kinds};
use crate::any_system::solve;
use crate::blocks::Block;
use crate::compiled::Compiled;
use crate::constant_fields::ConstantFields;
use crate::solver::systems::{
    MovingLine, TurningLine, TwoFold, coulomb_friction, decaying_friction,
};

const BELOW: Mode = Mode::Slip(Side::Below);
const ABOVE: Mode = Mode::Slip(Side::Above);

#[test]
fn each_of_the_six_tangent_points_is_left_the_way_its_visibility_says() {
    // μ0 = √3/9: x - x³ = ∓μ0 where 3θ = ±60° and so on. The field moves along Σ with speed vp, so
    // the normal component changes at the rate vp (1 - 3x²). Below, the point is visible where that
    // is negative, above where it is positive.
    let scale = 2.0 / 3f64.sqrt();
    let points = [
        (math::cos(PI / 9.0), BELOW),
        (math::cos(2.0 * PI / 9.0), Mode::Stick),
        (math::sin(PI / 18.0), ABOVE),
        (-math::sin(PI / 18.0), Mode::Stick),
        (-math::cos(2.0 * PI / 9.0), BELOW),
        (-math::cos(PI / 9.0), Mode::Stick),
    ];
    for belt_speed in [1.0, 0.4] {
        let belt = Block::on_belt(belt_speed);
        for (factor, mode) in points {
            let start = State::from([scale * factor, belt_speed]);
            let orbit = solve(&belt, 0.0, start, 0.05, &super::tol(TIGHT)).expect("runs");
            assert_consistent(&belt, &orbit);
            assert_eq!(
                orbit.phases[0].mode, mode,
                "x = {}, vp = {belt_speed}",
                start[0]
            );
            assert!(
                orbit.transitions.is_empty(),
                "x = {}: {:?}",
                start[0],
                orbit.transitions
            );
            // The run continues for long without errors.
            let orbit = solve(&belt, 0.0, start, 100.0, &super::tol(TIGHT)).expect("runs");
            assert_consistent(&belt, &orbit);
        }
    }
}

/// Asserts that a run started at any transition of an orbit repeats the rest of the orbit.
fn assert_repeats<S: Compiled<N>, const N: usize>(
    what: &str,
    system: &S,
    t0: f64,
    x0: State<N>,
    t_end: f64,
) {
    let options = super::tol(TIGHT);
    let orbit = solve(system, t0, x0, t_end, &options).expect("runs");
    assert_consistent(system, &orbit);
    assert!(orbit.transitions.len() > 3, "{what}");
    let mut worst = 0.0f64;
    for (k, start) in orbit.transitions.iter().enumerate() {
        let again = solve(system, start.t, start.x, t_end, &options).expect("runs");
        assert_consistent(system, &again);
        assert_eq!(
            again.phases[0].mode, start.to,
            "{what}: transition {k}, {start:?}"
        );
        assert_eq!(
            kinds(&again),
            kinds(&orbit)[k + 1..],
            "{what}: after transition {k}"
        );
        for (found, first) in again.transitions.iter().zip(&orbit.transitions[k + 1..]) {
            worst = worst
                .max((found.t - first.t).abs())
                .max((found.x - first.x).amax());
        }
    }
    // Other steps have other errors of 1e-13. The orbits attract or, over few transitions, amplify
    // errors by thousands.
    assert!(worst < 1e-9, "{what}: {worst}");
}

#[test]
fn a_run_from_any_transition_repeats_the_rest() {
    assert_repeats(
        "cycle",
        &Block::on_belt(1.0),
        0.0,
        State::from([0.5, 1.5]),
        60.0,
    );
    let slow = Block::on_belt(0.4);
    assert_repeats("slow belt", &slow, 0.0, State::from([0.5, 1.5]), 40.0);
    assert_repeats(
        "decaying",
        &decaying_friction(),
        0.0,
        State::from([0.04, -0.01]),
        60.0,
    );
    assert_repeats(
        "moving",
        &MovingLine { a: 0.3 },
        FRAC_PI_2,
        State::from([1.0]),
        60.0,
    );
    assert_repeats(
        "moving",
        &MovingLine { a: 0.9 },
        FRAC_PI_2,
        State::from([1.0]),
        60.0,
    );
    assert_repeats(
        "forced",
        &Block::shaken(),
        0.0,
        State::from([0.1, 0.2]),
        8.0,
    );
}

#[test]
fn the_end_of_a_stick_is_a_start_like_any_other() {
    let belt = coulomb_friction(0.3, 0.2);
    for end in [0.3, 0.3 * (1.0 - f64::EPSILON), 0.3 * (1.0 + f64::EPSILON)] {
        let orbit =
            solve(&belt, 0.0, State::from([end, 0.2]), 6.0, &super::tol(TIGHT)).expect("runs");
        assert_consistent(&belt, &orbit);
        assert_eq!(orbit.phases.last().map(|p| p.mode), Some(BELOW), "{end}");
        assert!(orbit.phases.len() <= 2, "{end}: {:?}", orbit.phases);
        // Six time units are less than the turn after which the circle returns.
        assert!(
            (orbit.x_end - State::from([0.3 + 0.2 * math::sin(6.0), 0.2 * math::cos(6.0)])).amax()
                < 1e-11
        );
    }
}

#[test]
fn where_the_boundary_repels_the_run_ends_or_goes_where_it_is_reported() {
    let system = ConstantFields {
        below: -1.0,
        above: 1.0,
    };
    let start = State::from([0.0]);
    let orbit = solve(&system, 2.0, start, 5.0, &super::tol(TIGHT)).expect("runs");
    assert_eq!(orbit.ending, Ending::Repelling);
    assert_eq!((orbit.t_end, orbit.x_end), (2.0, start));
    assert!(orbit.phases.is_empty() && orbit.steps.is_empty() && orbit.transitions.is_empty());
    assert_eq!(orbit.at(2.0).expect("the start"), start);
    for (choice, mode, sign) in [
        (AtRepelling::GoBelow, BELOW, -1.0),
        (AtRepelling::GoAbove, ABOVE, 1.0),
    ] {
        let options = super::tol(TIGHT).at_repelling(choice);
        let orbit = solve(&system, 2.0, start, 5.0, &options).expect("runs");
        assert_consistent(&system, &orbit);
        assert_eq!(
            (orbit.ending, orbit.phases.len(), orbit.phases[0].mode),
            (Ending::EndTime, 1, mode)
        );
        assert!((orbit.x_end[0] - 3.0 * sign).abs() < 1e-14);
    }
}

#[test]
fn a_field_along_the_boundary_does_not_lead_away_from_it() {
    for (below, above, wanted) in [
        (0.0, -1.0, Fate::Stick),
        (1.0, 0.0, Fate::Stick),
        (0.0, 1.0, Fate::Slip(Side::Above)),
        (-1.0, 0.0, Fate::Slip(Side::Below)),
    ] {
        let line = ConstantFields { below, above };
        let found = fate(&line.any(), 0.0, &State::from([0.0]));
        assert_eq!(found, wanted, "{below} {above}");
    }
}

#[test]
fn a_boundary_that_becomes_repelling_while_slid_on_ends_the_run_there() {
    for speed in [0.0, 0.1] {
        let system = TurningLine { speed };
        let start = State::from([0.1]);
        let orbit = solve(&system, 0.0, start, 3.0, &super::tol(TIGHT)).expect("runs");
        assert_eq!(orbit.ending, Ending::Repelling);
        // Located as a zero of cos t, with slope one.
        assert!((orbit.t_end - FRAC_PI_2).abs() < 1e-14, "{}", orbit.t_end);
        assert_eq!(orbit.phases.last().map(|p| p.mode), Some(Mode::Stick));
        let options = super::tol(TIGHT).at_repelling(AtRepelling::GoBelow);
        let orbit = solve(&system, 0.0, start, 3.0, &options).expect("runs");
        assert_consistent(&system, &orbit);
        assert_eq!(orbit.phases.last().map(|p| p.mode), Some(BELOW));
        let exact = speed * 4.5 - (1.0 - math::sin(3.0));
        assert!(
            (orbit.x_end[0] - exact).abs() < 1e-11,
            "{} {exact}",
            orbit.x_end[0]
        );
    }
}

#[test]
fn two_folds_are_left_as_both_visibilities_say() {
    let run = |below: f64, above: f64, x: [f64; 2]| {
        let system = TwoFold { below, above };
        let orbit = solve(&system, 0.0, State::from(x), 2.0, &super::tol(TIGHT)).expect("runs");
        if orbit.ending == Ending::EndTime {
            assert_consistent(&system, &orbit);
        }
        orbit
    };
    // Visible from both sides: no unique future.
    assert_eq!(run(-1.0, 1.0, [0.0, 0.0]).ending, Ending::Repelling);
    // Visible from one side: the orbit goes there, along a parabola.
    let orbit = run(-1.0, -2.0, [0.0, 0.0]);
    assert_eq!((orbit.phases.len(), orbit.phases[0].mode), (1, BELOW));
    assert!((orbit.x_end[1] + 2.0).abs() < 1e-13);
    let orbit = run(1.0, 2.0, [0.0, 0.0]);
    assert_eq!((orbit.phases.len(), orbit.phases[0].mode), (1, ABOVE));
    assert!((orbit.x_end[1] - 4.0).abs() < 1e-13);
}
