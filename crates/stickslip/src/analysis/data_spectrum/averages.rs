//! From stretchings to exponents: means, standard errors, running means.

use super::chain::Stretch;
use crate::math;

/// Blocks the reference points are divided into for the standard error.
const BLOCKS: usize = 32;
/// Fewest reference points of a block.
const SHORTEST_BLOCK: usize = 10;
/// Rows of the running means.
const ROWS: usize = 400;

/// Mean logarithm of the stretching in one position, per time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Average {
    /// NaN if no step determines it.
    pub(super) mean: f64,
    /// Standard error from the means over blocks of time; NaN for fewer than two blocks.
    pub(super) stderr: f64,
    /// Steps in which the direction was annihilated.
    pub(super) collapses: usize,
    /// Steps in which the data determine nothing.
    pub(super) undetermined: usize,
}

/// Sum and number of terms.
#[derive(Clone, Copy, Default)]
struct Sum(f64, usize);

impl Sum {
    fn add(&mut self, term: f64) {
        self.0 += term;
        self.1 += 1;
    }

    fn mean(self) -> f64 {
        if self.1 == 0 {
            f64::NAN
        } else {
            self.0 / self.1 as f64
        }
    }
}

/// Averages over the stretchings of all reference points in the order of time, each over the time `tau`. Running means follow,
/// each with the number of reference points before it.
pub(super) fn average<const N: usize>(
    stretches: &[Stretch<N>],
    tau: f64,
) -> ([Average; N], Vec<(usize, [f64; N])>) {
    let blocks = (stretches.len() / SHORTEST_BLOCK).clamp(1, BLOCKS);
    let thin = stretches.len().div_ceil(ROWS).max(1);
    let mut sums = [Sum::default(); N];
    let mut parts = vec![[Sum::default(); N]; blocks];
    let mut collapses = [0; N];
    let mut undetermined = [0; N];
    let mut running = Vec::with_capacity(ROWS + 1);
    for (i, stretch) in stretches.iter().enumerate() {
        let block = &mut parts[i * blocks / stretches.len()];
        for c in 0..N {
            if c < stretch.alive {
                let term = math::ln(stretch.factor[c]);
                sums[c].add(term);
                block[c].add(term);
            } else if c < stretch.determined {
                collapses[c] += 1;
            } else {
                undetermined[c] += 1;
            }
        }
        if (i + 1) % thin == 0 || i + 1 == stretches.len() {
            running.push((i + 1, sums.map(|sum| sum.mean() / tau)));
        }
    }
    let averages = std::array::from_fn(|c| Average {
        mean: sums[c].mean() / tau,
        stderr: block_error(parts.iter().map(|block| block[c])) / tau,
        collapses: collapses[c],
        undetermined: undetermined[c],
    });
    (averages, running)
}

/// The average of the volume that the first `dimension` vectors span: the sum of their exponents.
pub(super) fn volume<const N: usize>(
    stretches: &[Stretch<N>],
    dimension: usize,
    tau: f64,
) -> Average {
    let volumes: Vec<Stretch<1>> = stretches
        .iter()
        .map(|stretch| stretch.volume(dimension))
        .collect();
    average(&volumes, tau).0[0]
}

/// Standard error of the mean from the scatter of the means of blocks.
fn block_error(blocks: impl Iterator<Item = Sum>) -> f64 {
    let means: Vec<f64> = blocks.filter(|b| b.1 > 0).map(Sum::mean).collect();
    let count = means.len() as f64;
    if means.len() < 2 {
        return f64::NAN;
    }
    let mean = means.iter().sum::<f64>() / count;
    let squares: f64 = means.iter().map(|m| (m - mean) * (m - mean)).sum();
    (squares / (count - 1.0) / count).sqrt()
}
