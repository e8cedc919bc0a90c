//! Power laws by least squares.

/// A straight line through points whose coordinates are both positive, in logarithms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerLaw {
    /// The exponent: the slope by least squares.
    pub exponent: f64,
    /// Standard error of the exponent from the points' distances; not a number for two points.
    pub std_error: f64,
}

impl PowerLaw {
    /// Fits a law through points `(x, y)`; those with a `y` that is not positive are left out.
    ///
    /// ```
    /// use numerics::PowerLaw;
    ///
    /// let errors = [(0.1, 3e-4), (0.05, 3e-4 / 16.0), (0.025, 3e-4 / 256.0)];
    /// assert!((PowerLaw::through(errors).exponent - 4.0).abs() < 1e-12);
    /// ```
    pub fn through(points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let logs: Vec<(f64, f64)> = points
            .into_iter()
            .filter(|point| point.1 > 0.0)
            .map(|(x, y)| (libm::log(x), libm::log(y)))
            .collect();
        let n = logs.len() as f64;
        let (x, y) = (
            logs.iter().map(|p| p.0).sum::<f64>() / n,
            logs.iter().map(|p| p.1).sum::<f64>() / n,
        );
        let above: f64 = logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
        let below: f64 = logs.iter().map(|p| (p.0 - x) * (p.0 - x)).sum();
        let exponent = above / below;
        let residual = |p: &(f64, f64)| p.1 - y - exponent * (p.0 - x);
        let squares: f64 = logs.iter().map(|p| residual(p) * residual(p)).sum();
        let std_error = (squares / (n - 2.0) / below).sqrt();
        PowerLaw {
            exponent,
            std_error,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_law_with_scatter_has_the_textbook_s_error() {
        // Slope 2 through e³ with residuals 0.1, -0.2, 0.1 at -1, 0, 1: √(0.06/1/2).
        let e = std::f64::consts::E;
        let points = [(-1.0, 0.1), (0.0, -0.2), (1.0, 0.1)]
            .map(|(x, off)| (libm::pow(e, x), libm::exp(3.0 + 2.0 * x + off)));
        let law = PowerLaw::through(points.into_iter().chain([(1.0, 0.0)]));
        assert!((law.exponent - 2.0).abs() < 1e-14);
        assert!((law.std_error - 0.03f64.sqrt()).abs() < 1e-14);
    }
}
