//! The time between two rows: determined from a column, or compared with one.

use numerics::middle_two;

/// Relative deviation from `dt` that time steps may have. Times are often printed with three
/// digits.
const STEP_TOLERANCE: f64 = 0.01;
/// Relative error of times that are printed with ten digits. A step is rounded to ten digits if
/// that changes it by no more.
const PRINTING_ERROR: f64 = 1e-9;

/// Fewest values that show that uneven steps are rounded even ones. Chosen: a few values of any
/// column lie within the rounding of a line.
const ROUNDED_VALUES: usize = 10;

/// The median of the steps between values; `None` for fewer than two values.
pub(super) fn middle_step(values: impl Iterator<Item = f64> + Clone) -> Option<f64> {
    let pairs = values.clone().zip(values.skip(1));
    Some(rounded(middle_two(pairs.map(|(one, next)| next - one))?[0]))
}

/// Index of the first value that is not one step after the value before.
pub(super) fn first_gap(values: impl Iterator<Item = f64> + Clone, step: f64) -> Option<usize> {
    let mut pairs = (1..).zip(values.clone().zip(values.skip(1)));
    let (row, _) = pairs.find(|(_, (one, next))| !agree(next - one, step))?;
    Some(row)
}

/// Whether values go on by `step`, or by a mean step that their rounding hides in it. Rounded times
/// lie on a grid that is finer than the step, and off the even ones by less than its distance.
pub(super) fn is_even(values: impl DoubleEndedIterator<Item = f64> + Clone, step: f64) -> bool {
    if first_gap(values.clone(), step).is_none() {
        return true;
    }
    let mut sorted: Vec<f64> = values.clone().collect();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup();
    let (Some(grid), Some(mean)) = (common_step(&sorted), mean_step(values.clone())) else {
        return false;
    };
    let deviates_below = |step: f64, most: f64| {
        let away = (0u32..).zip(values.clone());
        let away = away.map(|(k, value)| value - f64::from(k) * step);
        let (low, high) = away.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), one| {
            (low.min(one), high.max(one))
        });
        high - low < (1.0 - PRINTING_ERROR) * most
    };
    // The mean itself is off by the rounding of both ends, and a lost row by a whole step.
    let is_near = agree(mean, step) || (mean - step).abs() <= grid;
    sorted.len() >= ROUNDED_VALUES
        && grid < 0.5 * step.abs()
        && (deviates_below(step, grid) || is_near && deviates_below(mean, 2.0 * grid))
}

/// The mean step of values; `None` for fewer than two values.
pub(super) fn mean_step(mut values: impl DoubleEndedIterator<Item = f64> + Clone) -> Option<f64> {
    let steps = values.clone().count().checked_sub(1)?;
    let (first, last) = (values.next()?, values.next_back()?);
    Some(rounded((last - first) / steps as f64))
}

/// The step of values that rise or fall evenly. Two values always do.
pub(super) fn even_step(values: impl DoubleEndedIterator<Item = f64> + Clone) -> Option<f64> {
    let step = mean_step(values.clone()).filter(|step| *step != 0.0)?;
    (values.clone().count() > 2 && is_even(values, step)).then_some(step)
}

/// The common divisor of all differences of distinct, ascending values, up to rounding. `None` if
/// the grid has more points than the square of the number of values: rows would then hardly ever
/// share a point.
pub(super) fn common_step(values: &[f64]) -> Option<f64> {
    let largest = values.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    // Each difference has an error of two half units in the last place, which Euclid's algorithm
    // multiplies by the quotients.
    let rounding = PRINTING_ERROR * largest;
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
    (step - dt).abs() <= STEP_TOLERANCE * dt.abs()
}

/// The step, or the number with fewer digits that it equals up to the rounding of printed times.
fn rounded(step: f64) -> f64 {
    let short: f64 = format!("{step:.9e}").parse().unwrap_or(step);
    if (short - step).abs() <= PRINTING_ERROR * step.abs() {
        short
    } else {
        step
    }
}
