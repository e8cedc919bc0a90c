//! Sums of logarithms over time, their blocks and their running means.

use super::settings::SpectrumOptions;
use super::spectrum::{Exponent, Running};

/// Growth of tangent vectors since measuring began: sums of logarithms, one for each vector. They
/// yield the exponents, their blocks and their running means.
#[derive(Clone, Debug)]
pub struct Growth {
    /// Time measuring began.
    begin: f64,
    /// Sums of the logarithms; −∞ for an annihilated vector.
    pub logs: Vec<f64>,
    block_length: f64,
    sample_length: f64,
    /// Number of the next sample.
    next_sample: usize,
    /// Start of the block under way: time since measuring began, and sums there.
    block_start: (f64, Vec<f64>),
    next_block: usize,
    /// Rates of each vector in the completed blocks.
    rates: Vec<Vec<f64>>,
    running: Vec<Running>,
}

impl Growth {
    /// Measures the given number of vectors from time `begin` on, with the duration, blocks and
    /// samples of `settings`.
    pub fn new(count: usize, begin: f64, settings: &SpectrumOptions) -> Self {
        let zeros = || vec![0.0; count];
        Growth {
            begin,
            logs: zeros(),
            block_length: settings.duration / settings.blocks as f64,
            sample_length: settings.duration / settings.samples as f64,
            next_sample: 1,
            block_start: (0.0, zeros()),
            next_block: 1,
            rates: vec![Vec::new(); count],
            running: Vec::new(),
        }
    }

    /// Ends a block or sample that is complete; called at the end of every step. A contribution of
    /// a transition at the same time belongs to the next block.
    pub fn tick(&mut self, t: f64) {
        let elapsed = t - self.begin;
        if elapsed >= self.next_block as f64 * self.block_length {
            self.end_block(elapsed);
            self.next_block = (elapsed / self.block_length) as usize + 1;
        }
        if elapsed >= self.next_sample as f64 * self.sample_length {
            self.sample(elapsed);
            self.next_sample = (elapsed / self.sample_length) as usize + 1;
        }
    }

    /// Time measured until `t`.
    pub(super) fn elapsed(&self, t: f64) -> f64 {
        t - self.begin
    }

    fn end_block(&mut self, elapsed: f64) {
        let (from, before) = std::mem::replace(&mut self.block_start, (elapsed, self.logs.clone()));
        let logs = self.logs.iter().zip(before);
        for (rates, (log, before)) in self.rates.iter_mut().zip(logs) {
            rates.push((log - before) / (elapsed - from));
        }
    }

    fn sample(&mut self, elapsed: f64) {
        self.running.push(Running {
            elapsed,
            exponents: self.means(elapsed),
        });
    }

    fn means(&self, elapsed: f64) -> Vec<f64> {
        self.logs.iter().map(|log| log / elapsed).collect()
    }

    /// The time measured up to `t`, the exponents in descending order, and the running ones in the
    /// same order.
    pub fn finish(mut self, t: f64) -> (f64, Vec<Exponent>, Vec<Running>) {
        let elapsed = t - self.begin;
        // Rounding can leave the last block slightly too short to count on its own.
        if elapsed - self.block_start.0 > 0.5 * self.block_length {
            self.end_block(elapsed);
        }
        if self
            .running
            .last()
            .is_none_or(|last| last.elapsed < elapsed)
        {
            self.sample(elapsed);
        } else {
            let means = self.means(elapsed);
            if let Some(last) = self.running.last_mut() {
                last.exponents = means;
            }
        }
        let order = self.order();
        let exponents = order.iter().map(|&j| {
            if self.logs[j] == f64::NEG_INFINITY {
                Exponent::Annihilated
            } else {
                Exponent::Finite {
                    value: self.logs[j] / elapsed,
                    std_error: std_error(&self.rates[j]),
                }
            }
        });
        let exponents = exponents.collect();
        for entry in &mut self.running {
            entry.exponents = order.iter().map(|&j| entry.exponents[j]).collect();
        }
        (elapsed, exponents, self.running)
    }

    /// The vectors in the order of their exponents.
    pub(super) fn order(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.logs.len()).collect();
        order.sort_by(|&i, &j| self.logs[j].total_cmp(&self.logs[i]));
        order
    }
}

