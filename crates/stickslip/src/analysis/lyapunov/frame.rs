//! The orthonormal frame.

use super::rounding::Shadow;
use crate::analysis::cycle::unit;
use crate::dynamics::{Matrix, Vector};
use crate::math::{self, product};

/// A unit vector lies in a space if the sine of its angle to the space is at most this. Frames are
/// orthonormal to a few units of 1e-16, so that this is some thousand roundings. A random angle is
/// as small once in 1e12 entries into stick.
const IN_SPAN: f64 = 1e-12;

/// Part of a vector's length below which what is left of it is made orthogonal once more. What is
/// not orthogonal then is a rounding over this part, a fifth of [`IN_SPAN`]. The lengths are those
/// of the first pass, whose errors are relative to the whole vector either way.
const SECOND_PASS: f64 = 5.0 * f64::EPSILON / IN_SPAN;

/// Orthonormal vectors, at most as many as there are states. Some may have been annihilated. The
/// surviving ones are in the order of their exponents. The annihilated ones continue the basis; in
/// a full frame they carry only the normal of the space of the others.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    columns: Vec<Vector>,
    alive: Vec<bool>,
    /// Effect of rounding on a full frame.
    pub(super) shadow: Option<Shadow>,
}

impl Frame {
    /// The first `count` vectors of a frame in general position, the same every time. A frame along
    /// the axes could lie in invariant subspaces of a decoupled system, and miss the largest
    /// exponent.
    pub(super) fn generic(states: usize, count: usize) -> Self {
        let entry = |i: usize, j: usize| {
            let k = (1 + i + states * j) as f64;
            math::sin(k * k)
        };
        let column = |j| Vector::from_fn(states, |i, _| entry(i, j));
        let mut frame = Frame {
            columns: (0..count).map(column).collect(),
            alive: vec![true; count],
            shadow: (count == states && states > 1).then(|| Shadow::of(states)),
        };
        if frame.orthonormalise().is_none() {
            frame.columns = (0..count).map(|j| unit(states, j)).collect();
        }
        frame
    }

    pub(super) fn is_alive(&self, j: usize) -> bool {
        self.alive[j]
    }

    /// The number of vectors.
    pub(super) fn len(&self) -> usize {
        self.columns.len()
    }

    /// Revives every direction.
    pub(super) fn revive(&mut self) {
        self.alive.fill(true);
    }

    /// Indices of the vectors: the surviving ones in order, then the others.
    fn order(&self) -> Vec<usize> {
        let dead = (0..self.len()).filter(|&j| !self.alive[j]);
        self.living().into_iter().chain(dead).collect()
    }

    fn living(&self) -> Vec<usize> {
        (0..self.len()).filter(|&j| self.alive[j]).collect()
    }

    /// All vectors.
    pub(super) fn columns_mut(&mut self) -> &mut [Vector] {
        &mut self.columns
    }

    /// Replaces all vectors, and returns those before.
    pub(super) fn replace(&mut self, columns: Vec<Vector>) -> Vec<Vector> {
        std::mem::replace(&mut self.columns, columns)
    }

    /// Changes the surviving vectors.
    pub(super) fn change_living(&mut self, change: impl Fn(&mut Vector)) {
        for j in self.living() {
            change(&mut self.columns[j]);
        }
    }

    /// Modified Gram–Schmidt: returns the length that remains of each vector after subtracting its
    /// projections on those before it. `None` if the square of one of them underflows or overflows.
    pub(super) fn orthonormalise(&mut self) -> Option<Vec<f64>> {
        self.gram_schmidt(self.len(), 0.0)
    }

    /// Gram–Schmidt for vectors with a relative error; `None` also if less remains of one of them
    /// than the root of that. The frame is then of no use.
    pub(super) fn orthonormalise_resolved(&mut self, error: f64) -> Option<Vec<f64>> {
        self.gram_schmidt(self.len(), error.max(f64::EPSILON).sqrt())
    }

    /// Orthonormalises the surviving vectors; the others are replaced by a completion of the basis.
    pub(super) fn orthonormalise_living(&mut self) -> Option<Vec<f64>> {
        let lengths = self.gram_schmidt(self.living().len(), 0.0)?;
        self.complete();
        Some(lengths)
    }

