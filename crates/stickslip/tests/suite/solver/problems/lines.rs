//! Systems in closed form: a spiral that is crossed, a line on which orbits slide, and a moving
//! line.

use stickslip::TransitionKind::{Crossing, StickEntry};
use stickslip::{Mode, Side, State, math};

use super::super::check::{
    TIGHT, assert_consistent, assert_lands_on_boundary, every_locator, kinds,
};
use crate::any_system::solve;
use crate::constant_fields::ConstantFields;
use crate::solver::systems::{Breathing, MovingLine, Spiral};

#[test]
fn the_spiral_crosses_the_circle_at_time_one() {
    for options in every_locator() {
        let start = State::from([math::exp(-1.0), 0.0]);
        let orbit = solve(&Spiral, 0.0, start, 2.3, &options).expect("runs");
        assert_eq!(kinds(&orbit), [Crossing]);
        assert_consistent(&Spiral, &orbit);
        let crossing = orbit.transitions[0];
        // One turn in forty steps with errors of 1e-13, at a radius that grows as fast as the
        // error.
        assert!((crossing.t - 1.0).abs() < 1e-12, "{}", crossing.t);
        assert!(
            (crossing.x - State::from([1.0, 0.0])).amax() < 1e-11,
            "{}",
            crossing.x
        );
        for t in [1.1, 1.7, 2.3] {
            let angle = 2.0 * std::f64::consts::PI * (t - 1.0);
            let exact = State::from([math::cos(angle), -math::sin(angle)]) * math::exp(t - 1.0);
            let error = (orbit.at(t).expect("inside") - exact).amax();
            assert!(error < 1e-11, "t = {t}: {error}");
        }
    }
}

#[test]
fn a_line_that_attracts_is_reached_and_kept() {
    for options in every_locator() {
        let system = ConstantFields {
            below: 3.0,
            above: -1.0,
        };
        let orbit = solve(&system, 0.0, State::from([-1.0]), 50.0, &options).expect("runs");
        assert_eq!(kinds(&orbit), [StickEntry]);
        assert!((orbit.transitions[0].t - 1.0 / 3.0).abs() < 1e-15);
        assert_eq!(orbit.x_end[0], 0.0);
        assert_consistent(&system, &orbit);
    }
}

/// The orbit of [`MovingLine`] from Σ at π/2, from its closed form alone. It has straight lines off
/// Σ; a scan and bisection find where they meet it. On Σ it has the normal components `±a - cos t`.
fn reference(a: f64, t_end: f64) -> Vec<(f64, Mode)> {
    let lift = math::acos(a);
    let (mut t, mut events) = (std::f64::consts::FRAC_PI_2, Vec::new());
    loop {
        // It slides until |cos t| = a, and leaves upwards where the line falls, downwards where it
        // rises.
        let pi = std::f64::consts::PI;
        let mut half_turns = 0.0;
        while half_turns * pi + pi - lift <= t {
            half_turns += 1.0;
        }
        t = half_turns * pi + pi - lift;
        let mut side = if half_turns as i64 % 2 == 0 {
            Side::Above
        } else {
            Side::Below
        };
        if t > t_end {
            return events;
        }
        events.push((t, Mode::Slip(side)));
        loop {
            let (from, height) = (t, math::sin(t));
            let clearance =
                |t: f64| side.sign() * (height - side.sign() * a * (t - from) - math::sin(t));
            let mut ahead = from + 1e-3;
            while clearance(ahead) > 0.0 {
                ahead += 1e-3;
            }
            let (mut low, mut high) = (ahead - 1e-3, ahead);
            while high - low > 4.0 * f64::EPSILON * high {
                let middle = 0.5 * (low + high);
                if clearance(middle) > 0.0 {
                    low = middle
                } else {
                    high = middle
                }
            }
            t = low;
            if t > t_end {
                return events;
            }
            if math::cos(t).abs() < a {
                events.push((t, Mode::Stick));
                break;
            }
            side = side.opposite();
            events.push((t, Mode::Slip(side)));
        }
    }
}

#[test]
fn a_moving_line_is_left_met_and_crossed_as_in_closed_form() {
    let mut crossings = 0;
    for a in [0.05, 0.1, 0.2, 0.3, 0.45, 0.6, 0.7, 0.8, 0.9, 0.97] {
        let expected = reference(a, 40.0);
        for options in every_locator() {
            let system = MovingLine { a };
            let start = std::f64::consts::FRAC_PI_2;
            let orbit = solve(&system, start, State::from([1.0]), 40.0, &options).expect("runs");
            assert_consistent(&system, &orbit);
            assert_lands_on_boundary(&system, &orbit);
            let found: Vec<_> = orbit.transitions.iter().map(|e| (e.t, e.to)).collect();
            assert_eq!(
                found.len(),
                expected.len(),
                "a = {a}: {found:?} {expected:?}"
            );
            // Rounding of the time (up to 40) enters the line's height; the rate across Σ divides
            // it.
            for (event, exact) in found.iter().zip(&expected) {
                let rate = (math::cos(exact.0).abs() - a).abs().max(1e-3);
                let error = (event.0 - exact.0).abs();
                assert_eq!(event.1, exact.1, "a = {a}, t = {}", exact.0);
                assert!(error < 1e-12 / rate, "a = {a}, t = {}: {error}", exact.0);
            }
            crossings += kinds(&orbit).iter().filter(|k| **k == Crossing).count();
        }
    }
    assert!(
        crossings > 20,
        "some of the meetings must be crossings, or half the rule goes untried"
    );
}

#[test]
fn nothing_depends_on_how_long_the_steps_are() {
    let system = MovingLine { a: 0.3 };
    let start = std::f64::consts::FRAC_PI_2;
    let exact = reference(0.3, 30.0);
    for longest in [0.01, 0.1, 0.37, 1.0, 5.0] {
        for &locator in super::super::LOCATORS {
            let options = super::super::tol(TIGHT)
                .locator(locator)
                .longest_step(longest);
            let orbit = solve(&system, start, State::from([1.0]), 30.0, &options).expect("runs");
            let found: Vec<_> = orbit.transitions.iter().map(|e| e.to).collect();
            assert_eq!(
                found,
                exact.iter().map(|e| e.1).collect::<Vec<_>>(),
                "{longest} {locator:?}"
            );
        }
    }
}

#[test]
fn the_adaptive_run_keeps_its_tolerance() {
    for tolerance in [1e-6, 1e-9, 1e-12] {
        let orbit = solve(
            &Breathing { ceiling: 10.0 },
            0.0,
            State::from([1.0]),
            30.0,
            &super::super::tol(tolerance),
        )
        .expect("runs");
        let ends = orbit.steps.iter().fold(0.0f64, |worst, step| {
            worst.max((step.x_end[0] - math::exp(math::sin(step.t_end))).abs())
        });
        // A step errs by at most atol + rtol |x| <= 3.8 tolerances, which the flow amplifies by at
        // most e².
        let steps = orbit.steps.len() as f64;
        assert!(ends < steps * 3.8 * math::exp(2.0) * tolerance, "{ends}");
    }
}
