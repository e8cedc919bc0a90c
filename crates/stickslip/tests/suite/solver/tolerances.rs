//! Absolute tolerances of the states, one for each.

use stickslip::{
    AbsoluteTolerance, Error, Filippov, Method, Options, Orbit, Scalar, Side, math, solve,
};

/// A driven block on a belt, whose velocity is counted in a unit: `x'' = -x - 0.3 sgn(x' - 0.2) +
/// 0.5 cos t`. A unit that is a power of two changes no bit but exponents.
struct Units {
    velocity: f64,
}

impl Filippov<2> for Units {
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 2]) -> [T; 2] {
        let force = -x[0] - 0.3 * side.sign() + t.cos() * 0.5;
        [x[1] * self.velocity, force / self.velocity]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[1] * self.velocity - 0.2
    }
}

const TOLERANCE: f64 = 1e-9;

fn run(velocity: f64, atol: AbsoluteTolerance, method: Method) -> Orbit<2> {
    let options = Options::tol(TOLERANCE).atol(atol).method(method);
    let start = [1.0, 0.3 / velocity];
    solve(&Units { velocity }, 0.0, start, 60.0, &options).unwrap()
}

fn each(values: &[f64]) -> AbsoluteTolerance {
    AbsoluteTolerance::each(values).unwrap()
}

/// With a tolerance in the same unit, every step is the same, and so is every bit.
#[test]
fn the_unit_of_a_state_and_of_its_tolerance_changes_nothing() {
    let (unit, method) = (1.0 / 1024.0, Method::Dop853);
    let plain = run(1.0, TOLERANCE.into(), method);
    let scaled = run(unit, each(&[TOLERANCE, TOLERANCE / unit]), method);
    assert!(plain.transitions.len() > 5, "{}", plain.transitions.len());
    assert_eq!(plain.counters, scaled.counters);
    assert_eq!(plain.x_end[0].to_bits(), scaled.x_end[0].to_bits());
    assert_eq!(plain.x_end[1].to_bits(), (scaled.x_end[1] * unit).to_bits());
    for (one, other) in plain.transitions.iter().zip(&scaled.transitions) {
        assert_eq!(one.t.to_bits(), other.t.to_bits());
    }
    // With one number for both, the velocity is followed a thousand times more closely.
    let common = run(unit, TOLERANCE.into(), method);
    assert!(common.counters.steps > plain.counters.steps);
    // Taylor steps estimate logarithms to some bits, and may differ by rounding.
    let plain = run(1.0, TOLERANCE.into(), Method::Taylor);
    let scaled = run(unit, each(&[TOLERANCE, TOLERANCE / unit]), Method::Taylor);
    assert_eq!(plain.counters.steps, scaled.counters.steps);
    assert!((plain.x_end[0] - scaled.x_end[0]).abs() < 1e-12);
    assert!((plain.x_end[1] - scaled.x_end[1] * unit).abs() < 1e-12);
}

#[test]
fn equal_values_are_one_number() {
    for method in [Method::Dop853, Method::Taylor] {
        let one = run(1.0, 1e-7.into(), method);
        let two = run(1.0, each(&[1e-7, 1e-7]), method);
        assert_eq!(one.counters, two.counters);
        assert_eq!(one.x_end, two.x_end);
    }
}

/// `x' = -x` and `y' = (40 cos 40t - 1) y` from 1 and 1e-8: the small state is as exact as its own
/// tolerance asks. It is `1e-8 exp(sin 40t - t)`.
#[test]
fn each_state_has_the_accuracy_of_its_own_tolerance() {
    struct Decay;
    impl Filippov<2> for Decay {
        fn field<T: Scalar>(&self, _: Side, t: T, x: &[T; 2]) -> [T; 2] {
            let turn = (t * 40.0).cos() * 40.0;
            [-x[0], x[1] * (turn - 1.0)]
        }
        fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
            x[0] + 1.0
        }
    }
    let error = |method: Method, atol: AbsoluteTolerance| {
        let options = Options::tol(1e-15).atol(atol).method(method);
        let orbit = solve(&Decay, 0.0, [1.0, 1e-8], 1.0, &options).unwrap();
        let exact = 1e-8 * math::exp(math::sin(40.0) - 1.0);
        let relative = (orbit.x_end[1] / exact - 1.0).abs();
        (relative, orbit.counters.steps)
    };
    for method in [Method::Dop853, Method::Taylor] {
        let (coarse, few) = error(method, 1e-6.into());
        let (fine, more) = error(method, each(&[1e-6, 1e-18]));
        let (other, as_few) = error(method, each(&[1e-18, 1e-6]));
        assert!(
            fine < 1e-8 && more > few,
            "{method:?}: {fine:e}, {more} steps"
        );
        assert!(
            coarse > 1e-5 && other > 1e-5,
            "{coarse:e} {other:e} {as_few}"
        );
    }
}

#[test]
fn a_list_that_is_not_one_of_the_states_is_refused() {
    let refusal = |atol: AbsoluteTolerance| {
        let options = Options::tol(1e-9).atol(atol);
        let run = solve(&Units { velocity: 1.0 }, 0.0, [1.0, 0.3], 1.0, &options);
        run.err().map(|failure| failure.error.to_string()).unwrap()
    };
    for (values, wanted) in [
        (&[1e-9][..], "atol has 1 values, and there are 2 states"),
        (&[1e-9; 3], "atol has 3 values, and there are 2 states"),
        (&[1e-9, -1e-9], "option atol = -1e-9 is not allowed"),
        (&[f64::NAN, 1e-9], "option atol = NaN is not allowed"),
        (&[1e-9, 0.0], "between 1e-280 and 0.1"),
        (&[1e-9, 0.2], "between 1e-280 and 0.1"),
    ] {
        let said = refusal(each(values));
        assert!(said.contains(wanted), "{values:?}: {said}");
    }
    for count in [0, 65] {
        let refused = AbsoluteTolerance::each(&vec![1e-9; count]);
        let refused = refused.unwrap_err();
        assert!(matches!(refused, Error::Option { value, .. } if value == count as f64));
        assert!(refused.to_string().contains("one for each state"));
    }
}
