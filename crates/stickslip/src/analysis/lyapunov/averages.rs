//! Sums of logarithms over time, their blocks and their running means.

use super::settings::SpectrumOptions;
use super::spectrum::{Exponent, Running};

/// Growth of tangent vectors since measuring began: sums of logarithms, one for each vector. They
/// yield the exponents, their blocks and their running means. Use it for growth that
/// [`crate::analysis::lyapunov_spectrum`] does not measure.
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
    /// Number of completed blocks, and for each vector the mean of their rates and the sum of
    /// squared deviations (Welford).
    blocks: usize,
    mean: Vec<f64>,
    squares: Vec<f64>,
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
            blocks: 0,
            mean: zeros(),
            squares: zeros(),
            running: Vec::new(),
        }
    }

    /// At the end of every step. A contribution of a transition at the same time belongs to the
    /// next block.
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

    fn end_block(&mut self, elapsed: f64) {
        let (from, before) = std::mem::replace(&mut self.block_start, (elapsed, self.logs.clone()));
        self.blocks += 1;
        for (j, before) in before.iter().enumerate() {
            if self.logs[j].is_finite() {
                let rate = (self.logs[j] - before) / (elapsed - from);
                let deviation = rate - self.mean[j];
                self.mean[j] += deviation / self.blocks as f64;
                self.squares[j] += deviation * (rate - self.mean[j]);
            }
        }
    }

    fn sample(&mut self, elapsed: f64) {
        self.running.push(Running {
            elapsed,
            exponents: self.rates(elapsed),
        });
    }

    fn rates(&self, elapsed: f64) -> Vec<f64> {
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
            let rates = self.rates(elapsed);
            if let Some(last) = self.running.last_mut() {
                last.exponents = rates;
            }
        }
        let mut order: Vec<usize> = (0..self.logs.len()).collect();
        order.sort_by(|&i, &j| self.logs[j].total_cmp(&self.logs[i]));
        let exponents = order.iter().map(|&j| {
            if self.logs[j] == f64::NEG_INFINITY {
                Exponent::Annihilated
            } else {
                Exponent::Finite {
                    value: self.logs[j] / elapsed,
                    std_error: self.std_error(j),
                }
            }
        });
        let exponents = exponents.collect();
        for entry in &mut self.running {
            entry.exponents = order.iter().map(|&j| entry.exponents[j]).collect();
        }
        (elapsed, exponents, self.running)
    }

    fn std_error(&self, j: usize) -> f64 {
        if self.blocks < 2 {
            return f64::INFINITY;
        }
        let n = self.blocks as f64;
        (self.squares[j] / (n * (n - 1.0))).sqrt()
    }
}
