//! Common sections: a plane in the state space, and a strobe in time.

use std::f64::consts::PI;

use super::{Direction, EventFunctions};
use crate::scalar::Scalar;
use crate::system::State;

/// A plane in the space of states, as a section: `normal · (x − point)` passes through zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Plane<const N: usize> {
    /// A state on it.
    pub(crate) point: State<N>,
    /// A vector across it, of any length.
    pub(crate) normal: State<N>,
    /// Direction of the passage: [`Direction::Rising`] is along `normal`.
    pub(crate) direction: Direction,
}

impl<const N: usize> EventFunctions<N> for Plane<N> {
    #[inline(always)]
    fn value<T: Scalar>(&self, _number: usize, _t: T, x: &[T; N]) -> T {
        let height = |sum: T, i: usize| sum + (x[i] - self.point[i]) * self.normal[i];
        (0..N).fold(T::zero(), height)
    }

    fn direction(&self, _number: usize) -> Direction {
        self.direction
    }

    fn is_as_smooth_as_state(&self, _number: usize) -> bool {
        true
    }

    fn is_affine(&self, _number: usize) -> bool {
        true
    }
}

/// A strobe: the section of a forced system that its orbits pass at `first`, `first + period`,
/// `first + 2 period`, ….
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Strobe {
    /// Time of a flash.
    pub(crate) first: f64,
    /// Time between two flashes.
    pub(crate) period: f64,
}

impl<const N: usize> EventFunctions<N> for Strobe {
    #[inline(always)]
    fn value<T: Scalar>(&self, _number: usize, t: T, _x: &[T; N]) -> T {
        // Zero at each flash, rising and falling in turn.
        ((t - self.first) * (PI / self.period)).sin()
    }
}
