//! Averages that turn stretchings into exponents: means, standard errors, running means.

use std::f64::consts::FRAC_2_PI;

use super::chain::Stretch;
use super::settings::SHORTEST_BLOCK;
use numerics::bisect;

/// Number of blocks of reference points for the standard error. Student's quantile for this many is
/// 4 % above that for infinitely many.
const BLOCKS: usize = 32;
/// Largest number of rows of the running means: a plot resolves hardly more points.
const RUNNING_ROWS: usize = 400;

/// Mean logarithm of the stretching in one position, per unit of time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Average {
    /// NaN if no step determines it.
    pub(crate) mean: f64,
    /// Standard error from the means over blocks of time; NaN for fewer than two blocks.
    pub(crate) stderr: f64,
    /// The standard error without the correction for a small number of blocks. Differences that
    /// scatter does not explain are measured in it.
    pub(crate) scatter: f64,
    /// Number of steps averaged over, including those without a stretching.
    pub(crate) steps: usize,
    /// Steps in which the direction was annihilated.
    pub(crate) collapses: usize,
    /// Steps in which the data do not determine the direction.
    pub(crate) undetermined: usize,
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

/// Averages the stretchings in one position over all reference points, in order of time. Each
/// stretching takes the time `tau`.
pub(crate) fn average(stretches: &[Stretch], position: usize, tau: f64) -> Average {
    let blocks = (stretches.len() / SHORTEST_BLOCK).clamp(1, BLOCKS);
    let mut all = Sum::default();
    let mut parts = vec![Sum::default(); blocks];
    let (mut collapses, mut undetermined) = (0, 0);
    for (i, stretch) in stretches.iter().enumerate() {
        if position < stretch.alive {
            let term = libm::log(stretch.factor[position]);
            all.add(term);
            parts[i * blocks / stretches.len()].add(term);
        } else if position < stretch.rank {
            collapses += 1;
        } else {
            undetermined += 1;
        }
    }
    let (scatter, widened) = block_error(parts.into_iter());
    Average {
        mean: all.mean() / tau,
        stderr: widened * scatter / tau,
        scatter: scatter / tau,
        steps: stretches.len(),
        collapses,
        undetermined,
    }
}

/// Running means of the stretchings, each with the number of reference points before it.
pub(crate) fn running(stretches: &[Stretch], columns: usize, tau: f64) -> Vec<(usize, Vec<f64>)> {
    let thin = stretches.len().div_ceil(RUNNING_ROWS).max(1);
    let mut sums = vec![Sum::default(); columns];
    let mut rows = Vec::with_capacity(RUNNING_ROWS + 1);
    for (i, stretch) in (1..).zip(stretches) {
        for (sum, factor) in sums.iter_mut().zip(&stretch.factor[..stretch.alive]) {
            sum.add(libm::log(*factor));
        }
        if i % thin == 0 || i == stretches.len() {
            rows.push((i, sums.iter().map(|sum| sum.mean() / tau).collect()));
        }
    }
    rows
}

/// The average of the volume that the first `dimension` vectors span: the sum of their exponents.
pub(crate) fn volume(stretches: &[Stretch], dimension: usize, tau: f64) -> Average {
    let volumes = stretches.iter().map(|stretch| stretch.volume(dimension));
    average(&volumes.collect::<Vec<_>>(), 0, tau)
}

/// Standard error of the mean from the scatter of block means, and the factor by which it is
/// widened. With fewer than [`BLOCKS`] blocks the scatter is less certain. The error is then
/// widened so that two standard errors contain the mean as often as with all blocks.
fn block_error(blocks: impl Iterator<Item = Sum>) -> (f64, f64) {
    let means: Vec<f64> = blocks.filter(|b| b.1 > 0).map(Sum::mean).collect();
    let count = means.len() as f64;
    if means.len() < 2 {
        return (f64::NAN, 1.0);
    }
    let mean = means.iter().sum::<f64>() / count;
    let squares: f64 = means.iter().map(|m| (m - mean) * (m - mean)).sum();
    let widened = if means.len() < BLOCKS {
        student(means.len() - 1) / student(BLOCKS - 1)
    } else {
        1.0
    };
    ((squares / (count - 1.0) / count).sqrt(), widened)
}

/// Number of standard errors, estimated with `freedom` degrees of freedom, that contain the mean as
/// often as two exact ones do. This is a quantile of Student's distribution.
fn student(freedom: usize) -> f64 {
    // Probability that a normal quantity is within two standard errors.
    const WITHIN_TWO: f64 = 0.954_499_736_103_641_6;
    // The probability grows from 0 to 1, and one degree of freedom needs 14.
    bisect(0.0, 16.0, |errors| within(errors, freedom) >= WITHIN_TWO)
}

/// Probability that a variable with Student's distribution is within `t` of zero (Abramowitz &
/// Stegun 1964, 26.7.3 and 26.7.4).
fn within(t: f64, freedom: usize) -> f64 {
    let angle = libm::atan(t / (freedom as f64).sqrt());
    let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
    // A sum of powers of the cosine: odd ones for odd degrees of freedom, even ones for even.
    let odd = freedom % 2;
    let mut term = if odd == 1 { cosine } else { 1.0 };
    let mut sum = 0.0;
    for power in (odd..freedom.saturating_sub(1)).step_by(2) {
        sum += term;
        let next = power as f64;
        term *= cosine * cosine * (next + 1.0) / (next + 2.0);
    }
    if odd == 1 {
        FRAC_2_PI * (angle + sine * sum)
    } else {
        sine * sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quantiles_of_student_are_those_of_the_tables() {
        // Two-sided 95 %.
        let quantiles = [
            (1, 12.7062),
            (2, 4.3027),
            (3, 3.1824),
            (4, 2.7764),
            (5, 2.5706),
            (10, 2.2281),
            (30, 2.0423),
        ];
        for (freedom, t) in quantiles {
            assert!((within(t, freedom) - 0.95).abs() < 1e-5, "{freedom}");
        }
        assert!((student(100_000) - 2.0).abs() < 1e-4);
    }

    #[test]
    fn an_error_from_three_blocks_is_wider_than_their_scatter_and_one_from_all_is_not() {
        let blocks = |count: usize| (0..count).map(|k| Sum((k % 2) as f64, 1));
        let plain = |count: usize| {
            let ones = (count / 2) as f64;
            let count = count as f64;
            (ones * (count - ones) / count / (count - 1.0) / count).sqrt()
        };
        let (scatter, wider) = block_error(blocks(BLOCKS));
        assert!((scatter / plain(BLOCKS) - 1.0).abs() < 1e-14 && wider == 1.0);
        // 4.5266 over 2.0840.
        let (scatter, wider) = block_error(blocks(3));
        assert!((scatter / plain(3) - 1.0).abs() < 1e-14);
        assert!((wider - 2.1721).abs() < 1e-4, "{wider}");
        assert!(block_error(blocks(1)).0.is_nan());
    }
}
