//! The linear equations of a Newton step, which may leave directions undetermined.

use crate::dynamics::{Matrix, Vector};

/// Solves the equations of a Newton step, the first of which are those of so many states. To within
/// their error, equations may leave directions undetermined: the position of a block on which
/// nothing depends, the energy of a pendulum. The solution has no component in these directions. At
/// least a given number of directions are excluded; the number excluded is returned, too.
///
/// The second matrix is the part of the first that is due to changes of the state. The error of the
/// equations is a fraction of that part: of a state that changes little in a period, it is small.
pub(super) fn newton_solution(
    [matrix, mut changes]: [Matrix; 2],
    right: &Vector,
    (states, least_free): (usize, usize),
    (sizes, error): (Vector, f64),
) -> Option<(Vector, usize)> {
    if !matrix.iter().all(|entry| entry.is_finite()) {
        return None;
    }
    if error == 0.0 {
        return Some((matrix.lu().solve(right)?, 0));
    }
    let count = matrix.nrows();
    let mut scaled = matrix.clone();
    let mut units = Vector::repeat(count, 1.0);
    let mut right_scaled = right.clone();
    let mut scale_row = |scaled: &mut Matrix, k: usize, by: f64| {
        scaled.row_mut(k).scale_mut(by);
        changes.row_mut(k).scale_mut(by);
        right_scaled[k] *= by;
    };
    for (k, size) in sizes.iter().take(states).enumerate() {
        units[k] = *size;
        scaled.column_mut(k).scale_mut(*size);
        scale_row(&mut scaled, k, size.recip());
    }
    // Other unknowns and equations are scaled by their entries: equations first, so that their
    // units do not decide which unknowns count.
    let mut by_rows = |scaled: &mut Matrix| {
        for k in states..count {
            let row = scaled.row(k).norm().max(f64::MIN_POSITIVE);
            scale_row(scaled, k, row.recip());
        }
    };
    by_rows(&mut scaled);
    for k in states..count {
        units[k] = scaled.column(k).norm().max(f64::MIN_POSITIVE).recip();
        scaled.column_mut(k).scale_mut(units[k]);
    }
    by_rows(&mut scaled);
    if !scaled.iter().all(|v| v.is_finite()) {
        return None;
    }
    for (k, unit) in units.iter().enumerate() {
        changes.column_mut(k).scale_mut(*unit);
    }
    let parts = scaled.svd(true, true);
    let (left, directions) = (parts.u?, parts.v_t?);
    let largest = parts.singular_values.max();
    let rounding = count as f64 * f64::EPSILON * largest;
    let mut all: Vec<usize> = (0..count).collect();
    all.sort_by(|&a, &b| parts.singular_values[a].total_cmp(&parts.singular_values[b]));
    let is_free = |(number, k): (usize, usize)| {
        let change = (&changes * directions.row(k).transpose())
            .norm()
            .min(largest);
        number < least_free || parts.singular_values[k] <= rounding.max(error * change)
    };
    let (mut solution, mut free) = (Vector::zeros(count), 0);
    for (number, k) in all.into_iter().enumerate() {
        if is_free((number, k)) {
            free += 1;
        } else {
            let part = left.column(k).dot(&right_scaled) / parts.singular_values[k];
            solution += directions.row(k).transpose() * part;
        }
    }
    match free {
        0 => Some((matrix.lu().solve(right)?, 0)),
        free => Some((solution.component_mul(&units), free)),
    }
}
