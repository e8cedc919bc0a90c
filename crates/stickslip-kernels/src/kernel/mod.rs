//! Systems that are known at run time: their tapes, and the library's solver for them.

mod branch;
mod change;
mod compiled;
mod erased;
mod reached;
mod system;

use std::cell::Cell;
use std::ops::ControlFlow;

use stickslip::analysis::{
    Attractors, BranchPoint, ContinuationSettings, RecurrenceSettings, SpectrumOptions,
    SweepSettings, attractor, continue_periodic_orbit_while, find_periodic_orbit,
    lyapunov_spectrum, multipliers, periodic_orbit, periodic_orbit_forced, sweep,
};
use stickslip::dynamics::{
    Dynamics, DynamicsRef, Happening, Moment, OrbitUnderWay, Phase, Section as Watched, Vector,
};
use stickslip::{Ending, Error, Options};

pub use branch::{BranchFound, OrbitThere, SpecialKind, SpecialThere};
pub use change::{Change, Equations, Family};
pub use erased::{
    Ended, Passage, Periodic, PhaseView, SpectrumFound, StepView, TransitionView, Watcher,
};
pub use reached::{Motion, Outcome, PhaseThere, TransitionThere};
pub use stickslip::dynamics::Modes;
pub use system::{Combination, Fields, ManyContacts, OneContact, Section, sides_to_check};

use system::OwnSection;

/// Most states that a system may have.
pub const MOST_STATES: usize = 64;

/// Most contacts that a system may have.
pub const MOST_CONTACTS: usize = 16;

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

/// A system of equations ready to be integrated. It can be shared between threads.
pub struct Kernel {
    dynamics: DynamicsRef<'static>,
}

impl Kernel {
    /// The kernel of these equations, with a section of their own; `None` for more states than
    /// [`MOST_STATES`] and a parameter, or more contacts than [`MOST_CONTACTS`].
    pub fn new(
        equations: Equations,
        section: Option<Section>,
        (states, contacts): (usize, usize),
    ) -> Option<Self> {
        let section = OwnSection(section);
        let size = (states, contacts);
        let dynamics = match equations {
            Equations::OneContact(system) => compiled::of_one_contact(*system, section, size),
            Equations::ManyContacts(system) => compiled::of_many_contacts(system, section, size),
        };
        let dynamics = DynamicsRef::Owned(dynamics?);
        Some(Kernel { dynamics })
    }

    /// Its dynamics, which the library's analyses take.
    pub fn dynamics(&self) -> &dyn Dynamics {
        &*self.dynamics
    }

