//! The tests of the solver that depend on the method, with Taylor steps, and tests of Taylor steps
//! alone.

#[path = "check.rs"]
mod check;
#[path = "errors.rs"]
mod errors;
#[path = "hard_cases.rs"]
mod hard_cases;
#[path = "monodromy.rs"]
mod monodromy;
#[path = "own_events.rs"]
mod own_events;
#[path = "problems/mod.rs"]
mod problems;
#[path = "properties.rs"]
mod properties;
#[path = "restarts.rs"]
mod restarts;

use stickslip::{Locator, Method, Options};

/// The default method of these tests.
const METHOD: Method = Method::Taylor;

/// The locators: Taylor steps have only one. `own_events` shows that the option has no effect, so
/// that no test need run for every locator.
const LOCATORS: &[Locator] = &[Locator::Auto];

fn tol(tolerance: f64) -> Options {
    Options::tol(tolerance).method(METHOD)
}
