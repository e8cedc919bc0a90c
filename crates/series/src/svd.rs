//! Small dense least squares: Householder triangle and one-sided Jacobi.
//!
//! Own code, because the sizes are tiny and the bits must be the same everywhere: only `+ − × ÷ √`,
//! in a fixed order. The triangle is found from the neighbour matrix itself and never from `Σ y
//! yᵀ`, whose condition number is the square.

use pulp::Arch;

use super::matrix::{Matrix, Row};
use super::series::MAX_COLUMNS;

/// A number in each lane.
type Lanes<const L: usize> = [f64; L];

/// One number for each lane. A loop over the array: the library's own way to fill one is not
/// inlined for many lanes.
#[inline(always)]
fn lanes<const L: usize>(mut f: impl FnMut(usize) -> f64) -> Lanes<L> {
    let mut out = [0.0; L];
    for (l, out) in out.iter_mut().enumerate() {
        *out = f(l);
    }
    out
}

/// Sweeps after which Jacobi's rotations stop; ten are more than ever needed.
const SWEEPS: usize = 40;
/// Cosine of two columns that counts as orthogonal: some units of rounding.
const ORTHOGONAL: f64 = 1e-15;

/// Turns `left` (`rows` × `columns`, column after column) into an upper triangle by reflections,
/// and applies them to `right` (with as many columns, or none). Returns the triangle and the upper
/// rows of the other. There must be as many rows as columns at least.
pub(crate) fn triangle(
    left: &mut [f64],
    right: &mut [f64],
    rows: usize,
    columns: usize,
) -> (Matrix, Matrix) {
    // With the machine's vectors, which change no bit: the partial sums of [`dot`] are lanes of
    // one.
    Arch::new().dispatch(
        #[inline(always)]
        || plain_triangle(left, right, rows, columns),
    )
}

#[inline(always)]
fn plain_triangle(
    left: &mut [f64],
    right: &mut [f64],
    rows: usize,
    columns: usize,
) -> (Matrix, Matrix) {
    let mut r = Matrix::zeros(columns, columns);
    let mut c = Matrix::zeros(columns, columns);
    for i in 0..columns {
        let (done, rest) = left.split_at_mut((i + 1) * rows);
        let mirror = &mut done[i * rows + i..];
        let norm = dot(mirror, mirror).sqrt();
        if norm > 0.0 {
            let corner = if mirror[0] > 0.0 { -norm } else { norm };
            mirror[0] -= corner;
            let square = dot(mirror, mirror);
            reflect_all(mirror, square, rest, (rows, i));
            reflect_all(mirror, square, right, (rows, i));
            r[i][i] = corner;
        }
        for (k, column) in rest.chunks_exact(rows).enumerate() {
            r[i][i + 1 + k] = column[i];
        }
    }
    for (k, column) in right.chunks_exact(rows).enumerate() {
        for i in 0..columns {
            c[i][k] = column[i];
        }
    }
    (r, c)
}

/// Columns that are reflected together: their sums do not wait for one another.
const TOGETHER: usize = 4;

/// Reflects columns of so many rows, each from row `first` on, at the plane across `mirror`, whose
/// square of length is `square`.
#[inline(always)]
pub(crate) fn reflect_all(
    mirror: &[f64],
    square: f64,
    columns: &mut [f64],
    (rows, first): (usize, usize),
) {
    let mut groups = columns.chunks_exact_mut(TOGETHER * rows);
    for group in &mut groups {
        let (a, group) = group.split_at_mut(rows);
        let (b, group) = group.split_at_mut(rows);
        let (c, d) = group.split_at_mut(rows);
        let group = [a, b, c, d].map(|column| &mut column[first..]);
        reflect(mirror, square, group);
    }
    let mut rest = groups.into_remainder().chunks_exact_mut(rows);
    let mut next = || -> Option<&mut [f64]> { rest.next().map(|column| &mut column[first..]) };
    match [next(), next(), next()] {
        [Some(a), Some(b), Some(c)] => reflect(mirror, square, [a, b, c]),
        [Some(a), Some(b), None] => reflect(mirror, square, [a, b]),
        [Some(a), ..] => reflect(mirror, square, [a]),
        _ => {}
    }
}

