//! Pulses far narrower than the steps without them: in the force on a sticking body, on a slipping
//! body, and in Σ.

use std::ops::ControlFlow;

use stickslip::Transition;
use stickslip::{
    Error, Filippov, Method, Observer, Options, Orbit, Scalar, Side, State, TransitionKind, math,
};

use crate::any_system::{run, solve};

/// A pulse of height and width 1.
#[derive(Clone, Copy, Debug)]
pub enum Shape {
    /// `exp(−u²)`
    Bell,
    /// `1/cosh u`
    Sech,
    /// `1/cosh u`, written as a power.
    Power,
    /// `1/cosh u`, written by exponential functions.
    Exponentials,
}

const SHAPES: [Shape; 4] = [Shape::Bell, Shape::Sech, Shape::Power, Shape::Exponentials];

impl Shape {
    fn at<T: Scalar>(self, u: T) -> T {
        match self {
            Shape::Bell => (-(u * u)).exp(),
            Shape::Sech => u.cosh().recip(),
            Shape::Power => u.cosh().powf(-1.0),
            Shape::Exponentials => (u.exp() + (-u).exp()).recip() * 2.0,
        }
    }

    /// Distance from its centre at which it has the height `y`.
    fn half_width(self, y: f64) -> f64 {
        match self {
            Shape::Bell => (-math::ln(y)).sqrt(),
            _ => math::ln((1.0 + (1.0 - y * y).sqrt()) / y),
        }
    }
}

/// A body on a belt with friction 1. A force shakes it and pushes it once.
#[derive(Clone, Copy, Debug)]
pub struct Pushed {
    shape: Shape,
    at: f64,
    width: f64,
    size: f64,
    /// Amplitude and frequency of the shaking.
    shaken: [f64; 2],
    /// Rate of another force.
    ramp: f64,
    spring: f64,
    friction: f64,
    belt: f64,
}

/// A block on a belt at rest, pushed with slightly more than the friction limit.
const PUSHED: Pushed = Pushed {
    shape: Shape::Bell,
    at: 0.0,
    width: 0.01,
    size: 1.2,
    shaken: [0.0; 2],
    ramp: 0.0,
    spring: 0.0,
    friction: 1.0,
    belt: 0.0,
};

impl Filippov<2> for Pushed {
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 2]) -> [T; 2] {
        let push = self.shape.at((t - self.at) * (1.0 / self.width)) * self.size;
        let [amplitude, frequency] = self.shaken;
        let drive = (t * frequency).sin() * amplitude + t * self.ramp;
        let force = push + drive - x[0] * self.spring;
        [x[1], force - self.friction * side.sign()]
    }

    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[1] - self.belt
    }
}

fn options(method: Method, digits: i32) -> Options {
    Options::tol(math::powi(10.0, -digits)).method(method)
}

fn kinds<const N: usize>(orbit: &Orbit<N>) -> Vec<TransitionKind> {
    orbit.transitions.iter().map(|at| at.kind).collect()
}

#[test]
fn a_stick_ends_in_a_pulse_however_long_it_has_lasted() {
    for shape in SHAPES {
        for (width, at, belt) in [
            (1.0, 20.0, 0.0),
            (1.0, 333.3, 0.5),
            (0.1, 50.0, 0.5),
            (0.01, 333.3, 0.0),
        ] {
            let system = Pushed {
                shape,
                at,
                width,
                belt,
                ..PUSHED
            };
            let exit = at - width * shape.half_width(1.0 / 1.2);
            for method in [Method::Dop853, Method::Taylor] {
                for digits in [4, 6, 8, 10, 12] {
                    let orbit = solve(&system, 0.0, [0.0, belt], 1000.0, &options(method, digits))
                        .expect("runs");
                    let what = format!("{system:?}, {method:?}, {digits}: {:?}", orbit.transitions);
                    let wanted = [TransitionKind::StickExit, TransitionKind::StickEntry];
                    assert_eq!(kinds(&orbit), wanted, "{what}");
                    assert!((orbit.transitions[0].t - exit).abs() < 1e-9, "{what}");
                }
            }
        }
    }
}

#[test]
fn a_stick_ends_in_a_pulse_before_it_ends_by_a_force_that_grows() {
    for at in (0..40).map(|k| 250.0 + 6.1 * f64::from(k)) {
        let system = Pushed {
            at,
            size: 0.6,
            ramp: 0.002,
            ..PUSHED
        };
        let orbit = solve(&system, 0.0, [0.0, 0.0], 600.0, &Options::default()).expect("runs");
        assert!((orbit.transitions[0].t - at).abs() < 0.02, "{at}");
    }
}

