//! The one loop: an integration that goes on step by step and says what happens.

use super::event::Event;
use super::flow::{Flow, GUARDS};
use super::observer::{Phase, StepRecord, Transition, TransitionKind};
use super::options::{AtPileUp, Options};
use super::pile_up::{PileUp, Series};
use super::run::{Run, Trial};
use super::solve::Summary;
use super::stepper::{Stepper, Work};
use super::switched::{Next, Rest, Settled, Switched, UseFlow, Velocity};
use super::taylor::GROW_MOST;
use crate::error::Error;
use crate::ode::{Dense, Timed};
use crate::orbit::{Counters, Ending};
use crate::system::{IntoState, Mode, State, components};

/// What happened in an integration; see [`Integration::step`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Progress<const N: usize, K = Mode> {
    /// A step was taken: [`Integration::last_step`].
    Step,
    /// A phase has ended at the end of the last step.
    PhaseEnd(Phase<N, K>),
    /// The mode changes, or Σ was touched, or contact lost or gained, at the end of the last step.
    Transition(Transition<N, K>),
    /// The run has ended; further calls say the same.
    End(Summary<N>),
}

/// An integration under way: a system, where it stands, and what it does next.
///
/// [`crate::solve`], [`crate::run`], [`crate::ensemble`] and everything in [`crate::analysis`] that follows an orbit are loops
/// over [`Integration::step`].
///
/// ```
/// use stickslip::{Integration, Options, Progress, models::BeltOscillator};
///
/// let belt = BeltOscillator::default();
/// let mut integration = Integration::new(&belt, 0.0, [0.5, 1.5], 20.0, &Options::default())?;
/// let mut highest = f64::NEG_INFINITY;
/// let summary = loop {
///     match integration.step()? {
///         Progress::Step => highest = highest.max(integration.x()[0]),
///         Progress::PhaseEnd(phase) => println!("{:?} for {}", phase.mode, phase.duration()),
///         Progress::Transition(at) => println!("{:?} at t = {}", at.kind, at.t),
///         Progress::End(summary) => break summary,
///     }
/// };
/// assert_eq!((summary.t, integration.t()), (20.0, 20.0));
/// assert!(highest > 0.5);
/// # Ok::<(), stickslip::Error>(())
/// ```
pub struct Integration<'a, S: Switched<N, G>, const N: usize, const G: usize = GUARDS> {
    pub(super) system: &'a S,
    pub(super) run: Run<N, G>,
    pub(super) stepper: Stepper<N, G>,
    pub(super) mode: S::Mode,
    /// What besides the mode decides the flow.
    pub(super) branch: S::Branch,
    /// The last step's mode.
    last_mode: S::Mode,
    pile_up: PileUp<N, S::Mode>,
    /// How the run goes on where transitions accumulate, while it is led there.
    rest: Option<Rest<S::Mode, S::Branch, N, G>>,
    due: Due,
}

/// What the next call begins with.
#[derive(Clone, Copy)]
enum Due {
    /// The first step of a phase, or of the rest of one.
    Begin,
    /// Another step.
    Step,
    /// Another step, after one without an event.
    Passed,
    /// The event that the last step has come to.
    Event,
    /// The phase has ended at the event; the rules decide what follows.
    Switch,
    /// The way to where transitions accumulate.
    Rest,
    /// Nothing but to say that the phase under way has ended with the run.
    PhaseEnd(Ending),
    /// Nothing: the run has ended.
    End(Ending),
}

impl<'a, S: Switched<N, G>, const N: usize, const G: usize> Integration<'a, S, N, G> {
    /// An integration of `system` from `(t0, x0)` to `t_end`. The start may lie anywhere: on either side, on Σ, at a tangent point.
    ///
    /// # Errors
    /// [`Error::Option`], [`Error::Interval`], [`Error::Parameter`], [`Error::StartOutsideDomain`] and [`Error::Escaped`]; those about
    /// friction of [`Integration::step`], if it starts on Σ.
    pub fn new(
        system: &'a S,
        t0: f64,
        x0: impl IntoState<N>,
        t_end: f64,
        options: &Options,
    ) -> Result<Self, Error> {
        let start = Timed {
            t: t0,
            x: x0.into_state(),
        };
        Self::with_stepper(system, (start, N), t_end, options, Stepper::new(options))
    }

