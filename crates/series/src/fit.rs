//! The map between neighbourhoods, Eq. (25).

use super::cloud::Cloud;
use super::neighbours::Neighbour;
use super::settings::DataSettings;
use super::svd::{Square, Svd, product, svds, triangle};

/// How far above the rounding of the data a singular value must be, for one neighbour.
const ABOVE_ROUNDING: f64 = 4.0;

/// What of the settings a fit depends on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rule {
    pub(crate) step: usize,
    pub(crate) affine: bool,
    pub(crate) rank_tolerance: f64,
    pub(crate) ridge: f64,
}

impl Rule {
    pub(crate) fn of(settings: &DataSettings) -> Self {
        Self {
            step: settings.step,
            affine: settings.affine,
            rank_tolerance: settings.rank_tolerance,
            ridge: settings.ridge,
        }
    }
}

/// A linear map fitted to a neighbourhood.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalMap<const N: usize> {
    /// `[row][column]`.
    pub(crate) matrix: Square<N>,
    /// How many directions the neighbourhood determines it in; it is zero in the others.
    pub(crate) rank: usize,
    /// The directions it is determined in, the widest first, and then the others.
    pub(crate) domain: Square<N>,
    /// A stretching below this is nothing: the map's own uncertainty from the rounding of the data, or the tolerance.
    pub(crate) nothing: f64,
}

/// Neighbour matrix of a point after reduction to its triangle.
#[derive(Clone, Copy)]
struct Reduced<const N: usize> {
    triangle: Square<N>,
    /// `Qᵀ Y'`, upper rows.
    images: Square<N>,
    /// Size of the rounding in the neighbour matrix.
    rounding: f64,
    /// Sum of squares of what no linear map of the neighbours makes of the images.
    outside: f64,
    /// Independent rows: the neighbours, less one where their mean is taken out.
    independent: usize,
}

/// The same with its singular values.
pub(crate) struct Decomposed<const N: usize> {
    of: Reduced<N>,
    svd: Svd<N>,
    /// Singular values up to here are zero.
    zero: f64,
}

/// Memory for neighbour matrices, used again for every point.
#[derive(Default)]
pub(crate) struct Scratch {
    left: Vec<f64>,
    right: Vec<f64>,
}

impl Scratch {
    /// The neighbour matrix of `j` and its images, decomposed.
    pub(crate) fn decompose<const N: usize>(
        &mut self,
        cloud: &Cloud<N>,
        j: usize,
        neighbours: &[Neighbour],
        rule: &Rule,
    ) -> Decomposed<N> {
        let [decomposed] = self.decompose_all(cloud, j, [neighbours], rule);
        decomposed
    }

    /// The same of several neighbourhoods of `j`, which takes hardly longer than of one.
    pub(crate) fn decompose_all<const N: usize, const L: usize>(
        &mut self,
        cloud: &Cloud<N>,
        j: usize,
        neighbourhoods: [&[Neighbour]; L],
        rule: &Rule,
    ) -> [Decomposed<N>; L] {
        let reduced = neighbourhoods.map(|neighbours| self.reduce(cloud, j, neighbours, rule));
        let decomposed: [Svd<N>; L] = svds(std::array::from_fn(|l| &reduced[l].triangle));
        std::array::from_fn(|l| {
            let (of, svd) = (reduced[l], decomposed[l]);
            let zero = of.rounding.max(rule.rank_tolerance * svd.s[0]);
            Decomposed { of, svd, zero }
        })
    }

    fn reduce<const N: usize>(
        &mut self,
        cloud: &Cloud<N>,
        j: usize,
        neighbours: &[Neighbour],
        rule: &Rule,
    ) -> Reduced<N> {
        let rows = self.fill(&cloud.points, j, neighbours, Some(rule.step), rule.affine);
        let (triangle, images) = triangle::<N>(&mut self.left, &mut self.right, rows);
        let rest = self
            .right
            .chunks_exact(rows)
            .flat_map(|column| &column[N..]);
        Reduced {
            triangle,
            images,
            rounding: ABOVE_ROUNDING * cloud.rounding * (rows as f64).sqrt(),
            outside: rest.map(|v| v * v).sum(),
            independent: neighbours.len().saturating_sub(usize::from(rule.affine)),
        }
    }

    /// Singular values of several neighbour matrices of `j`, each divided by the root of the number of neighbours, and what below
    /// is zero.
    pub(crate) fn singular_values<const N: usize, const L: usize>(
        &mut self,
        cloud: &Cloud<N>,
        j: usize,
        neighbourhoods: [&[Neighbour]; L],
        rule: &Rule,
    ) -> [([f64; N], f64); L] {
        let triangles = neighbourhoods.map(|neighbours| {
            let rows = self.fill(&cloud.points, j, neighbours, None, false);
            triangle::<N>(&mut self.left, &mut self.right, rows).0
        });
        let decomposed: [Svd<N>; L] = svds(triangles.each_ref());
        std::array::from_fn(|l| {
            let root = (neighbourhoods[l].len().max(1) as f64).sqrt();
            let s = decomposed[l].s.map(|s| s / root);
            let zero = (ABOVE_ROUNDING * cloud.rounding).max(rule.rank_tolerance * s[0]);
            (s, zero)
        })
    }

