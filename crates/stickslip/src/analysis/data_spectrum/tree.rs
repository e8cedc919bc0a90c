//! A search tree for the nearest points among those that may be neighbours.
//!
//! Own code, because the neighbours of a time series are not its nearest points: those next to them in time and exact repeats do not count,
//! and equally distant ones are told apart by index. Said inside the search, this costs nothing; from outside of it more points had to be
//! asked for, often several times, and half of the time of a spectrum went there.

use super::neighbours::Neighbour;

/// Points whose distances are computed together.
const LANES: usize = 8;
/// Most blocks of points in a leaf.
const BLOCKS: usize = 4;

/// The box around the points of a node.
#[derive(Clone, Copy)]
struct Bounds<const N: usize> {
    low: [f64; N],
    high: [f64; N],
}

impl<const N: usize> Bounds<N> {
    fn around(points: &[[f64; N]], indices: &[u32]) -> Self {
        let mut bounds = Bounds {
            low: [f64::INFINITY; N],
            high: [f64::NEG_INFINITY; N],
        };
        for &index in indices {
            for (c, v) in points[index as usize].iter().enumerate() {
                bounds.low[c] = bounds.low[c].min(*v);
                bounds.high[c] = bounds.high[c].max(*v);
            }
        }
        bounds
    }

    /// The column in which the box is widest.
    fn widest(&self) -> usize {
        let width = |c: &usize| self.high[*c] - self.low[*c];
        (0..N)
            .max_by(|a, b| width(a).total_cmp(&width(b)))
            .unwrap_or(0)
    }

    /// A square that no point of the box is nearer than: the subtractions and squares are those of [`super::cloud::distance2`], in its order,
    /// with smaller operands, and rounding is monotonic.
    #[inline(always)]
    fn distance2(&self, centre: &[f64; N]) -> f64 {
        let mut sum = 0.0;
        for (v, (low, high)) in centre.iter().zip(self.low.iter().zip(&self.high)) {
            let outside = (low - v).max(v - high).max(0.0);
            sum += outside * outside;
        }
        sum
    }
}

/// Some points of a leaf, column by column.
#[derive(Clone, Copy)]
struct Block<const N: usize> {
    columns: [[f64; LANES]; N],
    indices: [u32; LANES],
}

impl<const N: usize> Block<N> {
    /// Places that no point takes are no numbers, and so not within any distance.
    fn of(points: &[[f64; N]], indices: &[u32]) -> Self {
        let mut block = Block {
            columns: [[f64::NAN; LANES]; N],
            indices: [0; LANES],
        };
        for (lane, &index) in indices.iter().enumerate() {
            for (column, v) in block.columns.iter_mut().zip(&points[index as usize]) {
                column[lane] = *v;
            }
            block.indices[lane] = index;
        }
        block
    }

    /// Squares of the distances, each with the bits of [`super::cloud::distance2`].
    #[inline(always)]
    fn distances2(&self, centre: &[f64; N]) -> [f64; LANES] {
        let mut sums = [0.0; LANES];
        for (column, centre) in self.columns.iter().zip(centre) {
            for (sum, v) in sums.iter_mut().zip(column) {
                *sum += (v - centre) * (v - centre);
            }
        }
        sums
    }
}

/// A balanced tree: the children of node `i` are the nodes `2 i + 1` and `2 i + 2`, leaves are the nodes of the last level.
pub(super) struct Tree<const N: usize> {
    bounds: Vec<Bounds<N>>,
    first_leaf: usize,
    /// [`BLOCKS`] of each leaf, from left to right.
    blocks: Vec<Block<N>>,
}

impl<const N: usize> Tree<N> {
    /// A tree of the points, which are numbers.
    pub(super) fn new(points: &[[f64; N]]) -> Self {
        let mut indices: Vec<u32> = (0..).take(points.len()).collect();
        let mut leaves = 1;
        while leaves * LANES * BLOCKS < points.len() {
            leaves *= 2;
        }
        let first_leaf = leaves - 1;
        let mut bounds = Vec::with_capacity(first_leaf + leaves);
        // Of each node of a level, from left to right.
        let mut level: Vec<&mut [u32]> = vec![&mut indices];
        while level.len() < leaves {
            let mut next = Vec::with_capacity(2 * level.len());
            for part in level {
                let node = Bounds::around(points, part);
                let (c, middle) = (node.widest(), part.len() / 2);
                if middle > 0 {
                    let value = |index: &u32| points[*index as usize][c];
                    part.select_nth_unstable_by(middle, |a, b| value(a).total_cmp(&value(b)));
                }
                let (left, right) = part.split_at_mut(middle);
                next.extend([left, right]);
                bounds.push(node);
            }
            level = next;
        }
        let mut blocks = Vec::with_capacity(leaves * BLOCKS);
        for leaf in &level {
            bounds.push(Bounds::around(points, leaf));
            let parts = leaf.chunks(LANES).chain(std::iter::repeat(&[][..]));
            blocks.extend(parts.take(BLOCKS).map(|part| Block::of(points, part)));
        }
        Self {
            bounds,
            first_leaf,
            blocks,
        }
    }

    /// The `wanted` points nearest to `centre` whose square of distance is at most `radius2`, of those that are `admissible` by square and
    /// index: nearest first, equally distant ones by index. Fewer if there are no more.
    pub(super) fn nearest(
        &self,
        centre: &[f64; N],
        wanted: usize,
        radius2: f64,
        admissible: impl Fn(f64, u32) -> bool,
        found: &mut Vec<Neighbour>,
    ) {
        found.clear();
        if wanted == 0 {
            return;
        }
        let mut furthest = (radius2, u32::MAX);
        // Candidates are collected until they are twice as many, and those that are too far then go together.
        let mut full = wanted;
        let child = |node: usize| (node, self.bounds[node].distance2(centre));
        let mut open = vec![(0, 0.0)];
        while let Some((node, least)) = open.pop() {
            if least > furthest.0 {
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
            let leaf = (node - self.first_leaf) * BLOCKS;
            for block in &self.blocks[leaf..leaf + BLOCKS] {
                let squares = block.distances2(centre);
                for (square, &index) in squares.into_iter().zip(&block.indices) {
                    let is_near =
                        square <= furthest.0 && (square < furthest.0 || index <= furthest.1);
                    if is_near && admissible(square, index) {
                        found.push((square, index));
                    }
                }
            }
            if found.len() >= full {
                furthest = *found.select_nth_unstable_by_key(wanted - 1, order).1;
                found.truncate(wanted);
                full = wanted.saturating_mul(2);
            }
        }
        found.sort_unstable_by_key(order);
        found.truncate(wanted);
    }
}

/// By distance and then by index, as one number: the bits of positive numbers are in the order of the numbers.
fn order(neighbour: &Neighbour) -> u128 {
    u128::from(neighbour.0.to_bits()) << u32::BITS | u128::from(neighbour.1)
}
