//! Singular values of small matrices, by one-sided Jacobi rotations.
//!
//! Own code, because the sizes are tiny and the results must be bit-for-bit the same everywhere:
//! only `+ − × ÷ √`, in a fixed order.

use super::matrix::{Matrix, Row, product};
use super::series::MAX_COLUMNS;

/// Sweeps after which Jacobi's rotations stop. They converge quadratically, in fewer than ten.
const MOST_SWEEPS: usize = 40;
/// Cosine of two columns that counts as orthogonal: some units of rounding.
const ORTHOGONAL_COSINE: f64 = 1e-15;

/// `m = u diag(s) vᵀ`, singular values in descending order.
pub(crate) struct Svd {
    /// Left singular vectors, `u[i]` the `i`th; zero where the singular value is.
    pub(crate) u: Matrix,
    /// Singular values.
    pub(crate) s: Row,
    /// Right singular vectors, `v[i]` the `i`th.
    pub(crate) v: Matrix,
}

/// Singular value decomposition of a square matrix by rotations of the columns (Hestenes), which
/// computes small singular values to high relative accuracy.
pub(crate) fn svd(m: &Matrix) -> Svd {
    let n = m.columns();
    // Columns as rows: w[i] becomes u_i s_i.
    let mut w = [[0.0; MAX_COLUMNS]; MAX_COLUMNS];
    let mut v = w;
    for (k, row) in m.rows().enumerate() {
        for (column, cell) in w.iter_mut().zip(row) {
            column[k] = *cell;
        }
    }
    // Squares of the columns' lengths and their roots change by rotations only.
    let mut squares = [0.0; MAX_COLUMNS];
    let mut norms = squares;
    for i in 0..n {
        v[i][i] = 1.0;
        squares[i] = product(&w[i][..n], &w[i][..n]);
        norms[i] = squares[i].sqrt();
    }
    let pairs = || (0..n).flat_map(|p| (p + 1..n).map(move |q| (p, q)));
    for _ in 0..MOST_SWEEPS {
        let mut rotated = false;
        for (p, q) in pairs() {
            let pq = product(&w[p][..n], &w[q][..n]);
            if pq == 0.0 || pq.abs() <= ORTHOGONAL_COSINE * norms[p] * norms[q] {
                continue;
            }
            // The cotangent of the double angle.
            let zeta = (squares[q] - squares[p]) / (2.0 * pq);
            let t = zeta.signum() / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
            let cosine = 1.0 / (1.0 + t * t).sqrt();
            let sine = cosine * t;
            for matrix in [&mut w, &mut v] {
                let (upper, lower) = matrix.split_at_mut(q);
                for (a, b) in upper[p][..n].iter_mut().zip(&mut lower[0]) {
                    (*a, *b) = (cosine * *a - sine * *b, sine * *a + cosine * *b);
                }
            }
            for i in [p, q] {
                squares[i] = product(&w[i][..n], &w[i][..n]);
                norms[i] = squares[i].sqrt();
            }
            rotated = true;
        }
        if !rotated {
            break;
        }
    }
    let mut order: [usize; MAX_COLUMNS] = std::array::from_fn(|i| i);
    order[..n].sort_by(|&a, &b| norms[b].total_cmp(&norms[a]));
    let mut svd = Svd {
        u: Matrix::zeros(n, n),
        s: [0.0; MAX_COLUMNS],
        v: Matrix::zeros(n, n),
    };
    for (to, &i) in order[..n].iter().enumerate() {
        svd.s[to] = norms[i];
        if norms[i] > 0.0 {
            let unit = svd.u[to].iter_mut().zip(&w[i]);
            unit.for_each(|(u, w)| *u = w / norms[i]);
        }
        svd.v[to].copy_from_slice(&v[i][..n]);
    }
    svd
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix<const N: usize>(rows: [[f64; N]; N]) -> Matrix {
        Matrix::new(rows.concat(), N)
    }

    #[test]
    fn the_decomposition_multiplies_back() {
        let m = matrix([[1.0, 2.0, -3.0], [0.0, 1e-6, 4.0], [0.0, 0.0, 1e-9]]);
        let d = svd(&m);
        for r in 0..3 {
            for c in 0..3 {
                let back: f64 = (0..3).map(|i| d.u[i][r] * d.s[i] * d.v[i][c]).sum();
                assert!((m[r][c] - back).abs() < 1e-14, "{} {back}", m[r][c]);
                let unit = f64::from(u8::from(r == c));
                assert!((product(&d.v[r], &d.v[c]) - unit).abs() < 1e-14);
            }
        }
        assert!(d.s[0] > d.s[1] && d.s[1] > d.s[2]);
    }

    #[test]
    fn zero_and_deficient_matrices_have_zero_singular_values() {
        assert_eq!(svd(&Matrix::zeros(3, 3)).s[..3], [0.0; 3]);
        let d = svd(&matrix([[0.0, 3.0], [0.0, 4.0]]));
        assert_eq!(d.s[..2], [5.0, 0.0]);
        assert_eq!([d.v[0][0].abs(), d.v[0][1].abs()], [0.0, 1.0]);
    }
}
