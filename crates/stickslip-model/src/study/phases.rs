//! The phases of a periodic orbit.

use stickslip::dynamics::{Dynamics, Modes, Phase};

/// The modes of a run over one period as [`Modes::cycle`], and the time in which any contact
/// sticks. A run begins in the middle of a phase, and both parts of that phase count as one.
/// Impacts that accumulate are part of the phase that their landing ends.
pub fn phases_of_period(system: &dyn Dynamics, phases: &[Phase]) -> (Vec<Modes>, f64) {
    let jump = |phase: &Phase| Some(system.contacts() + phase.mode.jump()?);
    let jumps: Vec<Option<usize>> = phases.iter().map(jump).collect();
    let accumulating = system.accumulating(&jumps);
    let lasting = phases
        .iter()
        .zip(accumulating)
        .filter(|(_, accumulates)| !accumulates);
    let mut modes: Vec<Modes> = lasting.map(|(phase, _)| phase.mode).collect();
    if let [first, .., last] = modes[..]
        && first.until(None) == last
    {
        modes.pop();
    }
    let sticks = phases.iter().filter(|phase| phase.mode.any_sticks());
    let stick = sticks.fold(0.0, |stick, phase| stick + phase.duration());
    (Modes::cycle(modes), stick)
}
