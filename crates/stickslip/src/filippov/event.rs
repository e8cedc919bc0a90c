//! An event at the end of a step.

use crate::ode::Timed;

/// Where a guard reaches zero first.
#[derive(Clone, Copy, Debug)]
pub struct Event<const N: usize> {
    pub guard: usize,
    pub at: Timed<N>,
    /// Whether the guard turns back there, to within the touch tolerance, and does not pass through zero.
    pub is_touch: bool,
    /// Size of the guard left at that state.
    pub residual: f64,
}
