//! Coulomb friction on a belt: arcs of circles about ±μ0, so that trigonometry gives every event.

use std::f64::consts::PI;

use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed};
use stickslip::{Mode, Side, State, TransitionKind, math};

use super::super::check::{TIGHT, assert_consistent, changes, exact_locators};
use crate::any_system::solve;
use crate::solver::systems::coulomb_friction;

/// An event by trigonometry: time, position, next mode, and the rate at which Σ is met.
struct Event {
    t: f64,
    x: f64,
    to: Mode,
    rate: f64,
}

/// Clockwise angle from `(x0, v0)` to `(x1, v1)` about `(centre, 0)`. With unit stiffness and mass
/// it equals the time.
fn turn(centre: f64, (x0, v0): (f64, f64), (x1, v1): (f64, f64)) -> f64 {
    let angle = math::atan2(v0, x0 - centre) - math::atan2(v1, x1 - centre);
    if angle <= 0.0 {
        angle + 2.0 * PI
    } else {
        angle
    }
}

/// Events from a start below Σ up to the exit from the first stick; empty if Σ is never met.
fn trigonometry(mu0: f64, vp: f64, x0: f64, v0: f64) -> Vec<Event> {
    let mut events: Vec<Event> = Vec::new();
    let (mut t, mut from, mut side) = (0.0, (x0, v0), Side::Below);
    loop {
        let centre = -mu0 * side.sign();
        // Σ is met on the circle's left from below, on its right from above.
        let square = (from.0 - centre) * (from.0 - centre) + from.1 * from.1 - vp * vp;
        if square < 0.0 {
            return events;
        }
        let reach = square.sqrt();
        let x = centre + reach * side.sign();
        t += turn(centre, from, (x, vp));
        from = (x, vp);
        let sticks = x.abs() <= mu0;
        let to = if sticks {
            Mode::Stick
        } else {
            Mode::Slip(side.opposite())
        };
        events.push(Event {
            t,
            x,
            to,
            rate: reach,
        });
        if sticks {
            let exit = t + (mu0 - x) / vp;
            events.push(Event {
                t: exit,
                x: mu0,
                to: Mode::Slip(Side::Below),
                rate: 1.0,
            });
            return events;
        }
        side = side.opposite();
    }
}

fn seeded(cases: u32) -> Config {
    Config {
        cases,
        rng_seed: RngSeed::Fixed(20_131),
        failure_persistence: None,
        ..Config::default()
    }
}

proptest! {
    #![proptest_config(seeded(300))]

    #[test]
    fn every_event_is_where_trigonometry_has_it(
        mu0 in 0.05..1.5f64, vp in 0.05..1.0f64, x0 in -4.0..4.0f64, below in 1e-3..4.0f64,
        locator in prop::sample::select(exact_locators()),
    ) {
        let belt = coulomb_friction(mu0, vp);
        let v0 = vp - below;
        let exact = trigonometry(mu0, vp, x0, v0);
        // To the end of the first stick and five turns further.
        let t_end = exact.last().map_or(5.0, |e| e.t) + 10.0 * PI + 1.0;
        let options = super::super::tol(TIGHT).locator(locator);
        let orbit = solve(&belt, 0.0, State::from([x0, v0]), t_end, &options).expect("runs");
        assert_consistent(&belt, &orbit);
        let found = changes(&orbit);
        // A circle that only just reaches Σ, to the tolerance of the run, may or may not meet it.
        let least = exact.iter().map(|e| e.rate).fold(1.0, f64::min);
        prop_assume!(least > 1e-4);
        prop_assert_eq!(found.len(), exact.len(), "{:?}", found);
        // Errors of 1e-13 per step (times |x| <= 6) over up to a hundred steps. An event's time has
        // the radius's error divided by the rate, and inherits the errors of earlier events.
        let mut allowed = 0.0;
        for (event, exact) in found.iter().zip(&exact) {
            allowed += 3e-12 / exact.rate;
            prop_assert_eq!(event.to, exact.to);
            prop_assert!((event.t - exact.t).abs() < allowed, "t {} {}", event.t, exact.t);
            prop_assert!((event.x[0] - exact.x).abs() < allowed, "x {} {}", event.x[0], exact.x);
        }
        if let Some(stick) = orbit.sticks().next() {
            let end = if exact.is_empty() { stick.x_end[0] } else { mu0 };
            let length = stick.displacement()[0] - vp * stick.duration();
            // Every step rounds position and time once. Its weights add up to 13.6 in magnitude,
            // and so do their partial sums.
            let of_weights = 28.0 * f64::EPSILON * vp * stick.duration();
            prop_assert!((stick.x_end[0] - end).abs() <= 4.0 * f64::EPSILON + of_weights);
            // The acceleration in stick is zero, but is a difference of forces up to |x| + mu0. Its
            // rounding moves the body by half of it times the square of the step.
            let mut allowed = of_weights;
            for step in orbit.steps.iter().filter(|s| s.mode == Mode::Stick) {
                let force = mu0 + step.x_start[0].abs().max(step.x_end[0].abs());
                let h = step.t_end - step.t_start;
                allowed += f64::EPSILON * (mu0 + vp * stick.t_end + force * 0.5 * h * h);
            }
            prop_assert!(length.abs() <= allowed, "{length} {allowed}");
        }
    }

    #[test]
    fn after_the_stick_there_are_touches_at_most(
        mu0 in 0.05..1.5f64, vp in 0.05..1.0f64,
        tolerance in prop::sample::select(vec![1e-13, 1e-11, 1e-9]),
    ) {
        let belt = coulomb_friction(mu0, vp);
        let start = State::from([0.5 * mu0, vp]);
        let t_exit = 0.5 * mu0 / vp;
        let options = super::super::tol(tolerance);
        let orbit = solve(&belt, 0.0, start, t_exit + 40.5 * PI, &options).expect("runs");
        assert_consistent(&belt, &orbit);
        prop_assert_eq!(orbit.phases.len(), 2, "{:?}", orbit.phases);
        for touch in &orbit.transitions[1..] {
            prop_assert_eq!(touch.kind, TransitionKind::Touch);
            let turns = (touch.t - t_exit) / (2.0 * PI);
            // The position of a touch is accurate to the square root of its depth, ten tolerances.
            let allowed = (40.0 * tolerance / vp).sqrt() + 20.0 * tolerance;
            prop_assert!((turns - turns.round()).abs() < allowed, "{turns}");
        }
        prop_assert!(orbit.steps.len() < 20_000, "it must not creep: {} steps", orbit.steps.len());
    }
}

#[test]
fn the_exact_circle_starts_at_the_tangent_point_without_a_stick() {
    let belt = coulomb_friction(0.4, 0.25);
    let orbit = solve(
        &belt,
        0.0,
        State::from([0.4, 0.25]),
        63.0,
        &super::super::tol(TIGHT),
    )
    .expect("runs");
    assert_consistent(&belt, &orbit);
    assert_eq!(orbit.phases.len(), 1);
    assert_eq!(orbit.phases[0].mode, Mode::Slip(Side::Below));
}
