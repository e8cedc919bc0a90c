//! The ends of the stick zones of model 2, found along Σ by where the body sticks.

use crate::bisection::bisect;
use stickslip::filippov::{Fate, fate};
use stickslip::models::ForcedOscillator;
use stickslip::system::State;

/// Positions relative to the support (m) within which zones are sought, and the distance of the places looked at.
const REACH: f64 = 1.6;
const PLACES: u32 = 1600;

/// Positions x1 (m), ascending, at which stick begins or ends along Σ at time `t` (s).
pub(super) fn stick_ends(model: &ForcedOscillator, t: f64) -> Vec<f64> {
    let sticks = |x1: f64| fate(model, t, &State::from([x1, model.belt_speed])) == Fate::Stick;
    // Off the round numbers at which zones end for round parameters.
    let place = |k: u32| REACH * (2.0 * f64::from(k) / f64::from(PLACES) - 1.0) + 1.3e-4;
    let offset = model.support(t);
    let mut ends = Vec::new();
    for k in 1..=PLACES {
        let (low, high) = (offset + place(k - 1), offset + place(k));
        let before = sticks(low);
        if sticks(high) == before {
            continue;
        }
        ends.push(bisect(low, high, |x1| sticks(x1) != before));
    }
    ends
}
