//! Times after which orbits stay near their attractors.

use serde_json::{Value, json};
use stickslip::error::readable;

use crate::render::{state_words, within};

/// Times to return of the starts of one attractor.
#[derive(Clone, Debug, Default)]
pub(super) struct Returns {
    /// Number of starts with a time.
    starts: usize,
    mean: f64,
    /// Sum of the squares of the distances from the mean.
    squares: f64,
    largest: f64,
    /// The start with the largest time.
    slowest: Vec<f64>,
}

impl Returns {
    pub(super) fn add(&mut self, start: &[f64], time: f64) {
        self.starts += 1;
        // Welford's update: no difference of large sums.
        let off = time - self.mean;
        self.mean += off / self.starts as f64;
        self.squares += off * (time - self.mean);
        if time > self.largest || self.starts == 1 {
            self.largest = time;
            self.slowest = start.to_vec();
        }
    }

    pub(super) fn mean(&self) -> Option<f64> {
        (self.starts > 0).then_some(self.mean)
    }

    /// Standard error of the mean, as of random starts.
    pub(super) fn std_error(&self) -> Option<f64> {
        let n = self.starts as f64;
        (self.starts > 1).then(|| (self.squares / (n - 1.0) / n).sqrt())
    }

    pub(super) fn largest(&self) -> Option<f64> {
        (self.starts > 0).then_some(self.largest)
    }

    /// Time to return in words.
    pub(super) fn words(&self, distance: f64) -> Option<String> {
        Some(format!(
            "returns within {} after {} on average, {} at most, from {}",
            readable(distance),
            within(self.mean()?, self.std_error().unwrap_or(f64::INFINITY)),
            readable(self.largest),
            state_words(&self.slowest)
        ))
    }

    pub(super) fn json(&self, distance: f64) -> Value {
        json!({
            "within": distance,
            "starts": self.starts,
            "mean": self.mean(),
            "std_error": self.std_error(),
            "largest": self.largest(),
            "slowest": self.slowest,
        })
    }
}
