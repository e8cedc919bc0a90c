//! Whether points that do not repeat have filled their region.

use crate::dynamics::Moment;

/// Part of their extent within which points are near. Chosen: 400 points lie so near each other in
/// two dimensions, with twenty intervals in each.
pub(super) const NEAR_PART: f64 = 0.05;

/// Fraction of the points that must be near others, as the tips of a strange attractor are rarely
/// visited. Chosen.
const LEAST_INSIDE: f64 = 0.95;

/// Whether the last quarter of the points lies near the preceding half, so that no new region is
/// visited.
pub(super) fn returns_everywhere(points: &[Moment]) -> bool {
    let (middle, last) = (points.len() / 4, 3 * points.len() / 4);
    lies_in(&points[last..], &points[middle..last], &extent(points))
}

/// Whether two recurrent sets of points agree: each lies near the other.
pub(super) fn is_same_set(one: &[Moment], other: &[Moment]) -> bool {
    let (a, b) = (extent(one), extent(other));
    let wider: Vec<f64> = a.iter().zip(b).map(|(a, b)| a.max(b)).collect();
    lies_in(one, other, &wider) && lies_in(other, one, &wider)
}

fn lies_in(these: &[Moment], those: &[Moment], extent: &[f64]) -> bool {
    let near = |one: &Moment, other: &Moment| {
        (0..extent.len()).all(|i| (one.x[i] - other.x[i]).abs() <= NEAR_PART * extent[i])
    };
    let inside = |one: &&Moment| those.iter().any(|other| near(one, other));
    these.iter().filter(inside).count() as f64 >= LEAST_INSIDE * these.len() as f64
}

fn extent(points: &[Moment]) -> Vec<f64> {
    let states = points.first().map_or(0, |point| point.x.len());
    let extent = |i: usize| {
        let values = || points.iter().map(|point| point.x[i]);
        values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
    };
    (0..states).map(extent).collect()
}
