//! The instances.

use std::cell::Cell;
use std::ops::ControlFlow;

use stickslip::analysis::{
    BranchPoint, ContinuationSettings, PeriodicOrbit, RecurrenceSettings, SpectrumOptions,
    SweepSettings, attractor, continue_periodic_orbit_while, find_periodic_orbit,
    lyapunov_spectrum, multipliers, periodic_orbit, periodic_orbit_forced, sweep,
};
use stickslip::{
    Ending, Error, EventRecord, Happening, Integration, Options, Phase, Progress, Several, State,
    StepRecord, Summary, Switched, Watched,
};

use super::branch::BranchFound;
use super::change::{Change, Family, OfEquations};
use super::erased::{
    Ended, Erase, Passage, Periodic, PhaseView, SpectrumFound, StepView, TransitionView, Watcher,
};
use super::reached::Outcome;
use super::system::{ManyContacts, OneContact, Section};
use super::{Kernel, Run, Shooting};

/// Functions whose zeros end a mode of a system of one contact.
const GUARDS: usize = 3;

/// A system with its numbers of states and guards in its type.
struct Sized<S, const N: usize, const G: usize> {
    system: S,
    contacts: usize,
}

pub(super) fn of_one_contact(system: OneContact, states: usize) -> Option<Box<dyn Kernel>> {
    macro_rules! sized {
        ($($n:literal)*) => {
            match states {
                $($n => Box::new(Sized::<_, $n, GUARDS> { system, contacts: 1 }) as Box<dyn Kernel>,)*
                _ => return None,
            }
        };
    }
    Some(sized!(1 2 3 4 5 6 7 8))
}

pub(super) fn of_many_contacts(system: ManyContacts, states: usize) -> Option<Box<dyn Kernel>> {
    let contacts = system.field.len().trailing_zeros() as usize;
    let system = Several(system);
    macro_rules! sized {
        ($($n:literal)*) => {
            match states {
                $($n => Box::new(Sized::<_, $n, 4> { system, contacts }) as Box<dyn Kernel>,)*
                _ => return None,
            }
        };
    }
    Some(sized!(2 3 4 5 6 7 8))
}

impl<S, const N: usize, const G: usize> Sized<S, N, G>
where
    S: Switched<N, G>,
    S::Mode: Erase,
{
    /// Tells of what happened; whether the run is to stop.
    fn tell(
        &self,
        progress: &Progress<N, S::Mode>,
        last_step: impl FnOnce() -> StepRecord<N, S::Mode>,
        watcher: &mut dyn Watcher,
    ) -> Result<ControlFlow<()>, Summary<N>> {
        let modes = |mode: S::Mode| mode.erased(self.contacts);
        Ok(match progress {
            Progress::Step if !watcher.watches_steps() => ControlFlow::Continue(()),
            Progress::Step => {
                let step = last_step();
                watcher.step(&StepView {
                    modes: modes(step.mode),
                    t_start: step.t_start,
                    t_end: step.t_end,
                    x_end: step.x_end.as_slice(),
                    sample: &|t, x| x.copy_from_slice(step.dense.at_time(t).as_slice()),
                })
            }
            Progress::PhaseEnd(phase) => self.phase(phase, watcher),
            Progress::Transition(at) => TransitionView {
                kind: at.kind,
                contact: at.contact,
                from: modes(at.from),
                to: modes(at.to),
                t: at.t,
                x: at.x.as_slice(),
                residual: at.residual,
            }
            .tell(watcher),
            Progress::End(summary) => return Err(*summary),
        })
    }

    fn phase(&self, phase: &Phase<N, S::Mode>, watcher: &mut dyn Watcher) -> ControlFlow<()> {
        watcher.phase(&PhaseView {
            modes: phase.mode.erased(self.contacts),
            t_start: phase.t_start,
            t_end: phase.t_end,
            x_start: phase.x_start.as_slice(),
            x_end: phase.x_end.as_slice(),
        })
    }

    /// Where a run stops or fails, the phase under way ends, too.
    fn close(&self, integration: &Integration<'_, S, N, G>, watcher: &mut dyn Watcher) -> Ended {
        if let Some(phase) = integration.phase() {
            // The run ends whatever the watcher says.
            let _ = self.phase(&phase, watcher);
        }
        Ended {
            ending: Ending::Stopped,
            t: integration.t(),
            x: integration.x().as_slice().to_vec(),
            counters: *integration.counters(),
        }
    }

    fn passage(&self, at: &EventRecord<N, S::Mode>, watcher: &mut dyn Watcher) -> ControlFlow<()> {
        watcher.passage(&Passage {
            t: at.t,
            x: at.x.as_slice(),
            modes: at.mode.erased(self.contacts),
            direction: at.direction,
        })
    }
}

/// A state from a slice of its components; of a wrong number of them, the rest is not a number, which every run refuses.
pub(super) fn state<const N: usize>(x: &[f64]) -> State<N> {
    State::from_fn(|i, _| x.get(i).copied().unwrap_or(f64::NAN))
}

fn ended<const N: usize>(summary: &Summary<N>) -> Ended {
    Ended {
        ending: summary.ending,
        t: summary.t,
        x: summary.x.as_slice().to_vec(),
        counters: summary.counters,
    }
}

