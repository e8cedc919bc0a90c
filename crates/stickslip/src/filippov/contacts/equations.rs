//! Small linear systems on any scalar.

use crate::filippov::uncertainty::RELATIVE_ROUNDING;
use crate::scalar::Scalar;

/// Solves `a x = b` for the first `count` unknowns, in place; `b` becomes `x`.
///
/// Rows are not exchanged, so that no value decides and series stay series. If every problem of
/// these contacts has one solution, all principal minors have one sign (Samelson, Thrall & Wesler
/// 1958). Then no pivot vanishes.
#[inline(always)]
pub(super) fn solve<T: Scalar, const M: usize>(a: &mut [[T; M]; M], b: &mut [T; M], count: usize) {
    for k in 0..count {
        for i in k + 1..count {
            let factor = a[i][k] / a[k][k];
            let pivot = a[k];
            for (entry, above) in a[i][..count].iter_mut().zip(pivot).skip(k + 1) {
                *entry = *entry - factor * above;
            }
            b[i] = b[i] - factor * b[k];
        }
    }
    for k in (0..count).rev() {
        for j in k + 1..count {
            b[k] = b[k] - a[k][j] * b[j];
        }
        b[k] = b[k] / a[k][k];
    }
}

/// The determinant of the rows and columns in `chosen`, by elimination with pivots on the diagonal.
pub(super) fn principal_minor<const M: usize>(a: &[[f64; M]; M], chosen: &[usize]) -> f64 {
    let mut a = *a;
    let mut product = 1.0;
    for (index, &k) in chosen.iter().enumerate() {
        product *= a[k][k];
        if a[k][k] == 0.0 {
            return 0.0;
        }
        for &i in &chosen[index + 1..] {
            let factor = a[i][k] / a[k][k];
            for &j in &chosen[index + 1..] {
                a[i][j] -= factor * a[k][j];
            }
        }
    }
    product
}

/// Whether elimination finds all pivots positive, beyond rounding: of a symmetric matrix, whether
/// it is positive definite.
pub(super) fn has_positive_pivots<const M: usize>(a: &[[f64; M]; M], count: usize) -> bool {
    let mut left = *a;
    for k in 0..count {
        let is_positive = left[k][k] > RELATIVE_ROUNDING * a[k][k];
        if !is_positive {
            return false;
        }
        for i in k + 1..count {
            let factor = left[i][k] / left[k][k];
            let pivot = left[k];
            for (entry, above) in left[i][..count].iter_mut().zip(pivot).skip(k + 1) {
                *entry -= factor * above;
            }
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::principal_minor;

    #[test]
    fn minors_are_of_the_chosen_rows_and_vanish_with_any_pivot() {
        let matrix = [[2.0, 1.0, 0.0], [1.0, 2.0, 0.0], [0.0, 0.0, 5.0]];
        assert_eq!(principal_minor(&matrix, &[0, 1, 2]), 15.0);
        assert_eq!(principal_minor(&matrix, &[1, 2]), 10.0);
        // Two boundaries that coincide, before a third.
        let gram = [[1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        assert_eq!(principal_minor(&gram, &[0, 1, 2]), 0.0);
    }
}
