//! An integration under way: takes one step at a time and reports what happens.

use super::flow::{Flow, GUARDS};
use super::guard::Event;
use super::observer::{Phase, StepRecord, Transition, TransitionKind};
use super::options::{AtPileUp, Options};
use super::pile_up::PileUpDetector;
use super::recordings::Recordings;
use super::root_law::OntoRoot;
use super::run::{StepState, Trial};
use super::stepper::{Stepper, Work};
use super::switched::{IsDriven, Next, Settled, StickingPoint, Switched, UseFlow};
use super::two_fold::two_fold;
use crate::error::Error;
use crate::ode::Timed;
use crate::orbit::{Counters, Ending, Summary};
use crate::system::{IntoState, Mode, State};
use crate::taylor::recorded_calls::RecordedCalls;

/// Progress of an integration; see [`Integration::step`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Progress<const N: usize, K = Mode> {
    /// A step was taken: [`Integration::last_step`].
    Step,
    /// A phase has ended at the end of the last step.
    PhaseEnd(Phase<N, K>),
    /// The mode changes, or Σ was touched, or contact lost or gained, at the end of the last step.
    Transition(Transition<N, K>),
    /// The run has ended; further calls report the same.
    End(Summary<N>),
}

/// An integration under way: a system, its present time and state, and what follows.
///
/// [`crate::solve`], [`crate::run`], [`crate::ensemble`] and everything in [`crate::analysis`] that
/// follows an orbit are loops over [`Integration::step`].
///
/// ```
#[doc = include_str!("../../examples/common/belt.rs")]
/// use stickslip::{Integration, Options, Progress};
///
/// let belt = Belt { speed: 1.0 };
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
    pub(super) run: StepState<N, G>,
    pub(super) stepper: Stepper<N, G>,
    pub(super) mode: S::Mode,
    /// Choice of the flow besides the mode.
    pub(super) branch: S::Branch,
    /// The last step's mode.
    pub(super) last_mode: S::Mode,
    pub(super) pile_up: PileUpDetector<N, S::Mode>,
    /// The point where transitions accumulate, while the run is on its way there.
    pub(super) sticking_point: Option<StickingPoint<S::Mode, S::Branch, N, G>>,
    /// The jump that follows where jumps accumulate, with the number of each that has one.
    pub(super) rests: Vec<(usize, usize)>,
    /// The accumulation point of such jumps and those that follow there, while the run is on its
    /// way.
    pub(super) landing: Option<(f64, Vec<usize>)>,
    /// Recorded calls of the system's functions, if these are interpreted.
    pub(super) recordings: Recordings<S::Mode, S::Branch, N, G>,
    pub(super) due: Due,
    /// Whether the next step is prepared.
    is_ready: bool,
    /// Whether the next step is the first of a phase that begins at the zero of a guard.
    leaves: bool,
    /// Whether the next step is the first that the end of the run shortens.
    pub(super) is_before_end: bool,
    /// Whether it goes on from another run.
    pub(super) is_resumed: bool,
    /// Number of contacts that the system has; jumps are numbered after them.
    pub(super) contacts: usize,
    /// Whether inputs move the state at times that the run ends at in between.
    pub(super) has_inputs: bool,
    /// Whether the observer has asked for the end of the run at the end of a phase.
    pub(super) is_stopping: bool,
}

/// First task of the next call of [`Integration::step`].
#[derive(Clone, Copy)]
pub(super) enum Due {
    /// The first step of a phase, or of its continuation after an event that does not end it.
    Begin,
    /// Another step.
    Step,
    /// Another step after one without an event.
    AfterStep,
    /// The event at the end of the last step.
    Event,
    /// The mode that follows the event at which the phase has ended.
    Switch,
    /// The step to the point where transitions accumulate.
    Accumulation,
    /// The report that the phase under way has ended with the run.
    PhaseEnd(Ending),
    /// The report that the run has ended.
    End(Ending),
}

