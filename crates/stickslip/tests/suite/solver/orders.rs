//! Measured orders of convergence: of the integrators, of event times, of the Hénon step, and of
//! the dense output.

use std::f64::consts::PI;

use numerics::PowerLaw;
use stickslip::ode::{Dop853, Rk4, RungeKutta, Timed, henon_step};
use stickslip::{Locator, Method, Options, Orbit, State, math};

use super::check::changes;
use crate::any_system::{monodromy, solve};
use crate::blocks::Block;
use crate::solver::systems::{Breathing, Floor, decaying_friction};

/// Exponent of the error as a power of the step or of the tolerance.
fn order(points: &[(f64, f64)]) -> f64 {
    PowerLaw::through(points.iter().copied()).exponent
}

/// Tolerance that no step of the tests exceeds.
const LOOSE: f64 = 1e-2;

/// A fixed-step method, its expected order, and step counts over a span for which its error is
/// above rounding.
#[derive(Clone, Copy)]
enum Fixed {
    Rk4,
    Dop853,
}

impl Fixed {
    /// Steps of this length. Those of DOP853 are bounded by it, at a tolerance that they meet.
    fn options(self, step: f64) -> Options {
        match self {
            Fixed::Rk4 => Options::default().method(Method::Rk4 { step }),
            Fixed::Dop853 => Options {
                first_step: Some(step),
                ..Options::tol(LOOSE).longest_step(step)
            },
        }
    }

    fn assert_order(self, what: &str, points: &[(f64, f64)], more: f64) {
        let found = order(points);
        let (least, most) = match self {
            Fixed::Rk4 => (3.8, 4.3),
            Fixed::Dop853 => (7.5, 8.6),
        };
        let fits = least + more <= found && found <= most + more;
        assert!(fits, "{what}: order {found} from {points:?}");
    }
}

#[test]
fn a_smooth_orbit_converges_with_the_order_of_the_method() {
    for (fixed, counts) in [(Fixed::Rk4, 20..100), (Fixed::Dop853, 10..23)] {
        let points: Vec<_> = counts
            .step_by(3)
            .map(|n| {
                let step = 5.0 / f64::from(n);
                let options = fixed.options(step);
                let orbit = solve(
                    &Breathing { ceiling: 10.0 },
                    0.0,
                    State::from([1.0]),
                    5.0,
                    &options,
                )
                .expect("runs");
                (step, (orbit.x_end[0] - math::exp(math::sin(5.0))).abs())
            })
            .collect();
        fixed.assert_order("smooth", &points, 0.0);
    }
}

/// Error of an event time with `n + ½` steps to the first event. So the last step is cut at the
/// same fraction for all `n`.
fn event_errors(
    fixed: Fixed,
    locator: Locator,
    counts: &[u32],
    span: f64,
    run: impl Fn(&Options) -> f64,
) -> Vec<(f64, f64)> {
    counts
        .iter()
        .map(|n| {
            let step = span / (f64::from(*n) + 0.5);
            let options = fixed.options(step).locator(locator);
            (step, run(&options).abs())
        })
        .collect()
}

#[test]
fn the_touch_down_of_a_belt_oscillator_converges_with_the_order_of_the_method() {
    let belt = decaying_friction();
    let (slip, end) = (4.703_364_997_942_152, 9.230_770_458_082_98);
    // For DOP853 the leading error terms cancel until rounding hides them; circles show its order
    // below.
    for (fixed, counts) in [(Fixed::Rk4, [48, 68, 96, 136, 192])] {
        for locator in [Locator::Auto, Locator::Henon, Locator::RootSearch] {
            // From the exit from stick, a tangent point, to the touch-down and to the exit.
            let events = |options: &Options| {
                let orbit =
                    solve(&belt, 0.0, State::from([1.0, 0.2]), 20.0, options).expect("runs");
                changes(&orbit)
            };
            // Position and time of touch-down and exit: for a single number the leading term may
            // vanish nearby.
            let error = |options: &Options| {
                let found = events(options);
                let (touch_down, exit) = (found[0], found[1]);
                let place = (touch_down.x[0] - 0.094_518_907_971_834_62).abs();
                (touch_down.t - slip)
                    .abs()
                    .max((exit.t - end).abs())
                    .max(place)
            };
            let points = event_errors(fixed, locator, &counts, slip, error);
            fixed.assert_order(&format!("{locator:?} event"), &points, 0.0);
        }
    }
}

#[test]
fn crossings_in_a_row_converge_with_the_order_of_the_method() {
    for (fixed, counts) in [
        (Fixed::Rk4, [8, 12, 17, 24, 34]),
        (Fixed::Dop853, [2, 3, 4, 5, 6]),
    ] {
        for locator in [Locator::Auto, Locator::Henon, Locator::RootSearch] {
            let events = |options: &Options| -> Orbit<2> {
                solve(&Floor, 0.0, State::from([3.0, 0.0]), 14.0, options).expect("runs")
            };
            for k in 0..4 {
                let error =
                    |options: &Options| events(options).transitions[k].t - (k + 1) as f64 * PI;
                let points = event_errors(fixed, locator, &counts, PI, error);
                fixed.assert_order(&format!("{locator:?} crossing {k}"), &points, 0.0);
            }
        }
    }
}

