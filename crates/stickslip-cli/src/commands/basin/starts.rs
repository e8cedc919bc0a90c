//! Starts in a plane.

use std::num::NonZeroUsize;
use std::ops::Range;

use serde::{Deserialize, Serialize};
use stickslip::statistics::SplitMix;

use crate::commands::range::{StateRange, middle};
use crate::commands::sweeping::blocks;

/// Number of random starts in a block.
const IN_BLOCK: usize = 100;

/// Points of the plane.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Points {
    /// Centres of cells, row by row from the lowest second coordinate.
    Grid {
        columns: NonZeroUsize,
        rows: NonZeroUsize,
    },
    /// Uniformly distributed, independent.
    Random { number: NonZeroUsize, seed: u64 },
}

impl Points {
    /// Number of blocks. A row of a grid is one block.
    pub(super) fn blocks(&self) -> NonZeroUsize {
        match *self {
            Points::Grid { rows, .. } => rows,
            Points::Random { number, .. } => blocks(number, IN_BLOCK),
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

    /// Coordinates of a point in the plane.
    pub(super) fn at(&self, index: usize, ranges: &[StateRange; 2]) -> [f64; 2] {
        let parts = match *self {
            Points::Grid { columns, rows } => [
                middle(index % columns, columns),
                middle(index / columns, rows),
            ],
            Points::Random { seed, .. } => {
                let random = &mut SplitMix::from_index(seed, 2 * index as u64);
                [random.uniform(), random.uniform()]
            }
        };
        [0, 1].map(|k| ranges[k].at(parts[k]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
