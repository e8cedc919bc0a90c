//! Tests of analyses that use many orbits: attractors, basins, sweeps and branches. They compile
//! the solver for their own systems, and the tests of the solver do not wait for that.

mod any_system;
mod attractors;
mod basins;
mod bifurcations;
#[path = "../common/compiled.rs"]
mod compiled;
#[path = "../common/constant_fields.rs"]
mod constant_fields;
#[path = "../common/den_hartog.rs"]
mod den_hartog;
mod lyapunov_jumps;
#[path = "../common/smooth.rs"]
mod smooth;
mod uncertainties;

/// Whether two sequences are equal up to a cyclic shift.
fn is_same_cycle<A: PartialEq<B>, B>(one: &[A], other: &[B]) -> bool {
    let length = one.len();
    let is_shift = |by: usize| (0..length).all(|i| one[i] == other[(i + by) % length]);
    length == other.len() && (0..length.max(1)).any(is_shift)
}
