//! The time between two rows: from a column, or held against one.

use stickslip_series::statistics::middle_two;

/// Rows may be further apart in time than `dt` by this part of it: times are often printed with
/// three digits.
const UNEVEN: f64 = 0.01;
/// A step that differs from one of ten digits by no more than this part is that one: the rest is
/// rounding of the printed times.
const ROUNDING: f64 = 1e-9;

/// The middle one of the steps between values; none of fewer than two values.
pub(super) fn middle_step(values: impl Iterator<Item = f64> + Clone) -> Option<f64> {
    let pairs = values.clone().zip(values.skip(1));
    Some(rounded(middle_two(pairs.map(|(one, next)| next - one))?[0]))
}

/// The number, counted from 0, of the first value that is not a step behind the one before it.
pub(super) fn first_gap(values: impl Iterator<Item = f64> + Clone, step: f64) -> Option<usize> {
    let mut pairs = (1..).zip(values.clone().zip(values.skip(1)));
    let (row, _) = pairs.find(|(_, (one, next))| !agree(next - one, step))?;
    Some(row)
}

/// The step of values from the first to the last of them; none of fewer than two.
pub(super) fn mean_step(mut values: impl DoubleEndedIterator<Item = f64> + Clone) -> Option<f64> {
    let steps = values.clone().count().checked_sub(1)?;
    let (first, last) = (values.next()?, values.next_back()?);
    Some(rounded((last - first) / steps as f64))
}

/// The step of values that rise or fall evenly; two are even whatever they are.
pub(super) fn even_step(values: impl DoubleEndedIterator<Item = f64> + Clone) -> Option<f64> {
    let step = mean_step(values.clone()).filter(|step| *step != 0.0)?;
    let is_even = values.clone().count() > 2 && first_gap(values, step).is_none();
    is_even.then_some(step)
}

/// What all distances of different, ascending values are multiples of, up to rounding. None if
/// there are more such places than the square of the number of values: of so many, rows would
/// hardly ever share one.
pub(super) fn common_step(values: &[f64]) -> Option<f64> {
    let largest = values.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    // Each difference is off by two half units in the last place, and Euclid's algorithm multiplies
    // that by the quotients.
    let rounding = ROUNDING * largest;
    let step = values.windows(2).fold(0.0, |step: f64, pair| {
        let (mut a, mut b) = (pair[1] - pair[0], step);
        while b > rounding {
            (a, b) = (b, (a - b * (a / b).round()).abs());
        }
        a
    });
    let range = values.last()? - values.first()?;
    let places = (range / step).round();
    let count = values.len() as f64;
    (places <= count * count).then(|| rounded(range / places))
}

/// Whether two steps are the same.
pub(super) fn agree(step: f64, dt: f64) -> bool {
    (step - dt).abs() <= UNEVEN * dt.abs()
}

/// The step itself, or the shorter number that it is but for the rounding of printed times.
fn rounded(step: f64) -> f64 {
    let short: f64 = format!("{step:.9e}").parse().unwrap_or(step);
    if (short - step).abs() <= ROUNDING * step.abs() {
        short
    } else {
        step
    }
}
