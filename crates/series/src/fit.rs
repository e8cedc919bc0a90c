//! The map between neighbourhoods, Eq. (25).

use super::cloud::Cloud;
use super::matrix::{Matrix, Row, product};
use super::neighbours::Neighbour;
use super::settings::DataSettings;
use super::svd::{Svd, svds, triangle};

/// How far above the rounding of the data a singular value must be, for one neighbour.
pub(crate) const ABOVE_ROUNDING: f64 = 4.0;

/// A linear map fitted to a neighbourhood.
#[derive(Clone, Debug)]
pub(crate) struct LocalMap {
    /// `[row][column]`.
    pub(crate) matrix: Matrix,
    /// How many directions the neighbourhood determines it in; it is zero in the others.
    pub(crate) rank: usize,
    /// A stretching below this is nothing: the map's own uncertainty from the rounding of the data,
    /// or the tolerance.
    pub(crate) nothing: f64,
}

/// Neighbour matrix of a point after reduction to its triangle, with its singular values.
pub(crate) struct Decomposed {
    triangle: Matrix,
    /// `Qᵀ Y'`, upper rows.
    images: Matrix,
    /// Size of the rounding in the neighbour matrix.
    rounding: f64,
    /// Sum of squares of what no linear map of the neighbours makes of the images.
    outside: f64,
    /// Independent rows: the neighbours, less one where their mean is taken out.
    independent: usize,
    svd: Svd,
    /// How many singular values are not zero.
    rank: usize,
}

/// Memory for neighbour matrices, used again for every point.
#[derive(Default)]
pub(crate) struct Scratch {
    left: Vec<f64>,
    right: Vec<f64>,
}

impl Scratch {
    /// The matrices of several neighbourhoods of `j` and their images, decomposed, which takes
    /// hardly longer than of one.
    pub(crate) fn decompose<const L: usize>(
        &mut self,
        cloud: &Cloud,
        j: usize,
        neighbourhoods: [&[Neighbour]; L],
        settings: &DataSettings,
    ) -> [Decomposed; L] {
        let columns = cloud.points.columns();
        let mut decomposed = neighbourhoods.map(|neighbours| {
            let rows = self.fill(
                &cloud.points,
                j,
                neighbours,
                Some(settings.step),
                settings.affine,
            );
            let (triangle, images) = triangle(&mut self.left, &mut self.right, rows, columns);
            let right = self.right.chunks_exact(rows);
            let rest = right.flat_map(|column| &column[columns..]);
            Decomposed {
                triangle,
                images,
                rounding: ABOVE_ROUNDING * cloud.rounding * (rows as f64).sqrt(),
                outside: rest.map(|v| v * v).sum(),
                independent: neighbours
                    .len()
                    .saturating_sub(usize::from(settings.affine)),
                svd: Svd::default(),
                rank: 0,
            }
        });
        let found = svds(decomposed.each_ref().map(|one| &one.triangle));
        for (one, svd) in decomposed.iter_mut().zip(found) {
            let zero = one.rounding.max(settings.rank_tolerance * svd.s[0]);
            one.rank = svd.s.iter().filter(|&&s| s > zero).count();
            one.svd = svd;
        }
        decomposed
    }

    /// Singular values of several neighbour matrices of `j`, each divided by the root of the number
    /// of neighbours, and what below is zero.
    pub(crate) fn singular_values<const L: usize>(
        &mut self,
        cloud: &Cloud,
        j: usize,
        neighbourhoods: [&[Neighbour]; L],
        settings: &DataSettings,
    ) -> [(Row, f64); L] {
        let triangles = neighbourhoods.map(|neighbours| {
            let rows = self.fill(&cloud.points, j, neighbours, None, false);
            triangle(
                &mut self.left,
                &mut self.right,
                rows,
                cloud.points.columns(),
            )
            .0
        });
        let found = svds(triangles.each_ref());
        std::array::from_fn(|l| {
            let root = (neighbourhoods[l].len().max(1) as f64).sqrt();
            let s = found[l].s.map(|s| s / root);
            let zero = (ABOVE_ROUNDING * cloud.rounding).max(settings.rank_tolerance * s[0]);
            (s, zero)
        })
    }

    /// Writes the differences to the neighbours, column after column, and returns the number of
    /// rows (at least that of columns).
    fn fill(
        &mut self,
        points: &Matrix,
        j: usize,
        neighbours: &[Neighbour],
        step: Option<usize>,
        centred: bool,
    ) -> usize {
        let rows = neighbours.len().max(points.columns());
        self.right.clear();
        differences(points, j, 0, neighbours, rows, centred, &mut self.left);
        if let Some(step) = step {
            differences(points, j, step, neighbours, rows, centred, &mut self.right);
        }
        rows
    }
}

/// `x_{k + ahead} − x_{j + ahead}` of all neighbours `k`; with `centred` minus their mean, which is
/// what a fitted constant amounts to.
fn differences(
    points: &Matrix,
    j: usize,
    ahead: usize,
    neighbours: &[Neighbour],
    rows: usize,
    centred: bool,
    columns: &mut Vec<f64>,
) {
    let origin = &points[j + ahead];
    columns.clear();
    columns.resize(points.columns() * rows, 0.0);
    // A point's coordinates lie together: each point is fetched once.
    for (row, &(_, k)) in neighbours.iter().enumerate() {
        let point = &points[k as usize + ahead];
        for (c, (v, origin)) in point.iter().zip(origin).enumerate() {
            columns[c * rows + row] = v - origin;
        }
    }
    if centred && !neighbours.is_empty() {
        for column in columns.chunks_exact_mut(rows) {
            let column = &mut column[..neighbours.len()];
            let mean = column.iter().sum::<f64>() / neighbours.len() as f64;
            column.iter_mut().for_each(|v| *v -= mean);
        }
    }
}

impl Decomposed {
    /// Part of the images' deviations from the image of the point that the map (without ridge) does
    /// not predict: root mean square per degree of freedom, over the same without a map. 0 for a
    /// smooth map of small neighbourhoods, 1 if the images have nothing to do with the points. NaN
    /// if there are no degrees of freedom to tell from.
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
            nothing: uncertainty.max(settings.rank_tolerance * squares.sqrt()),
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

    /// A linear fit that cuts nothing off.
    fn plain() -> DataSettings {
        DataSettings {
            rank_tolerance: 0.0,
            ..DataSettings::default()
        }
    }

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
        let (mut scratch, mut found) = (Scratch::default(), Vec::new());
        for count in [10, 40] {
            finder.nearest(500, count, f64::INFINITY, &mut found);
            let [decomposed] = scratch.decompose(&cloud, 500, [&found], &plain());
            let map = decomposed.map(2, &plain());
            assert_eq!(map.rank, 2);
            for (row, wanted) in map.matrix.rows().zip([[c, -s], [s, c]]) {
                for (cell, wanted) in row.iter().zip(wanted) {
                    assert!((cell - wanted).abs() < map.nothing, "{cell} {wanted}");
                }
            }
            // Both by the root of the number of neighbours.
            let [(sizes, zero)] = scratch.singular_values(&cloud, 500, [&found], &plain());
            assert!((map.nothing * sizes[1] / zero - 1.0).abs() < 1e-9);
        }
    }
}
