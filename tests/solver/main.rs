//! The solver against what is known of its orbits without it: closed forms, orders of convergence, invariants.

mod check;
mod errors;
mod hard_cases;
mod monodromy;
mod orders;
mod problems;
mod properties;
mod restarts;
mod systems;
mod tableaux;