#[test]
fn a_pulse_right_behind_the_start_of_a_step_is_found() {
    for at in (0..60).map(|k| 260.0 + 0.3 * f64::from(k)) {
        for first_step in [None, Some(at - 0.02), Some(500.0)] {
            let system = Pushed {
                at,
                belt: 0.5,
                ..PUSHED
            };
            let options = Options {
                first_step,
                ..Options::default()
            };
            let orbit = solve(&system, 0.0, [0.0, 0.5], 1000.0, &options).expect("runs");
            let what = format!("{at} {first_step:?}");
            assert_eq!(orbit.transitions.len(), 2, "{what}");
        }
    }
}

/// A block on a belt that carries it over a place where friction is small for a hundredth of a
/// second.
pub struct Slippery {
    belt: f64,
}

impl Filippov<2> for Slippery {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
        let there = Shape::Bell.at((x[0] - self.belt * 300.0) * (100.0 / self.belt));
        [x[1], (there * 0.9 - 1.0) * side.sign() + 0.37]
    }

    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[1] - self.belt
    }
}

#[test]
fn a_narrow_place_in_state_is_found_where_only_rounding_bounds_the_step() {
    for belt in [0.125, 0.1, 0.3, 0.7, 1.3] {
        for digits in [6, 8, 10, 12, 13] {
            let options = options(Method::Dop853, digits);
            let orbit =
                solve(&Slippery { belt }, 0.0, [0.0, belt], 1000.0, &options).expect("runs");
            let wanted = [TransitionKind::StickExit, TransitionKind::StickEntry];
            assert_eq!(kinds(&orbit), wanted, "{belt} {digits}");
        }
    }
}

#[test]
fn a_pulse_is_found_among_the_waves_of_a_fast_drive() {
    for (amplitude, belt, count) in [(0.8, 0.4, 0), (0.9, 0.0, 8), (0.99, 0.4, 16)] {
        let system = Pushed {
            at: 330.0,
            width: 0.3,
            size: 0.2,
            shaken: [amplitude, 50.0],
            belt,
            ..PUSHED
        };
        let run = |method, digits| {
            solve(&system, 0.0, [0.0, belt], 400.0, &options(method, digits)).expect("runs")
        };
        let exact = run(Method::Taylor, 14);
        assert_eq!(exact.transitions.len(), count);
        for digits in [5, 8, 11] {
            let orbit = run(Method::Dop853, digits);
            assert_eq!(kinds(&orbit), kinds(&exact), "{system:?}, {digits}");
            for (found, exact) in orbit.transitions.iter().zip(&exact.transitions) {
                assert!((found.t - exact.t).abs() < 1e-5, "{found:?} {exact:?}");
            }
        }
    }
}

#[test]
fn series_meet_a_pulse_in_slip_and_come_out_with_its_whole_push() {
    for shape in SHAPES {
        for width in [0.1, 0.01, 0.001] {
            let system = Pushed {
                shape,
                at: 3.0,
                width,
                size: 0.4 / width,
                spring: 1.0,
                friction: 0.1,
                belt: 0.5,
                ..PUSHED
            };
            let run =
                |options: Options| solve(&system, 0.0, [0.05, -0.1], 8.0, &options).expect("runs");
            let exact = run(options(Method::Taylor, 14).longest_step(0.2 * width));
            assert_eq!(kinds(&exact), [TransitionKind::Crossing; 2], "{system:?}");
            for digits in [6, 8, 10, 12] {
                let orbit = run(options(Method::Taylor, digits));
                let what = format!("{system:?}, {digits}: {:?}", orbit.transitions);
                assert_eq!(kinds(&orbit), kinds(&exact), "{what}");
                let error = (orbit.x_end - exact.x_end).norm();
                assert!(
                    error < 100.0 * math::powi(10.0, -digits),
                    "{what}: {error:e}"
                );
            }
        }
    }
}

/// Approaches Σ slowly; a single pulse of Σ reaches it.
pub struct Spike {
    shape: Shape,
    width: f64,
}

impl Filippov<1> for Spike {
    fn field<T: Scalar>(&self, _side: Side, _t: T, _x: &[T; 1]) -> [T; 1] {
        [T::constant(0.01)]
    }

    fn boundary<T: Scalar>(&self, t: T, x: &[T; 1]) -> T {
        x[0] - 1.0 + self.shape.at((t - 3.0) * (1.0 / self.width)) * 0.98
    }
}

