//! The plainest section.

use super::{Direction, EventFunctions};
use crate::scalar::Scalar;
use crate::system::State;

/// A plane in the space of states, as a section: `normal · (x − point)` passes through zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane<const N: usize> {
    /// A state on it.
    pub point: State<N>,
    /// A vector across it, of any length.
    pub normal: State<N>,
    /// Direction of the passage: [`Direction::Rising`] is along `normal`.
    pub direction: Direction,
}

impl<const N: usize> EventFunctions<N, 1> for Plane<N> {
    #[inline(always)]
    fn values<T: Scalar>(&self, _t: T, x: &[T; N]) -> [T; 1] {
        let height = |sum: T, i: usize| sum + (x[i] - self.point[i]) * self.normal[i];
        [(0..N).fold(T::zero(), height)]
    }

    fn direction(&self, _number: usize) -> Direction {
        self.direction
    }

    fn is_as_smooth_as_state(&self, _number: usize) -> bool {
        true
    }
}
