//! Functions of one argument through points.

use std::fmt;

use stickslip::Scalar;
use stickslip::error::readable;

/// A function through points is extended beyond its ends by this part of its span before it is
/// refused there. Chosen: rounding of an argument is a millionth of it.
const MARGIN: f64 = 1e-9;

/// Interpolation of a curve between its points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Between {
    /// Straight lines.
    #[default]
    Linear,
    /// Cubics without overshoot, with a continuous slope.
    Monotone,
}

/// Continuation of a curve beyond its first and last point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Beyond {
    /// The value at the end.
    #[default]
    Hold,
    /// The line or cubic at the end goes on.
    Extend,
    /// No number.
    Error,
}

/// A continuous function of one argument: a polynomial on each of its pieces.
#[derive(Clone, Debug, PartialEq)]
pub struct PiecewisePolynomial {
    /// Abscissas at which one piece ends and the next begins.
    cuts: Vec<f64>,
    /// One more than there are cuts.
    pieces: Vec<Polynomial>,
}

/// A polynomial in the distance from a place.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Polynomial {
    from: f64,
    /// The coefficients, of the power 0 first.
    coefficients: [f64; 4],
}

/// Reason for which points make no curve.
#[derive(Clone, Debug, PartialEq)]
pub struct NoCurve {
    /// The fault.
    pub message: String,
    /// The remedy.
    pub help: &'static str,
}

impl fmt::Display for NoCurve {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}; {}", self.message, self.help)
    }
}

impl Polynomial {
    fn constant(value: f64) -> Self {
        Polynomial {
            from: 0.0,
            coefficients: [value, 0.0, 0.0, 0.0],
        }
    }

    fn of<T: Scalar>(&self, x: T) -> T {
        match self.coefficients {
            [c0, 0.0, 0.0, 0.0] => T::constant(c0),
            [c0, c1, 0.0, 0.0] => (x - self.from) * c1 + c0,
            [c0, c1, c2, c3] => {
                let x = x - self.from;
                ((x * c3 + c2) * x + c1) * x + c0
            }
        }
    }

    fn derivative(&self) -> Self {
        let [c0, c1, c2, c3] = self.coefficients;
        // What is no number has no slope.
        let c1 = if c0.is_nan() { c0 } else { c1 };
        Polynomial {
            coefficients: [c1, 2.0 * c2, 3.0 * c3, 0.0],
            ..*self
        }
    }
}

impl PiecewisePolynomial {
    /// A curve through the points `(xs[k], ys[k])`, of which there are as many `xs` as `ys`.
    ///
    /// # Errors
    /// [`NoCurve`] with fewer than two points, or arguments that do not rise.
    pub fn new(xs: &[f64], ys: &[f64], between: Between, beyond: Beyond) -> Result<Self, NoCurve> {
        let wrong = |message: String, help| Err(NoCurve { message, help });
        if xs.len() < 2 || ys.len() != xs.len() {
            let message = format!("a curve of {} points", xs.len().min(ys.len()));
            return wrong(
                message,
                "it needs two at least; what is constant is a parameter",
            );
        }
        if let Some(k) = (1..xs.len()).find(|&k| xs[k - 1] >= xs[k]) {
            let (before, behind) = (readable(xs[k - 1]), readable(xs[k]));
            let message = format!(
                "the points are not in order: {before} comes before {behind}, as number {k} and {} \
                 of {}",
                k + 1,
                xs.len()
            );
            return wrong(
                message,
                "the first number of each is larger than that before it",
            );
        }
        let last = xs.len() - 1;
        let slopes = match between {
            Between::Linear => Vec::new(),
            Between::Monotone => slopes(xs, ys),
        };
        let piece = |k: usize| {
            let h = xs[k + 1] - xs[k];
            let rise = (ys[k + 1] - ys[k]) / h;
            let coefficients = match slopes.get(k..=k + 1) {
                Some(&[begin, end]) => [
                    ys[k],
                    begin,
                    (3.0 * rise - 2.0 * begin - end) / h,
                    (begin + end - 2.0 * rise) / (h * h),
                ],
                _ => [ys[k], rise, 0.0, 0.0],
            };
            Polynomial {
                from: xs[k],
                coefficients,
            }
        };
        let mut cuts = xs[1..last].to_vec();
        let mut pieces: Vec<Polynomial> = (0..last).map(piece).collect();
        let margin = MARGIN * (xs[last] - xs[0]);
        let ends = match beyond {
            Beyond::Extend => None,
            Beyond::Hold => Some(([xs[0], xs[last]], [ys[0], ys[last]])),
            Beyond::Error => Some(([xs[0] - margin, xs[last] + margin], [f64::NAN; 2])),
        };
        if let Some(([first, last], values)) = ends {
            cuts.insert(0, first);
            cuts.push(last);
            let [before, behind] = values.map(Polynomial::constant);
            pieces.insert(0, before);
            pieces.push(behind);
        }
        Ok(PiecewisePolynomial { cuts, pieces })
    }

