//! What rounding does to a frame.

use super::frame::take_out;
use crate::dynamics::{Matrix, Vector};
use crate::math;
use numerics::SplitMix;

/// Largest disturbance of a vector per step, so that a disturbed frame is still one.
const LARGEST: f64 = 1e-4;

/// A second frame that is carried by the same maps and disturbed at random after each. The
/// difference of its exponents bounds the effect of rounding.
///
/// Rounding `ε` changes `n` equal exponents that are coupled in a chain by up to `ε^(1/n)`, where
/// it changes separate ones by `ε`. It has disturbed the first frame already. A disturbance of
/// `2^n` roundings changes exponents twice as much as rounding does in a chain of `n` states, and
/// more in a shorter one. The difference of the two frames is then at least the effect of rounding.
#[derive(Clone, Debug)]
pub(super) struct Shadow {
    states: usize,
    /// Largest relative disturbance of the first frame by rounding, as far as it was measured.
    rounding: f64,
    /// The vectors, by their components along those of the first frame.
    columns: Vec<Vector>,
    /// Sums of the logarithms of growth beyond that of the first frame's vectors.
    excess: Vec<f64>,
    random: SplitMix,
}

impl Shadow {
    pub(super) fn of(states: usize) -> Self {
        Shadow {
            states,
            rounding: f64::EPSILON,
            columns: Vec::new(),
            excess: vec![0.0; states],
            random: SplitMix::new(1),
        }
    }

    /// Notes the rounding of vectors. The image of their sum differs from the sum of the images.
    pub(super) fn note_rounding(&mut self, images: &[Vector], mut of_sum: Vector) {
        let largest = images.iter().map(|image| image.norm()).fold(0.0, f64::max);
        for image in images {
            of_sum -= image;
        }
        let rounding = of_sum.norm() / (largest * (self.states as f64).sqrt());
        self.rounding = self.rounding.max(rounding);
    }

    pub(super) fn begin_measuring(&mut self) {
        self.excess.fill(0.0);
    }

    /// Carries the frame by a map that is triangular in the living vectors of the first frame,
    /// before and after. Where some of those were annihilated, it begins at the others.
    pub(super) fn carry(&mut self, living: &[usize], triangle: &Matrix) {
        let count = living.len();
        if self.columns.len() != count {
            self.columns = (0..count)
                .map(|j| crate::analysis::cycle::unit(count, j))
                .collect();
        }
        let map = triangle.view((0, 0), (count, count));
        let size = self.disturbance();
        let mut done: Vec<Vector> = Vec::with_capacity(count);
        let mut lengths = Vec::with_capacity(count);
        for column in &self.columns {
            let mut image = map * column;
            let by = size * image.norm();
            for part in image.iter_mut() {
                *part += self.random.between(-by, by);
            }
            for before in &done {
                take_out(before, &mut image);
            }
            let length = image.norm();
            done.push(image / length);
            lengths.push(length);
        }
        if !lengths.iter().all(|length| length.is_normal()) {
            self.columns.clear();
            return;
        }
        self.columns = done;
        for (place, &j) in living.iter().enumerate() {
            self.excess[j] += math::ln(lengths[place] / triangle[(place, place)]);
        }
    }

    /// Relative size of a disturbance: `2^n` roundings for `n` states, unless that is too large.
    fn disturbance(&self) -> f64 {
        LARGEST.min(self.rounding * math::powi(2.0, self.states.min(60) as i32))
    }

    /// Bound of what rounding has added to the logarithm of a vector's growth.
    pub(super) fn bound(&self, vector: usize) -> f64 {
        let ratio = (self.disturbance() / self.rounding).max(2.0);
        let response = math::exp(math::ln(ratio) / self.states as f64) - 1.0;
        self.excess[vector].abs() / response
    }
}
