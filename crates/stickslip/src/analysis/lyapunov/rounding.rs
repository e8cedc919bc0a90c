//! Effect of rounding on a frame.

use super::frame::take_out;
use crate::dynamics::Vector;
use crate::math;
use numerics::SplitMix;

/// Largest disturbance of a vector per step, so that a disturbed frame is still one.
const LARGEST: f64 = 1e-4;

/// A second frame that is carried by the same maps and disturbed at random after each. The
/// difference of its exponents bounds the effect of rounding.
///
/// A component is disturbed relative to the terms of which it is the sum, as rounding does. Where
/// the components of vectors have very different sizes, as in a chain along the axes, the small
/// ones keep their digits.
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

    /// Carries the frame by a map of which the images of the first frame's living vectors are
    /// known.
    /// `frame` is the first frame after it, with the lengths that remained. Where some of its
    /// vectors were annihilated, the second frame begins at the others.
    pub(super) fn carry(
        &mut self,
        living: &[usize],
        images: &[Vector],
        (frame, lengths): (&[Vector], &[f64]),
    ) {
        let count = living.len();
        if self.columns.len() != count {
            self.columns = (0..count)
                .map(|j| crate::analysis::cycle::unit(count, j))
                .collect();
        }
        let size = self.disturbance();
        let mut done: Vec<Vector> = Vec::with_capacity(count);
        let mut growth = Vec::with_capacity(count);
        for (column, &j) in self.columns.iter().zip(living) {
            let mut image = Vector::zeros(self.states);
            let mut terms = image.clone();
            let mut add = |image: &mut Vector, vector: &Vector, part: f64| {
                for ((image, term), v) in image.iter_mut().zip(terms.iter_mut()).zip(vector.iter())
                {
                    *image += part * v;
                    *term += (part * v).abs();
                }
            };
            for (vector, &part) in images.iter().zip(column) {
                add(&mut image, vector, part);
            }
            for before in &done {
                let part = before.dot(&image);
                add(&mut image, before, -part);
            }
            for (part, term) in image.iter_mut().zip(&terms) {
                *part += self.random.between(-size * term, size * term);
            }
            for before in &done {
                take_out(before, &mut image);
            }
            let length = image.norm();
            done.push(image / length);
            growth.push(length / lengths[j]);
        }
        if !growth.iter().all(|growth| growth.is_normal()) {
            self.columns.clear();
            return;
        }
        let along = |vector: &Vector| {
            let parts = living.iter().map(|&j| frame[j].dot(vector));
            Vector::from_iterator(count, parts)
        };
        self.columns = done.iter().map(along).collect();
        for (&j, growth) in living.iter().zip(growth) {
            self.excess[j] += math::ln(growth);
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
