//! The solver compared with independent results: closed forms, orders of convergence, invariants.
//! All tests run with Runge–Kutta and with Taylor steps, over one copy of the systems.

mod by_series;
mod by_slopes;
pub mod systems;
mod tableaux;