    /// [`Integration::new`] of a system of so many states, which may be fewer than its type has room
    /// for. It takes a stepper's room that another integration with the same options has left.
    pub(crate) fn with_stepper(
        system: &'a S,
        (start, states): (Timed<N>, usize),
        t_end: f64,
        options: &Options,
        stepper: Stepper<N, G>,
    ) -> Result<Self, Error> {
        let mut run = Run::checked(system, (start, states), t_end, options)?;
        let (mode, due) = match system.first_mode(&mut run)? {
            Some((mode, orders)) => {
                run.orders = orders;
                (mode, Due::Begin)
            }
            None => (S::UNDECIDED, Due::End(Ending::Repelling)),
        };
        Ok(Integration {
            system,
            run,
            stepper,
            mode,
            branch: system.branch(mode, &start),
            last_mode: mode,
            pile_up: PileUp::new(&start, mode),
            rest: None,
            due,
        })
    }

    /// An integration that stays in a mode to its end, whatever the guards do. Contact is lost or
    /// kept as at `inside`.
    ///
    /// # Errors
    /// Those of [`Integration::new`].
    pub(crate) fn held(
        system: &'a S,
        (mode, inside): (S::Mode, &Timed<N>),
        start: (Timed<N>, usize),
        t_end: f64,
        options: &Options,
    ) -> Result<Self, Error> {
        let mut run = Run::checked(system, start, t_end, options)?;
        run.is_held = true;
        Ok(Integration {
            system,
            run,
            stepper: Stepper::new(options),
            mode,
            branch: system.branch(mode, inside),
            last_mode: mode,
            pile_up: PileUp::new(inside, mode),
            rest: None,
            due: Due::Begin,
        })
    }

    /// Takes the next step and says so, or says what the last one has led to, one thing a call: the end of a phase, then the
    /// transition behind it.
    ///
    /// # Errors
    /// [`Error::NonFinite`], [`Error::StepCollapse`], [`Error::EventPileUp`], [`Error::BranchPileUp`],
    /// [`Error::TooMany`] and [`Error::Escaped`]; [`Error::StaticBelowKinetic`]; of several contacts
    /// [`Error::NoUniqueMode`], [`Error::TooManyContacts`], [`Error::DependentContacts`], [`Error::HoldsElsewhere`] and
    /// [`Error::NotAdditive`]. The integration stays where it has come to.
    #[inline]
    pub fn step(&mut self) -> Result<Progress<N, S::Mode>, Error> {
        loop {
            if !self.prepare()? {
                return self.say();
            }
            if self.advance()? {
                return Ok(Progress::Step);
            }
        }
    }

    /// The last step, with the solution over it; of no length before the first.
    ///
    /// By [`crate::Method::Dop853`] a step far from all events has no dense output before it is asked for here, which saves a
    /// fifth of the field's calls. It is then taken again, and the next one has its dense output at once: asking every time
    /// costs no more than that, asking now and then two steps each time.
    #[inline]
    pub fn last_step(&mut self) -> StepRecord<N, S::Mode> {
        // The mode of a step without dense output is still the run's: only events change that. This work cannot fail.
        let _ = self.work(Work::Complete);
        self.run.wants_dense = true;
        self.run.last_step(self.last_mode)
    }

    /// Goes on to where a step is taken next, or to where something is to be said before; returns whether it is a step.
    #[inline(always)]
    pub(super) fn prepare(&mut self) -> Result<bool, Error> {
        match self.due {
            Due::Step => {}
            Due::Begin => {
                self.land();
                self.stepper.begin();
                self.due = Due::Step;
            }
            Due::Passed => {
                self.run.check_escape()?;
                if self.run.orders != [0; G] {
                    self.work(Work::NoteDepartures)?;
                }
                self.due = Due::Step;
            }
            Due::PhaseEnd(_) => {
                self.run.check_escape()?;
                return Ok(false);
            }
            Due::Event | Due::Switch | Due::Rest | Due::End(_) => return Ok(false),
        }
        if self.run.at.t >= self.run.t_end {
            self.due = Due::PhaseEnd(Ending::EndTime);
            return Ok(false);
        }
        self.run.check_steps()?;
        if self.stepper.needs_preparing() {
            self.work(Work::Prepare)?;
        }
        Ok(true)
    }

