//! The map between neighbourhoods, Eq. (25).

use super::cloud::Cloud;
use super::neighbours::Neighbour;
use super::svd::{Square, Svd, product, svd, triangle};

/// How far above the rounding of the data a singular value must be, for one neighbour.
const ABOVE_ROUNDING: f64 = 4.0;

/// What of the settings a fit depends on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rule {
    pub(super) step: usize,
    pub(super) affine: bool,
    pub(super) rank_tolerance: f64,
    pub(super) ridge: f64,
}

/// A linear map fitted to a neighbourhood.
#[derive(Clone, Copy, Debug)]
pub(super) struct LocalMap<const N: usize> {
    /// `[row][column]`.
    pub(super) matrix: Square<N>,
    /// How many directions the neighbourhood determines it in; it is zero in the others.
    pub(super) rank: usize,
    /// The directions it is determined in, the widest first, and then the others.
    pub(super) domain: Square<N>,
    /// A stretching below this is nothing: the map's own uncertainty from the rounding of the data, or the tolerance.
    pub(super) nothing: f64,
}

/// Neighbour matrix of a point after reduction to its triangle.
pub(super) struct Decomposed<const N: usize> {
    svd: Svd<N>,
    /// `Qᵀ Y'`, upper rows.
    images: Square<N>,
    /// Singular values up to here are zero.
    zero: f64,
    /// Size of the rounding in the neighbour matrix.
    rounding: f64,
}

/// Memory for neighbour matrices, used again for every point.
#[derive(Default)]
pub(super) struct Scratch {
    left: Vec<f64>,
    right: Vec<f64>,
}

impl Scratch {
    /// The neighbour matrix of `j` and its images, decomposed.
    pub(super) fn decompose<const N: usize>(
        &mut self,
        cloud: &Cloud<N>,
        j: usize,
        neighbours: &[Neighbour],
        rule: &Rule,
    ) -> Decomposed<N> {
        let rows = self.fill(&cloud.points, j, neighbours, Some(rule.step), rule.affine);
        let (r, images) = triangle::<N>(&mut self.left, &mut self.right, rows);
        let svd = svd(&r);
        let rounding = ABOVE_ROUNDING * cloud.rounding * (rows as f64).sqrt();
        let zero = rounding.max(rule.rank_tolerance * svd.s[0]);
        Decomposed {
            svd,
            images,
            zero,
            rounding,
        }
    }

    /// Singular values of the neighbour matrix of `j`, each divided by the root of the number of neighbours, and what below
    /// is zero.
    pub(super) fn singular_values<const N: usize>(
        &mut self,
        cloud: &Cloud<N>,
        j: usize,
        neighbours: &[Neighbour],
        rule: &Rule,
    ) -> ([f64; N], f64) {
        let rows = self.fill(&cloud.points, j, neighbours, None, false);
        let (r, _) = triangle::<N>(&mut self.left, &mut self.right, rows);
        let root = (neighbours.len().max(1) as f64).sqrt();
        let s = svd(&r).s.map(|s| s / root);
        (
            s,
            (ABOVE_ROUNDING * cloud.rounding).max(rule.rank_tolerance * s[0]),
        )
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
    for c in 0..N {
        let start = to.len();
        to.extend(
            neighbours
                .iter()
                .map(|&(_, k)| points[k as usize + ahead][c] - origin[c]),
        );
        if centred && !neighbours.is_empty() {
            let mean = to[start..].iter().sum::<f64>() / neighbours.len() as f64;
            to[start..].iter_mut().for_each(|v| *v -= mean);
        }
        to.resize(start + rows, 0.0);
    }
}

impl<const N: usize> Decomposed<N> {
    /// Directions that the neighbourhood spans, the widest first.
    pub(super) fn directions(&self) -> &Square<N> {
        &self.svd.v
    }

    /// The least-squares map, restricted to at most the `limit` widest directions: `A = Yᵀ' U S⁻¹ Vᵀ`.
    pub(super) fn map(&self, limit: usize, rule: &Rule) -> LocalMap<N> {
        let s = &self.svd.s;
        let rank = s.iter().take(limit).filter(|&&s| s > self.zero).count();
        let mut matrix = [[0.0; N]; N];
        let ridge = rule.ridge * s[0];
        for (i, &s) in s.iter().enumerate().take(rank) {
            let inverse = if ridge > 0.0 {
                s / (s * s + ridge * ridge)
            } else {
                1.0 / s
            };
            for (out, row) in matrix.iter_mut().enumerate() {
                let mut image = 0.0;
                for (images, u) in self.images.iter().zip(&self.svd.u[i]) {
                    image += images[out] * u;
                }
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
            Some(last) => self.rounding / s[last],
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