/// Reflects each column, with the bits that it has alone.
#[inline(always)]
fn reflect<const C: usize>(mirror: &[f64], square: f64, columns: [&mut [f64]; C]) {
    let sums = dots(mirror, columns.each_ref().map(|column| &**column));
    subtract(mirror, sums.map(|sum| 2.0 * sum / square), columns);
}

/// Subtracts multiples of the mirror from columns as long.
#[inline(always)]
fn subtract<const C: usize>(mirror: &[f64], factors: [f64; C], columns: [&mut [f64]; C]) {
    for (column, factor) in columns.into_iter().zip(factors) {
        for (v, m) in column.iter_mut().zip(mirror) {
            *v -= factor * m;
        }
    }
}

/// Reflects a row and the columns below it, each with as many rows as `mirror`, at the plane across
/// `first` and, below, `mirror`, whose square of length together is `square`.
#[inline(always)]
pub(crate) fn reflect_below(
    mirror: &[f64],
    (first, square): (f64, f64),
    row: &mut [f64],
    columns: &mut [f64],
) {
    let long = mirror.len();
    let scale = 2.0 / square;
    let mut groups = columns.chunks_exact_mut(TOGETHER * long);
    let mut heads = row.chunks_exact_mut(TOGETHER);
    for (group, head) in (&mut groups).zip(&mut heads) {
        let (a, group) = group.split_at_mut(long);
        let (b, group) = group.split_at_mut(long);
        let (c, d) = group.split_at_mut(long);
        let columns = [a, b, c, d];
        let sums = dots(mirror, columns.each_ref().map(|column| &**column));
        let factors: [f64; TOGETHER] = std::array::from_fn(|c| scale * (sums[c] + first * head[c]));
        for (head, factor) in head.iter_mut().zip(factors) {
            *head -= factor * first;
        }
        subtract(mirror, factors, columns);
    }
    let rest = groups.into_remainder().chunks_exact_mut(long);
    for (column, head) in rest.zip(heads.into_remainder()) {
        let factor = scale * (dot(mirror, column) + first * *head);
        *head -= factor * first;
        subtract(mirror, [factor], [column]);
    }
}

/// Scalar products with several columns as long, each with the bits of [`dot`].
#[inline(always)]
fn dots<const C: usize>(a: &[f64], columns: [&[f64]; C]) -> [f64; C] {
    let (a_fours, a_rest) = a.as_chunks::<4>();
    let columns = columns.map(|column| column[..a.len()].as_chunks::<4>());
    let fours = columns.map(|(fours, _)| &fours[..a_fours.len()]);
    let mut sums = [[0.0; 4]; C];
    // By index: iterators over so few columns are not unrolled.
    for k in 0..a_fours.len() {
        let x = a_fours[k];
        for c in 0..C {
            let y = fours[c][k];
            for i in 0..4 {
                sums[c][i] += x[i] * y[i];
            }
        }
    }
    std::array::from_fn(|c| {
        let [first, second, third, fourth] = sums[c];
        let rest: f64 = a_rest.iter().zip(columns[c].1).map(|(x, y)| x * y).sum();
        ((first + second) + (third + fourth)) + rest
    })
}

/// Four partial sums, in a fixed order: independent additions, so that they need not wait for one
/// another.
#[inline(always)]
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a_fours, a_rest) = a.as_chunks::<4>();
    let (b_fours, b_rest) = b.as_chunks::<4>();
    let mut sums = [0.0; 4];
    for (x, y) in a_fours.iter().zip(b_fours) {
        for i in 0..4 {
            sums[i] += x[i] * y[i];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(x, y)| x * y).sum();
    ((sums[0] + sums[1]) + (sums[2] + sums[3])) + rest
}

/// `m = u diag(s) vᵀ`, singular values in descending order.
#[derive(Default)]
pub(crate) struct Svd {
    /// Left singular vectors, `u[i]` the `i`th; zero where the singular value is.
    pub(crate) u: Matrix,
    /// Singular values.
    pub(crate) s: Row,
    /// Right singular vectors, `v[i]` the `i`th.
    pub(crate) v: Matrix,
}

