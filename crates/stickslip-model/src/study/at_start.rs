//! Jumps at the start of a run.
//!
//! A jump whose function depends on the state, is zero at the start and goes in its direction is
//! carried out there. One of time alone is not: a run that ended at that time has carried it out.

use std::ops::ControlFlow;

use stickslip::dynamics::{Moment, OrbitProgress, OrbitUnderWay, RecordedOrbit, Vector};
use stickslip::error::readable;
use stickslip::{Error, Options};

use crate::file::System;
use crate::kernel::follow_on;

/// Rounding of the time of an event, relative to its size: 64 units in the last place.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Numbers of the jumps that a run from a start (time, state) carries out before its first step, in
/// order; those of stops count as well.
///
/// # Errors
/// Those of a run that does not begin.
pub fn jumps_at_start(system: &System, (t, x): (f64, &[f64])) -> Result<Vec<usize>, Error> {
    let mut jumps = Vec::new();
    let mut watcher = |progress, _: &mut dyn OrbitUnderWay| match progress {
        OrbitProgress::Transition(at) if at.t - t > ROUNDING * t.abs() => ControlFlow::Break(()),
        OrbitProgress::Transition(at) => {
            jumps.extend(at.contact.checked_sub(system.contacts()));
            ControlFlow::Continue(())
        }
        OrbitProgress::Step => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    };
    // The times of a run do not matter to its start.
    let t_end = t + t.abs().max(1.0);
    let start = Moment {
        t,
        x: Vector::from_column_slice(x),
    };
    let begun = system
        .dynamics()
        .begin(&start, t_end, &Options::default(), &[]);
    // What happens later, a failure included, is not part of the start.
    let _later = follow_on(&mut *begun?, &mut watcher);
    Ok(jumps)
}

/// Warning of the jumps of time alone that are due at the start of a recorded orbit and that the
/// run has not carried out. Not meant for a run that goes on from another one.
pub fn left_out_at_start(system: &System, orbit: &RecordedOrbit) -> Option<String> {
    let Moment { t, x } = &orbit.start;
    let at_once = orbit
        .transitions()
        .take_while(|at| at.t - *t <= ROUNDING * t.abs());
    let done = at_once.filter_map(|at| at.contact.checked_sub(system.contacts()));
    left_out(system, (*t, x.as_slice()), &done.collect::<Vec<_>>())
}

/// Warning of the jumps of time alone that are due at a start and are not among those done there.
pub(super) fn left_out(system: &System, (t, x): (f64, &[f64]), done: &[usize]) -> Option<String> {
    let jumps = system.file.jumps.iter().enumerate();
    let names = jumps.filter_map(|(jump, of)| {
        let is_due = system.built.switching.is_due_by_time(jump, t, x);
        (is_due && !done.contains(&jump)).then_some(&*of.name)
    });
    let names: Vec<&str> = names.collect();
    let words = match &names[..] {
        [] => return None,
        [name] => format!("the jump {name} is"),
        names => format!("the jumps {} are", names.join(" and ")),
    };
    Some(format!(
        "{words} due by time alone at the start, t = {}: that counts as done; start earlier \
         otherwise",
        readable(t)
    ))
}
