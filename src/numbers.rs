//! Numerical helpers shared by all parts of the replication.

use numerics::bisect;
use stickslip::Error;

/// Largest difference that counts as rounding: relative, or absolute for values of order one in SI
/// units. It is thousands of rounding errors, and far below any printed digit.
pub(crate) const ROUNDING: f64 = 1e-12;

/// Points where a property begins or ends between neighbours of an ascending grid, to the last bit.
pub(crate) fn change_points(
    grid: impl IntoIterator<Item = f64>,
    has: impl Fn(f64) -> bool,
) -> Vec<f64> {
    let grid = grid.into_iter().map(|at| (at, has(at)));
    let grid: Vec<(f64, bool)> = grid.collect();
    let pairs = grid.windows(2).map(|pair| (pair[0], pair[1]));
    let changing = pairs.filter(|((_, before), (_, after))| before != after);
    changing
        .map(|((low, before), (high, _))| bisect(low, high, |at| has(at) != before))
        .collect()
}

/// Minimum and maximum of the values; `(∞, −∞)` for an empty sequence. NaN is skipped.
pub(crate) fn extent(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    let wider = |(low, high): (f64, f64), value: f64| (low.min(value), high.max(value));
    values.into_iter().fold(none, wider)
}

/// Maximum of nonnegative values; 0 for an empty sequence.
pub(crate) fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, f64::max)
}

/// Median; for an even count, the mean of the middle two.
pub(crate) fn median(values: &[f64]) -> Option<f64> {
    let middle = numerics::middle_two(values.iter().copied());
    middle.map(|[lower, upper]| 0.5 * (lower + upper))
}

/// The error of a search for `what` that started at time `t` and failed within `span` (s).
pub(crate) fn not_found(what: &'static str, t: f64, span: f64) -> Error {
    Error::NotFound { what, t, span }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_of_an_even_count_lies_between_the_middle_two() {
        assert_eq!(median(&[]), None);
        assert_eq!(median(&[3.0]), Some(3.0));
        assert_eq!(median(&[1.0, 2.0, 5.0]), Some(2.0));
        assert_eq!(median(&[1.0, 2.0, 5.0, 9.0]), Some(3.5));
    }
}