/// Singular value decomposition of square matrices by rotations of the columns (Hestenes), which
/// finds small singular values to high relative accuracy. Several at once: every rotation waits for
/// roots and quotients, which a vector of them takes no longer for. Each has the bits that it has
/// alone.
pub(crate) fn svds<const L: usize>(m: [&Matrix; L]) -> [Svd; L] {
    let n = m.first().map_or(0, |m| m.columns());
    // Columns as rows: w[i] becomes u_i s_i.
    let mut w = [[[0.0; L]; MAX_COLUMNS]; MAX_COLUMNS];
    let mut v = w;
    // Squares of the columns' lengths and their roots change by rotations only.
    let mut squares = [[0.0; L]; MAX_COLUMNS];
    let mut norms = squares;
    for l in 0..L {
        for (k, row) in m[l].rows().enumerate() {
            for (column, cell) in w.iter_mut().zip(row) {
                column[k][l] = *cell;
            }
        }
    }
    for i in 0..n {
        v[i][i] = [1.0; L];
        squares[i] = products(&w[i][..n], &w[i][..n]);
        norms[i] = squares[i].map(f64::sqrt);
    }
    for _ in 0..SWEEPS {
        let mut rotated = false;
        for p in 0..n {
            for q in p + 1..n {
                let pq = products(&w[p][..n], &w[q][..n]);
                let turns: [bool; L] = std::array::from_fn(|l| {
                    let is_right = pq[l].abs() <= ORTHOGONAL * norms[p][l] * norms[q][l];
                    !(pq[l] == 0.0 || is_right)
                });
                if turns == [false; L] {
                    continue;
                }
                let zeta = lanes(|l| (squares[q][l] - squares[p][l]) / (2.0 * pq[l]));
                rotate([&mut w, &mut v], n, (p, q), turns, zeta);
                for column in [p, q] {
                    let w = &w[column][..n];
                    squares[column] = products(w, w);
                    norms[column] = squares[column].map(f64::sqrt);
                }
                rotated = true;
            }
        }
        if !rotated {
            break;
        }
    }
    std::array::from_fn(|l| {
        let norm = |i: usize| norms[i][l];
        let mut order: [usize; MAX_COLUMNS] = std::array::from_fn(|i| i);
        let order = &mut order[..n];
        order.sort_by(|&a, &b| norm(b).total_cmp(&norm(a)));
        let unit = |i: usize, x: f64| if norm(i) > 0.0 { x / norm(i) } else { 0.0 };
        let mut svd = Svd {
            u: Matrix::zeros(n, n),
            s: [0.0; MAX_COLUMNS],
            v: Matrix::zeros(n, n),
        };
        for (to, &i) in order.iter().enumerate() {
            svd.s[to] = norm(i);
            for (u, w) in svd.u[to].iter_mut().zip(&w[i]) {
                *u = unit(i, w[l]);
            }
            for (to, v) in svd.v[to].iter_mut().zip(&v[i]) {
                *to = v[l];
            }
        }
        svd
    })
}

/// Makes columns `p` and `q` orthogonal where they turn, by a rotation whose double angle has the
/// cotangent `zeta`.
#[inline(always)]
fn rotate<const L: usize>(
    matrices: [&mut [[Lanes<L>; MAX_COLUMNS]; MAX_COLUMNS]; 2],
    n: usize,
    (p, q): (usize, usize),
    turns: [bool; L],
    zeta: Lanes<L>,
) {
    let t: Lanes<L> =
        lanes(|l| zeta[l].signum() / (zeta[l].abs() + (1.0 + zeta[l] * zeta[l]).sqrt()));
    let cosine: Lanes<L> = lanes(|l| 1.0 / (1.0 + t[l] * t[l]).sqrt());
    let sine: Lanes<L> = lanes(|l| cosine[l] * t[l]);
    for matrix in matrices {
        let (upper, lower) = matrix.split_at_mut(q);
        for (a, b) in upper[p][..n].iter_mut().zip(&mut lower[0]) {
            let (x, y) = (*a, *b);
            for l in 0..L {
                if turns[l] {
                    a[l] = cosine[l] * x[l] - sine[l] * y[l];
                    b[l] = sine[l] * x[l] + cosine[l] * y[l];
                }
            }
        }
    }
}

