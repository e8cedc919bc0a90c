//! Neighbours of a point.

use super::cloud::Cloud;
use super::error::DataError;
use super::matrix::{Matrix, distance2};
use super::settings::Neighbourhood;
use super::tree::{Neighbour, Tree};

/// Points nearer than this fraction of the spread count as repeats of one point. Their difference
/// is rounding or integration error, without information on the dynamics. Chosen: above the error
/// of usual solvers, and far below the distance of neighbours.
const REPEAT_DISTANCE: f64 = 1e-9;

/// A neighbourhood has at most one in this many of the points, as a larger one is no small part of
/// the attractor.
pub(crate) const POINTS_PER_NEIGHBOUR: usize = 20;

/// Number of the nearest points that form the requested neighbourhood.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Selection {
    /// Number of nearest points.
    pub(crate) count: usize,
    /// Whether the ball held too few, so that the nearest points were taken.
    pub(crate) starved: bool,
}

impl Selection {
    /// Selects from the nearest points, which must be at least as many as the neighbourhood may
    /// have.
    fn of(nearest: &[Neighbour], neighbours: &Neighbourhood, spread: f64) -> Self {
        match *neighbours {
            Neighbourhood::Nearest(k) => Selection {
                count: nearest.len().min(k),
                starved: nearest.len() < k,
            },
            Neighbourhood::Ball { eps, min, max } => {
                let radius = eps * spread;
                let inside = nearest.partition_point(|n| n.0 <= radius * radius).min(max);
                Selection {
                    count: inside.max(min).min(nearest.len()),
                    starved: inside < min,
                }
            }
        }
    }
}

/// Finds neighbours among the points that have an image.
pub(crate) struct Finder<'c> {
    tree: Tree,
    points: &'c Matrix,
    /// Number of points, from the first on, that have an image.
    candidates: usize,
    theiler: usize,
    repeat2: f64,
}

impl<'c> Finder<'c> {
    /// # Errors
    /// [`DataError::TooMany`].
    pub(crate) fn new(cloud: &'c Cloud, step: usize, theiler: usize) -> Result<Self, DataError> {
        let rows = cloud.points.len();
        if u32::try_from(rows).is_err() {
            return Err(DataError::TooMany {
                rows,
                max: u32::MAX as usize,
            });
        }
        let candidates = rows.saturating_sub(step);
        let repeat = (REPEAT_DISTANCE * cloud.spread).max(cloud.rounding);
        Ok(Self {
            tree: Tree::new(&cloud.points, candidates),
            points: &cloud.points,
            candidates,
            theiler,
            repeat2: repeat * repeat,
        })
    }

    /// Finds the neighbours of point `j` in a neighbourhood `times` the size, nearest first, or the
    /// `fewest` nearest points where it holds fewer. Returns how many of them are the neighbourhood
    /// itself. At the call `nearest` are those of the point `before`, if there is one.
    pub(crate) fn select(
        &self,
        (before, j): (Option<usize>, usize),
        neighbours: &Neighbourhood,
        (times, fewest): (usize, usize),
        spread: f64,
        nearest: &mut Vec<Neighbour>,
    ) -> Selection {
        let of_size = |count: usize| count.saturating_mul(times).max(fewest);
        let (least, most) = (of_size(neighbours.fewest()), of_size(neighbours.most()));
        // Where the ball only decides which points are starved, it does not bound the search.
        let radius = match *neighbours {
            Neighbourhood::Ball { eps, .. } if most > least => times as f64 * eps * spread,
            _ => f64::INFINITY,
        };
        self.follow((before, j), most, radius, nearest);
        if nearest.len() < least && radius.is_finite() {
            self.nearest(j, least, f64::INFINITY, nearest);
        }
        Selection::of(nearest, neighbours, spread)
    }

    /// Finds the neighbours of [`Finder::nearest`]. At the call, `nearest` holds those of the point
    /// `before`. At the call `nearest` are those of the point `before`. Their images bound the
    /// distance of the new ones, which makes the search short in a flow.
    pub(crate) fn follow(
        &self,
        (before, j): (Option<usize>, usize),
        wanted: usize,
        radius: f64,
        nearest: &mut Vec<Neighbour>,
    ) {
        let reach2 = match (before, nearest.get(..wanted)) {
            (Some(before), Some(nearest)) if before < j => self.reach2(j, j - before, nearest),
            _ => f64::INFINITY,
        };
        self.within(j, wanted, reach2.min(radius * radius), nearest);
    }

    /// Square of the largest distance from point `j` of the images of neighbours this much later.
    /// Infinite if one of the images is no valid neighbour.
    fn reach2(&self, j: usize, later: usize, nearest: &[Neighbour]) -> f64 {
        nearest.iter().fold(0.0, |reach: f64, &(_, k)| {
            let k = k as usize + later;
            let is_candidate = k < self.candidates;
            let square = is_candidate.then(|| distance2(&self.points[k], &self.points[j]));
            let admissible = square.filter(|square| *square > self.repeat2);
            reach.max(admissible.unwrap_or(f64::INFINITY))
        })
    }