    /// Gram–Schmidt on the first `count` vectors in order, each of which must keep more than the
    /// fraction `least` of its length.
    fn gram_schmidt(&mut self, count: usize, least: f64) -> Option<Vec<f64>> {
        let mut lengths = vec![0.0; self.len()];
        let order = self.order();
        let living = self.living();
        let images = |_: &Shadow| -> Vec<Vector> {
            living.iter().map(|&j| self.columns[j].clone()).collect()
        };
        let images = self.shadow.as_ref().map(images);
        for (place, &j) in order.iter().take(count).enumerate() {
            let mut column = std::mem::take(&mut self.columns[j]);
            let size = column.norm();
            for &i in &order[..place] {
                take_out(&self.columns[i], &mut column);
            }
            let length = column.norm();
            // Without a normal square, a length has underflowed or overflowed.
            if !(length > least * size && (length * length).is_normal()) {
                return None;
            }
            column /= length;
            // The less is left of a vector, the more of that is rounding along those before it. Two
            // passes leave rounding alone (Giraud, Langou, Rozložník & van den Eshof, Numer. Math.
            // 101 (2005) 87).
            if length < SECOND_PASS * size {
                for &i in &order[..place] {
                    take_out(&self.columns[i], &mut column);
                }
                column.normalize_mut();
            }
            self.columns[j] = column;
            lengths[j] = length;
        }
        if let Some((shadow, images)) = self.shadow.as_mut().zip(images) {
            shadow.carry(&living, &images, (&self.columns, &lengths));
        }
        Some(lengths)
    }

    /// Length of the part of `vector` outside the span of the surviving vectors.
    pub(super) fn height(&self, vector: &Vector) -> f64 {
        let mut outside = vector.clone();
        for j in self.living() {
            take_out(&self.columns[j], &mut outside);
        }
        outside.norm()
    }

    /// Removes the vectors that a map with this kernel annihilates, and returns their numbers. Such
    /// a vector is the first that, together with those before it, has another direction of the
    /// kernel in its span. The columns of `kernel` are orthonormal.
    pub(super) fn collapse(&mut self, mut kernel: Matrix) -> Vec<usize> {
        let mut removed = Vec::new();
        for j in self.living() {
            if kernel.is_empty() {
                break;
            }
            for mut direction in kernel.column_iter_mut() {
                let part = self.columns[j].dot(&direction);
                direction.axpy(-part, &self.columns[j], 1.0);
            }
            // The last combination of the kernel's directions has the shortest part outside.
            let parts = kernel.clone().svd(false, true);
            let last = kernel.ncols() - 1;
            if let Some(combinations) = parts.v_t
                && parts.singular_values[last] <= IN_SPAN
            {
                self.alive[j] = false;
                removed.push(j);
                kernel = product(&kernel, &combinations.rows(0, last).transpose());
            }
        }
        removed
    }

    /// Replaces the removed vectors by ones that continue the surviving ones to an orthonormal
    /// basis.
    fn complete(&mut self) {
        let states = self.columns.first().map_or(0, Vector::len);
        let living = self.living();
        let dead = self.order().split_off(living.len());
        let mut basis: Vec<Vector> = living.iter().map(|&j| self.columns[j].clone()).collect();
        for j in dead {
            // The axis with the largest component outside: at least 1/√N.
            let outside = |i: usize| {
                let mut axis = unit(states, i);
                for column in &basis {
                    take_out(column, &mut axis);
                }
                axis
            };
            let longest = (0..states)
                .map(outside)
                .fold(Vector::zeros(states), |longest, axis| {
                    if axis.norm() > longest.norm() {
                        axis
                    } else {
                        longest
                    }
                });
            self.columns[j] = &longest / longest.norm();
            basis.push(self.columns[j].clone());
        }
    }
}

