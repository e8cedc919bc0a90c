//! Passages of the plane through a state that is perpendicular to the flow there.

use super::monodromy::velocity_in;
use crate::dynamics::{Dynamics, Modes, Moment, OrbitProgress, Section};
use crate::error::Error;
use crate::filippov::{Direction, Options};

/// The plane through a state that is perpendicular to the flow of a mode, passed along the flow.
pub(super) fn plane(system: &dyn Dynamics, mode: Modes, at: &Moment) -> Section {
    Section::Plane {
        point: at.x.clone(),
        normal: velocity_in(system, mode, at),
        direction: Direction::Rising,
    }
}

/// Passages of the orbit from a start, within a time, through the plane through a state. The search
/// ends with the first passage that `is_last`.
pub(super) fn passages(
    system: &dyn Dynamics,
    (start, span): (&Moment, f64),
    state: &Moment,
    options: &Options,
    is_last: impl Fn(&Moment) -> bool,
) -> Result<Vec<Moment>, Error> {
    let begun = system.begin(state, state.t + span, options, &[])?;
    let plane = plane(system, begun.mode(), state);
    let mut run = system.begin(start, start.t + span, options, &[plane])?;
    let mut passages = Vec::new();
    loop {
        match run.step()? {
            OrbitProgress::Passage(at) => {
                passages.push(at.moment());
                if passages.last().is_some_and(&is_last) {
                    return Ok(passages);
                }
            }
            OrbitProgress::End(_) => return Ok(passages),
            _ => {}
        }
    }
}
