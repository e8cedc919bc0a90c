//! Least squares over the neighbours of a point, for linear maps and for polynomials, to which more
//! neighbours can be added.
//!
//! Own code, because the sizes are tiny and the results must be bit-for-bit the same everywhere:
//! only `+ − × ÷ √`, in a fixed order. The triangular factor is computed from the coordinates of
//! the neighbours, never from `Σ y yᵀ`, whose condition number is the square.

use pulp::Arch;

use super::matrix::Matrix;
use super::tree::Neighbour;

/// Partial sums of a scalar product. Rows are padded with zeros to a multiple of this, which
/// changes no sum and fills whole SIMD vectors.
const PARTIAL_SUMS: usize = 4;
/// Columns reflected together, so that their sums are independent instructions. It changes no bit.
const COLUMNS_TOGETHER: usize = 4;
/// Fraction of the largest singular value below which one is zero by default, and of a column's
/// length below which it depends on others. Chosen: some 1e5 roundings.
pub(crate) const RANK_TOLERANCE: f64 = 1e-10;

/// The terms of the polynomial fitted to each component of the image.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Terms {
    /// Number of directions with quadratic forms.
    pub(crate) forms: usize,
    /// Whether there is a constant.
    pub(crate) affine: bool,
    /// `d` of Eq. (25).
    pub(crate) step: usize,
}

impl Terms {
    /// Unknowns for each component of the image, in `columns` columns.
    pub(crate) fn unknowns(&self, columns: usize) -> usize {
        columns + self.forms * (self.forms + 1) / 2 + usize::from(self.affine)
    }
}

/// Components of images that are columns of the point itself. For delayed values one delay ahead
/// these are all but the last, and only the last is fitted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ShiftedColumns {
    /// The column of the point that each component of the image equals, if any.
    sources: Vec<Option<usize>>,
    /// The components that equal none.
    fitted: Vec<usize>,
}

impl ShiftedColumns {
    /// The shifted columns of points whose images come `step` later. A component equals a column of
    /// the point if it does so at all points.
    pub(crate) fn of(points: &Matrix, step: usize) -> Self {
        let columns = points.columns();
        let is_column = |component: usize, column: usize| {
            let mut pairs = points.rows().zip(points.rows().skip(step));
            column != component && pairs.all(|(a, b)| a[column] == b[component])
        };
        let sources: Vec<Option<usize>> = (0..columns)
            .map(|component| (0..columns).find(|&column| is_column(component, column)))
            .collect();
        let fitted = (0..columns).filter(|&c| sources[c].is_none()).collect();
        Self { sources, fitted }
    }
}

/// A fit, whose memory is reused for the next point.
pub(crate) struct LeastSquares<'a> {
    points: &'a Matrix,
    shifted: &'a ShiftedColumns,
    /// The triangle of the neighbours so far, row after row: constant, forms, coordinates along the
    /// directions, images. The linear terms come after the forms, so that their corner of the
    /// triangle is free of the forms.
    triangle: Vec<f64>,
    /// Rows of the neighbours to be added, column after column.
    rows: Vec<f64>,
    unknowns: usize,
    /// Neighbours so far.
    pub(crate) count: usize,
    /// Sum of squares of the residuals of their images.
    pub(crate) residual: f64,
}

impl<'a> LeastSquares<'a> {
    pub(crate) fn new(points: &'a Matrix, shifted: &'a ShiftedColumns) -> Self {
        Self {
            points,
            shifted,
            triangle: Vec::new(),
            rows: Vec::new(),
            unknowns: 0,
            count: 0,
            residual: 0.0,
        }
    }

    /// Fits the terms to the neighbours of point `j`, in coordinates along the directions.
    pub(crate) fn fit(
        &mut self,
        j: usize,
        neighbours: &[Neighbour],
        directions: &Matrix,
        terms: Terms,
    ) {
        self.unknowns = terms.unknowns(self.points.columns());
        let columns = self.unknowns + self.shifted.fitted.len();
        self.triangle.clear();
        self.triangle.resize(self.unknowns * columns, 0.0);
        (self.count, self.residual) = (0, 0.0);
        self.extend(j, neighbours, directions, terms);
    }

    /// Adds further neighbours to the fit. The triangle holds all that is needed of the earlier
    /// ones.
    pub(crate) fn extend(
        &mut self,
        j: usize,
        further: &[Neighbour],
        directions: &Matrix,
        terms: Terms,
    ) {
        self.count += further.len();
        if !further.is_empty() {
            // With the machine's vectors, which change no bit: the partial sums of [`dot`] are
            // lanes of one.
            self.residual += Arch::new().dispatch(
                #[inline(always)]
                || self.add(j, further, directions, terms),
            );
        }
    }

