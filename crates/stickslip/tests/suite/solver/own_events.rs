//! Taylor steps have one locator, and find the same events as Runge–Kutta steps.

use stickslip::{Locator, Method, Options, State};

use super::check::TIGHT;
use crate::any_system::solve;
use crate::solver::systems::coulomb_friction;

/// A belt oscillator whose circles shrink onto the stick zone, over some twenty events.
fn events(options: &Options) -> Vec<stickslip::Transition<2>> {
    let belt = coulomb_friction(0.05, 0.166);
    solve(&belt, 0.0, State::from([0.0, -2.4]), 90.0, options)
        .expect("runs")
        .transitions
}

#[test]
fn the_locator_changes_no_bit() {
    let own = events(&super::tol(TIGHT));
    for locator in [Locator::Auto, Locator::Henon, Locator::RootSearch] {
        assert_eq!(events(&super::tol(TIGHT).locator(locator)), own);
    }
}

#[test]
fn taylor_and_runge_kutta_find_the_same_events() {
    let series = events(&super::tol(TIGHT));
    let slopes = events(&super::tol(TIGHT).method(Method::Dop853));
    assert!(series.len() > 20, "{}", series.len());
    assert_eq!(series.len(), slopes.len());
    for (one, other) in series.iter().zip(&slopes) {
        assert_eq!(one.kind, other.kind);
        let off = (one.t - other.t).abs();
        assert!(off < 1e-10, "t = {}: {off}", other.t);
    }
    // Up to rounding they are two computations.
    assert_ne!(series, slopes);
}
