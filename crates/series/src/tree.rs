//! A search tree for the nearest points among those that may be neighbours.
//!
//! Own code, because the neighbours of a time series are not its nearest points. Those next to it
//! in time and exact repeats do not count, and equally distant ones are ordered by index. Inside
//! the search these conditions cost nothing. Outside of it, more points would have to be requested,
//! often several times, at half of the time of a spectrum.

use std::cmp::Ordering;

use pulp::Arch;

use super::matrix::Matrix;

/// A neighbour: squared distance and index.
pub(crate) type Neighbour = (f64, u32);

/// Points whose distances are computed together: two vectors of the machine.
const LANES: usize = 8;
/// Blocks of points in a leaf. Chosen for speed; it changes no bit.
const BLOCKS_PER_LEAF: usize = 4;

/// The box around the points of a node.
#[derive(Clone, Copy)]
struct Bounds<'a> {
    low: &'a [f64],
    high: &'a [f64],
    /// The smallest index.
    first: u32,
}

impl Bounds<'_> {
    /// The column in which the box is widest.
    fn widest(&self) -> usize {
        let width = |c: &usize| self.high[*c] - self.low[*c];
        (0..self.low.len())
            .max_by(|a, b| width(a).total_cmp(&width(b)))
            .unwrap_or(0)
    }

    /// Lower bound of the squared distance to the points of the box. The operations are those of
    /// [`super::matrix::distance2`], in its order, with smaller operands, and rounding is
    /// monotonic.
    #[inline(always)]
    fn distance2(&self, centre: &[f64]) -> f64 {
        let mut sum = 0.0;
        for ((v, low), high) in centre.iter().zip(self.low).zip(self.high) {
            let outside = (low - v).max(v - high).max(0.0);
            sum += outside * outside;
        }
        sum
    }

    /// Upper bound of the squared distance, in the same way.
    fn furthest2(&self, centre: &[f64]) -> f64 {
        let mut sum = 0.0;
        for ((v, low), high) in centre.iter().zip(self.low).zip(self.high) {
            let inside = (v - low).max(high - v);
            sum += inside * inside;
        }
        sum
    }

    /// Whether the box, which is no nearer than `least`, holds nothing but repeats, or nothing
    /// before the `furthest` neighbour found.
    #[inline(always)]
    fn has_none(&self, centre: &[f64], least: f64, repeat2: f64, furthest: Neighbour) -> bool {
        let is_far = least > furthest.0 || least == furthest.0 && self.first > furthest.1;
        is_far || least <= repeat2 && self.furthest2(centre) <= repeat2
    }
}

/// A balanced tree. The children of node `i` are the nodes `2 i + 1` and `2 i + 2`; leaves are the
/// nodes of the last level.
pub(crate) struct Tree {
    columns: usize,
    /// Lower ends of each node's box, then the upper ones.
    boxes: Vec<f64>,
    /// Smallest index in each node.
    first: Vec<u32>,
    first_leaf: usize,
    /// Points of the leaves, from left to right: [`BLOCKS_PER_LEAF`] blocks of each, and of each
    /// block its lanes, column by column. Places that no point takes are no numbers, and so not
    /// within any distance.
    lanes: Vec<[f64; LANES]>,
    /// Indices of the points, block by block.
    indices: Vec<[u32; LANES]>,
}

impl Tree {
    /// A tree of so many of the first points, which are numbers.
    pub(crate) fn new(points: &Matrix, count: usize) -> Self {
        // Column by column: what a node looks at lies together.
        let column = |c: usize| points.first(count).map(|row| row[c]).collect();
        let columns: Vec<Vec<f64>> = (0..points.columns()).map(column).collect();
        let mut indices: Vec<u32> = (0..).take(count).collect();
        let mut leaves = 1;
        while leaves * LANES * BLOCKS_PER_LEAF < count {
            leaves *= 2;
        }
        let first_leaf = leaves - 1;
        let mut tree = Self {
            columns: points.columns(),
            boxes: Vec::with_capacity((first_leaf + leaves) * 2 * points.columns()),
            first: Vec::with_capacity(first_leaf + leaves),
            first_leaf,
            lanes: Vec::with_capacity(leaves * BLOCKS_PER_LEAF * points.columns()),
            indices: Vec::with_capacity(leaves * BLOCKS_PER_LEAF),
        };
        // Of each node of a level, from left to right.
        let mut level: Vec<&mut [u32]> = vec![&mut indices];
        while level.len() < leaves {
            let mut next = Vec::with_capacity(2 * level.len());
            for part in level {
                let node = tree.push_box(&columns, part);
                let (c, middle) = (tree.bounds(node).widest(), part.len() / 2);
                if middle > 0 {
                    let column = columns[c].as_slice();
                    let value = |index: &u32| column[*index as usize];
                    part.select_nth_unstable_by(middle, |a, b| value(a).total_cmp(&value(b)));
                }
                let (left, right) = part.split_at_mut(middle);
                next.extend([left, right]);
            }
            level = next;
        }
        for leaf in &level {
            tree.push_box(&columns, leaf);
            let parts = leaf.chunks(LANES).chain(std::iter::repeat(&[][..]));
            parts
                .take(BLOCKS_PER_LEAF)
                .for_each(|part| tree.push_block(&columns, part));
        }
        tree
    }

