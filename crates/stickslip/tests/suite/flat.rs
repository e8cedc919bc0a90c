//! Functions that are constant to rounding over a part of a step: a saturated hyperbolic tangent,
//! the tails of a bell curve.

use std::f64::consts::PI;

use stickslip::{Filippov, Method, Options, Scalar, Side, math};

use crate::any_system::solve;

fn taylor(tolerance: f64) -> Options {
    Options::tol(tolerance).method(Method::Taylor)
}

/// `∫ f` by Simpson's rule.
fn integral(f: impl Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    const PARTS: i32 = 1_000_000;
    let h = (to - from) / f64::from(PARTS);
    let weigh = |i: i32| match i {
        0 | PARTS => 1.0,
        i if i % 2 == 0 => 2.0,
        _ => 4.0,
    };
    let sum: f64 = (0..=PARTS)
        .map(|i| weigh(i) * f(from + h * f64::from(i)))
        .sum();
    sum * h / 3.0
}

/// Pushed and pulled in turns by nearly constant forces; Σ is far away.
pub struct Square {
    steepness: f64,
    frequency: f64,
}

impl Filippov<1> for Square {
    fn field<T: Scalar>(&self, _side: Side, t: T, _x: &[T; 1]) -> [T; 1] {
        [((t * self.frequency).sin() * self.steepness).tanh()]
    }

    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 1]) -> T {
        x[0] - 100.0
    }
}

#[test]
fn a_saturated_push_is_followed_through_all_its_reversals() {
    for (steepness, frequency) in [(80.0, 1.0), (1000.0, 1.0), (80.0, 10.0), (20.0, 3.0)] {
        let square = Square {
            steepness,
            frequency,
        };
        // The remainder after whole periods.
        let rest = 8.0 % (2.0 * PI / frequency);
        let push = |t: f64| math::tanh(steepness * math::sin(frequency * t));
        let exact = integral(push, 0.0, rest);
        for digits in 4..=13 {
            let tolerance = math::powi(10.0, -digits);
            let orbit = solve(&square, 0.0, [0.0], 8.0, &taylor(tolerance)).expect("runs");
            let error = (orbit.x_end[0] - exact).abs();
            assert!(
                error < 10.0 * tolerance + 1e-12,
                "{steepness}, {frequency}, {digits} digits: {error:e}"
            );
        }
    }
}

/// An oscillator pushed and pulled in that way. Where the force is nearly constant, the series of
/// the state does not show its changes.
pub struct Driven {
    frequency: f64,
    /// Whether the push is written as a logistic function, which is equivalent.
    is_logistic: bool,
}

impl Filippov<2> for Driven {
    fn field<T: Scalar>(&self, _side: Side, t: T, x: &[T; 2]) -> [T; 2] {
        let u = (t * self.frequency).sin() * 80.0;
        let push = if self.is_logistic {
            ((u * -2.0).exp() + 1.0).recip() * 2.0 - 1.0
        } else {
            u.tanh()
        };
        [x[1], push - x[0]]
    }

    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[0] - 100.0
    }
}

#[test]
fn reversals_of_a_saturated_drive_are_seen_though_the_state_s_own_series_goes_on() {
    for frequency in [1.0, 3.0, 10.0] {
        let push = |t: f64| math::tanh(80.0 * math::sin(frequency * t));
        let exact = integral(|t| math::sin(8.0 - t) * push(t), 0.0, 8.0);
        for is_logistic in [false, true] {
            for digits in 4..=12 {
                let tolerance = math::powi(10.0, -digits);
                let system = Driven {
                    frequency,
                    is_logistic,
                };
                let orbit = solve(&system, 0.0, [0.0, 0.0], 8.0, &taylor(tolerance)).expect("runs");
                let error = (orbit.x_end[0] - exact).abs();
                assert!(
                    error < 10.0 * tolerance + 1e-11,
                    "{frequency} {is_logistic}, {digits} digits: {error:e}"
                );
            }
        }
    }
}

/// Oscillates as `x = sin t`, and is pushed along another axis where `x` exceeds 0.97. Σ is flat
/// except in a narrow range of `x`, or far away.
pub struct Narrow(Option<Feature>);

#[derive(Clone, Copy, Debug)]
enum Feature {
    Step,
    Bell,
}

impl Filippov<3> for Narrow {
    fn field<T: Scalar>(&self, _side: Side, _t: T, x: &[T; 3]) -> [T; 3] {
        let push = ((x[0] - 0.97) * 60.0).tanh();
        [x[1], -x[0], push.max(T::zero())]
    }

    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 3]) -> T {
        match self.0 {
            Some(Feature::Step) => ((x[0] - 0.97) * 200.0).tanh() + 0.5,
            Some(Feature::Bell) => (-((x[0] - 0.5) * 100.0).powi(2)).exp() - 0.5,
            None => x[0] - 100.0,
        }
    }
}

#[test]
fn a_boundary_that_is_flat_but_in_a_narrow_range_is_met_at_all_its_places() {
    let step = 0.97 - 0.5 * math::ln(3.0) / 200.0;
    let half = math::ln(2.0).sqrt() / 100.0;
    for (feature, places) in [
        (Feature::Step, vec![step]),
        (Feature::Bell, vec![0.5 - half, 0.5 + half]),
    ] {
        // Twice in each period.
        let mut wanted: Vec<f64> = (0..2)
            .flat_map(|period| [(period, -1.0), (period, 1.0)])
            .flat_map(|(period, sign)| {
                let turn = PI * (0.5 + 2.0 * f64::from(period));
                places
                    .iter()
                    .map(move |place| turn + sign * math::acos(*place))
            })
            .collect();
        wanted.sort_by(f64::total_cmp);
        for digits in 5..=14 {
            let tolerance = math::powi(10.0, -digits);
            let system = Narrow(Some(feature));
            let orbit = solve(&system, 0.0, [0.0, 1.0, 0.0], 12.0, &taylor(tolerance));
            let found = orbit.expect("runs").transitions;
            let what = format!("{feature:?}, {digits} digits: {found:?}");
            assert_eq!(found.len(), wanted.len(), "{what}");
            for (at, wanted) in found.iter().zip(&wanted) {
                assert!(
                    (at.t - wanted).abs() < 30.0 * tolerance + 1e-13,
                    "{what}: {wanted}"
                );
            }
        }
    }
}

#[test]
fn a_comparison_with_what_is_flat_but_in_a_narrow_range_is_seen_there() {
    let push = |t: f64| math::tanh(60.0 * (math::sin(t) - 0.97));
    let half = math::acos(0.97);
    let exact = 2.0 * integral(push, 0.5 * PI - half, 0.5 * PI + half);
    for digits in 5..=14 {
        let tolerance = math::powi(10.0, -digits);
        let orbit = solve(&Narrow(None), 0.0, [0.0, 1.0, 0.0], 9.0, &taylor(tolerance));
        let error = (orbit.expect("runs").x_end[2] - exact).abs();
        assert!(
            error < 10.0 * tolerance + 1e-13,
            "{digits} digits: {error:e}"
        );
    }
}
