//! The solver compared with independent results: closed forms, orders of convergence, invariants.
//! All tests run with Runge–Kutta and with Taylor steps, over one copy of the systems.

mod by_runge_kutta;
mod by_taylor;
pub mod systems;
mod tableaux;
mod tolerances;
