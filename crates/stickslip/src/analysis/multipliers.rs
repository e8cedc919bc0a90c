//! Eigenvalues of monodromy matrices.

use nalgebra::{Complex, Schur};

use super::cycle::{SAFETY, ULPS};
use crate::dynamics::Matrix;
use crate::math::modulus;

/// Multipliers of a periodic orbit: the eigenvalues of its monodromy matrix. The one nearest to 1
/// comes first (the trivial one of an autonomous system), then the others in descending order of
/// modulus. NaN where the matrix is not finite.
///
/// Two are computed by a closed form, more by the real Schur form.
///
/// ```
/// use stickslip::analysis::multipliers;
/// use stickslip::dynamics::Matrix;
/// use stickslip::math::modulus;
///
/// // A quarter turn about an axis along which all halves.
/// let matrix = Matrix::from_row_slice(3, 3, &[0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.5]);
/// let found = multipliers(&matrix);
/// assert!((found[0].re - 0.5).abs() < 1e-15);
/// assert!((found[1].im.abs() - 1.0).abs() < 1e-15 && modulus(found[1] + found[2]) < 1e-15);
/// ```
pub fn multipliers(matrix: &Matrix) -> Vec<Complex<f64>> {
    let mut found = eigenvalues(matrix);
    // The closed form puts the one nearer to 1 of two real eigenvalues first, and orders a pair.
    if found.len() == 2 {
        return found;
    }
    found.sort_by(|a, b| b.norm_sqr().total_cmp(&a.norm_sqr()));
    let off = |i: usize| (found[i] - 1.0).norm_sqr();
    if let Some(nearest) = (0..found.len()).min_by(|&i, &j| off(i).total_cmp(&off(j))) {
        found[..=nearest].rotate_right(1);
    }
    found
}

/// Eigenvalues of a square matrix in no order; NaN where it is not finite.
pub(super) fn eigenvalues(matrix: &Matrix) -> Vec<Complex<f64>> {
    let unknown = || vec![Complex::new(f64::NAN, f64::NAN); matrix.nrows()];
    if !matrix.iter().all(|v| v.is_finite()) {
        return unknown();
    }
    match matrix.nrows() {
        0 => Vec::new(),
        1 => vec![Complex::new(matrix[(0, 0)], 0.0)],
        2 => planar(
            matrix[(0, 0)],
            matrix[(0, 1)],
            matrix[(1, 0)],
            matrix[(1, 1)],
        )
        .to_vec(),
        _ => by_schur(matrix.clone()).unwrap_or_else(unknown),
    }
}

/// Uncertainties of multipliers from those of half the steps, each from the nearest one that is
/// left; NaN where there is none. `largest` is that of the entries of the monodromy matrix.
pub(super) fn uncertainties(
    found: &[Complex<f64>],
    mut others: Vec<Complex<f64>>,
    largest: f64,
) -> Vec<f64> {
    let rounding = ULPS * f64::EPSILON * largest;
    let uncertainty = |value: &Complex<f64>| {
        let off = |other: &Complex<f64>| modulus(other - value);
        let distances = others.iter().map(off).enumerate();
        let nearest = distances.min_by(|a, b| a.1.total_cmp(&b.1));
        nearest.map_or(f64::NAN, |(k, distance)| {
            others.swap_remove(k);
            SAFETY * distance + rounding
        })
    };
    found.iter().map(uncertainty).collect()
}

fn by_schur(matrix: Matrix) -> Option<Vec<Complex<f64>>> {
    let size = matrix.nrows();
    // Without convergence there is only rounding, which further iterations do not reduce.
    let schur = Schur::try_new(matrix, f64::EPSILON, 100 * size)?;
    Some(schur.complex_eigenvalues().iter().copied().collect())
}

/// Eigenvalues of the matrix with the rows (a, b) and (c, d).
fn planar(a: f64, b: f64, c: f64, d: f64) -> [Complex<f64>; 2] {
    let half_trace = 0.5 * (a + d);
    let determinant = a * d - b * c;
    let discriminant = half_trace * half_trace - determinant;
    if discriminant < 0.0 {
        let imaginary = (-discriminant).sqrt();
        return [
            Complex::new(half_trace, imaginary),
            Complex::new(half_trace, -imaginary),
        ];
    }
    // The larger by modulus without cancellation, the other from the product.
    let larger = half_trace + discriminant.sqrt() * half_trace.signum();
    let smaller = if larger == 0.0 {
        0.0
    } else {
        determinant / larger
    };
    let pair = [Complex::new(larger, 0.0), Complex::new(smaller, 0.0)];
    if (larger - 1.0).abs() <= (smaller - 1.0).abs() {
        pair
    } else {
        [pair[1], pair[0]]
    }
}
