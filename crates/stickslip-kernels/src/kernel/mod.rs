//! The solver, compiled for every number of states and contacts, behind one interface without type parameters.
//!
//! Everything of this package that is compiled once for each kind of system is in this folder, and it is as little as there can be: loops over
//! the library's functions that hand what they find to who asked, as slices. An instance costs seconds of compile time; the
//! rest of the package is compiled once.

mod branch;
mod change;
mod compiled;
mod erased;
mod reached;
mod system;

pub use branch::{BranchFound, OrbitThere, SpecialKind, SpecialThere};
pub use change::{Change, Equations, Family};
pub use erased::{
    Ended, Modes, Passage, Periodic, PhaseView, SpectrumFound, StepView, TransitionView, Watcher,
};
pub use reached::{Motion, Outcome, PhaseThere, TransitionThere};
pub use system::{ManyContacts, OneContact, Section};

use stickslip::analysis::{
    ContinuationSettings, RecurrenceSettings, SpectrumOptions, SweepSettings,
};
use stickslip::{Error, Options};

/// Most states that a system may have.
pub const MOST_STATES: usize = 8;

/// Most contacts that a system may have.
pub const MOST_CONTACTS: usize = 4;

/// Where a run begins and ends, and how it is made.
#[derive(Clone, Copy, Debug)]
pub struct Run<'a> {
    /// Time at the start.
    pub t: f64,
    /// State at the start; as many components as the system has states.
    pub x: &'a [f64],
    /// Time at the end.
    pub t_end: f64,
    /// Settings of the solver.
    pub options: &'a Options,
}

/// How a periodic orbit is looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shooting {
    /// Newton's iteration for the state, of a system whose period is known because it is driven.
    Forced {
        /// Period.
        period: f64,
    },
    /// Newton's iteration for state and period together.
    Free {
        /// About the period.
        period: f64,
    },
    /// A run first, then Newton's iteration from where it has come.
    Found {
        /// How long the run is.
        transient: f64,
        /// How long after that a return may take.
        longest: f64,
    },
}

/// A system of some number of states and contacts, ready to be integrated. Calls cost nothing but themselves; it can be shared between threads.
pub trait Kernel: Send + Sync {
    /// Follows an orbit and tells `watcher` of it; passages of `section` among the rest, if there is one.
    ///
    /// # Errors
    /// Those of [`stickslip::run`].
    fn run(
        &self,
        run: &Run<'_>,
        section: Option<&Section>,
        watcher: &mut dyn Watcher,
    ) -> Result<Ended, Error>;

    /// A periodic orbit near the start of `run`, whose end is not looked at.
    ///
    /// # Errors
    /// Those of [`stickslip::analysis::periodic_orbit`] and [`stickslip::analysis::find_periodic_orbit`].
    fn periodic(&self, run: &Run<'_>, shooting: Shooting) -> Result<Periodic, Error>;

    /// The Lyapunov spectrum of the orbit from `(t, x)`.
    ///
    /// # Errors
    /// Those of [`stickslip::analysis::lyapunov_spectrum`].
    fn spectrum(
        &self,
        t: f64,
        x: &[f64],
        settings: &SpectrumOptions,
    ) -> Result<SpectrumFound, Error>;

    /// The attractor that the orbit from `x` at time 0 comes to; `told` puts into words what an integration failed with.
    ///
    /// # Errors
    /// Those of [`stickslip::analysis::attractor`].
    fn attractor(
        &self,
        x: &[f64],
        settings: &RecurrenceSettings,
        options: &Options,
        told: &dyn Fn(&Error) -> String,
    ) -> Result<Outcome, Error>;

    /// What becomes of the attractor that the orbit from `x` comes to at the first of two values of a parameter, when the parameter goes to
    /// the second and the state is carried on; nothing if it stays the same kind of motion.
    ///
    /// # Errors
    /// Those of [`stickslip::analysis::sweep`].
    fn changes(
        &self,
        family: &Family<'_>,
        between: (f64, f64),
        x: &[f64],
        settings: &SweepSettings,
        options: &Options,
    ) -> Result<Vec<Change>, Error>;

    /// The branch of periodic orbits through the one near `x` at time 0, with a period near `period`. The last state is its parameter; `seen` gets that of
    /// every orbit as it is found.
    ///
    /// # Errors
    /// Those of [`stickslip::analysis::continue_periodic_orbit`].
    fn branch(
        &self,
        x: &[f64],
        period: f64,
        upwards: bool,
        settings: &ContinuationSettings,
        options: &Options,
        seen: &dyn Fn(f64),
    ) -> Result<BranchFound, Error>;

    /// Whether two orbits have come to the same attractor.
    fn is_same_attractor(
        &self,
        one: &Outcome,
        other: &Outcome,
        settings: &RecurrenceSettings,
        options: &Options,
    ) -> bool;

    /// Dimension of the family of periodic orbits that an attractor is one of; 0 where it is
    /// isolated.
    fn family(&self, one: &Outcome, settings: &RecurrenceSettings, options: &Options) -> usize;
}

/// The kernel of a system of one contact and `states` states; `None` for more than [`MOST_STATES`], or none.
pub fn of_one_contact(system: OneContact, states: usize) -> Option<Box<dyn Kernel>> {
    compiled::of_one_contact(system, states)
}

/// The kernel of a system of several contacts; `None` for more than [`MOST_CONTACTS`] or [`MOST_STATES`].
pub fn of_many_contacts(system: ManyContacts, states: usize) -> Option<Box<dyn Kernel>> {
    compiled::of_many_contacts(system, states)
}
