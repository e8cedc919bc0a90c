//! Starts in a plane.

use std::num::NonZeroUsize;
use std::ops::Range;

use numerics::SplitMix;
use serde::{Deserialize, Serialize};
use stickslip_model::study::shares::{error_of_grid, error_of_random};

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

    /// Standard error of the share of one attractor, if `reached` has the number of the attractor
    /// of each point.
    pub(super) fn std_error(&self, reached: &[u32], number: u32) -> f64 {
        match *self {
            Points::Grid { columns, .. } => error_of_grid(reached, columns.get(), number),
            Points::Random { .. } => error_of_random(reached, number),
        }
    }
}

#[cfg(test)]
mod tests {
    use stickslip::math;

    use super::*;

    /// Ratio of the mean standard error of a share to the root mean square of its errors. A set is
    /// put at many places of a grid of 40 x 30 cells. All errors are within four standard errors.
    fn coverage(area: impl Fn([f64; 3]) -> f64, is_in: impl Fn([f64; 2], [f64; 3]) -> bool) -> f64 {
        let size = |n| NonZeroUsize::new(n).unwrap();
        let (columns, rows) = (size(40), size(30));
        let grid = Points::Grid { columns, rows };
        let random = &mut SplitMix::new(3);
        let (mut errors, mut squares) = (0.0, 0.0);
        for _ in 0..500 {
            let place = [random.uniform(), random.uniform(), random.uniform()];
            let middles = (0..1200).map(|k| [(k % 40) as f64 + 0.5, (k / 40) as f64 + 0.5]);
            let reached: Vec<u32> = middles.map(|at| u32::from(is_in(at, place))).collect();
            let share = reached.iter().sum::<u32>() as f64 / 1200.0;
            let (error, bound) = (share - area(place) / 1200.0, grid.std_error(&reached, 1));
            assert_eq!(bound, grid.std_error(&reached, 0));
            assert!(error.abs() <= 4.0 * bound, "{place:?}: {error}, {bound}");
            errors += bound / 500.0;
            squares += error * error / 500.0;
        }
        errors / squares.sqrt()
    }

    #[test]
    fn standard_errors_of_a_grid_cover_areas_that_are_known() {
        // A disc of radius 10 somewhere.
        let ratio = coverage(
            |_| std::f64::consts::PI * 100.0,
            |[x, y], [a, b, _]| math::hypot(x - 15.0 - a, y - 14.0 - b) < 10.0,
        );
        assert!((0.9..3.0).contains(&ratio), "{ratio}");
        // A strip along the grid, each side of which is off by the same part of each cell.
        let ratio = coverage(
            |[a, b, _]| (10.0 + b - a) * 30.0,
            |[x, _], [a, b, _]| (10.0 + a..20.0 + b).contains(&x),
        );
        assert!((0.9..1.1).contains(&ratio), "{ratio}");
        // A square of any slope: along a slope errors cancel.
        let ratio = coverage(
            |_| 16.4 * 16.4,
            |[x, y], [a, b, c]| {
                let angle = std::f64::consts::TAU * c;
                let (sine, cosine) = (math::sin(angle), math::cos(angle));
                let (x, y) = (x - 20.0 - a, y - 15.0 - b);
                (x * cosine + y * sine).abs() < 8.2 && (y * cosine - x * sine).abs() < 8.2
            },
        );
        assert!((0.9..3.0).contains(&ratio), "{ratio}");
        // Random starts would have errors above 1.2 % in all three.
        let size = |n| NonZeroUsize::new(n).unwrap();
        let random = Points::Random {
            number: size(4),
            seed: 1,
        };
        assert_eq!(random.std_error(&[1, 1, 0, 0], 1), 0.25);
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
