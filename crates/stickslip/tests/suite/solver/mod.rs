//! The solver against what is known of its orbits without it: closed forms, orders of convergence,
//! invariants. Everything is tested by slopes and by series, over one copy of the systems.

mod by_series;
mod by_slopes;
pub mod systems;
mod tableaux;