/// Largest error of one Hénon step on the unit circle `x' = v, v' = -x` with `v` as the independent
/// variable, by length.
fn henon_errors<M: RungeKutta>(changes: &[f64]) -> Vec<(f64, f64)> {
    let slope = &mut |at: &Timed<2>| {
        let rate = -at.x[0];
        Timed {
            t: 1.0 / rate,
            x: State::from([at.x[1] / rate, -at.x[0] / rate]),
        }
    };
    changes
        .iter()
        .map(|change| {
            // v falls from half the change to its negative: the middle of the circle's side, where
            // even powers cancel.
            let v0 = 0.5 * change;
            let start = math::atan2(v0, (1.0 - v0 * v0).sqrt());
            let from = Timed {
                t: 0.0,
                x: State::from([math::cos(start), v0]),
            };
            let to = henon_step::<M, 2>(slope, &from, -change);
            let v = v0 - change;
            assert!(
                (to.x[1] - v).abs() <= 4.0 * f64::EPSILON,
                "lands to rounding: {}",
                to.x[1] - v
            );
            let x = (1.0 - v * v).sqrt();
            let t = start - math::atan2(v, x);
            (*change, (to.t - t).abs().max((to.x[0] - x).abs()))
        })
        .collect()
}

#[test]
fn one_henon_step_errs_by_one_order_more_than_the_method() {
    Fixed::Rk4.assert_order(
        "henon",
        &henon_errors::<Rk4>(&[0.08, 0.06, 0.04, 0.03, 0.02]),
        1.0,
    );
    Fixed::Dop853.assert_order(
        "henon",
        &henon_errors::<Dop853>(&[0.4, 0.34, 0.29, 0.25, 0.21]),
        1.0,
    );
}

#[test]
fn the_dense_output_errs_by_the_fourth_power_of_the_step_and_by_the_eighth() {
    for (fixed, counts) in [
        (Fixed::Rk4, [24, 36, 50, 70, 100]),
        (Fixed::Dop853, [4, 6, 8, 10, 13]),
    ] {
        let points: Vec<_> = counts
            .iter()
            .map(|n| {
                let step = 5.0 / f64::from(*n);
                let options = fixed.options(step);
                let orbit = solve(
                    &Breathing { ceiling: 10.0 },
                    0.0,
                    State::from([1.0]),
                    5.0,
                    &options,
                )
                .expect("runs");
                let worst = (0..=1000)
                    .map(|i| {
                        let t = 5.0 * f64::from(i) / 1000.0;
                        (orbit.at(t).expect("inside")[0] - math::exp(math::sin(t))).abs()
                    })
                    .fold(0.0, f64::max);
                (step, worst)
            })
            .collect();
        fixed.assert_order("dense", &points, 0.0);
    }
}

#[test]
fn the_error_of_a_sensitive_orbit_follows_the_tolerance_and_is_the_flow_of_each_step_s_own() {
    let belt = Block::on_belt(0.4);
    let (start, end) = (State::from([0.5, 1.5]), 30.0);
    let exact = |t: f64, x: State<2>, to: f64| {
        let options = Options::tol(1e-15).method(Method::Taylor);
        solve(&belt, t, x, to, &options).expect("runs")
    };
    let last_event = |orbit: &Orbit<2>| orbit.transitions.last().expect("events").t;
    let wanted = last_event(&exact(0.0, start, end));
    let mut errors = Vec::new();
    for tolerance in [1e-8, 1e-10, 1e-12, 1e-13, 1e-14] {
        let orbit = solve(&belt, 0.0, start, end, &Options::tol(tolerance)).expect("runs");
        let mut worst = 0.0;
        let mut explained = 0.0;
        for step in &orbit.steps {
            let own = (exact(step.t_start, step.x_start, step.t_end).x_end - step.x_end).amax();
            worst = f64::max(worst, own);
            if step.t_end < end {
                let flow = monodromy(&belt, step.t_end, step.x_end, end, &Options::tol(1e-8));
                explained += own * flow.expect("runs").matrix.amax().max(1.0);
            }
        }
        // Each step errs by at most its tolerance. A later event has at most the sum of these
        // errors, amplified by up to 404.
        assert!(worst <= tolerance, "{tolerance:e}: {worst:e}");
        let error = (last_event(&orbit) - wanted).abs();
        let rounding = 1e-12;
        assert!(error <= explained + rounding, "{tolerance:e}: {error:e}");
        errors.push((tolerance, error));
    }
    let exponent = order(&errors);
    assert!((exponent - 1.0).abs() < 0.1, "{exponent}: {errors:?}");
}
