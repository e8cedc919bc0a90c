//! An event at the end of a step.

use crate::ode::Timed;

/// Where a guard reaches zero first.
#[derive(Clone, Copy, Debug)]
pub struct Event<const N: usize> {
    pub guard: usize,
    pub at: Timed<N>,
    /// Whether the guard turns back there, within the touch tolerance, instead of passing through
    /// zero.
    pub is_touch: bool,
    /// Size of the guard that remains at that state.
    pub residual: f64,
}
