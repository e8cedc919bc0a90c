//! The points as the estimator uses them: rows scaled by a power of two.

use super::error::DataError;
use super::matrix::{Matrix, distance2};
use super::series::Series;

/// Rows of the series for each row of the longest lag considered. A Theiler window of that length
/// leaves four fifths of the points as neighbours.
const ROWS_PER_LAG: usize = 10;
/// Terms in the estimate of an autocorrelation, whose standard error is then 1/64.
const CORRELATION_TERMS: usize = 4096;
/// Units in the last place of the largest value by which equal values may differ. The difference of
/// two rounded values has one; the others are for the arithmetic that made them.
const ULPS: f64 = 4.0;

/// The points, divided by a power of two near their extent. This does not change exponents, and no
/// square over- or underflows, whatever the unit of the data.
pub(crate) struct Cloud {
    pub(crate) points: Matrix,
    /// The divisor of the points.
    pub(crate) unit: f64,
    /// `√Σ var`, in the scaled unit.
    pub(crate) spread: f64,
    /// Difference below which two values are equal to rounding, in the scaled unit.
    pub(crate) rounding: f64,
}

impl Cloud {
    /// # Errors
    /// [`DataError::Constant`] if the points differ by rounding at most, [`DataError::Overflow`] if
    /// they differ by too much.
    pub(crate) fn new(series: &Series) -> Result<Self, DataError> {
        let constant = DataError::Constant { rows: series.len() };
        let columns = series.columns();
        let rows = || series.values().chunks_exact(columns);
        let Some(first) = rows().next() else {
            return Err(constant);
        };
        let mut extent: f64 = 0.0;
        // Two points may lie on opposite sides of the first, in all columns.
        let farthest = 0.25 * f64::MAX / (columns as f64).sqrt();
        for (i, row) in rows().enumerate() {
            for (c, (v, origin)) in row.iter().zip(first).enumerate() {
                // Halve first: the difference of two finite numbers may overflow.
                let half = (0.5 * v - 0.5 * origin).abs();
                if half > farthest {
                    let (row, column, value) = (i + 1, c + 1, *v);
                    return Err(DataError::Overflow { row, column, value });
                }
                extent = extent.max(half);
            }
        }
        if extent == 0.0 {
            return Err(constant);
        }
        let unit = power_of_two_near(extent);
        let scaled = series.values().iter().map(|v| v / unit).collect();
        let points = Matrix::new(scaled, columns);
        let mean = mean(&points);
        let largest = points.cells().iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let squares = points.rows().map(|p| distance2(p, &mean)).sum::<f64>();
        let variance = squares / series.len() as f64;
        let spread = variance.sqrt();
        let rounding = ULPS * f64::EPSILON * largest;
        if spread.is_nan() || spread <= rounding {
            return Err(constant);
        }
        Ok(Self {
            points,
            unit,
            spread,
            rounding,
        })
    }

    /// The first lag at which the autocorrelation of the series, all columns together, is below
    /// 1/e, or else the longest lag considered.
    pub(crate) fn decorrelation(&self) -> usize {
        let at = self.uncorrelated_at(libm::exp(-1.0));
        at.unwrap_or(longest_lag(self.points.len()))
    }

    /// Decorrelation time and spread of all columns together, in the unit of the data.
    pub(crate) fn scales(&self) -> (usize, f64) {
        (self.decorrelation(), self.unit * self.spread)
    }

    /// The first lag at which the autocorrelation of all columns together is below the threshold.
    /// `None` if there is none among the lags considered.
    pub(crate) fn uncorrelated_at(&self, threshold: f64) -> Option<usize> {
        let points = &self.points;
        let mean = mean(points);
        let thin = points.len().div_ceil(CORRELATION_TERMS);
        let correlation = |lag: usize| -> (f64, f64) {
            let pairs = points.rows().zip(points.rows().skip(lag)).step_by(thin);
            pairs.fold((0.0, 0.0), |(product, square), (a, b)| {
                let mut sums = (product, square);
                for c in 0..mean.len() {
                    sums.0 += (a[c] - mean[c]) * (b[c] - mean[c]);
                    sums.1 += (a[c] - mean[c]) * (a[c] - mean[c]);
                }
                sums
            })
        };
        (1..longest_lag(points.len())).find(|&lag| {
            let (product, square) = correlation(lag);
            product < threshold * square
        })
    }
}

/// The longest lag considered for this many rows.
pub(crate) fn longest_lag(rows: usize) -> usize {
    (rows / ROWS_PER_LAG).max(1)
}

fn mean(points: &Matrix) -> Vec<f64> {
    let mut mean = vec![0.0; points.columns()];
    for point in points.rows() {
        for (sum, v) in mean.iter_mut().zip(point) {
            *sum += v;
        }
    }
    mean.iter().map(|sum| sum / points.len() as f64).collect()
}

/// The largest power of two not above `v > 0`, limited to those with an exact reciprocal.
fn power_of_two_near(v: f64) -> f64 {
    const BIAS: i32 = 1023;
    // Eleven bits of exponent follow the sign.
    let exponent = ((v.to_bits() >> 52) & 0x7ff) as i32 - BIAS;
    f64::from_bits(((exponent.clamp(-1021, 1021) + BIAS) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_two() {
        for v in [1.0, 1.9, 2.0, 0.3, 5e300, 3e-300] {
            let power = power_of_two_near(v);
            assert!(power <= v && v < 2.0 * power, "{v}: {power}");
            assert_eq!(power.to_bits() << 12, 0, "{v}: {power}");
        }
    }

    #[test]
    fn decorrelation_of_a_sine_is_its_arc() {
        // cos(2π lag / 100) < 1/e from lag = 100 acos(1/e)/2π = 19.005 on.
        let angle = |i: usize| std::f64::consts::TAU * i as f64 / 100.0;
        // Wherever the sine's mean is.
        for mean in [0.0, 1000.0] {
            let rows = (0..5000).map(|i| [libm::cos(angle(i)) + mean, libm::sin(angle(i))]);
            let cloud = Cloud::new(&Series::from_rows(rows, 1.0).unwrap()).unwrap();
            assert!((19..=20).contains(&cloud.decorrelation()), "{mean}");
        }
    }
}
