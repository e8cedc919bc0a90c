//! Difficult cases: on Σ to rounding only, at two-folds, at the edge of a field's domain, at
//! accumulating transitions, and with long steps.

use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::ControlFlow;
use std::sync::atomic::AtomicU64;

use stickslip::TransitionKind::{ContactGain, ContactLoss, Crossing, StickEntry, StickExit, Touch};
use stickslip::{
    AtRepelling, Ending, Error, Mode, Observer, Options, Phase, State, StepRecord, Transition,
    TransitionKind, math,
};

use super::check::{TIGHT, assert_consistent, every_locator, kinds};
use crate::any_system::{run, solve};
use crate::blocks::Bracket;
use crate::compiled::Compiled;
use crate::den_hartog::DenHartog;
use crate::solver::systems::{
    BlowUp, Breathing, Ceiling, ComesToRest, Dip, Floor, Parabola, TurningLine, TwoFold, Zeno,
    decaying_friction,
};

#[test]
fn a_state_on_the_boundary_to_rounding_is_on_it() {
    // The floor's Σ is at zero velocity; rounding may leave a velocity of 1e-17.
    for velocity in [0.0, 1e-17, -1e-17, 1e-300, -1e-300] {
        let start = State::from([0.1, velocity]);
        let orbit = solve(&Floor, 0.0, start, 1.0, &super::tol(TIGHT)).expect("runs");
        assert_consistent(&Floor, &orbit);
        assert_eq!(
            orbit.phases.last().map(|p| p.mode),
            Some(Mode::Stick),
            "{velocity}"
        );
        let start = State::from([-2.2, velocity]);
        let orbit = solve(&Floor, 0.0, start, 1.0, &super::tol(TIGHT)).expect("runs");
        assert_consistent(&Floor, &orbit);
    }
}

#[test]
fn a_run_from_any_transition_of_the_floor_repeats_the_rest() {
    let options = super::tol(TIGHT);
    let orbit = solve(&Floor, 0.0, State::from([3.0, 0.0]), 20.0, &options).expect("runs");
    for (k, start) in orbit.transitions.iter().enumerate() {
        let again = solve(&Floor, start.t, start.x, 20.0, &options).expect("runs");
        assert_consistent(&Floor, &again);
        assert_eq!(
            kinds(&again),
            kinds(&orbit)[k + 1..],
            "after transition {k}"
        );
        assert!((again.x_end - orbit.x_end).amax() < 1e-11);
    }
}

#[test]
fn a_two_fold_at_the_origin_is_one_to_rounding() {
    // Stable sliding reaches x₁ = 0 at time 1; beyond it both fields point away.
    let system = TwoFold {
        below: -1.0,
        above: 1.0,
    };
    let orbit = solve(
        &system,
        0.0,
        State::from([-1.0, 0.0]),
        2.0,
        &super::tol(TIGHT),
    )
    .expect("runs");
    // The fields agree there. The orbit ends because they point away beyond it.
    assert_eq!(orbit.ending, Ending::Repelling);
    assert!((orbit.t_end - 1.0).abs() < 1e-14, "{}", orbit.t_end);
}

#[test]
fn a_two_fold_invisible_from_both_sides_is_slid_on() {
    // The weights of the sliding field are 0/0 there and have a limit: x₁' = 1.
    let system = TwoFold {
        below: 1.0,
        above: -1.0,
    };
    let orbit = solve(
        &system,
        0.0,
        State::from([0.0, 0.0]),
        2.0,
        &super::tol(TIGHT),
    )
    .expect("runs");
    assert_consistent(&system, &orbit);
    assert_eq!((orbit.phases.len(), orbit.phases[0].mode), (1, Mode::Stick));
    assert!((orbit.x_end[0] - 2.0).abs() < 1e-14);
}

#[test]
fn a_moving_boundary_that_becomes_repelling_ends_the_run_there() {
    for speed in [0.7, 1.3] {
        for tolerance in [1e-13, 1e-10, 1e-7] {
            let system = TurningLine { speed };
            let options = super::tol(tolerance);
            let orbit = solve(&system, 0.0, State::from([0.1]), 3.0, &options).expect("runs");
            assert_eq!(orbit.ending, Ending::Repelling);
            assert!((orbit.t_end - FRAC_PI_2).abs() < 1e-13, "{}", orbit.t_end);
            let options = options.at_repelling(AtRepelling::GoBelow);
            let orbit = solve(&system, 0.0, State::from([0.1]), 3.0, &options).expect("runs");
            let exact = speed * 4.5 - (1.0 - math::sin(3.0));
            assert!((orbit.x_end[0] - exact).abs() < 100.0 * tolerance);
        }
    }
}

#[test]
fn the_step_on_which_a_run_escapes_is_kept() {
    let options = super::tol(1e-10).escape(1e3);
    let failure = solve(&BlowUp, 0.0, State::from([0.5]), 10.0, &options).expect_err("escapes");
    let Error::Escaped { t, .. } = failure.error else {
        panic!("{}", failure.error)
    };
    assert_eq!(
        failure.partial.counters.steps as usize,
        failure.partial.steps.len()
    );
    assert_eq!(failure.partial.t_end, t);
}

