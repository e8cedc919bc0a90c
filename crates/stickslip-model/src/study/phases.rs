//! The phases of a periodic orbit.

use stickslip::dynamics::{Modes, Phase};

/// The modes of a run over one period as [`Modes::cycle`], and the time in which any contact
/// sticks. A run begins in the middle of a phase, and both parts of that phase count as one.
pub fn phases_of_period(phases: &[Phase]) -> (Vec<Modes>, f64) {
    let mut modes: Vec<Modes> = phases.iter().map(|phase| phase.mode).collect();
    if let [first, .., last] = modes[..]
        && first.until(None) == last
    {
        modes.pop();
    }
    let sticks = phases.iter().filter(|phase| phase.mode.any_sticks());
    let stick = sticks.fold(0.0, |stick, phase| stick + phase.duration());
    (Modes::cycle(modes), stick)
}
