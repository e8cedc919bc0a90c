//! The solver against what is known of its orbits without it: closed forms, orders of convergence, invariants.

mod check;
mod problems;
mod systems;
