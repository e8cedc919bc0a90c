//! The tests of the solver with Runge–Kutta steps.

#[path = "check.rs"]
mod check;
#[path = "dense_on_demand.rs"]
mod dense_on_demand;
#[path = "errors.rs"]
mod errors;
#[path = "every_method.rs"]
mod every_method;
#[path = "hard_cases.rs"]
mod hard_cases;
#[path = "locators.rs"]
mod locators;
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

use stickslip::{Locator, Method, Options};

/// The default method of these tests.
const METHOD: Method = Method::Dop853;

/// The locators.
const LOCATORS: &[Locator] = &[Locator::Auto, Locator::Henon, Locator::RootSearch];

fn tol(tolerance: f64) -> Options {
    Options::tol(tolerance).method(METHOD)
}