    /// Writes the columns, each of `long` rows.
    #[inline(always)]
    fn fill(
        &mut self,
        j: usize,
        further: &[Neighbour],
        directions: &Matrix,
        terms: Terms,
        long: usize,
    ) {
        let (forms, unknowns) = (terms.forms, self.unknowns);
        let components = self.points.columns();
        // Temporarily, the differences to the point come last.
        let columns = unknowns + self.shifted.fitted.len();
        let cells = (columns + components) * long;
        if self.rows.len() < cells {
            self.rows.resize(cells, 0.0);
        }
        let (columns, differences) = self.rows[..cells].split_at_mut(columns * long);
        let (known, images) = columns.split_at_mut(unknowns * long);
        let (before, along) = known.split_at_mut((unknowns - components) * long);
        let count = further.len();
        let origin = &self.points[j];
        let image = &self.points[j + terms.step];
        for (row, &(_, k)) in further.iter().enumerate() {
            let point = &self.points[k as usize];
            for (c, (v, origin)) in point.iter().zip(origin).enumerate() {
                differences[c * long + row] = v - origin;
            }
            let ahead = &self.points[k as usize + terms.step];
            for (i, &c) in self.shifted.fitted.iter().enumerate() {
                images[i * long + row] = ahead[c] - image[c];
            }
        }
        let written = images.chunks_exact_mut(long);
        for column in written.chain(differences.chunks_exact_mut(long)) {
            column[count..].fill(0.0);
        }
        for (along, direction) in along.chunks_exact_mut(long).zip(directions.rows()) {
            along.fill(0.0);
            for (part, column) in direction.iter().zip(differences.chunks_exact(long)) {
                for (sum, difference) in along.iter_mut().zip(column) {
                    *sum += part * difference;
                }
            }
        }
        let mut columns = before.chunks_exact_mut(long);
        if terms.affine
            && let Some(ones) = columns.next()
        {
            ones[..count].fill(1.0);
            ones[count..].fill(0.0);
        }
        let pairs = (0..forms).flat_map(|a| (a..forms).map(move |b| (a, b)));
        for (column, (a, b)) in columns.zip(pairs) {
            let factors = along[a * long..][..long].iter().zip(&along[b * long..]);
            for (product, (a, b)) in column.iter_mut().zip(factors) {
                *product = a * b;
            }
        }
    }

    /// Adds neighbours to the triangle, by reflections that annihilate their rows, and returns the
    /// sum of squares of the residuals of their images. A column of which at most
    /// [`RANK_TOLERANCE`] is orthogonal to those before it gets a zero on the diagonal and is
    /// skipped.
    #[inline(always)]
    fn add(&mut self, j: usize, further: &[Neighbour], directions: &Matrix, terms: Terms) -> f64 {
        let long = further.len().next_multiple_of(PARTIAL_SUMS);
        self.fill(j, further, directions, terms, long);
        let unknowns = self.unknowns;
        let columns = self.triangle.len() / unknowns;
        let rows = &mut self.rows[..columns * long];
        for i in 0..unknowns {
            let above: f64 = (0..i)
                .map(|row| self.triangle[row * columns + i])
                .map(|v| v * v)
                .sum();
            let row = &mut self.triangle[i * columns..][..columns];
            let (done, rest) = rows.split_at_mut((i + 1) * long);
            let mirror = &done[i * long..];
            let below = dot(mirror, mirror);
            let square = row[i] * row[i] + below;
            let norm = square.sqrt();
            if norm <= RANK_TOLERANCE * (above + square).sqrt() {
                row[i] = 0.0;
                continue;
            }
            let corner = if row[i] > 0.0 { -norm } else { norm };
            let first = row[i] - corner;
            row[i] = corner;
            reflect_below(
                mirror,
                (first, first * first + below),
                &mut row[i + 1..],
                rest,
            );
        }
        let images = &rows[unknowns * long..];
        dot(images, images)
    }

    /// The part of the linear terms alone: the triangle of the coordinates along the directions,
    /// and the images row by row. For an image that equals a column of the point, it is the part of
    /// that column.
    pub(crate) fn linear_part(&self, directions: &Matrix) -> (Matrix, Matrix) {
        let components = self.points.columns();
        let first = self.unknowns - components;
        let columns = self.unknowns + self.shifted.fitted.len();
        let mut triangle = Matrix::zeros(components, components);
        let mut images = triangle.clone();
        for (i, row) in self.triangle.chunks_exact(columns).skip(first).enumerate() {
            let (along, fitted) = row[first..].split_at(components);
            triangle[i].copy_from_slice(along);
            for (&component, image) in self.shifted.fitted.iter().zip(fitted) {
                images[i][component] = *image;
            }
            for (component, source) in self.shifted.sources.iter().enumerate() {
                if let Some(column) = *source {
                    let terms = (i..components).map(|k| along[k] * directions[k][column]);
                    images[i][component] = terms.sum();
                }
            }
        }
        (triangle, images)
    }
}