    /// Value of the curve.
    pub fn of<T: Scalar>(&self, x: T) -> T {
        x.in_pieces(&self.cuts, |piece, x| match self.pieces.get(piece) {
            Some(polynomial) => polynomial.of(x),
            None => T::constant(f64::NAN),
        })
    }

    /// Slope of the curve as a function, which has steps where lines meet.
    #[must_use]
    pub fn derivative(&self) -> Self {
        PiecewisePolynomial {
            cuts: self.cuts.clone(),
            pieces: self.pieces.iter().map(Polynomial::derivative).collect(),
        }
    }
}

/// Slopes at the points with which cubics rise or fall as the points do: zero at a turn, else the
/// weighted harmonic mean of the two neighbouring rises (Fritsch & Carlson, *SIAM J. Numer. Anal.*
/// 17, 238 (1980); Fritsch & Butland, *SIAM J. Sci. Stat. Comput.* 5, 300 (1984)).
fn slopes(xs: &[f64], ys: &[f64]) -> Vec<f64> {
    let gaps: Vec<f64> = xs.windows(2).map(|x| x[1] - x[0]).collect();
    let rises: Vec<f64> = ys
        .windows(2)
        .zip(&gaps)
        .map(|(y, gap)| (y[1] - y[0]) / gap)
        .collect();
    let count = gaps.len();
    if count == 1 {
        return vec![rises[0]; 2];
    }
    let inner = |k: usize| {
        let ([h0, h1], [d0, d1]) = ([gaps[k - 1], gaps[k]], [rises[k - 1], rises[k]]);
        if d0 * d1 <= 0.0 {
            return 0.0;
        }
        let (w0, w1) = (2.0 * h1 + h0, h1 + 2.0 * h0);
        (w0 + w1) / (w0 / d0 + w1 / d1)
    };
    let first = end_slope([gaps[0], gaps[1]], [rises[0], rises[1]]);
    let last = end_slope(
        [gaps[count - 1], gaps[count - 2]],
        [rises[count - 1], rises[count - 2]],
    );
    let inner = (1..count).map(inner);
    std::iter::once(first).chain(inner).chain([last]).collect()
}

/// The slope at an end by the parabola through its three points, limited so that the cubic there
/// does not turn (Moler, *Numerical Computing with MATLAB*, 2004, Sect. 3.4). The gap and rise next
/// to the end come first.
fn end_slope([h0, h1]: [f64; 2], [d0, d1]: [f64; 2]) -> f64 {
    let slope = ((2.0 * h0 + h1) * d0 - h0 * d1) / (h0 + h1);
    if slope * d0 <= 0.0 {
        0.0
    } else if d0 * d1 <= 0.0 && slope.abs() > 3.0 * d0.abs() {
        3.0 * d0
    } else {
        slope
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stickslip::scalar::{Dual, Interval};

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
            let curve = PiecewisePolynomial::new(&XS, &ys, Between::Monotone, Beyond::Extend)
                .expect("a curve");
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
        let same =
            PiecewisePolynomial::new(&[0.0, 1.0, 1.0], &[1.0; 3], Between::Linear, Beyond::Hold);
        let message = same.unwrap_err().message;
        assert!(
            message.contains("1 comes before 1, as number 2 and 3 of 3"),
            "{message}"
        );
    }
}
