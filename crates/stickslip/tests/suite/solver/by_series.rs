//! The tests of the solver that depend on the method, with Taylor steps, and what holds of these
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

/// What every test runs that does not say otherwise.
const METHOD: Method = Method::Taylor;

/// The ways in which it locates events: one, its own. `own_events` shows that the choice changes
/// nothing, so that no test need run for every locator.
const LOCATORS: &[Locator] = &[Locator::Auto];

fn tol(tolerance: f64) -> Options {
    Options::tol(tolerance).method(METHOD)
}
