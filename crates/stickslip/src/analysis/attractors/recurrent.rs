//! Whether points that do not repeat have filled what they fill.

use super::SectionPoint;

/// Part of their extent within which points count as near.
pub(super) const PART: f64 = 0.05;

/// Part of the points that must be near to others; the tips of a strange attractor are met rarely.
const MOST: f64 = 0.95;

/// Whether the last quarter of the points lies near to the half before it: no new ground is won.
pub(super) fn returns_everywhere<const N: usize>(points: &[SectionPoint<N>]) -> bool {
    let (middle, last) = (points.len() / 4, 3 * points.len() / 4);
    lies_in(&points[last..], &points[middle..last], &extent(points))
}

/// Whether two recurrent sets of points are one: each lies near to the other.
pub(super) fn is_same_set<const N: usize>(
    one: &[SectionPoint<N>],
    other: &[SectionPoint<N>],
) -> bool {
    let (a, b) = (extent(one), extent(other));
    let wider = std::array::from_fn(|i| a[i].max(b[i]));
    lies_in(one, other, &wider) && lies_in(other, one, &wider)
}

fn lies_in<const N: usize>(
    these: &[SectionPoint<N>],
    those: &[SectionPoint<N>],
    extent: &[f64; N],
) -> bool {
    let near = |one: &SectionPoint<N>, other: &SectionPoint<N>| {
        (0..N).all(|i| (one.x[i] - other.x[i]).abs() <= PART * extent[i])
    };
    let inside = |one: &&SectionPoint<N>| those.iter().any(|other| near(one, other));
    these.iter().filter(inside).count() as f64 >= MOST * these.len() as f64
}

fn extent<const N: usize>(points: &[SectionPoint<N>]) -> [f64; N] {
    std::array::from_fn(|i| {
        let values = || points.iter().map(|point| point.x[i]);
        values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
    })
}
