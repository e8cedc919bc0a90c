//! The linear map between neighbourhoods, Eq. (25).

use super::cloud::Cloud;
use super::least_squares::Scratch;
use super::matrix::{Matrix, Row, product};
use super::settings::DataSettings;
use super::svd::{Svd, svd};
use super::tree::Neighbour;

/// A linear map fitted to a neighbourhood.
#[derive(Clone, Debug)]
pub(crate) struct LocalMap {
    /// `[row][column]`.
    pub(crate) matrix: Matrix,
    /// Number of directions in which the neighbourhood determines the map; it is zero in the
    /// others.
    pub(crate) rank: usize,
    /// A stretching up to this counts as zero: the uncertainty of the map from rounding of the
    /// data, or the tolerance.
    pub(crate) negligible: f64,
}

/// A linear fit with the singular values of its neighbour matrix.
pub(crate) struct Decomposed {
    /// `Qᵀ Y'`, upper rows.
    images: Matrix,
    /// Size of rounding errors in the neighbour matrix.
    rounding: f64,
    /// Sum of squares of the part of the images that no linear map of the neighbours explains.
    outside: f64,
    /// Independent rows: the neighbours, less one where a constant is fitted.
    independent: usize,
    svd: Svd,
    /// Number of singular values that are not zero.
    rank: usize,
}

impl Decomposed {
    /// Fits the neighbours of point `j`, with a constant or without one.
    pub(crate) fn new(
        scratch: &mut Scratch,
        cloud: &Cloud,
        (j, neighbours): (usize, &[Neighbour]),
        affine: bool,
        settings: &DataSettings,
    ) -> Self {
        let triangle = scratch.triangle(&cloud.points, j, neighbours, settings.step, affine);
        let svd = svd(&triangle.points);
        let rounding = cloud.rounding * (triangle.rows as f64).sqrt();
        let zero = rounding.max(settings.rank_tolerance * svd.s[0]);
        Self {
            images: triangle.images,
            rounding,
            outside: triangle.residual,
            independent: neighbours.len().saturating_sub(usize::from(affine)),
            rank: svd.s.iter().filter(|&&s| s > zero).count(),
            svd,
        }
    }

    /// Singular values of the neighbour matrix.
    pub(crate) fn sizes(&self) -> &Row {
        &self.svd.s
    }

    /// Residual ratio: the fraction of the images' deviations from the image of the point that the
    /// map (without ridge) does not predict. It is the root mean square per degree of freedom, over
    /// the same without a map. It is 0 for a smooth map of small neighbourhoods, and 1 if the
    /// images do not depend on the points. It is NaN without degrees of freedom.
    pub(crate) fn residual_ratio(&self) -> f64 {
        let (rank, columns) = (self.rank, self.images.columns());
        if self.independent <= rank {
            return f64::NAN;
        }
        let within: f64 = self.images.rows().map(|row| product(row, row)).sum();
        let explained: f64 = (0..rank)
            .flat_map(|i| (0..columns).map(move |out| self.image(i, out)))
            .map(|image| image * image)
            .sum();
        let total = self.outside + within;
        if total == 0.0 {
            return 0.0;
        }
        let unexplained = self.outside + (within - explained).max(0.0);
        let (count, free) = (self.independent as f64, (self.independent - rank) as f64);
        ((unexplained / free) / (total / count)).sqrt()
    }

    /// Component `out` of the images along the `i`-th left singular vector.
    fn image(&self, i: usize, out: usize) -> f64 {
        let mut image = 0.0;
        for (images, u) in self.images.rows().zip(&self.svd.u[i]) {
            image += images[out] * u;
        }
        image
    }

    /// The least-squares map, restricted to at most the `limit` widest directions: `A = Yᵀ' U S⁻¹
    /// Vᵀ`.
    pub(crate) fn map(&self, limit: usize, settings: &DataSettings) -> LocalMap {
        let Svd { s, v, .. } = &self.svd;
        let columns = v.columns();
        let rank = self.rank.min(limit);
        let mut matrix = Matrix::zeros(columns, columns);
        let ridge = settings.ridge * s[0];
        for (i, &s) in s.iter().enumerate().take(rank) {
            let inverse = if ridge > 0.0 {
                s / (s * s + ridge * ridge)
            } else {
                1.0 / s
            };
            for (out, row) in matrix.rows_mut().enumerate() {
                let image = self.image(i, out);
                for (cell, v) in row.iter_mut().zip(&v[i]) {
                    *cell += image * inverse * v;
                }
            }
        }
        let squares: f64 = matrix.rows().map(|row| product(row, row)).sum();
        let uncertainty = match rank.checked_sub(1) {
            Some(last) => self.rounding / s[last],
            None => 0.0,
        };
        LocalMap {
            matrix,
            rank,
            negligible: uncertainty.max(settings.rank_tolerance * squares.sqrt()),
        }
    }

    /// Directions that the neighbourhood spans, the widest first.
    pub(crate) fn into_directions(self) -> Matrix {
        self.svd.v
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::neighbours::Finder;
    use crate::series::Series;

    #[test]
    fn a_linear_map_is_recovered_to_the_rounding_over_the_extent_of_the_neighbourhood() {
        // A spiral inwards.
        let (c, s) = (0.999 * libm::cos(1.0), 0.999 * libm::sin(1.0));
        let mut x = [1.0, 0.0];
        let rows = (0..1000).map(|_| {
            let now = x;
            x = [c * x[0] - s * x[1], s * x[0] + c * x[1]];
            now
        });
        let cloud = Cloud::new(&Series::from_rows(rows, 1.0).unwrap()).unwrap();
        let finder = Finder::new(&cloud, 1, 0).unwrap();
        // Nothing is cut off.
        let plain = DataSettings {
            rank_tolerance: 0.0,
            ..DataSettings::default()
        };
        let (mut scratch, mut nearest) = (Scratch::default(), Vec::new());
        for count in [10, 40] {
            finder.nearest(500, count, f64::INFINITY, &mut nearest);
            let decomposed = Decomposed::new(&mut scratch, &cloud, (500, &nearest), false, &plain);
            let map = decomposed.map(2, &plain);
            assert_eq!(map.rank, 2);
            for (row, wanted) in map.matrix.rows().zip([[c, -s], [s, c]]) {
                for (cell, wanted) in row.iter().zip(wanted) {
                    assert!((cell - wanted).abs() < map.negligible, "{cell} {wanted}");
                }
            }
        }
    }
}
