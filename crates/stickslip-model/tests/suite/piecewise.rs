//! Curves through points: values, slopes and bounds.

use stickslip::scalar::{Dual, Interval};
use stickslip_model::expression::{Between, Beyond, PiecewisePolynomial};

const XS: [f64; 5] = [0.0, 0.5, 1.25, 2.0, 4.0];
const YS: [f64; 5] = [0.4, 0.3, 0.32, 0.32, -1.0];

fn curve(between: Between, beyond: Beyond) -> PiecewisePolynomial {
    PiecewisePolynomial::new(&XS, &YS, between, beyond).expect("a curve")
}

#[test]
fn passes_through_its_points_and_is_held_extended_or_refused_beyond() {
    for between in [Between::Linear, Between::Monotone] {
        for beyond in [Beyond::Hold, Beyond::Extend, Beyond::Error] {
            let curve = curve(between, beyond);
            for (x, y) in XS.into_iter().zip(YS) {
                assert!((curve.of(x) - y).abs() < 1e-15, "{x}");
            }
        }
        let [hold, error] = [Beyond::Hold, Beyond::Error].map(|one| curve(between, one));
        assert_eq!([hold.of(-3.0), hold.of(9.0)], [0.4, -1.0]);
        assert!(error.of(-3.0).is_nan() && error.of(4.1).is_nan());
        // Rounding of the argument is inside.
        assert!((error.of(-1e-12) - 0.4).abs() < 1e-11);
    }
    let line = curve(Between::Linear, Beyond::Extend);
    assert!((line.of(-1.0) - 0.6).abs() < 1e-15);
}

/// A cubic is neither above nor below both of its points, and its slope has no step.
#[test]
fn a_monotone_curve_does_not_overshoot() {
    let curve = curve(Between::Monotone, Beyond::Hold);
    for (x, y) in XS.windows(2).zip(YS.windows(2)) {
        let (low, high) = (y[0].min(y[1]), y[0].max(y[1]));
        for k in 0..=100 {
            let at = x[0] + f64::from(k) / 100.0 * (x[1] - x[0]);
            let value = curve.of(at);
            assert!(value >= low - 1e-15 && value <= high + 1e-15, "{at}");
        }
    }
    let slope = |x: f64| curve.of(Dual::new(x, 1.0)).eps;
    for x in &XS[1..4] {
        assert!((slope(x - 1e-12) - slope(x + 1e-12)).abs() < 1e-10, "{x}");
    }
}

/// Slopes at the points, and those of `PchipInterpolator(xs, ys).derivative()` of SciPy 1.17.
#[test]
fn slopes_are_those_of_another_program() {
    for (ys, slopes) in [
        (YS, [-0.290_666_666_666_666_74, 0.0, 0.0, 0.0, -1.14]),
        (
            [0.4, 0.3, 0.25, 0.1, -1.0],
            [
                -0.253_333_333_333_333_4,
                -0.103_448_275_862_068_98,
                -0.1,
                -0.273_962_264_150_943_4,
                -0.804_545_454_545_454_7,
            ],
        ),
    ] {
        let curve =
            PiecewisePolynomial::new(&XS, &ys, Between::Monotone, Beyond::Extend).expect("a curve");
        for (x, wanted) in XS.into_iter().zip(slopes) {
            let found = curve.of(Dual::new(x, 1.0)).eps;
            assert!((found - wanted).abs() < 1e-14, "{found} {wanted}");
        }
    }
}

#[test]
fn derivative_and_bounds_hold_what_values_do() {
    for between in [Between::Linear, Between::Monotone] {
        let curve = curve(between, Beyond::Hold);
        let slope = curve.derivative();
        for k in 0..200 {
            let x = -0.51 + f64::from(k) * 0.025;
            let dual = curve.of(Dual::new(x, 1.0));
            assert_eq!(dual.re, curve.of(x));
            assert!((dual.eps - slope.of(x)).abs() < 1e-13, "{x}");
            let range = Interval::new(x - 0.3, x + 0.7);
            let bounds = Interval::decided(|| curve.of(range)).expect("no branch is open");
            for part in 0..=20 {
                let value = curve.of(x - 0.3 + 0.05 * f64::from(part));
                let room = 1e-14;
                assert!(
                    bounds.low - room <= value && value <= bounds.high + room,
                    "{x}"
                );
            }
        }
    }
}

#[test]
fn points_out_of_order_are_refused() {
    let one = PiecewisePolynomial::new(&[0.0], &[1.0], Between::Linear, Beyond::Hold);
    assert_eq!(one.unwrap_err().message, "a curve of 1 points");
    let same = PiecewisePolynomial::new(&[0.0, 1.0, 1.0], &[1.0; 3], Between::Linear, Beyond::Hold);
    let message = same.unwrap_err().message;
    assert!(
        message.contains("1 comes before 1, as number 2 and 3 of 3"),
        "{message}"
    );
}
