//! Corners of Σ and of fields, and apparent touches.

use stickslip::{Filippov, Method, Options, Orbit, Scalar, Side, TransitionKind, math};

use crate::any_system::solve;

fn kinds<const N: usize>(orbit: &Orbit<N>) -> Vec<TransitionKind> {
    orbit.transitions.iter().map(|at| at.kind).collect()
}

/// Sticks to a belt that moves as a sine, and faster beyond x = 1; friction is larger from below.
pub struct CornerOfBoundary;

impl Filippov<2> for CornerOfBoundary {
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 2]) -> [T; 2] {
        let slip = self.boundary(t, x) * side.sign();
        let friction = if side == Side::Above { 1.0 } else { 1.2 };
        let force = (slip * 4.0 + 1.0).recip() * (friction * side.sign());
        [x[1], -(x[0] * 1.5) - force]
    }

    fn boundary<T: Scalar>(&self, t: T, x: &[T; 2]) -> T {
        x[1] - t.sin() - (x[0] - 1.0).abs() * 0.25
    }
}

#[test]
fn a_stick_that_ends_at_a_corner_of_the_boundary_ends_there_once() {
    let run = |tolerance: f64| {
        let options = Options::tol(tolerance).method(Method::Taylor);
        solve(&CornerOfBoundary, 0.0, [0.0, 0.0], 9.0, &options).expect("runs")
    };
    let exact = run(1e-15).transitions[1].t;
    for digits in 4..=14 {
        let tolerance = math::powi(10.0, -digits);
        let orbit = run(tolerance);
        let what = format!("{digits} digits: {:?}", orbit.transitions);
        let wanted = [TransitionKind::StickEntry, TransitionKind::StickExit];
        assert_eq!(kinds(&orbit), wanted, "{what}");
        let exit = &orbit.transitions[1];
        // The force balance is not zero by then: the corner causes the release.
        assert!(
            (exit.x[0] - 1.0).abs() < 1e-13 && exit.residual > 0.1,
            "{what}"
        );
        assert!((exit.t - exact).abs() < 30.0 * tolerance, "{what}");
    }
}

/// A block on a belt, driven by the positive half waves of a sine; the weight decides the time of
/// release.
pub struct CornerOfField {
    friction: f64,
}

impl Filippov<2> for CornerOfField {
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 2]) -> [T; 2] {
        let drive = (t * 2.0).sin().max(T::zero());
        [x[1], drive - x[0] - self.friction * side.sign()]
    }

    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[1] - 0.3
    }
}

#[test]
fn a_stick_that_ends_just_before_a_corner_of_the_field_ends_by_runge_kutta_too() {
    let corner = 0.5 * std::f64::consts::PI;
    for digits in [5, 7, 9] {
        let tolerance = math::powi(10.0, -digits);
        for before in (0..60).map(|k| 1e-6 * math::pow(10.0, f64::from(k) / 12.0)) {
            let exit = corner - before;
            // Then the spring balances friction and drive.
            let friction = 0.5 + 0.3 * exit - math::sin(2.0 * exit);
            let options = Options::tol(tolerance);
            let orbit = solve(&CornerOfField { friction }, 0.5, [0.65, 0.3], 3.0, &options);
            let orbit = orbit.unwrap_or_else(|failure| panic!("{digits} {before:e}: {failure}"));
            let first = &orbit.transitions[0];
            let what = format!("{digits} digits, {before:e}: {first:?}");
            assert_eq!(first.kind, TransitionKind::StickExit, "{what}");
            assert!((first.t - exit).abs() < 100.0 * tolerance, "{what}");
        }
    }
}

/// A block on a belt that moves as a sine, with constant friction, written as the maximum of two
/// forces that are equal during stick.
pub struct EqualInStick;

