//! Systems defined at run time: their tapes and the library's solver for them.

mod compiled;
mod conditions;
mod impacts;
mod inputs;
mod system;

use std::ops::ControlFlow;

use stickslip::dynamics::{
    DynamicsRef, Moment, OrbitProgress, OrbitUnderWay, Section, Summary, Transition, Vector,
    Watching,
};
use stickslip::{Ending, Error, Options, TransitionKind};

pub use compiled::{Size, dynamics};
pub use conditions::{Choice, JumpCondition};
pub use impacts::Impacts;
pub(crate) use impacts::ROUNDING;
pub use inputs::{HELD_PER_INPUT, Input, InputPiece, Jump, Map, Shape, Switching, pulse};
pub use system::{
    ByCombination, Combination, Equations, Fields, SectionFunction, TapedContacts, TapedFilippov,
    sides_to_check,
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
    sections: &[Section],
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
    loop {
        let progress = orbit.step();
        if let Some(ended) = watched(progress, orbit, watcher) {
            return ended;
        }
    }
}

/// Receives what happens along several orbits, each by the index of its start, as a [`Watcher`] of
/// each would. Items of one orbit come in order, between those of others.
pub type WatcherOfMany<'w> =
    dyn FnMut(usize, OrbitProgress, &mut dyn OrbitUnderWay) -> ControlFlow<()> + 'w;

/// Follows the orbit from each start as [`follow`] does, with the same bits, and reports all to
/// `watcher`. Returns how each ended, in the order of the starts.
pub fn follow_all(
    system: &DynamicsRef<'_>,
    starts: &[Moment],
    t_end: f64,
    options: &Options,
    watching: Watching<'_>,
    watcher: &mut WatcherOfMany<'_>,
) -> Vec<Result<Summary, Error>> {
    let mut ended: Vec<_> = starts.iter().map(|_| None).collect();
    let listener = &mut |number: usize, progress, orbit: &mut dyn OrbitUnderWay| {
        let own = &mut |progress, orbit: &mut dyn OrbitUnderWay| watcher(number, progress, orbit);
        ended[number] = watched(progress, orbit, own);
        match ended[number] {
            None => ControlFlow::Continue(()),
            Some(_) => ControlFlow::Break(()),
        }
    };
    let begun = system.follow_all(starts, t_end, options, watching, listener);
    let outcomes = ended.into_iter().zip(begun).zip(starts);
    let outcome = |((ended, begun), start): ((Option<_>, Result<(), Error>), &Moment)| {
        let unfinished = Err(Error::Interrupted {
            t: start.t,
            x: (&start.x).into(),
        });
        begun.and_then(|()| ended.unwrap_or(unfinished))
    };
    outcomes.map(outcome).collect()
}

/// Reports to the watcher what a step of an orbit returned. Returns how the orbit ended, if it did.
fn watched(
    progress: Result<OrbitProgress, Error>,
    orbit: &mut dyn OrbitUnderWay,
    watcher: &mut Watcher<'_>,
) -> Option<Result<Summary, Error>> {
    let decision = match progress {
        Ok(OrbitProgress::End(summary)) => return Some(Ok(summary)),
        Ok(OrbitProgress::Transition(at)) => {
            let others = other_changes(&at);
            let mut all = std::iter::once(at).chain(others);
            Ok(all.try_for_each(|at| watcher(OrbitProgress::Transition(at), orbit)))
        }
        Ok(progress) => Ok(watcher(progress, orbit)),
        Err(error) => Err(error),
    };
    let ended = match decision {
        Ok(ControlFlow::Continue(())) => return None,
        Ok(ControlFlow::Break(())) => {
            let Moment { t, x } = orbit.now();
            Ok(Summary {
                ending: Ending::Stopped,
                t,
                x,
                counters: orbit.counters(),
            })
        }
        Err(error) => Err(error),
    };
    // The current phase also ends where a run stops or fails, whatever the watcher returns.
    if let Some(phase) = orbit.phase() {
        let _ = watcher(OrbitProgress::PhaseEnd(phase), orbit);
    }
    Some(ended)
}

/// The change of each other contact whose mode changes at the instant of a transition.
fn other_changes(at: &Transition) -> Vec<Transition> {
    let modes = at.from.iter().zip(at.to.iter()).enumerate();
    let others = modes.filter(|(contact, (from, to))| *contact != at.contact && from != to);
    let of = |(contact, (from, to))| Transition {
        kind: TransitionKind::between(from, to),
        contact,
        ..at.clone()
    };
    others.map(of).collect()
}
