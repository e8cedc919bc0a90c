//! The linear equations of a Newton step, which may leave directions undetermined.

use super::Jacobian;
use super::jacobian::Eliminated;
use crate::analysis::elimination::orthonormal;
use crate::dynamics::Vector;

/// The linear equations of a Newton step.
pub(super) struct NewtonEquations {
    pub jacobian: Jacobian,
    pub right: Vector,
    /// Size of each state. The first equations are those of the states.
    pub sizes: Vector,
    /// Relative error of the part of the equations that is due to changes of the state: of a state
    /// that changes little in a period, the error is small.
    pub error: f64,
}

/// Directions that the equations leave undetermined to within their error.
struct Undetermined {
    directions: Vec<Vector>,
    units: Vector,
    weights: Vector,
    eliminated: Eliminated,
}

impl NewtonEquations {
    /// The solution of the equations, if they determine it.
    pub fn solution(&self) -> Option<Vector> {
        if !self.jacobian.is_finite() {
            return None;
        }
        self.jacobian.solve(&self.right)
    }

    /// Number of directions that the equations leave undetermined: the position of a block on which
    /// nothing depends, the energy of a pendulum.
    pub fn free(&self, states: usize) -> usize {
        let found = self.undetermined((states, 0));
        found.map_or(0, |found| found.directions.len())
    }

    /// The solution without a component in undetermined directions; at least a given number of
    /// them.
    pub fn solution_without(&self, (states, least_free): (usize, usize)) -> Option<Vector> {
        let found = self.undetermined((states, least_free))?;
        if found.directions.is_empty() {
            return self.solution();
        }
        let solved = |right: &Vector| found.eliminated.solve(right);
        let transposed = |right: &Vector| found.eliminated.solve_transposed(right);
        // One inverse iteration yields the left singular vectors, and makes the right ones precise.
        let left: Option<Vec<Vector>> = found.directions.iter().map(transposed).collect();
        let left = orthonormal(&left?);
        let directions: Option<Vec<Vector>> = left.iter().map(solved).collect();
        let directions = orthonormal(&directions?);
        let without = |mut vector: Vector, directions: &[Vector]| {
            for one in directions {
                vector.axpy(-one.dot(&vector), one, 1.0);
            }
            vector
        };
        let right = without(self.right.component_mul(&found.weights), &left);
        let solution = without(solved(&right)?, &directions);
        let is_finite = solution.iter().all(|value| value.is_finite());
        is_finite.then(|| solution.component_mul(&found.units))
    }

    /// The undetermined directions, in units in which the equations are of one size.
    fn undetermined(&self, (states, least_free): (usize, usize)) -> Option<Undetermined> {
        let jacobian = &self.jacobian;
        if !jacobian.is_finite() {
            return None;
        }
        let count = self.right.len();
        let [mut units, mut weights] = [(); 2].map(|()| Vector::repeat(count, 1.0));
        for (k, size) in self.sizes.iter().take(states).enumerate() {
            units[k] = *size;
            weights[k] = size.recip();
        }
        // Other unknowns and equations are scaled by their entries: equations first, so that their
        // units do not decide which unknowns count.
        let by_rows = |units: &Vector, weights: &mut Vector| {
            let lengths = jacobian.row_lengths(units);
            for k in states..count {
                weights[k] = lengths[k].max(f64::MIN_POSITIVE).recip();
            }
        };
        by_rows(&units, &mut weights);
        let lengths = jacobian.column_lengths(&weights);
        for k in states..count {
            units[k] = lengths[k].max(f64::MIN_POSITIVE).recip();
        }
        by_rows(&units, &mut weights);
        let lengths = jacobian.row_lengths(&units).component_mul(&weights);
        if !lengths.iter().all(|length| length.is_finite()) {
            return None;
        }
        let largest = lengths.norm();
        let rounding = count as f64 * f64::EPSILON * largest;
        let eliminated = jacobian.eliminated((&units, &weights));
        let least = eliminated.least_determined(jacobian, (&units, &weights))?;
        let is_free = |(number, (length, direction)): &(usize, (f64, Vector))| {
            let direction = direction.component_mul(&units);
            let changes = jacobian.changes(&direction).component_mul(&weights);
            let change = changes.norm().min(largest);
            *number < least_free || *length <= rounding.max(self.error * change)
        };
        let free = least.into_iter().enumerate().filter(is_free);
        Some(Undetermined {
            directions: free.map(|(_, (_, direction))| direction).collect(),
            units,
            weights,
            eliminated,
        })
    }
}