impl Filippov<2> for EqualInStick {
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 2]) -> [T; 2] {
        let slip = self.boundary(t, x) * side.sign();
        let friction = (slip * -1.2 + 1.0).max(T::one()) * (0.6 * side.sign());
        [x[1], -x[0] - friction]
    }

    fn boundary<T: Scalar>(&self, t: T, x: &[T; 2]) -> T {
        x[1] - 0.3 - t.sin() * 0.1
    }
}

#[test]
fn a_stick_ends_where_it_does_though_two_that_are_compared_are_equal_in_it() {
    // With the belt, x = 0.3 t + 0.1 (1 − cos t). It is released where x + x'' equals the friction.
    let left = |t: f64| 0.6 - (0.3 * t + 0.1 * (1.0 - math::cos(t))) - 0.1 * math::cos(t);
    let exit = stickslip::first_zero(left, 0.0, 3.0).expect("ends");
    for digits in 4..=14 {
        let tolerance = math::powi(10.0, -digits);
        let options = Options::tol(tolerance).method(Method::Taylor);
        let orbit = solve(&EqualInStick, 0.0, [0.0, 0.3], 3.0, &options).expect("runs");
        let what = format!("{digits} digits: {:?}", orbit.transitions);
        let first = &orbit.transitions[0];
        assert_eq!(first.kind, TransitionKind::StickExit, "{what}");
        assert!((first.t - exit).abs() < tolerance, "{what}: {exit}");
    }
}

/// Comes to rest on Σ, by damping that is smooth and steep.
pub struct Creep;

impl Filippov<2> for Creep {
    fn field<T: Scalar>(&self, _side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
        [x[1], -x[0] - (x[1] * 43.0).tanh() * 0.7]
    }

    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[1]
    }
}

#[test]
fn a_body_that_creeps_along_the_boundary_does_not_touch_it_without_end() {
    for digits in 4..=12 {
        let tolerance = math::powi(10.0, -digits);
        for method in [Method::Dop853, Method::Taylor] {
            let options = Options::tol(tolerance).method(method);
            let orbit = solve(&Creep, 0.0, [0.0, 1.0], 87.0, &options).expect("runs");
            // The term linear in the velocity, 30.1, balances the spring: exp(-t/30.1).
            let fall = orbit.x_end[0] / orbit.at(57.0).expect("inside")[0];
            let rate = -math::ln(fall) / 30.0;
            assert!(
                (rate - 1.0 / 30.1).abs() < 1e-3,
                "{method:?}, {digits} digits: {rate}"
            );
        }
    }
}

/// A body that sticks where its friction is the smaller of two very different forces.
pub struct Weaker;

impl Filippov<4> for Weaker {
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 4]) -> [T; 4] {
        let slip = self.boundary(t, x) * side.sign();
        let firm = if side == Side::Above { 0.26 } else { 1.33 };
        let load = ((t * 0.555).sin() * 0.435 + 1.0) * firm;
        let friction = (-(slip * 5.8) + 1.0).max(T::constant(0.53)) * load * side.sign();
        let link = (x[0] - x[2]) * 0.45 + (x[1] - x[3]) * 0.29;
        let spring = (x[0] * 31.0).tanh() * 0.62;
        [
            x[1],
            -(x[1] * 0.237) - spring - friction - link,
            x[3],
            link / 0.787,
        ]
    }

    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 4]) -> T {
        x[1] + x[0].sin() * 0.538
    }
}

#[test]
fn a_comparison_of_what_is_far_from_equal_does_not_make_steps_short_by_rounding() {
    for tolerance in [1e-5, 1e-6, 1e-7, 4.4e-8, 2e-8, 1e-8, 1e-9, 1e-11, 1e-13] {
        let options = Options::tol(tolerance).method(Method::Taylor);
        let orbit = solve(&Weaker, 0.0, [1.42, 0.3, 0.5, 0.0], 75.0, &options).expect("runs");
        let steps = orbit.counters.steps;
        assert!(steps < 100, "{tolerance:e}: {steps} steps");
    }
}