    /// The `wanted` nearest admissible points within `radius`, nearest first, equally distant ones
    /// by index. Fewer if there are no more.
    pub(crate) fn nearest(
        &self,
        j: usize,
        wanted: usize,
        radius: f64,
        nearest: &mut Vec<Neighbour>,
    ) {
        self.within(j, wanted, radius * radius, nearest);
    }

    fn within(&self, j: usize, wanted: usize, radius2: f64, nearest: &mut Vec<Neighbour>) {
        let between = (self.repeat2, radius2);
        let admissible = |k: u32| (k as usize).abs_diff(j) > self.theiler;
        self.tree
            .nearest(&self.points[j], wanted, between, admissible, nearest);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::series::Series;

    /// [`Finder::nearest`] by exhaustive search.
    fn brute(
        cloud: &Cloud,
        finder: &Finder<'_>,
        step: usize,
        j: usize,
        wanted: usize,
        radius: f64,
    ) -> Vec<Neighbour> {
        let last = cloud.points.len() - step;
        let mut all: Vec<Neighbour> = (0..last)
            .filter(|k| k.abs_diff(j) > finder.theiler)
            .map(|k| (distance2(&cloud.points[k], &cloud.points[j]), k as u32))
            .filter(|n| n.0 > finder.repeat2 && n.0 <= radius * radius)
            .collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        all.truncate(wanted);
        all
    }

    fn agrees_with_brute_force<const N: usize>(rows: impl Iterator<Item = [f64; N]>) {
        let series = Series::from_rows(rows, 1.0).unwrap();
        let cloud = Cloud::new(&series).unwrap();
        let mut nearest = Vec::new();
        for (step, theiler) in [(1, 0), (1, 1), (3, 40)] {
            let finder = Finder::new(&cloud, step, theiler).unwrap();
            for j in (0..cloud.points.len()).step_by(17) {
                for (wanted, radius) in [(30, f64::INFINITY), (30, 0.05), (500, 0.3), (1, 1.0)] {
                    finder.nearest(j, wanted, radius, &mut nearest);
                    let expected = brute(&cloud, &finder, step, j, wanted, radius);
                    assert_eq!(nearest, expected, "{j} {wanted} {radius}");
                }
            }
            // A chain for each radius: what is followed was found within it, and is fewer than
            // wanted where the ball holds fewer.
            for (wanted, radius) in [(30, f64::INFINITY), (30, 0.05), (30, 0.3), (3, 1.5)] {
                let mut before = None;
                for j in (0..cloud.points.len()).step_by(3) {
                    finder.follow((before, j), wanted, radius, &mut nearest);
                    before = Some(j);
                    if j % 17 == 0 {
                        let expected = brute(&cloud, &finder, step, j, wanted, radius);
                        assert_eq!(nearest, expected, "{j} {wanted} {radius}");
                    }
                }
            }
        }
    }

    /// Stick data: one coordinate often is the belt's speed exactly, and one is constant. The other
    /// two are rounded to a grid, so that coordinates and distances repeat.
    #[test]
    fn the_tree_finds_what_brute_force_finds_on_stick_data() {
        agrees_with_brute_force((0..3000).map(|i| {
            let t = f64::from(i) * 0.137;
            let grid = |v: f64| (v * 64.0).round() / 64.0;
            [
                grid(libm::sin(t)),
                libm::cos(t).min(0.5),
                0.25,
                grid(libm::cos(0.7 * t)),
            ]
        }));
    }

    #[test]
    fn the_tree_finds_what_brute_force_finds_on_a_grid() {
        agrees_with_brute_force((0..2500).map(|i| [f64::from(i % 50), f64::from(i / 50)]));
    }

    /// Nine tenths of the points coincide. Near them there are only repeats; from elsewhere they
    /// are one far neighbour.
    #[test]
    fn the_tree_finds_what_brute_force_finds_beside_rest() {
        agrees_with_brute_force((0..3000).map(|i| {
            let at = f64::from(if i % 100 < 90 { 0 } else { i });
            [libm::sin(at), libm::sin(2.0 * at), 0.1 * at]
        }));
    }

    /// Half of the points are repeats of the reference point, and all others are equally distant.
    #[test]
    fn the_tree_finds_what_brute_force_finds_behind_repeats() {
        agrees_with_brute_force((0..3000).map(|i| [f64::from(i % 2)]));
    }

    #[test]
    fn only_repeats_end_the_search_with_nothing() {
        // Only the last point differs, and it has no image.
        let rows = (0..3000).map(|i| [f64::from(u8::from(i == 2999))]);
        let cloud = Cloud::new(&Series::from_rows(rows, 1.0).unwrap()).unwrap();
        let finder = Finder::new(&cloud, 1, 1).unwrap();
        let mut nearest = vec![(0.0, 0)];
        finder.nearest(10, 20, f64::INFINITY, &mut nearest);
        assert!(nearest.is_empty());
    }
}
