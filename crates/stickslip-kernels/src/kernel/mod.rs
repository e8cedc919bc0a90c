//! Systems defined at run time: their tapes and the library's solver for them.

mod change;
mod compiled;
mod inputs;
mod outcome;
mod system;

use std::ops::ControlFlow;

use stickslip::dynamics::{
    DynamicsRef, Kink, Moment, OrbitProgress, OrbitUnderWay, Passage, Phase, Section as Watched,
    Step, Summary, Transition, Vector,
};
use stickslip::{Ending, Error, Options, TransitionKind};

pub use change::Change;
pub use compiled::dynamics;
pub use inputs::{HELD_PER_INPUT, Input, Jump, Piece, Shape, Switching};
pub use outcome::{AttractorPhase, AttractorTransition, Motion, Outcome};
pub use system::{
    Combination, Equations, Fields, ManyContacts, OneContact, Section, sides_to_check,
};

/// Largest number of states of a system.
pub const MOST_STATES: usize = 64;

/// Largest number of contacts of a system.
pub const MOST_CONTACTS: usize = 16;

/// Start, end and solver settings of a run.
#[derive(Clone, Copy, Debug)]
pub struct Run<'a> {
    /// Time at the start.
    pub t: f64,
    /// Initial state, with as many components as the system has states.
    pub x: &'a [f64],
    /// End time.
    pub t_end: f64,
    /// Settings of the solver.
    pub options: &'a Options,
}

/// Receives the events of an orbit in order of time. Each method may end the run.
pub trait Watcher {
    /// Whether steps are wanted. If not, part of the work is omitted.
    fn watches_steps(&self) -> bool {
        false
    }
    /// Called after every step, with the orbit, which gives the solution over it on request.
    fn step(&mut self, _step: Step, _orbit: &mut dyn OrbitUnderWay) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
    /// Called after every phase.
    fn phase(&mut self, _phase: Phase) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
    /// Called at every transition, after the phase that it ends. With several contacts, called once
    /// for each whose mode changes.
    fn transition(&mut self, _at: Transition) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
    /// Called at every kink of an input, before its consequences.
    fn kink(&mut self, _at: Kink) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
    /// Called at every crossing of the section.
    fn passage(&mut self, _at: Passage) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// A watcher that ignores everything.
impl Watcher for () {}

/// Follows an orbit and reports it to `watcher`, including crossings of the section.
///
/// # Errors
/// Those of [`stickslip::run`].
pub fn follow(
    system: &DynamicsRef<'_>,
    run: &Run<'_>,
    section: &Watched,
    watcher: &mut dyn Watcher,
) -> Result<Summary, Error> {
    let start = Moment {
        t: run.t,
        x: Vector::from_column_slice(run.x),
    };
    let mut orbit = system.begin(&start, run.t_end, run.options, section)?;
    loop {
        let decision = match orbit.step() {
            Ok(OrbitProgress::Step) if !watcher.watches_steps() => ControlFlow::Continue(()),
            Ok(OrbitProgress::Step) => watcher.step(orbit.last_step(), &mut *orbit),
            Ok(OrbitProgress::PhaseEnd(phase)) => watcher.phase(phase),
            Ok(OrbitProgress::Kink(at)) => watcher.kink(at),
            Ok(OrbitProgress::Passage(at)) => watcher.passage(at),
            Ok(OrbitProgress::Transition(at)) => report_transition(at, watcher),
            Ok(OrbitProgress::End(summary)) => return Ok(summary),
            Err(error) => {
                report_last_phase(&*orbit, watcher);
                return Err(error);
            }
        };
        if decision.is_break() {
            report_last_phase(&*orbit, watcher);
            let Moment { t, x } = orbit.now();
            return Ok(Summary {
                ending: Ending::Stopped,
                t,
                x,
                counters: orbit.counters(),
            });
        }
    }
}

/// Reports a transition, and the change of each other contact whose mode changes at the same
/// instant.
fn report_transition(at: Transition, watcher: &mut dyn Watcher) -> ControlFlow<()> {
    let modes = at.from.iter().zip(at.to.iter()).enumerate();
    let others = modes.filter(|(contact, (from, to))| *contact != at.contact && from != to);
    let of = |(contact, (from, to))| Transition {
        kind: TransitionKind::between(from, to),
        contact,
        ..at.clone()
    };
    let others: Vec<Transition> = others.map(of).collect();
    watcher.transition(at)?;
    others.into_iter().try_for_each(|at| watcher.transition(at))
}

/// The current phase also ends where a run stops or fails.
fn report_last_phase(orbit: &dyn OrbitUnderWay, watcher: &mut dyn Watcher) {
    if let Some(phase) = orbit.phase() {
        // The run ends whatever the watcher returns.
        let _ = watcher.phase(phase);
    }
}