    /// Writes the differences to the neighbours, column after column, and returns the number of rows (at least N).
    fn fill<const N: usize>(
        &mut self,
        points: &[[f64; N]],
        j: usize,
        neighbours: &[Neighbour],
        step: Option<usize>,
        centred: bool,
    ) -> usize {
        let rows = neighbours.len().max(N);
        self.left.clear();
        self.right.clear();
        differences(points, j, 0, neighbours, rows, centred, &mut self.left);
        if let Some(step) = step {
            differences(points, j, step, neighbours, rows, centred, &mut self.right);
        }
        rows
    }
}

/// Appends `x_{k + ahead} − x_{j + ahead}` of all neighbours `k`; with `centred` minus their mean, which is what a fitted
/// constant amounts to.
fn differences<const N: usize>(
    points: &[[f64; N]],
    j: usize,
    ahead: usize,
    neighbours: &[Neighbour],
    rows: usize,
    centred: bool,
    to: &mut Vec<f64>,
) {
    let origin = &points[j + ahead];
    let start = to.len();
    to.resize(start + N * rows, 0.0);
    let columns = &mut to[start..];
    // A point's coordinates lie together: each point is fetched once.
    for (row, &(_, k)) in neighbours.iter().enumerate() {
        let point = &points[k as usize + ahead];
        for c in 0..N {
            columns[c * rows + row] = point[c] - origin[c];
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

impl<const N: usize> Decomposed<N> {
    /// Directions that the neighbourhood spans, the widest first.
    pub(crate) fn directions(&self) -> &Square<N> {
        &self.svd.v
    }

    /// Part of the images' deviations from the image of the point that the map (without ridge) does not predict: root mean
    /// square per degree of freedom, over the same without a map. 0 for a smooth map of small neighbourhoods, 1 if the
    /// images have nothing to do with the points. NaN if there are no degrees of freedom to tell from.
    pub(crate) fn residual_ratio(&self) -> f64 {
        let rank = self.rank();
        if self.of.independent <= rank {
            return f64::NAN;
        }
        let within: f64 = self.of.images.iter().map(|row| product(row, row)).sum();
        let explained: f64 = (0..rank)
            .flat_map(|i| (0..N).map(move |out| self.image(i, out)))
            .map(|image| image * image)
            .sum();
        let total = self.of.outside + within;
        if total == 0.0 {
            return 0.0;
        }
        let unexplained = self.of.outside + (within - explained).max(0.0);
        let (count, free) = (
            self.of.independent as f64,
            (self.of.independent - rank) as f64,
        );
        ((unexplained / free) / (total / count)).sqrt()
    }

    fn rank(&self) -> usize {
        self.svd.s.iter().filter(|&&s| s > self.zero).count()
    }

    /// Component `out` of the images along the `i`-th left singular vector.
    fn image(&self, i: usize, out: usize) -> f64 {
        let mut image = 0.0;
        for (images, u) in self.of.images.iter().zip(&self.svd.u[i]) {
            image += images[out] * u;
        }
        image
    }

    /// The least-squares map, restricted to at most the `limit` widest directions: `A = Yᵀ' U S⁻¹ Vᵀ`.
    pub(crate) fn map(&self, limit: usize, rule: &Rule) -> LocalMap<N> {
        let s = &self.svd.s;
        let rank = self.rank().min(limit);
        let mut matrix = [[0.0; N]; N];
        let ridge = rule.ridge * s[0];
        for (i, &s) in s.iter().enumerate().take(rank) {
            let inverse = if ridge > 0.0 {
                s / (s * s + ridge * ridge)
            } else {
                1.0 / s
            };
            for (out, row) in matrix.iter_mut().enumerate() {
                let image = self.image(i, out);
                for (cell, v) in row.iter_mut().zip(&self.svd.v[i]) {
                    *cell += image * inverse * v;
                }
            }
        }
        let norm = matrix
            .iter()
            .map(|row| product(row, row))
            .sum::<f64>()
            .sqrt();
        let uncertainty = match rank.checked_sub(1) {
            Some(last) => self.of.rounding / s[last],
            None => 0.0,
        };
        LocalMap {
            matrix,
            rank,
            domain: self.svd.v,
            nothing: uncertainty.max(rule.rank_tolerance * norm),
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::neighbours::Finder;
    use crate::series::Series;

    /// A linear fit that cuts nothing off.
    pub(crate) const PLAIN: Rule = Rule {
        step: 1,
        affine: false,
        rank_tolerance: 0.0,
        ridge: 0.0,
    };

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
        let cloud = Cloud::<2>::new(&Series::from_rows(rows, 1.0).unwrap()).unwrap();
        let finder = Finder::new(&cloud, 1, 0).unwrap();
        let (mut scratch, mut found) = (Scratch::default(), Vec::new());
        for count in [10, 40] {
            finder.nearest(500, count, f64::INFINITY, &mut found);
            let map = scratch
                .decompose(&cloud, 500, &found, &PLAIN)
                .map(2, &PLAIN);
            assert_eq!(map.rank, 2);
            for (row, wanted) in map.matrix.iter().zip([[c, -s], [s, c]]) {
                for (cell, wanted) in row.iter().zip(wanted) {
                    assert!((cell - wanted).abs() < map.nothing, "{cell} {wanted}");
                }
            }
            // Both by the root of the number of neighbours.
            let [(sizes, zero)] = scratch.singular_values(&cloud, 500, [&found], &PLAIN);
            assert!((map.nothing * sizes[1] / zero - 1.0).abs() < 1e-9);
        }
    }
}