/// Applies a Householder reflection to a row and the columns below it, each with as many rows as
/// `mirror`. The vector of the reflection is `first` followed by `mirror`, with the squared length
/// `square`.
#[inline(always)]
fn reflect_below(
    mirror: &[f64],
    (first, square): (f64, f64),
    row: &mut [f64],
    columns: &mut [f64],
) {
    let long = mirror.len();
    let scale = 2.0 / square;
    let mut groups = columns.chunks_exact_mut(COLUMNS_TOGETHER * long);
    let mut heads = row.chunks_exact_mut(COLUMNS_TOGETHER);
    for (group, head) in (&mut groups).zip(&mut heads) {
        let (a, group) = group.split_at_mut(long);
        let (b, group) = group.split_at_mut(long);
        let (c, d) = group.split_at_mut(long);
        let columns = [a, b, c, d];
        let sums = dots(mirror, columns.each_ref().map(|column| &**column));
        let factors: [f64; COLUMNS_TOGETHER] =
            std::array::from_fn(|c| scale * (sums[c] + first * head[c]));
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

/// Subtracts multiples of the mirror from columns of the same length.
#[inline(always)]
fn subtract<const C: usize>(mirror: &[f64], factors: [f64; C], columns: [&mut [f64]; C]) {
    for (column, factor) in columns.into_iter().zip(factors) {
        for (v, m) in column.iter_mut().zip(mirror) {
            *v -= factor * m;
        }
    }
}

/// Scalar products with several columns of the same length, each bit-for-bit that of [`dot`].
#[inline(always)]
fn dots<const C: usize>(a: &[f64], columns: [&[f64]; C]) -> [f64; C] {
    let (a_fours, a_rest) = a.as_chunks::<PARTIAL_SUMS>();
    let columns = columns.map(|column| column[..a.len()].as_chunks::<PARTIAL_SUMS>());
    let mut sums = [[0.0; PARTIAL_SUMS]; C];
    // By index: iterators over so few columns are not unrolled.
    for (k, x) in a_fours.iter().enumerate() {
        for c in 0..C {
            let y = columns[c].0[k];
            for i in 0..PARTIAL_SUMS {
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

/// Four partial sums, in a fixed order, so that additions are independent.
#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let [sum] = dots(a, [b]);
    sum
}

/// Workspace for the least squares of linear maps, reused for every point.
#[derive(Default)]
pub(crate) struct Scratch {
    left: Vec<f64>,
    right: Vec<f64>,
}

/// The least squares of a linear map.
pub(crate) struct Triangle {
    pub(crate) points: Matrix,
    /// `Qᵀ Y'`, upper rows.
    pub(crate) images: Matrix,
    /// Sum of squares of its lower rows, which no linear map explains.
    pub(crate) residual: f64,
    /// Number of rows, at least that of the columns.
    pub(crate) rows: usize,
}

impl Scratch {
    /// Reduces the differences between point `j` and its neighbours to a triangle by reflections.
    /// These are also applied to the differences `step` later. With `affine` the means are
    /// subtracted, which is equivalent to fitting a constant.
    pub(crate) fn triangle(
        &mut self,
        points: &Matrix,
        j: usize,
        neighbours: &[Neighbour],
        step: usize,
        affine: bool,
    ) -> Triangle {
        let columns = points.columns();
        let rows = neighbours.len().max(columns);
        differences(points, j, 0, neighbours, affine, &mut self.left);
        differences(points, j, step, neighbours, affine, &mut self.right);
        // With the machine's vectors, which change no bit: the partial sums of [`dot`] are lanes of
        // one.
        let triangle = Arch::new().dispatch(
            #[inline(always)]
            || reflect(&mut self.left, &mut self.right, rows, columns),
        );
        let mut images = Matrix::zeros(columns, columns);
        for (k, column) in self.right.chunks_exact(rows).enumerate() {
            (0..columns).for_each(|i| images[i][k] = column[i]);
        }
        let lower = self.right.chunks_exact(rows).flat_map(|c| &c[columns..]);
        Triangle {
            points: triangle,
            images,
            residual: lower.map(|v| v * v).sum(),
            rows,
        }
    }
}

/// `x_{k + ahead} − x_{j + ahead}` of all neighbours `k`, column after column, padded with zeros to
/// as many rows as columns; with `affine` minus their mean.
fn differences(
    points: &Matrix,
    j: usize,
    ahead: usize,
    neighbours: &[Neighbour],
    affine: bool,
    columns: &mut Vec<f64>,
) {
    let origin = &points[j + ahead];
    let rows = neighbours.len().max(points.columns());
    columns.clear();
    columns.resize(points.columns() * rows, 0.0);
    // The coordinates of a point are contiguous, so each point is fetched once.
    for (row, &(_, k)) in neighbours.iter().enumerate() {
        let point = &points[k as usize + ahead];
        for (c, (v, origin)) in point.iter().zip(origin).enumerate() {
            columns[c * rows + row] = v - origin;
        }
    }
    if affine && !neighbours.is_empty() {
        for column in columns.chunks_exact_mut(rows) {
            let column = &mut column[..neighbours.len()];
            let mean = column.iter().sum::<f64>() / neighbours.len() as f64;
            column.iter_mut().for_each(|v| *v -= mean);
        }
    }
}

/// Reflects columns with this many rows until the left ones form an upper triangle, which is
/// returned.
#[inline(always)]
fn reflect(left: &mut [f64], right: &mut [f64], rows: usize, columns: usize) -> Matrix {
    let mut triangle = Matrix::zeros(columns, columns);
    for i in 0..columns {
        let (done, others) = left.split_at_mut((i + 1) * rows);
        let mirror = &mut done[i * rows + i..];
        let norm = dot(mirror, mirror).sqrt();
        if norm > 0.0 {
            let corner = if mirror[0] > 0.0 { -norm } else { norm };
            mirror[0] -= corner;
            let square = dot(mirror, mirror);
            let others = others.chunks_exact_mut(rows);
            for column in others.chain(right.chunks_exact_mut(rows)) {
                let column = &mut column[i..];
                let factor = 2.0 * dot(mirror, column) / square;
                subtract(mirror, [factor], [column]);
            }
            triangle[i][i] = corner;
        }
        for (k, column) in others.chunks_exact(rows).enumerate() {
            triangle[i][i + 1 + k] = column[i];
        }
    }
    triangle
}

#[cfg(test)]
mod tests {
    use super::*;
    use numerics::SplitMix;

    /// Points followed by their images; all points but the first are neighbours of it.
    fn triangle_of(pairs: &[[[f64; 2]; 2]]) -> Triangle {
        let points = Matrix::new(pairs.as_flattened().as_flattened().to_vec(), 2);
        let neighbours: Vec<Neighbour> = (1..pairs.len()).map(|k| (1.0, 2 * k as u32)).collect();
        Scratch::default().triangle(&points, 0, &neighbours, 1, false)
    }

    #[test]
    fn the_machine_s_vectors_change_no_bit() {
        let mut draw = SplitMix::new(14);
        let columns: Vec<f64> = (0..8 * 37).map(|_| draw.between(-1.0, 1.0)).collect();
        let [mut plain, mut vectors] = [columns.clone(), columns];
        let (left, right) = plain.split_at_mut(4 * 37);
        let by_plain = reflect(left, right, 37, 4);
        let (left, right) = vectors.split_at_mut(4 * 37);
        let by_vectors = Arch::new().dispatch(|| reflect(left, right, 37, 4));
        assert_eq!(by_plain, by_vectors);
        assert_eq!(plain, vectors);
    }

    /// A map with a condition number of 1e10 is recovered to 1e-5 (rounding times condition);
    /// normal equations, whose condition would be 1e20, would recover nothing.
    #[test]
    fn ill_conditioned_least_squares() {
        let map = [[0.3, 0.7], [-1.1, 0.4]];
        let mut pairs = vec![[[0.0; 2]; 2]];
        for k in 0..9 {
            let a = f64::from(k) - 3.7;
            let y = [a, a + 1e-10 * (a * a - 5.0)];
            pairs.push([y, map.map(|row| row[0] * y[0] + row[1] * y[1])]);
        }
        let Triangle { points, images, .. } = triangle_of(&pairs);
        for (out, row) in map.iter().enumerate() {
            let last = images[1][out] / points[1][1];
            let first = (images[0][out] - points[0][1] * last) / points[0][0];
            for (fitted, expected) in [first, last].iter().zip(row) {
                assert!((fitted - expected).abs() < 1e-5, "{fitted} {expected}");
            }
        }
    }
}
