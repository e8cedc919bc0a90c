//! The product of the local maps along the series.

use super::fit::LocalMap;
use super::matrix::{Matrix, Row, product};
use super::series::MAX_COLUMNS;
use super::svd::svd;

/// Stretching of the tangent vectors by one map.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stretch {
    /// Stretching in each position; 0 where there is none.
    pub(crate) factor: Row,
    /// Positions from here on are annihilated: the data determine the map, and it is zero there.
    pub(crate) alive: usize,
    /// Positions from here on are not determined by the data.
    pub(crate) rank: usize,
}

impl Stretch {
    /// The stretching of the volume that the first `dimension` vectors span.
    pub(crate) fn volume(&self, dimension: usize) -> Stretch {
        let mut factor = [0.0; MAX_COLUMNS];
        factor[0] = self.factor[..dimension].iter().product();
        Stretch {
            factor,
            alive: usize::from(self.alive >= dimension),
            rank: usize::from(self.rank >= dimension),
        }
    }
}

/// Interleaved chains of maps. The image of a reference point is a reference point of the same
/// chain.
pub(crate) struct Chains {
    /// Number of chains, and number of vectors carried along each.
    pub(crate) count: usize,
    pub(crate) width: usize,
    /// The current vectors of each chain.
    bases: Vec<Matrix>,
    /// Workspace for the next vectors.
    next: Matrix,
    /// Stretchings at all reference points so far, in order of time.
    pub(crate) stretches: Vec<Stretch>,
}

impl Chains {
    pub(crate) fn new(count: usize, width: usize) -> Self {
        Self {
            count,
            width,
            bases: Vec::new(),
            next: Matrix::default(),
            stretches: Vec::new(),
        }
    }

    /// Applies the map of the next reference point to the vectors. Initially they are the
    /// directions of the neighbourhood, so that undetermined ones come last.
    pub(crate) fn push(&mut self, map: &LocalMap, directions: &Matrix) {
        let i = self.stretches.len();
        if i < self.count {
            self.bases.push(directions.clone());
            self.next = directions.clone();
        }
        let basis = &mut self.bases[i % self.count];
        let stretch = advance(map, directions, (basis, &mut self.next), self.width);
        self.stretches.push(stretch);
    }
}

/// Applies a map to orthonormal vectors (the first `width` rows of `basis`) and orthonormalises the
/// images, with `next` as workspace.
///
/// A vector goes to the end if its image is zero or depends on the images before it. There it is
/// replaced by one orthogonal to all others. Thus positions follow the order of exponents even if
/// the map is singular, and the rounding error of a vanished vector never enters the product.
fn advance(
    map: &LocalMap,
    directions: &Matrix,
    (basis, next): (&mut Matrix, &mut Matrix),
    width: usize,
) -> Stretch {
    let columns = basis.columns();
    let rank = map.rank.min(width);
    let mut stretch = Stretch {
        factor: [0.0; MAX_COLUMNS],
        alive: rank,
        rank,
    };
    if rank == 0 {
        // The map is unknown here, so the vectors are kept for the next one.
        return stretch;
    }
    if width < columns && rank == width {
        align(basis, directions, width);
    }
    let mut kept = 0;
    let mut image = [0.0; MAX_COLUMNS];
    let image = &mut image[..columns];
    for vector in basis.first(width) {
        if kept == rank {
            break;
        }
        for (cell, row) in image.iter_mut().zip(map.matrix.rows()) {
            *cell = product(row, vector);
        }
        let length = orthogonalise(image, next.first(kept));
        if length > map.negligible {
            for (cell, v) in next[kept].iter_mut().zip(&*image) {
                *cell = v / length;
            }
            stretch.factor[kept] = length;
            kept += 1;
        }
    }
    stretch.alive = kept;
    for position in kept..width {
        let vector = complement(next, position);
        next[position].copy_from_slice(&vector);
    }
    for row in width..columns {
        next[row].fill(0.0);
    }
    std::mem::swap(basis, next);
    stretch
}

