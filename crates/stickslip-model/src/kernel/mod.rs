//! Systems defined at run time: their tapes and the library's solver for them.

mod compiled;
mod impacts;
mod inputs;
mod system;

use std::ops::ControlFlow;

use stickslip::dynamics::{
    DynamicsRef, Moment, OrbitProgress, OrbitUnderWay, Section as Watched, Summary, Transition,
    Vector,
};
use stickslip::{Ending, Error, Options, TransitionKind};

pub use compiled::{Size, dynamics};
pub use impacts::Impacts;
pub use inputs::{Condition, HELD_PER_INPUT, Input, Jump, Map, Piece, Shape, Switching, pulse};
pub use system::{
    Combination, Equations, Fields, ManyContacts, OneContact, Section, sides_to_check,
};

/// Largest number of states of a system.
pub const MOST_STATES: usize = 64;

/// Largest number of contacts of a system.
pub const MOST_CONTACTS: usize = 16;

/// Receives what happens along an orbit in order of time, with the orbit, which has the last step
/// and the solution over it. With several contacts a transition is reported once for each whose
/// mode changes. The watcher may end the run.
pub type Watcher<'w> = dyn FnMut(OrbitProgress, &mut dyn OrbitUnderWay) -> ControlFlow<()> + 'w;

/// Watches nothing.
pub fn ignore(_: OrbitProgress, _: &mut dyn OrbitUnderWay) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Follows the orbit from a time and state and reports it to `watcher`, including passages of the
/// sections.
///
/// # Errors
/// Those of [`stickslip::run`].
pub fn follow(
    system: &DynamicsRef<'_>,
    (t, x): (f64, &[f64]),
    t_end: f64,
    options: &Options,
    sections: &[Watched],
    watcher: &mut Watcher<'_>,
) -> Result<Summary, Error> {
    let x = Vector::from_column_slice(x);
    let mut orbit = system.begin(&Moment { t, x }, t_end, options, sections)?;
    follow_on(&mut *orbit, watcher)
}

/// Follows an orbit that has begun to its end, and reports it to `watcher`.
///
/// # Errors
/// Those of [`stickslip::run`].
pub fn follow_on(
    orbit: &mut dyn OrbitUnderWay,
    watcher: &mut Watcher<'_>,
) -> Result<Summary, Error> {
    let ended = loop {
        let decision = match orbit.step() {
            Ok(OrbitProgress::End(summary)) => return Ok(summary),
            Ok(OrbitProgress::Transition(at)) => changes(at)
                .into_iter()
                .try_for_each(|at| watcher(OrbitProgress::Transition(at), orbit)),
            Ok(progress) => watcher(progress, orbit),
            Err(error) => break Err(error),
        };
        if decision.is_break() {
            let Moment { t, x } = orbit.now();
            break Ok(Summary {
                ending: Ending::Stopped,
                t,
                x,
                counters: orbit.counters(),
            });
        }
    };
    // The current phase also ends where a run stops or fails, whatever the watcher returns.
    if let Some(phase) = orbit.phase() {
        let _ = watcher(OrbitProgress::PhaseEnd(phase), orbit);
    }
    ended
}

/// A transition, and the change of each other contact whose mode changes at the same instant.
fn changes(at: Transition) -> Vec<Transition> {
    let modes = at.from.iter().zip(at.to.iter()).enumerate();
    let others = modes.filter(|(contact, (from, to))| *contact != at.contact && from != to);
    let of = |(contact, (from, to))| Transition {
        kind: TransitionKind::between(from, to),
        contact,
        ..at.clone()
    };
    let others: Vec<Transition> = others.map(of).collect();
    std::iter::once(at).chain(others).collect()
}
