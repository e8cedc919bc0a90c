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

use stickslip::{Method, Options};

/// What every test runs that does not say otherwise.
const METHOD: Method = Method::Dop853;

fn tol(tolerance: f64) -> Options {
    Options::tol(tolerance).method(METHOD)
}