/// Rotates the vectors into the subspace on which the map is determined, without shortening them.
///
/// The images of the last neighbourhood and the points of this one span the same tangent space, up
/// to errors. A projection from one onto the other loses the cosine of the angle at every step.
/// These losses add up to a negative contribution that grows with the sampling rate. The rotation
/// nearest to the projection (its orthogonal polar factor) loses nothing.
fn align(basis: &mut Matrix, domain: &Matrix, width: usize) {
    let columns = basis.columns();
    let mut projection = Matrix::zeros(columns, columns);
    for (row, direction) in projection.rows_mut().zip(domain.first(width)) {
        for (cell, vector) in row.iter_mut().zip(basis.first(width)) {
            *cell = product(direction, vector);
        }
    }
    let parts = svd(&projection);
    for (c, vector) in basis.rows_mut().enumerate().take(width) {
        vector.fill(0.0);
        for (r, direction) in domain.first(width).enumerate() {
            let mut factor = 0.0;
            for i in 0..width {
                factor += parts.u[i][r] * parts.v[i][c];
            }
            for (v, d) in vector.iter_mut().zip(direction) {
                *v += factor * d;
            }
        }
    }
}

/// Subtracts the components along orthonormal vectors, twice, so that the remainder is orthogonal
/// to rounding (Giraud, Langou and Rozložník 2005). Returns its length.
fn orthogonalise<'a>(vector: &mut [f64], others: impl Iterator<Item = &'a [f64]> + Clone) -> f64 {
    for _ in 0..2 {
        for other in others.clone() {
            let along = product(vector, other);
            for (v, o) in vector.iter_mut().zip(other) {
                *v -= along * o;
            }
        }
    }
    product(vector, vector).sqrt()
}

/// A unit vector orthogonal to the given orthonormal ones, which must be fewer than their
/// components. It is the orthogonal part of the coordinate axis furthest from them.
fn complement(others: &Matrix, count: usize) -> Vec<f64> {
    let columns = others.columns();
    let mut best = (vec![0.0; columns], 0.0);
    for axis in 0..columns {
        let mut vector = vec![0.0; columns];
        vector[axis] = 1.0;
        let length = orthogonalise(&mut vector, others.first(count));
        if length > best.1 {
            best = (vector.iter().map(|v| v / length).collect(), length);
        }
    }
    best.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Applies a map of a given rank to the coordinate axes, and also returns the vectors after it.
    fn through<const N: usize>(matrix: [[f64; N]; N], rank: usize) -> (Stretch, Matrix) {
        let map = LocalMap {
            matrix: Matrix::new(matrix.concat(), N),
            rank,
            negligible: 1e-12,
        };
        let mut basis = Matrix::identity(N);
        let mut next = basis.clone();
        let stretch = advance(&map, &Matrix::identity(N), (&mut basis, &mut next), N);
        (stretch, basis)
    }

    #[test]
    fn the_product_of_the_factors_is_the_determinant() {
        let (stretch, _) = through([[2.0, 1.0, 0.0], [0.0, 3.0, 1.0], [1.0, 0.0, 1.0]], 3);
        // 2 (3 · 1 − 1 · 0) − 1 (0 · 1 − 1 · 1) = 7.
        assert!((stretch.factor[..3].iter().product::<f64>() - 7.0).abs() < 1e-14);
        assert_eq!((stretch.alive, stretch.rank), (3, 3));
    }

    #[test]
    fn an_annihilated_vector_goes_to_the_end() {
        let (stretch, basis) = through([[0.0, 0.0, 0.0], [0.0, 5.0, 0.0], [0.0, 0.0, 3.0]], 3);
        assert_eq!(stretch.factor[..3], [5.0, 3.0, 0.0]);
        assert_eq!((stretch.alive, stretch.rank), (2, 3));
        assert_eq!([0, 1, 2].map(|c| basis[2][c].abs()), [1.0, 0.0, 0.0]);
    }

    #[test]
    fn a_complement_is_a_unit_vector_orthogonal_to_the_others() {
        let found = complement(&Matrix::new(vec![0.6, 0.8], 2), 1);
        assert!((found[0] - 0.8).abs() < 1e-15 && (found[1] + 0.6).abs() < 1e-15);
    }

    #[test]
    fn undetermined_is_distinguished_from_annihilated() {
        let (stretch, _) = through([[0.0, 0.0], [0.0, 5.0]], 1);
        assert_eq!((stretch.alive, stretch.rank), (1, 1));
        let (stretch, basis) = through([[0.0; 2]; 2], 0);
        assert_eq!((stretch.alive, stretch.rank), (0, 0));
        assert_eq!(basis, Matrix::identity(2));
    }
}