    /// Its dynamics alone.
    pub fn into_dynamics(self) -> DynamicsRef<'static> {
        self.dynamics
    }

    /// Follows an orbit and tells `watcher` of it; passages of its section among the rest, if they are asked for.
    ///
    /// # Errors
    /// Those of [`stickslip::run`].
    pub fn run(
        &self,
        run: &Run<'_>,
        section: Option<&Section>,
        watcher: &mut dyn Watcher,
    ) -> Result<Ended, Error> {
        let start = Moment {
            t: run.t,
            x: Vector::from_column_slice(run.x),
        };
        let section = match section {
            Some(_) => Watched::Own,
            None => Watched::None,
        };
        let mut orbit = self
            .dynamics
            .begin(&start, run.t_end, run.options, &section)?;
        loop {
            let told = match orbit.step() {
                Ok(Happening::Step) if !watcher.watches_steps() => ControlFlow::Continue(()),
                Ok(Happening::Step) => {
                    let (step, solution) = (orbit.last_step(), orbit.solution());
                    watcher.step(&StepView {
                        modes: step.mode,
                        t_start: step.t_start,
                        t_end: step.t_end,
                        x_end: step.x_end.as_slice(),
                        sample: &|t, x| x.copy_from_slice(solution(t).as_slice()),
                    })
                }
                Ok(Happening::PhaseEnd(phase)) => tell_phase(&phase, watcher),
                Ok(Happening::Passage(at)) => watcher.passage(&Passage {
                    t: at.t,
                    x: at.x.as_slice(),
                    modes: at.mode,
                    direction: at.direction,
                }),
                Ok(Happening::Transition(at)) => TransitionView {
                    kind: at.kind,
                    contact: at.contact,
                    from: at.from,
                    to: at.to,
                    t: at.t,
                    x: at.x.as_slice(),
                    residual: at.residual,
                }
                .tell(watcher),
                Ok(Happening::End(summary)) => {
                    return Ok(Ended {
                        ending: summary.ending,
                        t: summary.t,
                        x: summary.x.as_slice().to_vec(),
                        counters: summary.counters,
                    });
                }
                Err(error) => {
                    close(&*orbit, watcher);
                    return Err(error);
                }
            };
            if told.is_break() {
                return Ok(close(&*orbit, watcher));
            }
        }
    }

    /// A periodic orbit near the start of `run`, whose end is not looked at.
    ///
    /// # Errors
    /// Those of [`stickslip::analysis::periodic_orbit`] and [`stickslip::analysis::find_periodic_orbit`].
    pub fn periodic(&self, run: &Run<'_>, shooting: Shooting) -> Result<Periodic, Error> {
        let (system, x, options) = (&self.dynamics, run.x, run.options);
        let orbit = match shooting {
            Shooting::Forced { period } => periodic_orbit_forced(system, run.t, x, period, options),
            Shooting::Free { period } => periodic_orbit(system, x, period, options),
            Shooting::Found { transient, longest } => {
                find_periodic_orbit(system, x, transient, longest, options)
            }
        }?;
        Ok(Periodic {
            t: orbit.t,
            x: orbit.x.as_slice().to_vec(),
            period: orbit.period,
            residual: orbit.residual,
            multipliers: multipliers(&orbit.monodromy),
            family: orbit.family,
        })
    }

    /// The Lyapunov spectrum of the orbit from `(t, x)`.
    ///
    /// # Errors
    /// Those of [`stickslip::analysis::lyapunov_spectrum`].
    pub fn spectrum(
        &self,
        t: f64,
        x: &[f64],
        settings: &SpectrumOptions,
    ) -> Result<SpectrumFound, Error> {
        let spectrum = lyapunov_spectrum(&self.dynamics, (t, x), settings)?;
        let defect = spectrum.defect();
        let running = spectrum.convergence.into_iter();
        Ok(SpectrumFound {
            convergence: running.map(|at| (at.elapsed, at.exponents)).collect(),
            defect,
            exponents: spectrum.exponents,
            stick_entries: spectrum.stick_entries,
            stick_fraction: spectrum.stick_fraction,
            duration: spectrum.duration,
        })
    }

    /// The attractor that the orbit from `x` at time 0 comes to; `told` puts into words what an integration failed with.
    ///
    /// # Errors
    /// Those of [`stickslip::analysis::attractor`].
    pub fn attractor(
        &self,
        x: &[f64],
        settings: &RecurrenceSettings,
        options: &Options,
        told: &dyn Fn(&Error) -> String,
    ) -> Result<Outcome, Error> {
        let reached = attractor(&self.dynamics, x, settings, options)?;
        Ok(Outcome::of(&reached, told))
    }

    /// What becomes of the attractor that the orbit from `x` comes to at the first of two values of a parameter, when the parameter goes to
    /// the second and the state is carried on; nothing if it stays the same kind of motion.
    ///
    /// # Errors
    /// Those of [`stickslip::analysis::sweep`].
    pub fn changes(
        &self,
        family: &Family<'_>,
        (from, to): (f64, f64),
        x: &[f64],
        settings: &SweepSettings,
        options: &Options,
    ) -> Result<Vec<Change>, Error> {
        // Where there is no system, the search goes on with this one, and what it finds is not told.
        let complete = Cell::new(true);
        let size = (self.dynamics.states(), self.dynamics.contacts());
        let system = |parameter| {
            let kernel = family(parameter).and_then(|one| Kernel::new(one, None, size));
            kernel.map_or_else(
                || {
                    complete.set(false);
                    DynamicsRef::Borrowed(&*self.dynamics)
                },
                |kernel| kernel.dynamics,
            )
        };
        let found = sweep(system, [from, to], x, settings, options)?;
        if !complete.get() {
            return Ok(vec![Change::Unlocated]);
        }
        let changes = found.changes.iter();
        Ok(changes.map(Change::of).collect())
    }

    /// The branch of periodic orbits through the one near `x` at time 0, with a period near `period`. The last state is its parameter; `seen` gets that of
    /// every orbit as it is found.
    ///
    /// # Errors
    /// Those of [`stickslip::analysis::continue_periodic_orbit`].
    pub fn branch(
        &self,
        x: &[f64],
        period: f64,
        upwards: bool,
        settings: &ContinuationSettings,
        options: &Options,
        seen: &dyn Fn(f64),
    ) -> Result<BranchFound, Error> {
        let each = |point: &BranchPoint| {
            seen(point.parameter);
            ControlFlow::Continue(())
        };
        let system = &self.dynamics;
        let found =
            continue_periodic_orbit_while(system, x, period, upwards, settings, options, each)?;
        Ok(BranchFound::of(&found))
    }

    /// Whether two orbits have come to the same attractor.
    pub fn is_same_attractor(
        &self,
        one: &Outcome,
        other: &Outcome,
        settings: &RecurrenceSettings,
        options: &Options,
    ) -> bool {
        one.is_same(other, &Attractors::new(&self.dynamics, settings, options))
    }

    /// Dimension of the family of periodic orbits that an attractor is one of; 0 where it is
    /// isolated.
    pub fn family(&self, one: &Outcome, settings: &RecurrenceSettings, options: &Options) -> usize {
        one.family(&Attractors::new(&self.dynamics, settings, options))
    }
}

fn tell_phase(phase: &Phase, watcher: &mut dyn Watcher) -> ControlFlow<()> {
    watcher.phase(&PhaseView {
        modes: phase.mode,
        t_start: phase.t_start,
        t_end: phase.t_end,
        x_start: phase.x_start.as_slice(),
        x_end: phase.x_end.as_slice(),
    })
}

/// Where a run stops or fails, the phase under way ends, too.
fn close(orbit: &dyn OrbitUnderWay, watcher: &mut dyn Watcher) -> Ended {
    if let Some(phase) = orbit.phase() {
        // The run ends whatever the watcher says.
        let _ = tell_phase(&phase, watcher);
    }
    Ended {
        ending: Ending::Stopped,
        t: orbit.t(),
        x: orbit.x().to_vec(),
        counters: orbit.counters(),
    }
}