    /// Tries a step, and says whether it was taken.
    #[inline(always)]
    pub(super) fn advance(&mut self) -> Result<bool, Error> {
        self.due = match self.work(Work::Advance) {
            Ok(Trial::NoStep) => return Ok(false),
            Ok(Trial::Step) => Due::Passed,
            Ok(Trial::Event) => Due::Event,
            Err(error) => {
                self.due = self.after(error)?;
                return Ok(false);
            }
        };
        self.last_mode = self.mode;
        Ok(true)
    }

    /// What is to be said before the next step, one thing a call.
    pub(super) fn say(&mut self) -> Result<Progress<N, S::Mode>, Error> {
        if let (Due::Event | Due::Switch, Some(event)) = (self.due, self.run.event) {
            match self.conclude(&event) {
                Err(error) => {
                    let is_between = matches!(self.due, Due::Switch);
                    self.due = self.after(error)?;
                    if is_between && let Due::Rest = self.due {
                        return Ok(self.on_the_way(&event));
                    }
                }
                said => return said,
            }
        }
        match self.due {
            Due::Rest => Ok(self.come_to_rest()),
            Due::PhaseEnd(ending) => {
                let phase = self.phase_so_far();
                self.due = Due::End(ending);
                Ok(Progress::PhaseEnd(phase))
            }
            Due::End(ending) => Ok(Progress::End(self.summary(ending))),
            _ => self.step(),
        }
    }

    /// What a step that has failed means: an event that no step resolves, a pile-up or an ending; if it is none, the error.
    #[cold]
    fn after(&mut self, error: Error) -> Result<Due, Error> {
        let (t, options) = (self.run.at.t, &self.run.options);
        // Near an accumulation point contacts are not told apart by tolerance any more, nor steps by rounding.
        let series = match &error {
            Error::EventPileUp { .. } => return self.piled_up(self.pile_up.series()),
            Error::StepCollapse { .. } => self.pile_up.under_way(t, options),
            Error::NoUniqueMode { contacts, .. } => self.pile_up.of_contacts(t, contacts),
            _ => None,
        };
        if series.is_some() {
            return self.piled_up(series);
        }
        if let Error::StepCollapse { .. } = error
            && let Some(guard) = self.system.guard_at_collapse(&self.run, self.mode)
        {
            self.run.event = Some(Event {
                guard,
                at: self.run.at,
                is_touch: false,
                residual: 0.0,
            });
            return Ok(Due::Event);
        }
        Err(error)
    }

    /// What follows transitions that pile up: rest where they accumulate, an ending, or the error.
    fn piled_up(&mut self, series: Option<Series<N>>) -> Result<Due, Error> {
        let rest = series.as_ref().and_then(|series| {
            let run = &mut self.run;
            let rest = self
                .system
                .rest(run, self.mode, &series.contacts, &series.at)?;
            let off = (rest.at.x - series.at.x).amax();
            (off <= series.distance + run.slack()).then_some(rest)
        });
        let holds = rest.is_some();
        if holds && self.run.options.at_pile_up == AtPileUp::Rest {
            self.rest = rest;
            return Ok(Due::Rest);
        }
        let two_fold = self.system.ending_of_pile_up(&self.run, self.mode);
        let shrinks = series.is_none() && self.pile_up.shrinks();
        let ending = two_fold.or(shrinks.then_some(Ending::Shrunk));
        let Some(ending) = ending else {
            let (at, options) = (&self.run.at, &self.run.options);
            return Err(self.pile_up.error(at, series.as_ref(), holds, options));
        };
        Ok(match self.phase() {
            Some(_) => Due::PhaseEnd(ending),
            None => Due::End(ending),
        })
    }