/// Takes the direction of a unit vector out of another vector, and returns its component.
pub(super) fn take_out(unit: &Vector, vector: &mut Vector) -> f64 {
    let part = unit.dot(vector);
    *vector -= unit * part;
    part
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(x: [f64; 3]) -> Vector {
        let x = Vector::from_column_slice(&x);
        &x / x.norm()
    }

    fn columns<const D: usize>(directions: [Vector; D]) -> Matrix {
        Matrix::from_columns(&directions)
    }

    #[test]
    fn gram_schmidt_finds_lengths_and_leaves_an_orthonormal_frame() {
        let mut frame = Frame::generic(3, 3);
        for q in frame.columns_mut() {
            *q = Vector::from_column_slice(&[2.0 * q[0] + q[2], 3.0 * q[1], 0.5 * q[2]]);
        }
        let lengths = frame.orthonormalise().unwrap();
        // The map's determinant.
        approx::assert_relative_eq!(lengths.iter().product::<f64>(), 3.0, max_relative = 1e-14);
        for i in 0..3 {
            for j in 0..3 {
                let product = frame.columns[i].dot(&frame.columns[j]);
                approx::assert_abs_diff_eq!(product, f64::from(u8::from(i == j)), epsilon = 1e-15);
            }
        }
    }

    /// An impact of little speed leaves them so, or states in units of which one is a millionth.
    #[test]
    fn vectors_that_are_nearly_parallel_become_orthogonal() {
        let mut frame = Frame::generic(3, 3);
        let [first, second, third] = [0, 1, 2].map(|j| frame.columns[j].clone());
        let columns = frame.columns_mut();
        columns[1] = &first + second * 1e-7;
        columns[2] = &first + &columns[1] + third * 1e-6;
        let lengths = frame.orthonormalise().unwrap();
        approx::assert_relative_eq!(lengths[1], 1e-7, max_relative = 1e-7);
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            let product = frame.columns[i].dot(&frame.columns[j]);
            approx::assert_abs_diff_eq!(product, 0.0, epsilon = 1e-15);
        }
    }

    #[test]
    fn a_full_frame_loses_its_last_vector_and_then_none() {
        let mut frame = Frame::generic(3, 3);
        let kernel = unit([0.2, -1.0, 0.4]);
        assert_eq!(frame.collapse(columns([kernel])), [2]);
        frame.orthonormalise_living().unwrap();
        let kernel = unit([0.3, 0.1, 0.7]);
        assert!(frame.collapse(columns([kernel])).is_empty());
    }

    #[test]
    fn the_first_vector_alone_is_that_of_a_full_frame() {
        let full = Frame::generic(3, 3);
        let mut alone = Frame::generic(3, 1);
        assert_eq!(alone.columns[0], full.columns[0]);
        // Only a kernel along it annihilates it; another direction continues the basis then.
        let kernel = unit([0.2, -1.0, 0.4]);
        assert!(alone.collapse(columns([kernel])).is_empty());
        assert_eq!(alone.collapse(columns([full.columns[0].clone()])), [0]);
        assert_eq!(alone.orthonormalise_living().unwrap().len(), 1);
        approx::assert_relative_eq!(alone.columns[0].norm(), 1.0, max_relative = 1e-14);
    }

    #[test]
    fn a_kernel_within_the_span_of_the_first_vectors_takes_one_of_them() {
        let mut frame = Frame::generic(3, 3);
        let kernel = &frame.columns[0] * 0.6 - &frame.columns[1] * 0.8;
        assert_eq!(frame.collapse(columns([kernel])), [1]);
        assert!(frame.is_alive(0) && frame.is_alive(2));
    }

    #[test]
    fn a_kernel_takes_as_many_vectors_as_it_has_directions() {
        let directions = Frame::generic(3, 3).columns;
        let axes = || [0, 1, 2].map(|i| crate::analysis::cycle::unit(3, i));
        let [x, y, z] = axes();
        assert_eq!(Frame::generic(3, 3).collapse(columns([x, y])), [1, 2]);
        let mut all = Frame::generic(3, 3);
        assert_eq!(all.collapse(columns(axes())), [0, 1, 2]);
        assert_eq!(all.orthonormalise_living(), Some(vec![0.0; 3]));
        assert!(all.collapse(columns([z])).is_empty());
        // One direction along the first vector, another in general position.
        let [first, second, third] = [0, 1, 2].map(|j| directions[j].clone());
        let other = (second + third) * 0.5_f64.sqrt();
        assert_eq!(
            Frame::generic(3, 3).collapse(columns([first, other])),
            [0, 2]
        );
    }

    #[test]
    fn dead_vectors_are_completed_to_a_basis() {
        let mut frame = Frame::generic(3, 3);
        frame.alive = vec![true, false, false];
        frame.columns[1] = frame.columns[0].clone();
        frame.columns[2].fill(0.0);
        frame.orthonormalise_living().unwrap();
        let lengths = frame.orthonormalise().unwrap();
        for length in lengths {
            approx::assert_relative_eq!(length, 1.0, max_relative = 1e-14);
        }
    }

    #[test]
    fn a_vanished_vector_is_reported() {
        let mut frame = Frame::generic(3, 3);
        frame.columns_mut()[1].fill(0.0);
        assert_eq!(frame.orthonormalise(), None);
    }
}