    /// The next node's box, around these points; returns its number.
    fn push_box(&mut self, columns: &[Vec<f64>], indices: &[u32]) -> usize {
        for column in columns {
            let values = indices.iter().map(|index| column[*index as usize]);
            self.boxes.push(values.fold(f64::INFINITY, f64::min));
        }
        for column in columns {
            let values = indices.iter().map(|index| column[*index as usize]);
            self.boxes.push(values.fold(f64::NEG_INFINITY, f64::max));
        }
        let first = indices.iter().copied().min();
        self.first.push(first.unwrap_or(u32::MAX));
        self.first.len() - 1
    }

    fn push_block(&mut self, columns: &[Vec<f64>], indices: &[u32]) {
        for column in columns {
            let mut lanes = [f64::NAN; LANES];
            for (lane, index) in lanes.iter_mut().zip(indices) {
                *lane = column[*index as usize];
            }
            self.lanes.push(lanes);
        }
        let mut lanes = [0; LANES];
        lanes[..indices.len()].copy_from_slice(indices);
        self.indices.push(lanes);
    }

    #[inline(always)]
    fn bounds(&self, node: usize) -> Bounds<'_> {
        let ends = &self.boxes[2 * node * self.columns..][..2 * self.columns];
        let (low, high) = ends.split_at(self.columns);
        let first = self.first[node];
        Bounds { low, high, first }
    }

    /// Squares of the distances of a block's points, each with the bits of
    /// [`super::matrix::distance2`].
    #[inline(always)]
    fn distances2(&self, block: usize, centre: &[f64]) -> [f64; LANES] {
        let columns = &self.lanes[block * self.columns..][..self.columns];
        let mut sums = [0.0; LANES];
        for (column, centre) in columns.iter().zip(centre) {
            for (sum, v) in sums.iter_mut().zip(column) {
                *sum += (v - centre) * (v - centre);
            }
        }
        sums
    }

    /// The `wanted` points nearest to `centre` that are `admissible` by index, nearest first,
    /// equally distant ones by index. Their squared distance is above `repeat2` and at most
    /// `radius2`. Fewer if there are no more.
    ///
    /// Where a system is at equilibrium or sticks, thousands of points coincide. A node with
    /// repeats only is skipped. So is a node as far as the last neighbour so far, if all its
    /// indices are larger.
    pub(crate) fn nearest(
        &self,
        centre: &[f64],
        wanted: usize,
        between: (f64, f64),
        admissible: impl Fn(u32) -> bool,
        nearest: &mut Vec<Neighbour>,
    ) {
        nearest.clear();
        if wanted == 0 {
            return;
        }
        // Compiled for the SIMD vectors of the machine, which change no bit: each distance is one
        // lane.
        Arch::new().dispatch(
            #[inline(always)]
            || self.collect(centre, wanted, between, admissible, nearest),
        );
        sort(nearest, wanted);
    }

    /// Points that [`Tree::nearest`] looks for, unsorted, and some beyond the wanted ones.
    #[inline(always)]
    fn collect(
        &self,
        centre: &[f64],
        wanted: usize,
        (repeat2, radius2): (f64, f64),
        admissible: impl Fn(u32) -> bool,
        nearest: &mut Vec<Neighbour>,
    ) {
        let mut furthest = (radius2, u32::MAX);
        // Candidates are collected until they are twice as many as wanted; those that are too far
        // are then removed together. Without a radius, the first removal is earlier, since it gives
        // a bound of the distance.
        let mut full = if radius2.is_finite() {
            wanted.saturating_mul(2)
        } else {
            wanted
        };
        let child = |node: usize| (node, self.bounds(node).distance2(centre));
        // One of each level and the root's other child: no more levels are needed for all indices.
        let mut open = Vec::with_capacity(u32::BITS as usize);
        open.push((0, 0.0));
        while let Some((node, least)) = open.pop() {
            if self.bounds(node).has_none(centre, least, repeat2, furthest) {
                continue;
            }
            if node < self.first_leaf {
                let (left, right) = (child(2 * node + 1), child(2 * node + 2));
                // The nearer one is looked at first.
                open.extend(if left.1 <= right.1 {
                    [right, left]
                } else {
                    [left, right]
                });
                continue;
            }
            let leaf = (node - self.first_leaf) * BLOCKS_PER_LEAF;
            for block in leaf..leaf + BLOCKS_PER_LEAF {
                let squares = self.distances2(block, centre);
                // Most blocks hold none that is near enough: these are passed over.
                let is_any = squares
                    .iter()
                    .fold(false, |any, square| any | (*square <= furthest.0));
                if !is_any {
                    continue;
                }
                for (&square, &index) in squares.iter().zip(&self.indices[block]) {
                    let is_inside = square > repeat2 && square <= furthest.0;
                    let is_before = square < furthest.0 || index <= furthest.1;
                    if is_inside && is_before && admissible(index) {
                        nearest.push((square, index));
                    }
                }
            }
            if nearest.len() >= full {
                furthest = *nearest.select_nth_unstable_by(wanted - 1, order).1;
                nearest.truncate(wanted);
                full = wanted.saturating_mul(2);
            }
        }
    }
}