    /// The transition at an event behind which the run is led to where transitions accumulate.
    fn on_the_way(&mut self, event: &Event<N>) -> Progress<N, S::Mode> {
        let from = self.mode;
        self.mode = self.pile_up.mode_after(event.at.t).unwrap_or(from);
        self.run.from = self.run.at;
        let contact = S::contact_of(event.guard);
        let of = |mode| S::erased(mode, S::CONTACTS).get(contact);
        let kind = TransitionKind::between(of(from), of(self.mode));
        self.transition((kind, contact), from, event.residual)
    }

    /// The step to where transitions accumulate, or as far as the run goes.
    fn come_to_rest(&mut self) -> Progress<N, S::Mode> {
        let from = self.run.at;
        let Some(rest) = &self.rest else {
            return Progress::End(self.summary(Ending::Failed));
        };
        let to = Timed {
            t: rest.at.t.max(from.t),
            x: rest.at.x,
        };
        self.stepper.begin();
        self.run.dense = Dense::straight(&from, &to);
        self.run.counters.steps += 1;
        self.last_mode = self.mode;
        if to.t > self.run.t_end {
            let t = self.run.t_end;
            let x = self.run.dense.at_time(t);
            self.run.accept(Timed { t, x }, None);
            self.due = Due::PhaseEnd(Ending::EndTime);
            return Progress::Step;
        }
        let event = Event {
            guard: rest.contact,
            at: to,
            is_touch: false,
            residual: 0.0,
        };
        self.run.accept(to, Some(&event));
        self.due = Due::Event;
        Progress::Step
    }

    /// Cuts the last step short at a state inside it, where the run ends.
    pub(crate) fn stop_at(&mut self, at: Timed<N>) {
        self.run.at = at;
        self.run.last.1 = at;
        self.due = Due::PhaseEnd(Ending::Stopped);
    }

    /// Sets when the run ends.
    pub(crate) fn end_at(&mut self, t_end: f64) {
        self.run.t_end = t_end;
    }

    /// Whether it has come to its end time, and has nothing else to report first.
    pub(crate) fn is_at_end(&self) -> bool {
        let goes_on = matches!(self.due, Due::Begin | Due::Step | Due::Passed);
        goes_on && self.run.at.t >= self.run.t_end
    }

    /// Whether the end of a phase is reported next.
    pub(crate) fn ends_phase(&self) -> bool {
        matches!(self.due, Due::PhaseEnd(_))
    }

    /// Whether it stays in its mode whatever the guards do.
    pub(crate) fn is_held(&self) -> bool {
        self.run.is_held
    }

    /// Goes on from another state at the same time, or ends there. What it can be in is decided as
    /// at a start. It counts as a transition of a contact of that number.
    ///
    /// # Errors
    /// Those of [`Integration::new`], and of [`Integration::step`] about too many transitions.
    pub(crate) fn leap(
        &mut self,
        number: usize,
        x: State<N>,
        ending: Option<Ending>,
    ) -> Result<(), Error> {
        self.run.at.x = x;
        // After a jump the motion may be as much faster as the one before it was short.
        let (from, to) = &self.run.last;
        self.run.h = self.run.h.min(GROW_MOST * (to.t - from.t));
        self.begin_phase();
        self.decide()?;
        // What happens again in no time is not resolved any more.
        if self.pile_up.was_at(number, self.run.at.t) {
            return Err(self.accumulated());
        }
        match self.note_event(number, self.mode) {
            Err(Error::EventPileUp { .. }) if self.pile_up.accumulates(&self.run.options) => {
                return Err(self.accumulated());
            }
            // Jumps may go on where nothing moves any more, by a clock.
            Err(Error::EventPileUp { .. }) | Ok(()) => {}
            Err(other) => return Err(other),
        }
        if let Some(ending) = ending {
            self.due = Due::End(ending);
        }
        Ok(())
    }