fn periodic<const N: usize>(orbit: &PeriodicOrbit<N>) -> Periodic {
    Periodic {
        t: orbit.t,
        x: orbit.x.as_slice().to_vec(),
        period: orbit.period,
        residual: orbit.residual,
        multipliers: multipliers(&orbit.monodromy).to_vec(),
        family: orbit.family,
    }
}

impl<S, const N: usize, const G: usize> Kernel for Sized<S, N, G>
where
    S: Switched<N, G> + OfEquations + Send + Sync,
    S::Mode: Erase,
{
    fn run(
        &self,
        run: &Run<'_>,
        section: Option<&Section>,
        watcher: &mut dyn Watcher,
    ) -> Result<Ended, Error> {
        let start = state::<N>(run.x);
        let mut integration = Integration::new(&self.system, run.t, start, run.t_end, run.options)?;
        let Some(section) = section else {
            loop {
                let told = match integration.step() {
                    Ok(progress) => self.tell(&progress, || integration.last_step(), watcher),
                    Err(error) => {
                        self.close(&integration, watcher);
                        return Err(error);
                    }
                };
                match told {
                    Ok(ControlFlow::Continue(())) => {}
                    Ok(ControlFlow::Break(())) => return Ok(self.close(&integration, watcher)),
                    Err(summary) => return Ok(ended(&summary)),
                }
            }
        };
        let mut watched = Watched::new(integration, section);
        loop {
            let told = match watched.step() {
                Ok(Happening::Event(event)) => Ok(self.passage(&event, watcher)),
                Ok(Happening::Progress(progress)) => {
                    self.tell(&progress, || watched.last_step(), watcher)
                }
                Err(error) => {
                    self.close(watched.integration(), watcher);
                    return Err(error);
                }
            };
            match told {
                Ok(ControlFlow::Continue(())) => {}
                Ok(ControlFlow::Break(())) => return Ok(self.close(watched.integration(), watcher)),
                Err(summary) => return Ok(ended(&summary)),
            }
        }
    }

    fn periodic(&self, run: &Run<'_>, shooting: Shooting) -> Result<Periodic, Error> {
        let (system, x, options) = (&self.system, state::<N>(run.x), run.options);
        let found = match shooting {
            Shooting::Forced { period } => periodic_orbit_forced(system, run.t, x, period, options),
            Shooting::Free { period } => periodic_orbit(system, x, period, options),
            Shooting::Found { transient, longest } => {
                find_periodic_orbit(system, x, transient, longest, options)
            }
        };
        found.map(|orbit| periodic(&orbit))
    }

    fn spectrum(
        &self,
        t: f64,
        x: &[f64],
        settings: &SpectrumOptions,
    ) -> Result<SpectrumFound, Error> {
        let spectrum = lyapunov_spectrum(&self.system, (t, state::<N>(x)), settings)?;
        let running = spectrum.convergence.iter();
        Ok(SpectrumFound {
            exponents: spectrum.exponents.to_vec(),
            convergence: running
                .map(|at| (at.elapsed, at.exponents.to_vec()))
                .collect(),
            defect: spectrum.defect(),
            stick_entries: spectrum.stick_entries,
            stick_fraction: spectrum.stick_fraction,
            duration: spectrum.duration,
        })
    }

    fn attractor(
        &self,
        x: &[f64],
        settings: &RecurrenceSettings,
        options: &Options,
        told: &dyn Fn(&Error) -> String,
    ) -> Result<Outcome, Error> {
        let reached = attractor(&self.system, state::<N>(x), settings, options)?;
        Ok(Outcome::of(&reached, self.contacts, told))
    }

    fn changes(
        &self,
        family: &Family<'_>,
        (from, to): (f64, f64),
        x: &[f64],
        settings: &SweepSettings,
        options: &Options,
    ) -> Result<Vec<Change>, Error> {
        // Where there is no system, the search goes on with this one, and what it finds is not told.
        let complete = Cell::new(true);
        let system = |parameter| {
            let system = family(parameter).and_then(S::of);
            system.unwrap_or_else(|| {
                complete.set(false);
                self.system.clone()
            })
        };
        let found = sweep(system, [from, to], state::<N>(x), settings, options)?;
        if !complete.get() {
            return Ok(vec![Change::Unlocated]);
        }
        let changes = found.changes.iter();
        Ok(changes
            .map(|change| Change::of(change, self.contacts))
            .collect())
    }

    fn branch(
        &self,
        x: &[f64],
        period: f64,
        upwards: bool,
        settings: &ContinuationSettings,
        options: &Options,
        seen: &dyn Fn(f64),
    ) -> Result<BranchFound, Error> {
        let x = state::<N>(x);
        let system = &self.system;
        let each = |point: &BranchPoint<N, S::Mode>| {
            seen(point.parameter);
            ControlFlow::Continue(())
        };
        let found =
            continue_periodic_orbit_while(system, x, period, upwards, settings, options, each)?;
        Ok(BranchFound::of(&found, self.contacts))
    }

    fn is_same_attractor(
        &self,
        one: &Outcome,
        other: &Outcome,
        settings: &RecurrenceSettings,
        options: &Options,
    ) -> bool {
        one.is_same(other, &self.system, settings, options)
    }

    fn family(&self, one: &Outcome, settings: &RecurrenceSettings, options: &Options) -> usize {
        one.family(&self.system, settings, options)
    }
}
