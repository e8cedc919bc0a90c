//! The product of the local maps, taken along the series.

use super::fit::LocalMap;
use super::svd::{Square, product, svd};

/// What one map did to the tangent vectors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stretch<const N: usize> {
    /// Stretching in each position; 0 where there was none.
    pub(crate) factor: [f64; N],
    /// Positions from here on were annihilated: the data determine the map, and it is zero.
    pub(crate) alive: usize,
    /// Positions from here on are not determined by the data.
    pub(crate) determined: usize,
}

impl<const N: usize> Stretch<N> {
    /// The stretching of the volume that the first `dimension` vectors span.
    pub(crate) fn volume(&self, dimension: usize) -> Stretch<1> {
        Stretch {
            factor: [self.factor[..dimension].iter().product()],
            alive: usize::from(self.alive >= dimension),
            determined: usize::from(self.determined >= dimension),
        }
    }
}

/// Takes orthonormal vectors (the first `width` rows of `basis`) through a map and makes them orthonormal again.
///
/// A vector of which nothing is left after the map, or nothing that is independent of those before it, goes to the end and is
/// replaced by one orthogonal to all others. Positions are thus in the order of exponents also when the map is singular,
/// and the product never contains the rounding error of a vector that vanished.
pub(crate) fn advance<const N: usize>(
    map: &LocalMap<N>,
    basis: &mut Square<N>,
    width: usize,
) -> Stretch<N> {
    let determined = map.rank.min(width);
    if width < N && determined == width && determined > 0 {
        align(basis, &map.domain, width);
    }
    carry(&map.matrix, map.nothing, determined, basis, width)
}

/// As [`advance`] without turning the vectors first, with a matrix that is determined in so many directions and takes to nothing what it makes shorter than `nothing`.
pub(crate) fn carry<const N: usize>(
    matrix: &Square<N>,
    nothing: f64,
    determined: usize,
    basis: &mut Square<N>,
    width: usize,
) -> Stretch<N> {
    let mut stretch = Stretch {
        factor: [0.0; N],
        alive: determined,
        determined,
    };
    if determined == 0 {
        // Nothing is known here; the vectors wait for the next map.
        return stretch;
    }
    let mut next = [[0.0; N]; N];
    let mut kept = 0;
    for vector in basis.iter().take(width) {
        if kept == determined {
            break;
        }
        let mut image = std::array::from_fn(|row| product(&matrix[row], vector));
        let length = orthogonalise(&mut image, &next[..kept]);
        if length > nothing {
            next[kept] = image.map(|v| v / length);
            stretch.factor[kept] = length;
            kept += 1;
        }
    }
    stretch.alive = kept;
    for position in kept..width {
        next[position] = complement(&next[..position]);
    }
    *basis = next;
    stretch
}

/// Turns the vectors into the space that the map is determined in, without shortening them.
///
/// The images of the last neighbourhood and the points of this one span the same tangent space, but for the error of either;
/// a projection from the one onto the other would lose the cosine of the angle at every step, which adds up to a
/// negative contribution that grows with the sampling rate. The rotation nearest to the projection (its orthogonal polar factor)
/// loses nothing.
fn align<const N: usize>(basis: &mut Square<N>, domain: &Square<N>, width: usize) {
    let mut projection = [[0.0; N]; N];
    for (row, direction) in projection.iter_mut().zip(domain).take(width) {
        for (cell, vector) in row.iter_mut().zip(basis.iter()).take(width) {
            *cell = product(direction, vector);
        }
    }
    let parts = svd(&projection);
    let mut turned = *basis;
    for (c, vector) in turned.iter_mut().enumerate().take(width) {
        *vector = [0.0; N];
        for (r, direction) in domain.iter().enumerate().take(width) {
            let mut factor = 0.0;
            for i in 0..width {
                factor += parts.u[i][r] * parts.v[i][c];
            }
            for (v, d) in vector.iter_mut().zip(direction) {
                *v += factor * d;
            }
        }
    }
    *basis = turned;
}

/// Subtracts the components along orthonormal vectors, twice, so that what is left is orthogonal to rounding (Giraud,
/// Langou and Rozložník 2005); returns its length.
fn orthogonalise<const N: usize>(vector: &mut [f64; N], others: &[[f64; N]]) -> f64 {
    for _ in 0..2 {
        for other in others {
            let along = product(vector, other);
            for (v, o) in vector.iter_mut().zip(other) {
                *v -= along * o;
            }
        }
    }
    product(vector, vector).sqrt()
}

/// A unit vector orthogonal to fewer than N orthonormal ones: what is left of the coordinate axis furthest from them.
fn complement<const N: usize>(others: &[[f64; N]]) -> [f64; N] {
    let mut best = ([0.0; N], 0.0);
    for axis in 0..N {
        let mut vector = [0.0; N];
        vector[axis] = 1.0;
        let length = orthogonalise(&mut vector, others);
        if length > best.1 {
            best = (vector.map(|v| v / length), length);
        }
    }
    best.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map<const N: usize>(matrix: Square<N>, rank: usize) -> LocalMap<N> {
        LocalMap {
            matrix,
            rank,
            domain: identity(),
            nothing: 1e-12,
        }
    }

    fn identity<const N: usize>() -> Square<N> {
        std::array::from_fn(|i| std::array::from_fn(|k| f64::from(u8::from(i == k))))
    }

    #[test]
    fn the_product_of_the_factors_is_the_determinant() {
        let matrix = [[2.0, 1.0, 0.0], [0.0, 3.0, 1.0], [1.0, 0.0, 1.0]];
        let mut basis = identity();
        let stretch = advance(&map(matrix, 3), &mut basis, 3);
        // 2 (3 · 1 − 1 · 0) − 1 (0 · 1 − 1 · 1) = 7.
        assert!((stretch.factor.iter().product::<f64>() - 7.0).abs() < 1e-14);
        assert_eq!((stretch.alive, stretch.determined), (3, 3));
    }

    #[test]
    fn an_annihilated_vector_goes_to_the_end() {
        let matrix = [[0.0, 0.0, 0.0], [0.0, 5.0, 0.0], [0.0, 0.0, 3.0]];
        let mut basis = identity();
        let stretch = advance(&map(matrix, 3), &mut basis, 3);
        assert_eq!(stretch.factor, [5.0, 3.0, 0.0]);
        assert_eq!((stretch.alive, stretch.determined), (2, 3));
        assert_eq!(basis[2].map(f64::abs), [1.0, 0.0, 0.0]);
    }

    #[test]
    fn a_complement_is_a_unit_vector_orthogonal_to_the_others() {
        let found = complement(&[[0.6, 0.8]]);
        assert!((found[0] - 0.8).abs() < 1e-15 && (found[1] + 0.6).abs() < 1e-15);
    }

    #[test]
    fn undetermined_is_told_from_annihilated() {
        let matrix = [[0.0, 0.0], [0.0, 5.0]];
        let stretch = advance(&map(matrix, 1), &mut identity(), 2);
        assert_eq!((stretch.alive, stretch.determined), (1, 1));
        let mut basis = identity();
        let stretch = advance(&map([[0.0; 2]; 2], 0), &mut basis, 2);
        assert_eq!((stretch.alive, stretch.determined), (0, 0));
        assert_eq!(basis, identity());
    }
}