    /// Goes on where the field jumps at this time. The state may differ in what an input holds. The
    /// transition, where a contact changes its mode.
    ///
    /// # Errors
    /// Those of [`Integration::new`].
    pub(crate) fn kink(&mut self, x: State<N>) -> Result<Option<Transition<N, S::Mode>>, Error> {
        self.run.at.x = x;
        let from = self.mode;
        if self.run.is_held {
            self.due = Due::Begin;
            return Ok(None);
        }
        self.decide()?;
        if self.mode == from {
            return Ok(None);
        }
        let (kind, contact) = S::change(from, self.mode);
        self.note_event(contact, self.mode)?;
        let Timed { t, x } = self.run.at;
        Ok(Some(Transition {
            t,
            x,
            kind,
            from,
            to: self.mode,
            contact,
            residual: 0.0,
        }))
    }

    /// The velocity here.
    pub(crate) fn velocity(&self) -> State<N> {
        let Timed { t, x } = self.run.at;
        let velocity = Velocity(t, components(&x));
        State::from(self.system.with_flow(self.mode, self.branch, velocity))
    }

    /// The pile-up that the last transitions are.
    fn accumulated(&self) -> Error {
        let (at, options) = (&self.run.at, &self.run.options);
        let series = self.pile_up.series();
        self.pile_up.error(at, series.as_ref(), false, options)
    }

    /// A phase begins here.
    pub(crate) fn begin_phase(&mut self) {
        self.run.from = self.run.at;
    }

    /// Decides the mode as at a start.
    fn decide(&mut self) -> Result<(), Error> {
        if self.run.at.t < self.run.t_end {
            let (at, t_end) = (self.run.at, self.run.t_end);
            self.system.check(&at, t_end, &self.run.options)?;
        }
        self.due = match self.system.first_mode(&mut self.run)? {
            Some((mode, orders)) => {
                self.mode = mode;
                self.run.orders = orders;
                Due::Begin
            }
            None => Due::End(Ending::Repelling),
        };
        self.branch = self.system.branch(self.mode, &self.run.at);
        Ok(())
    }

    /// Does what depends on the mode, with the flow of the mode.
    #[inline(always)]
    fn work(&mut self, work: Work) -> Result<Trial, Error> {
        let on_flow = OnFlow {
            work,
            stepper: &mut self.stepper,
            run: &mut self.run,
        };
        self.system.with_flow(self.mode, self.branch, on_flow)
    }

    /// A stick phase begins on Σ.
    fn land(&mut self) {
        if S::any_sticks(self.mode) {
            let settled = Settled(self.run.at);
            self.run.at.x = self.system.with_flow(self.mode, self.branch, settled);
        }
    }

    /// What the event that the last step has come to leads to.
    #[cold]
    fn conclude(&mut self, event: &Event<N>) -> Result<Progress<N, S::Mode>, Error> {
        self.run.check_escape()?;
        if let Due::Switch = self.due {
            return self.switch(event);
        }
        let mode = self.mode;
        let (guard, residual) = (event.guard, event.residual);
        if event.is_touch {
            self.note_event(S::contact_of(guard), mode)?;
            self.run.orders[guard] = 2;
            self.due = Due::Step;
            let touch = (TransitionKind::Touch, S::contact_of(guard));
            return Ok(self.transition(touch, mode, residual));
        }
        let mut branch = self.branch;
        let Some(kind) = self.system.passed(guard, &mut branch) else {
            self.due = Due::Switch;
            return Ok(Progress::PhaseEnd(self.phase_so_far()));
        };
        self.note_event(S::contact_of(guard), mode)?;
        self.branch = branch;
        self.run.orders[guard] = 1;
        self.due = Due::Begin;
        Ok(self.transition((kind, S::contact_of(guard)), mode, residual))
    }

