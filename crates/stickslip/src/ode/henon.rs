//! The Hénon step: the independent variable is changed so that one integration step ends on a
//! surface.
//!
//! M. Hénon, *On the numerical computation of Poincaré maps*, Physica D 5 (1982) 412.

use super::linear::Timed;
use super::step::stages;
use super::tableau::RungeKutta;

/// One step of method `M` with the value η of a function `η(t, x)` as the independent variable,
/// over `change` in η. Returns time and state where η has changed by that much.
///
/// `slope` gives `(dt/dη, dx/dη) = (1, f)/η̇`, where `η̇ = ∂η/∂t + ∇η·f` is the rate of η along the
/// field. The step has the order of `M`. If η is a coordinate of the state, its value is exact to
/// rounding.
///
/// It is compiled once for each number of states, with `slope` as a dynamic call: such steps are
/// rare.
#[inline(never)]
pub fn henon_step<M: RungeKutta, const N: usize>(
    slope: &mut dyn FnMut(&Timed<N>) -> Timed<N>,
    from: &Timed<N>,
    change: f64,
) -> Timed<N> {
    let first = slope(from);
    let autonomous = &mut |_: f64, at: &Timed<N>| slope(at);
    stages::<M, f64, Timed<N>>(autonomous, 0.0, from, first, change).end
}
