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

/// Slopes at the points with which cubics rise or fall as the points do. A slope is zero at a turn,
/// else the weighted harmonic mean of the two neighbouring rises (Fritsch & Carlson, *SIAM J.
/// Numer. Anal.* 17, 238 (1980); Fritsch & Butland, *SIAM J. Sci. Stat. Comput.* 5, 300 (1984)).
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