impl<'a, S: Switched<N, G>, const N: usize, const G: usize> Integration<'a, S, N, G> {
    /// An integration of `system` from `(t0, x0)` to `t_end`. The start may lie on either side, on
    /// Σ, or at a tangent point.
    ///
    /// # Errors
    /// [`Error::Option`], [`Error::Interval`], [`Error::Parameter`], [`Error::StartOutsideDomain`]
    /// and [`Error::Escaped`]; those about friction of [`Integration::step`], if it starts on Σ.
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
        Self::with_stepper(system, start, t_end, options, Stepper::new(options))
    }

    /// [`Integration::new`] with a stepper that may have served another integration with the same
    /// options.
    pub(crate) fn with_stepper(
        system: &'a S,
        start: Timed<N>,
        t_end: f64,
        options: &Options,
        stepper: Stepper<N, G>,
    ) -> Result<Self, Error> {
        system.check(&start, t_end, options)?;
        let mut run = StepState::new((start, system.dimension()), t_end, options)?;
        let (mode, due) = match system.first_mode(&mut run)? {
            Next::Mode(mode, orders) => {
                run.orders = orders;
                (mode, Due::Begin)
            }
            Next::End(ending) => (S::UNDECIDED, Due::End(ending)),
        };
        let begun = Self::begun(system, run, stepper, (mode, &start));
        Ok(Integration { due, ..begun })
    }

    /// An integration that stays in a mode to its end regardless of the guards. Contact is lost or
    /// kept as at `inside`.
    ///
    /// # Errors
    /// Those of [`Integration::new`].
    pub(crate) fn in_mode(
        system: &'a S,
        (mode, inside): (S::Mode, &Timed<N>),
        start: Timed<N>,
        t_end: f64,
        options: &Options,
    ) -> Result<Self, Error> {
        let mut begun = Self::new_in(system, (mode, inside), start, t_end, options)?;
        begun.run.is_prescribed = true;
        Ok(begun)
    }

    /// An integration that begins in a mode, with contact lost or kept as at `inside`.
    ///
    /// # Errors
    /// Those of [`Integration::new`].
    pub(super) fn new_in(
        system: &'a S,
        (mode, inside): (S::Mode, &Timed<N>),
        start: Timed<N>,
        t_end: f64,
        options: &Options,
    ) -> Result<Self, Error> {
        system.check(&start, t_end, options)?;
        let run = StepState::new((start, system.dimension()), t_end, options)?;
        let stepper = Stepper::new(options);
        Ok(Self::begun(system, run, stepper, (mode, inside)))
    }

    /// An integration in a mode, before its first step.
    fn begun(
        system: &'a S,
        run: StepState<N, G>,
        stepper: Stepper<N, G>,
        (mode, inside): (S::Mode, &Timed<N>),
    ) -> Self {
        Integration {
            system,
            run,
            stepper,
            mode,
            branch: system.branch(mode, inside),
            last_mode: mode,
            pile_up: PileUpDetector::new(inside, mode, S::of_contacts),
            sticking_point: None,
            rests: Vec::new(),
            landing: None,
            recordings: Recordings::default(),
            due: Due::Begin,
            is_ready: false,
            leaves: false,
            is_before_end: false,
            is_resumed: false,
            contacts: S::CONTACTS,
            has_inputs: false,
            is_stopping: false,
        }
    }

    /// Continues the phase from where the last step was cut.
    ///
    /// # Errors
    /// [`Error::Escaped`].
    pub(crate) fn go_on_in_phase(&mut self) -> Result<(), Error> {
        self.run.check_escape()?;
        if self.run.orders != [0; G] {
            self.work(Work::RecordDepartures)?;
        }
        self.due = Due::Begin;
        Ok(())
    }

    /// Takes the next step and reports it, or reports a consequence of the last one. Each call
    /// reports one item: the end of a phase, then the transition that follows.
    ///
    /// # Errors
    /// [`Error::NonFinite`], [`Error::StepCollapse`], [`Error::EventPileUp`],
    /// [`Error::BranchPileUp`], [`Error::TooMany`] and [`Error::Escaped`];
    /// [`Error::Contacts`]. The integration stays at the last state.
    #[inline]
    pub fn step(&mut self) -> Result<Progress<N, S::Mode>, Error> {
        loop {
            if let Some(progress) = self.go_on()? {
                return Ok(progress);
            }
        }
    }

    /// Takes the step that was prepared, if there is one, or continues until the next one is
    /// prepared. Returns what happened, or `None` if a step was prepared.
    #[inline(always)]
    pub(crate) fn go_on(&mut self) -> Result<Option<Progress<N, S::Mode>>, Error> {
        if std::mem::take(&mut self.is_ready) {
            if self.advance()? {
                return Ok(Some(Progress::Step));
            }
            if self.is_before_end {
                // The same attempt follows, with the series that is expanded already.
                self.is_ready = true;
                return Ok(None);
            }
        }
        self.is_ready = self.prepare()?;
        if self.is_ready {
            return Ok(None);
        }
        self.report().map(Some)
    }

    /// Whether the next step is prepared.
    pub(crate) fn is_ready(&self) -> bool {
        self.is_ready
    }

    /// The last step, with the solution over it; of zero length before the first.
    ///
    /// With [`crate::Method::Dop853`], a step far from all events has no dense output until this
    /// call requests it, which saves a fifth of the field's calls. The call repeats the step, and
    /// the next step has its dense output at once. Requests for every step cost no more than that.
    /// A request now and then costs two steps.
    #[inline]
    pub fn last_step(&mut self) -> StepRecord<N, S::Mode> {
        // A step without dense output is in the run's mode, since only events change that. This
        // work cannot fail.
        let _ = self.work(Work::Complete);
        self.run.wants_dense = true;
        self.run.last_step(self.last_mode)
    }

    /// Mode and ends of the last step, as in [`Integration::last_step`], without the solution
    /// between them.
    pub(crate) fn last_ends(&self) -> (S::Mode, [Timed<N>; 2]) {
        let (from, to) = self.run.last;
        (self.last_mode, [from, to])
    }

    /// Continues until a step is to be taken, or an item is to be reported first. Returns whether
    /// it is a step.
    #[inline(always)]
    fn prepare(&mut self) -> Result<bool, Error> {
        match self.due {
            Due::Step => {}
            Due::Begin => {
                self.land();
                self.stepper.begin();
                self.leaves = self.run.orders != [0; G] && !self.run.is_prescribed;
                self.due = Due::Step;
            }
            Due::AfterStep => {
                self.run.check_escape()?;
                if self.run.orders != [0; G] {
                    self.work(Work::RecordDepartures)?;
                }
                self.due = Due::Step;
            }
            Due::PhaseEnd(_) => {
                self.run.check_escape()?;
                return Ok(false);
            }
            Due::Event | Due::Switch | Due::Accumulation | Due::End(_) => return Ok(false),
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

    /// Tries a step. Returns whether it was taken.
    #[inline(always)]
    fn advance(&mut self) -> Result<bool, Error> {
        if std::mem::take(&mut self.leaves) && self.leave_by_root()? {
            return Ok(true);
        }
        self.due = match self.work(Work::Advance) {
            Ok(Trial::NoStep) => return Ok(false),
            Ok(Trial::BeforeEnd) => {
                self.is_before_end = true;
                return Ok(false);
            }
            Ok(Trial::Step) => Due::AfterStep,
            Ok(Trial::Event) => Due::Event,
            Err(error) => {
                self.due = self.resolve_failure(error)?;
                return Ok(false);
            }
        };
        self.last_mode = self.mode;
        self.pile_up.follow(&self.run);
        Ok(true)
    }

    /// The state on the boundary of a guard, if the field is a root of the distance there.
    fn onto_root(&self, guard: usize) -> Result<Option<State<N>>, Error> {
        let onto = OntoRoot {
            run: &self.run,
            guard,
            is_followed: S::CONTACTS == 1,
        };
        self.system.with_flow(self.mode, self.branch, onto)
    }

    /// Takes the first step from a boundary at which the field is a root of the distance. Returns
    /// whether it is one.
    #[cold]
    fn leave_by_root(&mut self) -> Result<bool, Error> {
        let mut is_root = false;
        for guard in (0..G).filter(|&guard| self.run.orders[guard] != 0) {
            is_root |= self.onto_root(guard)?.is_some();
        }
        if !is_root {
            return Ok(false);
        }
        let Trial::Step = self.work(Work::Leave)? else {
            return Ok(false);
        };
        self.stepper.begin();
        self.due = Due::AfterStep;
        self.last_mode = self.mode;
        self.pile_up.follow(&self.run);
        Ok(true)
    }

    /// The next item to be reported before the next step.
    fn report(&mut self) -> Result<Progress<N, S::Mode>, Error> {
        if let (Due::Event | Due::Switch, Some(event)) = (self.due, self.run.event) {
            match self.conclude(&event) {
                Err(error) => {
                    let is_between = matches!(self.due, Due::Switch);
                    self.due = self.resolve_failure(error)?;
                    if is_between && let Due::Accumulation = self.due {
                        return Ok(self.transition_towards_accumulation(&event));
                    }
                }
                reported => return reported,
            }
        }
        match self.due {
            Due::Accumulation => Ok(self.step_to_accumulation()),
            Due::PhaseEnd(ending) => {
                let phase = self.phase_so_far();
                self.due = Due::End(ending);
                Ok(Progress::PhaseEnd(phase))
            }
            Due::End(ending) => Ok(Progress::End(self.summary(ending))),
            _ => self.step(),
        }
    }

    /// Does work on the flow of the mode.
    #[inline(always)]
    fn work(&mut self, work: Work) -> Result<Trial, Error> {
        let is_series = matches!((work, &self.stepper), (Work::Advance, Stepper::Taylor(_)));
        let expands = S::INTERPRETED && is_series;
        let repeated = expands.then(|| self.recordings.get_or_insert((self.mode, self.branch)));
        let on_flow = OnFlow {
            work,
            repeated,
            stepper: &mut self.stepper,
            run: &mut self.run,
        };
        self.system.with_flow(self.mode, self.branch, on_flow)
    }

    /// Projects the state onto Σ if a stick phase begins.
    fn land(&mut self) {
        if S::of_contacts(&self.mode).contains(&Mode::Stick) {
            let settled = Settled(self.run.at);
            self.run.at.x = self.system.with_flow(self.mode, self.branch, settled);
        }
    }

    /// The consequence of the event at the end of the last step.
    #[cold]
    fn conclude(&mut self, event: &Event<N>) -> Result<Progress<N, S::Mode>, Error> {
        self.run.check_escape()?;
        if let Due::Switch = self.due {
            return self.switch(event);
        }
        let mode = self.mode;
        let (guard, residual) = (event.guard, event.residual);
        // A slide that touches its end at a two-fold has no unique future.
        let contact = S::contact_of(guard);
        let ends = || {
            S::of_contacts(&mode)[contact] == Mode::Stick
                && two_fold(self.system, &self.run, mode, contact).is_some()
        };
        if event.is_touch && !ends() {
            self.record_event(contact, mode)?;
            self.run.orders[guard] = 2;
            self.due = Due::Step;
            let touch = (TransitionKind::Touch, contact);
            return Ok(Progress::Transition(self.transition(touch, mode, residual)));
        }
        let mut branch = self.branch;
        let Some(kind) = self.system.event_within_mode(guard, &mut branch) else {
            if let Some(x) = self.onto_root(guard)? {
                self.run.at.x = x;
            }
            self.due = Due::Switch;
            return Ok(Progress::PhaseEnd(self.phase_so_far()));
        };
        self.record_event(S::contact_of(guard), mode)?;
        self.branch = branch;
        self.run.orders[guard] = 1;
        self.due = Due::Begin;
        let within = self.transition((kind, S::contact_of(guard)), mode, residual);
        Ok(Progress::Transition(within))
    }

    /// Continues from the end of a phase to the next mode or to the end of the run.
    fn switch(&mut self, event: &Event<N>) -> Result<Progress<N, S::Mode>, Error> {
        let from = self.mode;
        if let Some(point) = self.sticking_point.take() {
            self.pile_up = PileUpDetector::new(&self.run.at, point.to, S::of_contacts);
            self.record_event(point.contact, point.to)?;
            (self.mode, self.branch) = (point.to, point.branch);
            self.run.orders = point.orders;
            self.run.from = self.run.at;
            self.due = Due::Begin;
            let entry = (TransitionKind::StickEntry, point.contact);
            return Ok(Progress::Transition(self.transition(entry, from, 0.0)));
        }
        // At a two-fold of one contact the rules would end the run, or rounding would decide how
        // long it sticks.
        if self.run.options.at_pile_up == AtPileUp::Rest
            && self.system.ending_of_pile_up(&self.run, from).is_some()
            && let Some(series) = self
                .pile_up
                .series_reached_at(event.at.t, &self.run.options)
        {
            return Err(self
                .pile_up
                .error(&event.at, Some(&series), false, &self.run.options));
        }
        let next = self
            .system
            .switch(&mut self.run, from, &mut self.branch, event)?;
        let (to, orders) = match next {
            Next::Mode(to, orders) => (to, orders),
            Next::End(ending) => {
                self.due = Due::End(ending);
                return Ok(Progress::End(self.summary(ending)));
            }
        };
        let contact = S::contact_of(event.guard);
        self.record_event(contact, to)?;
        self.mode = to;
        self.run.orders = orders;
        self.run.from = self.run.at;
        self.due = Due::Begin;
        let change = self.change_of(contact, from, event.residual);
        Ok(Progress::Transition(change))
    }

    /// The transition at the present state into the present mode, by a contact whose mode changes.
    pub(super) fn change_of(
        &self,
        contact: usize,
        from: S::Mode,
        residual: f64,
    ) -> Transition<N, S::Mode> {
        let [before, after] = [&from, &self.mode].map(|mode| S::of_contacts(mode)[contact]);
        let kind = TransitionKind::between(before, after);
        self.transition((kind, contact), from, residual)
    }

    /// A transition at the present state into the present mode.
    fn transition(
        &self,
        (kind, contact): (TransitionKind, usize),
        from: S::Mode,
        residual: f64,
    ) -> Transition<N, S::Mode> {
        let Timed { t, x } = self.run.at;
        Transition {
            t,
            x,
            kind,
            from,
            to: self.mode,
            contact,
            residual,
        }
    }

    /// Counts a transition of a contact into `mode`.
    pub(super) fn record_event(&mut self, contact: usize, mode: S::Mode) -> Result<(), Error> {
        self.run.record_event()?;
        let (at, options) = (&self.run.at, &self.run.options);
        let (system, branch, has_inputs) = (self.system, self.branch, self.has_inputs);
        let is_driven = || has_inputs || system.with_flow(mode, branch, IsDriven(at));
        if self.pile_up.record(at, (contact, mode), is_driven, options) {
            return Err(self.pile_up.error(at, None, false, options));
        }
        Ok(())
    }
}

/// Work on the flow of the mode.
struct OnFlow<'a, const N: usize, const G: usize> {
    work: Work,
    repeated: Option<&'a mut RecordedCalls<N, G>>,
    stepper: &'a mut Stepper<N, G>,
    run: &'a mut StepState<N, G>,
}

impl<const N: usize, const G: usize> UseFlow<N> for OnFlow<'_, N, G> {
    type Output = Result<Trial, Error>;

    #[inline(always)]
    fn with<F: Flow<N>>(self, flow: &F) -> Self::Output {
        self.stepper.work(self.work, self.run, flow, self.repeated)
    }
}

impl<S: Switched<N, G>, const N: usize, const G: usize> Integration<'_, S, N, G> {
    /// Present time.
    pub fn t(&self) -> f64 {
        self.run.at.t
    }

    /// Present state.
    pub fn x(&self) -> &State<N> {
        &self.run.at.x
    }

    /// The mode of the next step.
    pub fn mode(&self) -> S::Mode {
        self.mode
    }

    /// The phase under way so far; `None` between phases.
    pub fn phase(&self) -> Option<Phase<N, S::Mode>> {
        let is_open = !matches!(self.due, Due::Switch | Due::End(_));
        (is_open && self.run.from.t < self.run.at.t).then(|| self.phase_so_far())
    }

    /// Work done so far.
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