#[test]
fn a_step_whose_dense_output_is_not_finite_is_not_searched_for_ever() {
    static LOOKS: AtomicU64 = AtomicU64::new(0);
    let system = ComesToRest { looks: &LOOKS };
    // Until time 2 the solution is 1 - (1 - t/2)². Then it rests at 1, at the edge of the field's
    // domain. The run must continue or end there without delay.
    let x = match solve(&system, 0.0, State::from([0.0]), 2.5, &super::tol(1e-10)) {
        Ok(orbit) => orbit.x_end[0],
        Err(failure) => {
            let (Error::StepCollapse { t, x, .. }
            | Error::NonFinite { t, x, .. }
            | Error::NotLipschitz { t, x }) = failure.error
            else {
                panic!("{}", failure.error);
            };
            // The edge is a double zero, so its time is accurate to the square root of the
            // tolerance.
            assert!(t > 2.0 - 1e-4, "{t}");
            x.0[0]
        }
    };
    assert!((x - 1.0).abs() < 1e-8, "{x}");
}

/// Ends a run that would not end.
struct StopAfter(usize);

impl Observer<2> for StopAfter {
    fn step(&mut self, step: &StepRecord<2>) -> ControlFlow<()> {
        assert!(step.t_start <= step.t_end);
        self.0 -= 1;
        if self.0 > 0 {
            ControlFlow::Continue(())
        } else {
            ControlFlow::Break(())
        }
    }
}

#[test]
fn a_pile_up_too_fast_to_be_counted_ends_the_run_all_the_same() {
    for brake in [
        0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.75, 0.8, 0.85, 0.9,
    ] {
        for tolerance in [1e-13, 1e-12, 1e-10, 1e-8] {
            let mut at_most = StopAfter(20_000);
            let start = State::from([0.0, 1.0]);
            let result = run(
                &Zeno { brake },
                0.0,
                start,
                100.0,
                &super::tol(tolerance),
                &mut at_most,
            );
            // Both fields are tangent to Σ where the excursions end. At the loosest tolerance they
            // are not followed so far, and errors of steps may keep the motion alive beside it.
            let reported = match &result {
                Ok(summary) if tolerance == 1e-8 && summary.ending == Ending::Stopped => {
                    summary.x.amax() < 200.0 * tolerance
                }
                Ok(summary) => matches!(summary.ending, Ending::TwoFold(_)),
                Err(failure) => matches!(
                    failure.error,
                    Error::EventPileUp { .. }
                        | Error::StepCollapse { .. }
                        | Error::NonFinite { .. }
                ),
            };
            assert!(reported, "{brake} {tolerance}: {result:?}");
        }
    }
}

#[test]
fn a_block_on_a_floor_that_sticks_in_every_period_goes_on() {
    // Its velocity vanishes at either end of every slip. That does not make the slip an
    // accumulation.
    let block = DenHartog {
        frequency: 0.3,
        friction: 0.6,
    };
    let orbit = solve(
        &block,
        0.0,
        State::from([0.0, 0.0]),
        1500.0,
        &super::tol(1e-9),
    );
    let orbit = orbit.expect("runs");
    assert_eq!(orbit.ending, Ending::EndTime);
    let sticks = orbit.sticks().count();
    assert!(sticks > 100, "{sticks}");
    assert!(orbit.phases.len() <= 2 * sticks + 1);
}

#[test]
fn a_short_release_far_into_a_long_step_is_no_touch() {
    // The function that ends the stick is accurate, at the release, to twice the width times the
    // error of x₁. That is far better than its slope at the start of the step, where q is as long
    // as the step.
    for (centre, width, tolerance) in [
        (10.0, 5e-6, 1e-13),
        (20.0, 1e-5, 1e-13),
        (50.0, 1e-5, 1e-13),
        (300.0, 1e-4, 1e-13),
        (50.0, 1e-3, 1e-10),
    ] {
        let dip = Dip {
            centre,
            width,
            amplitude: 0.0,
        };
        let options = super::tol(tolerance);
        let orbit =
            solve(&dip, 0.0, State::from([0.0, 0.0]), 1.5 * centre, &options).expect("runs");
        assert_eq!(
            kinds(&orbit),
            [StickExit, StickEntry],
            "width {width} at {centre}"
        );
    }
}