/// Sorts by distance and then by index, and keeps the first so many.
fn sort(nearest: &mut Vec<Neighbour>, wanted: usize) {
    nearest.sort_unstable_by(order);
    nearest.truncate(wanted);
}

/// Order by distance and then by index.
fn order(a: &Neighbour, b: &Neighbour) -> Ordering {
    a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matrix::distance2;
    use numerics::SplitMix;

    /// Compares with an exhaustive search. There are up to some hundred points, in space, on a
    /// grid, or in a few places far from the origin.
    fn agrees_with_brute_force(columns: usize) {
        let mut draw = SplitMix::new(45);
        for round in 0..200 {
            let count = draw.between(0.0, 300.0) as usize;
            let cells = (0..count * columns).map(|_| match round % 3 {
                0 => draw.uniform(),
                1 => (4.0 * draw.uniform()).floor(),
                _ => 1e6 + (2.0 * draw.uniform()).floor() * 1e-9,
            });
            let points = Matrix::new(cells.collect(), columns);
            let tree = Tree::new(&points, count);
            let centre = points
                .rows()
                .last()
                .map_or(vec![0.5; columns], <[f64]>::to_vec);
            let admissible = |k: u32| !k.is_multiple_of(3);
            for wanted in [0, 1, 2, 30, 500, usize::MAX] {
                for between in [(-1.0, f64::INFINITY), (0.0, 0.0), (1e-20, 0.05), (0.0, 2.0)] {
                    let mut nearest = Vec::new();
                    tree.nearest(&centre, wanted, between, admissible, &mut nearest);
                    let mut all: Vec<Neighbour> = (0..)
                        .zip(points.rows())
                        .map(|(k, point)| (distance2(point, &centre), k))
                        .filter(|&(square, k)| {
                            square > between.0 && square <= between.1 && admissible(k)
                        })
                        .collect();
                    all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                    all.truncate(wanted);
                    assert_eq!(nearest, all, "{columns} {count} {wanted} {between:?}");
                }
            }
        }
    }

    #[test]
    fn nearest_points_are_those_of_a_look_at_all() {
        agrees_with_brute_force(1);
        agrees_with_brute_force(3);
        agrees_with_brute_force(10);
    }

    /// Difference in few places, by a few units in the last place.
    #[test]
    fn neighbours_are_sorted_by_distance_and_then_by_index() {
        let mut draw = SplitMix::new(7);
        for count in [0, 1, 2, 50, 4096, 4097, 6000] {
            let mut nearest: Vec<Neighbour> = (0..count)
                .map(|_| {
                    let place = (3.0 * draw.uniform()).floor();
                    let ulps = (5.0 * draw.uniform()).floor();
                    (
                        1.0 + place + ulps * f64::EPSILON,
                        draw.between(0.0, 20.0) as u32,
                    )
                })
                .collect();
            let mut expected = nearest.clone();
            expected.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let mut all = nearest.clone();
            sort(&mut all, count);
            assert_eq!(all, expected, "{count}");
            expected.truncate(40);
            sort(&mut nearest, 40);
            assert_eq!(nearest, expected, "40 of {count}");
        }
    }

    /// The search stays short where a system is at equilibrium.
    #[test]
    fn a_box_of_repeats_and_one_of_later_points_as_far_are_passed_over() {
        let (place, beside) = ([0.5, 1.0], [0.5, 3.0]);
        let tree = Tree::new(&Matrix::new(place.repeat(1000), 2), 1000);
        let root = tree.bounds(0);
        assert!(root.has_none(&place, 0.0, 1e-18, (f64::INFINITY, u32::MAX)));
        assert!(!root.has_none(&place, 0.0, -1.0, (f64::INFINITY, u32::MAX)));
        let least = root.distance2(&beside);
        assert_eq!((least, root.furthest2(&beside)), (4.0, 4.0));
        // Its first point is wanted if it is not behind the last that was found.
        assert!(!root.has_none(&beside, least, 1e-18, (4.0, 0)));
        assert!(root.has_none(&beside, least, 1e-18, (3.9, u32::MAX)));
        let later = Bounds { first: 7, ..root };
        assert!(later.has_none(&beside, least, 1e-18, (4.0, 6)));
    }
}
