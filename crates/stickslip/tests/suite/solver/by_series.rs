//! The tests of the solver with Taylor steps.

#[path = "check.rs"]
mod check;
#[path = "errors.rs"]
mod errors;
#[path = "hard_cases.rs"]
mod hard_cases;
#[path = "monodromy.rs"]
mod monodromy;
#[path = "orders.rs"]
mod orders;
#[path = "problems/mod.rs"]
mod problems;
#[path = "properties.rs"]
mod properties;
#[path = "restarts.rs"]
mod restarts;

use stickslip::{Method, Options};

/// What every test runs that does not say otherwise.
const METHOD: Method = Method::Taylor;

fn tol(tolerance: f64) -> Options {
    Options::tol(tolerance).method(METHOD)
}