    /// From the end of a phase to the next mode or to the end of the run.
    fn switch(&mut self, event: &Event<N>) -> Result<Progress<N, S::Mode>, Error> {
        let from = self.mode;
        if let Some(rest) = self.rest.take() {
            self.pile_up = PileUp::new(&self.run.at, rest.to);
            self.note_event(rest.contact, rest.to)?;
            (self.mode, self.branch) = (rest.to, rest.branch);
            self.run.orders = rest.orders;
            self.run.from = self.run.at;
            self.due = Due::Begin;
            let entry = (TransitionKind::StickEntry, rest.contact);
            return Ok(self.transition(entry, from, 0.0));
        }
        // At a two-fold of one contact the rules would end the run, or let it stick as far as rounding does.
        if self.run.options.at_pile_up == AtPileUp::Rest
            && self.system.ending_of_pile_up(&self.run, from).is_some()
            && let Some(series) = self.pile_up.under_way(event.at.t, &self.run.options)
        {
            return Err(self
                .pile_up
                .error(&event.at, Some(&series), false, &self.run.options));
        }
        let next = match self
            .system
            .switch(&mut self.run, from, &mut self.branch, event)?
        {
            Next::Mode(next) => next,
            Next::End(ending) => {
                self.due = Due::End(ending);
                return Ok(Progress::End(self.summary(ending)));
            }
        };
        self.note_event(next.contact, next.to)?;
        self.mode = next.to;
        self.run.orders = next.orders;
        self.run.from = self.run.at;
        self.due = Due::Begin;
        Ok(self.transition((next.kind, next.contact), from, event.residual))
    }

    /// A transition here, into the mode that the run is in now.
    fn transition(
        &self,
        (kind, contact): (TransitionKind, usize),
        from: S::Mode,
        residual: f64,
    ) -> Progress<N, S::Mode> {
        let Timed { t, x } = self.run.at;
        Progress::Transition(Transition {
            t,
            x,
            kind,
            from,
            to: self.mode,
            contact,
            residual,
        })
    }

    /// Counts a transition of a contact into `mode`.
    fn note_event(&mut self, contact: usize, mode: S::Mode) -> Result<(), Error> {
        self.run.note_event()?;
        let Timed { t, x } = self.run.at;
        let velocity = Velocity(t, components(&x));
        let velocity = self.system.with_flow(mode, self.branch, velocity).into();
        let (at, options) = (&self.run.at, &self.run.options);
        if self.pile_up.note(at, (contact, mode), &velocity, options) {
            return Err(self.pile_up.error(at, None, false, options));
        }
        Ok(())
    }
}

/// Work on the flow of the mode.
struct OnFlow<'a, const N: usize, const G: usize> {
    work: Work,
    stepper: &'a mut Stepper<N, G>,
    run: &'a mut Run<N, G>,
}

impl<const N: usize, const G: usize> UseFlow<N> for OnFlow<'_, N, G> {
    type Output = Result<Trial, Error>;

    #[inline(always)]
    fn with<F: Flow<N>>(self, flow: &F) -> Self::Output {
        self.stepper.work(self.work, self.run, flow)
    }
}

impl<S: Switched<N, G>, const N: usize, const G: usize> Integration<'_, S, N, G> {
    /// The time reached.
    pub fn t(&self) -> f64 {
        self.run.at.t
    }

    /// The state reached.
    pub fn x(&self) -> &State<N> {
        &self.run.at.x
    }

    /// The mode that the next step is taken in.
    pub fn mode(&self) -> S::Mode {
        self.mode
    }

    /// The phase under way as far as it has come; `None` between phases.
    pub fn phase(&self) -> Option<Phase<N, S::Mode>> {
        let is_open = !matches!(self.due, Due::Switch | Due::End(_));
        (is_open && self.run.from.t < self.run.at.t).then(|| self.phase_so_far())
    }

    /// The work done so far.
    pub fn counters(&self) -> &Counters {
        &self.run.counters
    }

    pub(crate) fn phase_so_far(&self) -> Phase<N, S::Mode> {
        let (from, to) = (&self.run.from, &self.run.at);
        Phase {
            mode: self.mode,
            t_start: from.t,
            t_end: to.t,
            x_start: from.x,
            x_end: to.x,
        }
    }

    pub(super) fn summary(&self, ending: Ending) -> Summary<N> {
        Summary {
            ending,
            t: self.run.at.t,
            x: self.run.at.x,
            counters: self.run.counters,
        }
    }
}