#[test]
fn a_boundary_that_comes_and_goes_in_no_time_is_met_twice() {
    for shape in SHAPES {
        for width in [0.1, 0.01, 0.001] {
            // From x = 0 at t = 0. At the pulse it is 0.03, minus half the pulse's width, so that
            // 0.97 of 0.98 are needed.
            let half = width * shape.half_width(0.97 / 0.98);
            for method in [Method::Dop853, Method::Taylor] {
                for digits in [4, 6, 8, 10, 12] {
                    let orbit = solve(
                        &Spike { shape, width },
                        0.0,
                        [0.0],
                        50.0,
                        &options(method, digits),
                    )
                    .expect("runs");
                    let what = format!(
                        "{shape:?} {width} {method:?} {digits}: {:?}",
                        orbit.transitions
                    );
                    assert_eq!(kinds(&orbit), [TransitionKind::Crossing; 2], "{what}");
                    for (found, exact) in orbit.transitions.iter().zip([3.0 - half, 3.0 + half]) {
                        assert!((found.t - exact).abs() < 0.02 * width, "{what}: {exact}");
                    }
                }
            }
        }
    }
}

/// Pushed up on both sides of Σ, and additionally by a term that vanishes where it overflows.
#[derive(Clone, Copy, Debug)]
pub enum Overflowing {
    Sech,
    Logistic,
    LogisticInTime,
    /// Divided by a product that overflows before its factors do.
    Square,
}

impl Filippov<2> for Overflowing {
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 2]) -> [T; 2] {
        let nothing = match self {
            Overflowing::Sech => ((x[0] + 1.0) * 1000.0).cosh().recip(),
            Overflowing::Logistic => (((x[0] + 1.0) * 1000.0).exp() + 1.0).recip(),
            Overflowing::LogisticInTime => (((t + 1.0) * 1000.0).exp() + 1.0).recip(),
            Overflowing::Square => {
                let e = ((t + 0.6) * 190.0).exp();
                e / ((e + 1.0) * (e + 1.0))
            }
        };
        [x[1], nothing + 1.0 - 0.2 * side.sign()]
    }

    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[1] - 1.2
    }
}

#[test]
fn what_overflows_inside_a_field_that_does_not_is_no_stick_and_no_obstacle() {
    for system in [
        Overflowing::Sech,
        Overflowing::Logistic,
        Overflowing::LogisticInTime,
        Overflowing::Square,
    ] {
        for method in [Method::Dop853, Method::Taylor] {
            for digits in [6, 10] {
                let options = options(method, digits);
                let orbit = solve(&system, 0.0, [0.5, 0.0], 3.0, &options);
                if matches!((system, method), (Overflowing::Square, Method::Taylor)) {
                    // The coefficients of that product are not finite over any step.
                    let failure = orbit.expect_err("a product overflows");
                    assert!(matches!(failure.error, Error::StepCollapse { t, .. } if t > 1.2));
                    assert!(failure.partial.counters.steps < 1000);
                    continue;
                }
                let orbit = orbit.expect("runs");
                let what = format!("{system:?} {method:?} {digits}: {:?}", orbit.transitions);
                assert_eq!(kinds(&orbit), [TransitionKind::Crossing], "{what}");
                assert!((orbit.transitions[0].t - 1.0).abs() < 1e-9, "{what}");
                // x = 0.5 + 0.6 at the crossing, then 1.2 · 2 + 0.8 · 2.
                let exact = State::from([5.1, 2.8]);
                assert!((orbit.x_end - exact).norm() < 1e-9, "{what}");
                assert!(orbit.counters.steps < 100, "{what}");
            }
        }
    }
}

/// Watches transitions, and optionally steps.
struct TransitionWatcher {
    at_steps: bool,
    events: Vec<f64>,
}

impl<const N: usize> Observer<N> for TransitionWatcher {
    fn transition(&mut self, at: &Transition<N>) -> ControlFlow<()> {
        self.events.push(at.t);
        ControlFlow::Continue(())
    }

    fn watches_steps(&self) -> bool {
        self.at_steps
    }
}

#[test]
fn an_orbit_is_the_same_whoever_looks_at_its_steps() {
    let system = Pushed {
        at: 3.0,
        size: 40.0,
        spring: 1.0,
        friction: 0.1,
        belt: 0.5,
        ..PUSHED
    };
    for k in 0..200 {
        let part = f64::from(k) / 199.0;
        let start = State::from([part - 0.5, 0.4 - part]);
        for digits in [6, 7, 8, 9] {
            let [one, other] = [false, true].map(|at_steps| {
                let mut looks = TransitionWatcher {
                    at_steps,
                    events: Vec::new(),
                };
                let options = options(Method::Dop853, digits);
                let end = run(&system, 0.0, start, 8.0, &options, &mut looks).expect("runs");
                (end.x, looks.events)
            });
            assert_eq!(one, other, "start {k}, {digits} digits");
        }
    }
}