#[test]
fn an_event_at_which_the_rate_across_the_boundary_changes_by_factors_keeps_the_tolerance() {
    for options in every_locator() {
        // A circle 1e-2 beyond the ceiling: the rate across Σ changes by factors within a step.
        let system = Ceiling { gap: 1e-2 };
        for k in 0..12 {
            let phase = 0.4 + 0.45 * f64::from(k);
            let start = State::from([math::cos(phase), -math::sin(phase)]);
            let orbit = solve(&system, 0.0, start, 2.0 * PI, &options).expect("runs");
            assert_eq!(kinds(&orbit), [Crossing, Crossing]);
            for (event, sign) in orbit.transitions.iter().zip([-1.0, 1.0]) {
                let exact = 2.0 * PI - phase + sign * math::acos(0.99);
                assert!(
                    (event.t - exact).abs() < 1e-11,
                    "{:?}, phase {phase}: off by {}",
                    options.locator,
                    event.t - exact
                );
            }
        }
        let x0 = -1.635;
        let short = Options {
            first_step: Some(0.01),
            longest_step: 0.05,
            ..options
        };
        let start = State::from([x0, x0 * x0]);
        let orbit = solve(&Parabola { level: 0.01 }, 0.0, start, 4.0, &short).expect("runs");
        assert_eq!(kinds(&orbit), [Crossing, Crossing]);
        for (event, exact) in orbit.transitions.iter().zip([-0.1, 0.1]) {
            assert!((event.x[0] - exact).abs() < 1e-12, "{}", event.x[0]);
        }
    }
}

#[test]
fn a_graze_shallower_than_the_dense_output_is_exact_is_found() {
    // Inside a step the dense output may err by many tolerances, while the steps' ends err by one.
    // A solution that exceeds the ceiling by 25 tolerances, little more than a touch, must not seem
    // to stay below it.
    for tolerance in [1e-12, 1e-11, 1e-10, 1e-9] {
        let top = math::exp(1.0);
        let gap = 25.0 * tolerance * top;
        let system = Breathing { ceiling: top - gap };
        for k in 0..300 {
            let t = -1.5 + 0.009 * f64::from(k);
            let start = State::from([math::exp(math::sin(t))]);
            let options = super::tol(tolerance);
            let orbit = solve(&system, t, start, 3.0, &options).expect("runs");
            assert_eq!(kinds(&orbit), [Crossing, Crossing], "{tolerance} {t}");
        }
    }
}

#[test]
fn an_orbit_that_starts_without_contact_first_gains_it() {
    let model = Bracket { unloading: 3.0 };
    let start = State::from([0.1, 0.1, 0.5, 0.1]);
    assert!(model.normal_force(start.as_ref()) < 0.0);
    let orbit = solve(&model, 0.0, start, 60.0, &super::tol(1e-12)).expect("runs");
    let mut changes = orbit
        .transitions
        .iter()
        .filter(|at| matches!(at.kind, ContactGain | ContactLoss));
    for wanted in [ContactGain, ContactLoss, ContactGain] {
        let at = changes.next().expect("contact changes");
        assert_eq!(at.kind, wanted, "t = {}", at.t);
        assert!(model.normal_force(at.x.as_ref()).abs() < 1e-10);
        let after = orbit.at(at.t + 1e-3).expect("covered");
        let force = model.normal_force(after.as_ref());
        assert_eq!(force > 0.0, wanted == ContactGain, "t = {}", at.t);
    }
}

/// Records the ends of phases, and ends the run at a transition.
struct StopAtTransition {
    left: usize,
    phase_ends: Vec<f64>,
}

impl Observer<2> for StopAtTransition {
    fn transition(&mut self, _: &Transition<2>) -> ControlFlow<()> {
        self.left -= 1;
        if self.left > 0 {
            ControlFlow::Continue(())
        } else {
            ControlFlow::Break(())
        }
    }
    fn phase(&mut self, phase: &Phase<2>) -> ControlFlow<()> {
        assert_eq!(phase.t_start, *self.phase_ends.last().unwrap_or(&0.0));
        self.phase_ends.push(phase.t_end);
        ControlFlow::Continue(())
    }
}

fn assert_phases_are_reported<S: Compiled<2>>(
    system: &S,
    start: [f64; 2],
    kinds: &[TransitionKind],
) {
    let orbit = solve(system, 0.0, start, 40.0, &super::tol(1e-12)).expect("runs");
    for (i, (at, kind)) in orbit.transitions.iter().zip(kinds).enumerate() {
        assert_eq!(at.kind, *kind);
        let mut until = StopAtTransition {
            left: i + 1,
            phase_ends: vec![],
        };
        let options = super::tol(1e-12);
        let end = run(system, 0.0, start, 40.0, &options, &mut until).expect("runs");
        assert_eq!((end.ending, end.t), (Ending::Stopped, at.t));
        // This includes the phase during which a touch occurs.
        assert_eq!(until.phase_ends.last(), Some(&at.t), "{kind:?}");
        let ended = orbit.phases.iter().filter(|phase| phase.t_end <= at.t);
        let open = usize::from(*kind == Touch);
        assert_eq!(until.phase_ends.len(), ended.count() + open, "{kind:?}");
    }
    assert!(orbit.transitions.len() >= kinds.len());
}

#[test]
fn a_run_stopped_at_a_transition_has_reported_each_phase_up_to_it_once() {
    let touching = Parabola { level: 0.0 };
    assert_phases_are_reported(&touching, [-1.0, 1.0 - 1e-12], &[Touch]);
    assert_phases_are_reported(
        &Floor,
        [3.0, 0.0],
        &[Crossing, Crossing, Crossing, StickEntry],
    );
    let block = decaying_friction();
    assert_phases_are_reported(&block, [0.04, -0.01], &[StickEntry, StickExit, StickEntry]);
}