/// Standard error of the mean of the rates of successive blocks, which an orbit may correlate over
/// several of them.
///
/// The autocovariances of the blocks are added up to the first that is not positive (Geyer, *Stat.
/// Sci.* 7 (1992) 473). Those of deviations from the sample mean are too small by the variance of
/// that mean. The sum up to a lag `k` of `n` blocks is divided by `1 − (2k+1)/n + k(k+1)/n²`. The
/// error is never below that of independent blocks. Infinite for fewer than two blocks.
fn std_error(rates: &[f64]) -> f64 {
    let n = rates.len() as f64;
    if rates.len() < 2 {
        return f64::INFINITY;
    }
    let mean = rates.iter().sum::<f64>() / n;
    let covariance = |lag: usize| {
        let pairs = rates.iter().zip(&rates[lag..]);
        pairs.map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>() / n
    };
    let of_mean = |sum: f64, lag: usize| {
        let k = lag as f64;
        sum / n / (1.0 - (2.0 * k + 1.0) / n + k * (k + 1.0) / (n * n))
    };
    let mut sum = covariance(0);
    let independent = of_mean(sum, 0);
    let mut variance = independent;
    for lag in 1..rates.len() / 2 {
        let next = covariance(lag);
        if next + variance <= 0.0 {
            break;
        }
        sum += 2.0 * next;
        variance = of_mean(sum, lag);
    }
    variance.max(independent).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use numerics::SplitMix;

    /// Parts of 2000 means of 20 blocks beyond two, three and four of their standard errors, and
    /// the mean of these errors over the true one. The rates are averages of ten values, each
    /// `memory` times the one before plus noise.
    fn beyond(memory: f64) -> ([f64; 3], f64) {
        let random = &mut SplitMix::new(7);
        let mut noise = || (0..12).map(|_| random.uniform()).sum::<f64>() - 6.0;
        let (mut out, mut errors, mut squares) = ([0.0; 3], 0.0, 0.0);
        for _ in 0..2000 {
            let mut value = noise() / (1.0 - memory * memory).sqrt();
            let mut block = || {
                let values = (0..10).map(|_| {
                    value = memory * value + noise();
                    value
                });
                values.sum::<f64>() / 10.0
            };
            let rates: Vec<f64> = (0..20).map(|_| block()).collect();
            let (mean, error) = (rates.iter().sum::<f64>() / 20.0, std_error(&rates));
            for (k, out) in (2u8..).zip(&mut out) {
                *out += f64::from(u8::from(mean.abs() > f64::from(k) * error)) / 2000.0;
            }
            errors += error / 2000.0;
            squares += mean * mean / 2000.0;
        }
        (out, errors / squares.sqrt())
    }

    #[test]
    fn errors_cover_means_of_independent_and_of_correlated_blocks() {
        let (out, ratio) = beyond(0.0);
        assert!(out[0] < 0.06 && out[1] < 0.01 && out[2] < 0.003, "{out:?}");
        assert!((0.9..1.3).contains(&ratio), "{ratio}");
        // Correlated over a block and more. Independent blocks would leave 24 % and 3 % outside.
        let (out, ratio) = beyond(0.9);
        assert!(out[0] < 0.1 && out[2] < 0.012, "{out:?}");
        assert!((0.9..1.3).contains(&ratio), "{ratio}");
    }

    #[test]
    fn a_trend_is_no_scatter() {
        // Growth in proportion to time beside the exponent, after a transient of a tenth.
        let log = |t: f64| crate::math::ln(200.0 + t);
        let rate = |k: usize| (log(100.0 * (k + 1) as f64) - log(100.0 * k as f64)) / 100.0;
        let rates: Vec<f64> = (0..20).map(rate).collect();
        let mean = rates.iter().sum::<f64>() / 20.0;
        assert!(mean < 4.0 * std_error(&rates), "{mean}");
        assert_eq!(std_error(&[1.0]), f64::INFINITY);
        assert_eq!(std_error(&[1.0, 3.0]), 1.0);
    }

    /// Two vectors that grow at the rates 0.25 and 0.5, from time 2 on.
    #[test]
    fn a_growth_has_one_running_mean_to_a_time_and_the_last_at_its_end() {
        // To the end of a sample, and slightly beyond.
        for (steps, samples) in [(80, 5), (81, 6)] {
            let settings = SpectrumOptions::over(0.0, 10.0).blocks(4).samples(5);
            let mut growth = Growth::new(2, 2.0, &settings);
            let elapsed = f64::from(steps) / 8.0;
            for step in 1..=steps {
                growth.logs[0] += 0.25 / 8.0;
                growth.logs[1] += 0.5 / 8.0;
                growth.tick(2.0 + f64::from(step) / 8.0);
            }
            let (measured, exponents, running) = growth.finish(2.0 + elapsed);
            assert_eq!(measured, elapsed);
            assert_eq!(running.len(), samples, "{running:?}");
            assert!(running.is_sorted_by(|one, next| one.elapsed < next.elapsed));
            assert_eq!(running.last().map(|last| last.elapsed), Some(elapsed));
            assert!(running.iter().all(|entry| entry.exponents == [0.5, 0.25]));
            for (exponent, value) in exponents.iter().zip([0.5, 0.25]) {
                let std_error = 0.0;
                assert_eq!(*exponent, Exponent::Finite { value, std_error });
            }
        }
    }
}