/// Scalar products.
#[inline(always)]
fn products<const L: usize>(a: &[Lanes<L>], b: &[Lanes<L>]) -> Lanes<L> {
    let mut sum = [0.0; L];
    for (a, b) in a.iter().zip(b) {
        for l in 0..L {
            sum[l] += a[l] * b[l];
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matrix::product;
    use crate::statistics::SplitMix;

    fn matrix<const N: usize>(rows: [[f64; N]; N]) -> Matrix {
        Matrix::new(rows.concat(), N)
    }

    fn svd(m: &Matrix) -> Svd {
        let [svd] = svds([m]);
        svd
    }

    #[test]
    fn several_at_once_have_the_bits_that_each_has_alone() {
        let mut draw = SplitMix::new(1958);
        for case in 0..200 {
            // One needs many rotations, another none, a third has no rank.
            let random = Matrix::new((0..16).map(|_| draw.between(-1.0, 1.0)).collect(), 4);
            let mut diagonal = Matrix::zeros(4, 4);
            (0..4).for_each(|i| diagonal[i][i] = draw.between(-1.0, 1.0));
            let mut narrow = random.clone();
            narrow[3].copy_from_slice(&random[case % 3]);
            let all = [&random, &diagonal, &narrow, &Matrix::zeros(4, 4)];
            for (together, one) in svds(all).iter().zip(all) {
                let alone = svd(one);
                for (one, other) in [
                    (together.u.cells(), alone.u.cells()),
                    (&together.s[..], &alone.s),
                    (together.v.cells(), alone.v.cells()),
                ] {
                    let bits = |m: &[f64]| m.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
                    assert_eq!(bits(one), bits(other));
                }
            }
        }
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

    #[test]
    fn a_triangle_is_its_own_up_to_signs() {
        let (mut left, mut right) = (vec![2.0, 0.0, 0.0, 1.0, 3.0, 0.0], vec![1.0; 6]);
        let (r, c) = triangle(&mut left, &mut right, 3, 2);
        let sizes = |m: &Matrix| m.cells().iter().map(|v| v.abs()).collect::<Vec<_>>();
        assert_eq!(sizes(&r), [2.0, 1.0, 0.0, 3.0]);
        assert_eq!(sizes(&c), [1.0; 4]);
    }

    #[test]
    fn the_machine_s_vectors_change_no_bit() {
        let mut draw = SplitMix::new(14);
        let columns: Vec<f64> = (0..8 * 37).map(|_| draw.between(-1.0, 1.0)).collect();
        let [mut plain, mut vectors] = [columns.clone(), columns];
        let (left, right) = plain.split_at_mut(4 * 37);
        let by_plain = plain_triangle(left, right, 37, 4);
        let (left, right) = vectors.split_at_mut(4 * 37);
        let by_vectors = triangle(left, right, 37, 4);
        assert_eq!(by_plain, by_vectors);
        assert_eq!(plain, vectors);
    }

    /// A map with a condition number of 1e10 is recovered to 1e-5 (rounding times condition);
    /// normal equations, whose condition would be 1e20, would recover nothing.
    #[test]
    fn ill_conditioned_least_squares() {
        const ROWS: usize = 9;
        let map = [[0.3, 0.7], [-1.1, 0.4]];
        let mut left = vec![0.0; 2 * ROWS];
        let mut right = vec![0.0; 2 * ROWS];
        for k in 0..ROWS {
            let a = k as f64 - 3.7;
            let y = [a, a + 1e-10 * (a * a - 5.0)];
            for c in 0..2 {
                left[c * ROWS + k] = y[c];
                right[c * ROWS + k] = map[c][0] * y[0] + map[c][1] * y[1];
            }
        }
        let (r, c) = triangle(&mut left, &mut right, ROWS, 2);
        let d = svd(&r);
        for (out, row) in map.iter().enumerate() {
            for (from, expected) in row.iter().enumerate() {
                let fitted: f64 = (0..2)
                    .map(|i| {
                        let image: f64 = (0..2).map(|k| d.u[i][k] * c[k][out]).sum();
                        d.v[i][from] * image / d.s[i]
                    })
                    .sum();
                assert!((fitted - expected).abs() < 1e-5, "{fitted} {expected}");
            }
        }
    }
}
