//! The linear equations of a Newton step, which may leave directions undetermined.

use crate::dynamics::{Matrix, Vector};

/// Solves the equations of a Newton step, the first of which are those of so many states. To within
/// their error, equations may leave directions undetermined: the position of a block on which
/// nothing depends, the energy of a pendulum. The solution has no component in these directions. At
/// least a given number of directions are excluded; the number excluded is returned, too.
pub(super) fn newton_solution(
    matrix: Matrix,
    right: &Vector,
    (states, least_free): (usize, usize),
    (sizes, error): (Vector, f64),
) -> Option<(Vector, usize)> {
    let count = matrix.nrows();
    let mut scaled = matrix.clone();
    let mut units = Vector::repeat(count, 1.0);
    let mut right_scaled = right.clone();
    for (k, size) in sizes.iter().take(states).enumerate() {
        units[k] = *size;
        scaled.column_mut(k).scale_mut(*size);
        scaled.row_mut(k).unscale_mut(*size);
        right_scaled[k] /= *size;
    }
    // Other unknowns and equations are scaled by their entries: equations first, so that their
    // units do not decide which unknowns count.
    let by_rows = |scaled: &mut Matrix, right: &mut Vector| {
        for k in states..count {
            let row = scaled.row(k).norm().max(f64::MIN_POSITIVE);
            scaled.row_mut(k).unscale_mut(row);
            right[k] /= row;
        }
    };
    by_rows(&mut scaled, &mut right_scaled);
    for k in states..count {
        units[k] = scaled.column(k).norm().max(f64::MIN_POSITIVE).recip();
        scaled.column_mut(k).scale_mut(units[k]);
    }
    by_rows(&mut scaled, &mut right_scaled);
    if !scaled.iter().all(|v| v.is_finite()) {
        return None;
    }
    if error == 0.0 {
        return Some((matrix.lu().solve(right)?, 0));
    }
    let parts = scaled.svd(true, true);
    let mut values: Vec<f64> = parts.singular_values.iter().copied().collect();
    values.sort_by(f64::total_cmp);
    let rounding = count as f64 * f64::EPSILON;
    let resolved = error.max(rounding) * parts.singular_values.max();
    let bound = values
        .iter()
        .take(least_free)
        .copied()
        .fold(resolved, f64::max);
    let free = values.iter().filter(|value| **value <= bound);
    match free.count() {
        0 => Some((matrix.lu().solve(right)?, 0)),
        free => {
            let solution = parts.solve(&right_scaled, bound).ok()?;
            Some((solution.component_mul(&units), free))
        }
    }
}
