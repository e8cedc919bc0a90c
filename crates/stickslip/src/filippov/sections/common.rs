//! Common sections: a plane in the state space, and a strobe in time.

use std::f64::consts::PI;

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
///
/// ```
/// use stickslip::{Filippov, Options, Scalar, Side, Strobe, analysis::PoincareMap};
///
/// /// A block on a floor, pushed with period 2.
/// struct Pushed;
///
/// impl Filippov<2> for Pushed {
///     fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 2]) -> [T; 2] {
///         let push = (t * std::f64::consts::PI).cos() * 3.0;
///         [x[1], push - x[0] - 0.4 * side.sign()]
///     }
///     fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
///         x[1]
///     }
/// }
///
/// let strobe = Strobe { first: 0.0, period: 2.0 };
/// let options = Options::tol(1e-10);
/// let mut map = PoincareMap::new(&Pushed, &strobe, (0.0, [0.1, 0.2]), 3.0, &options)?;
/// assert!((map.step()?.t - 2.0).abs() < 1e-12);
/// # Ok::<(), stickslip::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strobe {
    /// Time of a flash.
    pub first: f64,
    /// Time between two flashes.
    pub period: f64,
}

impl<const N: usize> EventFunctions<N> for Strobe {
    #[inline(always)]
    fn value<T: Scalar>(&self, _number: usize, t: T, _x: &[T; N]) -> T {
        // Zero at each flash, rising and falling in turn.
        ((t - self.first) * (PI / self.period)).sin()
    }
}
