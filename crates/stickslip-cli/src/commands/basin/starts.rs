//! The starts of a basin: a grid or random points in a plane.

use std::num::NonZeroUsize;
use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::super::range::{StateRange, middle};

/// Random starts in a block.
const IN_BLOCK: usize = 100;

/// Which points of the plane.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Points {
    /// The middles of cells, row by row from the lowest second coordinate.
    Grid {
        columns: NonZeroUsize,
        rows: NonZeroUsize,
    },
    /// Uniformly distributed, independent.
    Random { number: NonZeroUsize, seed: u64 },
}

impl Points {
    /// Number of blocks: a row of a grid is one.
    pub(super) fn blocks(&self) -> NonZeroUsize {
        match *self {
            Points::Grid { rows, .. } => rows,
            Points::Random { number, .. } => {
                let blocks = number.get().div_ceil(IN_BLOCK);
                NonZeroUsize::new(blocks).unwrap_or(NonZeroUsize::MIN)
            }
        }
    }

    /// The points of a block, by number.
    pub(super) fn of_block(&self, block: usize) -> Range<usize> {
        match *self {
            Points::Grid { columns, .. } => {
                let columns = columns.get();
                block * columns..(block + 1) * columns
            }
            Points::Random { number, .. } => {
                let number = number.get();
                (block * IN_BLOCK).min(number)..((block + 1) * IN_BLOCK).min(number)
            }
        }
    }

    /// Where in the plane a point is.
    pub(super) fn at(&self, index: usize, ranges: &[StateRange; 2]) -> [f64; 2] {
        let parts = match *self {
            Points::Grid { columns, rows } => [
                middle(index % columns, columns),
                middle(index / columns, rows),
            ],
            Points::Random { seed, .. } => {
                let first = 2 * index as u64;
                [uniform(seed, first), uniform(seed, first + 1)]
            }
        };
        [0, 1].map(|k| ranges[k].at(parts[k]))
    }
}

/// The `index`-th of a sequence of numbers in [0, 1): SplitMix64 (Steele, Lea and Flood 2014), whose numbers can be had in any order.
fn uniform(seed: u64, index: u64) -> f64 {
    const GAMMA: u64 = 0x9e37_79b9_7f4a_7c15;
    let mut z = seed.wrapping_add(index.wrapping_add(1).wrapping_mul(GAMMA));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^= z >> 31;
    // The upper 53 bits are those of a mantissa.
    (z >> 11) as f64 / (1_u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sequence_is_the_published_one() {
        // The first numbers that SplitMix64 gives for the seed 1234567.
        let published = [6_457_827_717_110_365_317_u64, 3_203_168_211_198_807_973];
        for (index, whole) in published.into_iter().enumerate() {
            let wanted = (whole >> 11) as f64 / (1_u64 << 53) as f64;
            assert_eq!(uniform(1_234_567, index as u64), wanted);
        }
    }

    #[test]
    fn blocks_have_every_point_once() {
        let size = |n| NonZeroUsize::new(n).unwrap();
        for (points, number) in [
            (
                Points::Grid {
                    columns: size(7),
                    rows: size(3),
                },
                21,
            ),
            (
                Points::Random {
                    number: size(250),
                    seed: 1,
                },
                250,
            ),
        ] {
            let all = (0..points.blocks().get()).flat_map(|block| points.of_block(block));
            assert!(all.eq(0..number));
        }
    }
}
