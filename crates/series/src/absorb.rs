//! Neighbours put into the triangle of a least-squares fit.

use pulp::NullaryFnOnce;

use super::matrix::Matrix;
use super::neighbours::Neighbour;
use super::polynomial::Polynomial;
use super::svd::{dot, reflect_below};

/// A column of which less than this part is left by those before it is a combination of them: the
/// default of the rank tolerance.
const DEPENDENT: f64 = 1e-10;
/// Rows are filled up with zeros, which change no sum, so that no vector is broken.
const VECTOR: usize = 4;

/// Adds neighbours to a triangle, by reflections that take their rows to zero, and returns the sum
/// of squares of what is left of their images. A column that depends on those before it gets a zero
/// corner and is passed over.
pub(crate) struct Absorb<'a> {
    /// Components of the images that are fitted.
    pub(crate) fitted: &'a [usize],
    pub(crate) triangle: &'a mut [f64],
    pub(crate) rows: &'a mut Vec<f64>,
    pub(crate) points: &'a Matrix,
    pub(crate) j: usize,
    pub(crate) further: &'a [Neighbour],
    pub(crate) directions: &'a Matrix,
    pub(crate) polynomial: &'a Polynomial,
}

impl Absorb<'_> {
    /// Writes the columns, each of `long` rows.
    #[inline(always)]
    fn fill(&mut self, long: usize) {
        let (forms, affine) = (self.polynomial.forms, self.polynomial.affine);
        let components = self.points.columns();
        let unknowns = self.polynomial.unknowns(components);
        // Differences to the point come last, for a while.
        let columns = unknowns + self.fitted.len();
        let cells = (columns + components) * long;
        if self.rows.len() < cells {
            self.rows.resize(cells, 0.0);
        }
        let (columns, differences) = self.rows[..cells].split_at_mut(columns * long);
        let (known, images) = columns.split_at_mut(unknowns * long);
        let (before, along) = known.split_at_mut((unknowns - components) * long);
        let count = self.further.len();
        let origin = &self.points[self.j];
        let image = &self.points[self.j + self.polynomial.step];
        for (row, &(_, k)) in self.further.iter().enumerate() {
            let point = &self.points[k as usize];
            for (c, (v, origin)) in point.iter().zip(origin).enumerate() {
                differences[c * long + row] = v - origin;
            }
            let ahead = &self.points[k as usize + self.polynomial.step];
            for (i, &c) in self.fitted.iter().enumerate() {
                images[i * long + row] = ahead[c] - image[c];
            }
        }
        let written = images.chunks_exact_mut(long);
        for column in written.chain(differences.chunks_exact_mut(long)) {
            column[count..].fill(0.0);
        }
        for (along, direction) in along.chunks_exact_mut(long).zip(self.directions.rows()) {
            along.fill(0.0);
            for (part, column) in direction.iter().zip(differences.chunks_exact(long)) {
                for (sum, difference) in along.iter_mut().zip(column) {
                    *sum += part * difference;
                }
            }
        }
        let mut columns = before.chunks_exact_mut(long);
        if affine && let Some(ones) = columns.next() {
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
}

/// With the machine's vectors, which change no bit: the partial sums of [`dot`] are lanes of one
/// vector.
impl NullaryFnOnce for Absorb<'_> {
    type Output = f64;

    #[inline(always)]
    fn call(mut self) -> f64 {
        let long = self.further.len().next_multiple_of(VECTOR);
        self.fill(long);
        let unknowns = self.polynomial.unknowns(self.points.columns());
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
            if norm <= DEPENDENT * (above + square).sqrt() {
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
}
