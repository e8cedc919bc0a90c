//! The tests of the solver, all of them with Taylor steps.

#[path = "../solver/check.rs"]
mod check;
#[path = "../solver/errors.rs"]
mod errors;
#[path = "../solver/hard_cases.rs"]
mod hard_cases;
#[path = "../solver/monodromy.rs"]
mod monodromy;
#[path = "../solver/orders.rs"]
mod orders;
#[path = "../solver/problems/mod.rs"]
mod problems;
#[path = "../solver/properties.rs"]
mod properties;
#[path = "../solver/restarts.rs"]
mod restarts;
#[path = "../solver/systems.rs"]
mod systems;

use stickslip::{Method, Options};

/// What every test runs that does not say otherwise.
const METHOD: Method = Method::Taylor;

fn tol(tolerance: f64) -> Options {
    Options::tol(tolerance).method(METHOD)
}
