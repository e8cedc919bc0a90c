//! Comparison of the locators of Runge–Kutta steps.

use stickslip::{Locator, Options, State, Transition};

use super::check::TIGHT;
use crate::any_system::solve;
use crate::solver::systems::coulomb_friction;

#[test]
fn a_henon_step_and_a_root_search_find_the_same_events() {
    let belt = coulomb_friction(0.05, 0.166);
    let events = |locator| -> Vec<Transition<2>> {
        let options: Options = super::tol(TIGHT).locator(locator);
        solve(&belt, 0.0, State::from([0.0, -2.4]), 90.0, &options)
            .expect("runs")
            .transitions
    };
    let (by_henon, by_search) = (events(Locator::Henon), events(Locator::RootSearch));
    assert!(by_search.len() > 20, "{}", by_search.len());
    assert_eq!(by_henon.len(), by_search.len());
    for (one, other) in by_henon.iter().zip(&by_search) {
        assert_eq!(one.kind, other.kind);
        let off = (one.t - other.t).abs();
        assert!(off < 1e-10, "t = {}: {off}", other.t);
    }
    // They are two methods, not one under two names.
    assert_ne!(by_henon, by_search);
}
