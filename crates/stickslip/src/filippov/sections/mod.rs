//! Events of the user's own: zeros of functions that do not affect the motion, searched in every
//! step after it was taken.

mod affine;
mod common;
mod composed;
mod crossings;
mod over_step;
mod search;
mod solve;
mod watched;

use crate::scalar::Scalar;
use crate::system::{Mode, State};

pub(crate) use common::{Plane, Strobe};
pub use search::EventSearch;
pub(crate) use search::{SearchMemory, TOLERATED};
pub use solve::solve_with_events;
use watched::{Watched, WatchedProgress};

/// Direction in which a function passes through zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Direction {
    /// Upwards: from below zero to above.
    Rising,
    /// Downwards: from above zero to below.
    Falling,
    /// Either way.
    Both,
}

impl Direction {
    /// Direction of a passage from the side of zero with this sign.
    pub(crate) fn leaving(side: f64) -> Direction {
        match side < 0.0 {
            true => Direction::Rising,
            false => Direction::Falling,
        }
    }

    /// Whether a passage in the direction `passed` is requested.
    pub(crate) fn includes(self, passed: Direction) -> bool {
        self == Direction::Both || self == passed
    }
}

/// Functions of time and state whose zeros are events: a section, a level, the end of a run. They
/// do not affect the motion.
///
/// An event is a change of sign by more than rounding. A function that touches zero and turns back
/// has no event. A function may stay at zero for a while, as a boundary function does during stick.
/// It passes through zero where it reaches it with a rate, or else where it leaves for the other
/// side. A start at zero is no event. A function that is not a number has none.
///
/// ```
#[doc = include_str!("../../../examples/common/belt.rs")]
/// use stickslip::{Direction, EventFunctions, Options, solve_with_events};
///
/// /// Where the block passes the place 0.3, and where it turns back.
/// struct PlaceAndTurn;
/// impl EventFunctions<2> for PlaceAndTurn {
///     fn count(&self) -> usize {
///         2
///     }
///     fn value<T: Scalar>(&self, number: usize, _t: T, x: &[T; 2]) -> T {
///         match number {
///             0 => x[0] - 0.3,
///             _ => x[1],
///         }
///     }
///     fn direction(&self, number: usize) -> Direction {
///         [Direction::Both, Direction::Falling][number]
///     }
/// }
///
/// let belt = Belt { speed: 1.0 };
/// let options = Options::default();
/// let found = solve_with_events(&belt, &PlaceAndTurn, 0.0, [0.5, 1.5], 20.0, &options)?;
/// for event in &found.events {
///     println!("{} at t = {}, x = {}, in {:?}", event.number, event.t, event.x, event.mode);
/// }
/// assert!(found.events.iter().any(|event| event.number == 1 && event.rate < 0.0));
/// # Ok::<(), stickslip::Error>(())
/// ```
pub trait EventFunctions<const N: usize> {
    /// Number of functions; the default is one.
    fn count(&self) -> usize {
        1
    }

    /// Function `number`, counted from 0, at time `t` and state `x`, in any unit.
    fn value<T: Scalar>(&self, number: usize, t: T, x: &[T; N]) -> T;

    /// Direction of the passages of function `number` that are events; the default takes both.
    fn direction(&self, _number: usize) -> Direction {
        Direction::Both
    }

    /// Whether the run ends at an event of function `number`; by default it continues.
    fn is_terminal(&self, _number: usize) -> bool {
        false
    }

    /// Whether error control resolves function `number` over a step as it does the state: a
    /// component of the state, or a linear function of it. Others are also bounded over the step,
    /// so that no zero is missed however fast they vary. The default is to bound.
    fn is_as_smooth_as_state(&self, _number: usize) -> bool {
        false
    }

    /// Whether function `number` is affine: a sum of constant multiples of time and the state's
    /// components, and a constant. Its bounds over a step, and over a Taylor step its zeros, then
    /// follow from the solution, without a call. The default is to call it.
    fn is_affine(&self, _number: usize) -> bool {
        false
    }
}

impl<V: EventFunctions<N>, const N: usize> EventFunctions<N> for &V {
    fn count(&self) -> usize {
        (**self).count()
    }
    #[inline(always)]
    fn value<T: Scalar>(&self, number: usize, t: T, x: &[T; N]) -> T {
        (**self).value(number, t, x)
    }
    fn direction(&self, number: usize) -> Direction {
        (**self).direction(number)
    }
    fn is_terminal(&self, number: usize) -> bool {
        (**self).is_terminal(number)
    }
    fn is_as_smooth_as_state(&self, number: usize) -> bool {
        (**self).is_as_smooth_as_state(number)
    }
    fn is_affine(&self, number: usize) -> bool {
        (**self).is_affine(number)
    }
}

/// No events.
impl<const N: usize> EventFunctions<N> for () {
    fn count(&self) -> usize {
        0
    }
    #[inline(always)]
    fn value<T: Scalar>(&self, _number: usize, _t: T, _x: &[T; N]) -> T {
        T::one()
    }
}

/// An event of the user's own, of a system of `N` states.
pub type EventRecord<const N: usize, K = Mode> = EventOf<State<N>, K>;

/// An event of the user's own; `X` is a state, `K` a mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EventOf<X, K> {
    /// Number of the function, from 0.
    pub number: usize,
    /// Time.
    pub t: f64,
    /// State.
    pub x: X,
    /// Mode of the system; at the very end of a phase, the mode that ends.
    pub mode: K,
    /// [`Direction::Rising`] or [`Direction::Falling`].
    pub direction: Direction,
    /// Rate of the function along the motion, in its unit per unit of time.
    pub rate: f64,
}
