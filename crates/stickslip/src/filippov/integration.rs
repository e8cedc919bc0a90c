//! The one loop: an integration that goes on step by step and says what happens.

use super::check::check;
use super::event::Event;
use super::flow::{CONTACT, MOST_GUARDS, Slip, Stick, project, sliding_field};
use super::observer::{Phase, StepRecord, Transition, TransitionKind};
use super::options::Options;
use super::pile_up::PileUp;
use super::rules::{Departure, Leading, LieDerivatives, departure};
use super::run::{Run, Trial};
use super::solve::Summary;
use super::stepper::{Stepper, Work};
use super::switch::{kind, next_mode};
use crate::dual::Dual;
use crate::error::Error;
use crate::ode::{Dense, Timed};
use crate::orbit::{Counters, Ending};
use crate::system::{Filippov, Mode, Side, State, components};

/// What happened in an integration; see [`Integration::step`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Progress<const N: usize> {
    /// A step was taken: [`Integration::last_step`].
    Step,
    /// A phase has ended at the end of the last step.
    PhaseEnd(Phase<N>),
    /// The mode changes, or Σ was touched, or contact lost or gained, at the end of the last step.
    Transition(Transition<N>),
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
pub struct Integration<'a, S, const N: usize> {
    pub(super) system: &'a S,
    pub(super) run: Run<N>,
    pub(super) stepper: Stepper<N>,
    /// Where the phase under way began.
    from: Timed<N>,
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
    /// Nothing: the run has ended.
    End(Ending),
}

impl<'a, S: Filippov<N>, const N: usize> Integration<'a, S, N> {
    /// An integration of `system` from `(t0, x0)` to `t_end`. The start may lie anywhere: on either side, on Σ, at a tangent point.
    ///
    /// # Errors
    /// [`Error::Option`], [`Error::Interval`], [`Error::StartOutsideDomain`] and [`Error::Escaped`].
    pub fn new(
        system: &'a S,
        t0: f64,
        x0: impl Into<State<N>>,
        t_end: f64,
        options: &Options,
    ) -> Result<Self, Error> {
        let start = Timed {
            t: t0,
            x: x0.into(),
        };
        Self::with_stepper(system, start, t_end, options, Stepper::new(options))
    }

    /// [`Integration::new`] with a stepper's room that another integration with the same options has left.
    pub(super) fn with_stepper(
        system: &'a S,
        start: Timed<N>,
        t_end: f64,
        options: &Options,
        stepper: Stepper<N>,
    ) -> Result<Self, Error> {
        check(system, &start, t_end, options)?;
        let run = Run {
            options: *options,
            counters: Counters::default(),
            pile_up: PileUp::new(),
            t_end,
            h: 0.0,
            at: start,
            mode: Mode::Stick,
            contact: contact_sign(system, &start),
            orders: [0; MOST_GUARDS],
            last: (Mode::Stick, start, start),
            dense: Dense::resting(start.t, start.x),
            event: None,
        };
        let mut integration = Integration {
            system,
            run,
            stepper,
            from: start,
            due: Due::Begin,
        };
        match integration.first_mode() {
            Some((mode, orders)) => (integration.run.mode, integration.run.orders) = (mode, orders),
            None => integration.due = Due::End(Ending::Repelling),
        }
        Ok(integration)
    }

    /// Takes the next step and says so, or says what the last one has led to, one thing a call: the end of a phase, then the
    /// transition behind it.
    ///
    /// # Errors
    /// [`Error::NonFinite`], [`Error::StepCollapse`], [`Error::EventPileUp`] and [`Error::Escaped`]; the integration stays where it
    /// has come to.
    #[inline]
    pub fn step(&mut self) -> Result<Progress<N>, Error> {
        loop {
            if let Some(progress) = self.prepare()? {
                return Ok(progress);
            }
            if self.advance()? {
                return Ok(Progress::Step);
            }
        }
    }

    /// Goes on to where a step is taken next, or to what is to be said before.
    #[inline(always)]
    pub(super) fn prepare(&mut self) -> Result<Option<Progress<N>>, Error> {
        match self.due {
            Due::Step => {}
            Due::Begin => {
                self.land();
                self.stepper.begin();
                self.due = Due::Step;
            }
            Due::Passed => {
                self.run.check_escape()?;
                if self.run.orders != [0; MOST_GUARDS] {
                    self.work(Work::NoteDepartures)?;
                }
                self.due = Due::Step;
            }
            Due::Event | Due::Switch => {
                if let Some(event) = self.run.event {
                    return self.conclude(&event).map(Some);
                }
            }
            Due::End(ending) => return Ok(Some(Progress::End(self.summary(ending)))),
        }
        if self.run.at.t >= self.run.t_end {
            self.due = Due::End(Ending::EndTime);
            return Ok(Some(Progress::PhaseEnd(self.phase_so_far())));
        }
        if self.stepper.needs_preparing() {
            self.work(Work::Prepare)?;
        }
        Ok(None)
    }

    /// Tries a step, and says whether it was taken.
    #[inline(always)]
    pub(super) fn advance(&mut self) -> Result<bool, Error> {
        self.due = match self.work(Work::Advance)? {
            Trial::NoStep => return Ok(false),
            Trial::Step => Due::Passed,
            Trial::Event => Due::Event,
        };
        Ok(true)
    }

    /// Does what depends on the mode, with the flow of the mode.
    #[inline(always)]
    fn work(&mut self, work: Work) -> Result<Trial, Error> {
        let (system, contact) = (self.system, self.run.contact);
        let (stepper, run) = (&mut self.stepper, &mut self.run);
        match run.mode {
            Mode::Slip(Side::Below) => {
                stepper.work(work, run, &Slip::<_, false> { system, contact })
            }
            Mode::Slip(Side::Above) => {
                stepper.work(work, run, &Slip::<_, true> { system, contact })
            }
            Mode::Stick => stepper.work(work, run, &Stick { system, contact }),
        }
    }

    /// A stick phase begins on Σ.
    fn land(&mut self) {
        if self.run.mode == Mode::Stick {
            let at = &mut self.run.at;
            at.x = project(self.system, at.t, at.x);
        }
    }

    /// What the event that the last step has come to leads to.
    #[cold]
    fn conclude(&mut self, event: &Event<N>) -> Result<Progress<N>, Error> {
        self.run.check_escape()?;
        if let Due::Switch = self.due {
            return self.switch(event);
        }
        let mode = self.run.mode;
        let (guard, residual) = (event.guard, event.residual);
        if event.is_touch {
            self.note_event(mode)?;
            self.run.orders[guard] = 2;
            self.due = Due::Step;
            let touch = self.transition(TransitionKind::Touch, mode, residual);
            return Ok(Progress::Transition(touch));
        }
        if guard != CONTACT {
            self.due = Due::Switch;
            return Ok(Progress::PhaseEnd(self.phase_so_far()));
        }
        self.note_event(mode)?;
        let kind = if self.run.contact > 0.0 {
            TransitionKind::ContactLoss
        } else {
            TransitionKind::ContactGain
        };
        self.run.contact = -self.run.contact;
        self.run.orders[CONTACT] = 1;
        self.due = Due::Begin;
        let change = self.transition(kind, mode, residual);
        Ok(Progress::Transition(change))
    }

    /// From the end of a phase to the next mode or to the end of the run.
    fn switch(&mut self, event: &Event<N>) -> Result<Progress<N>, Error> {
        let from = self.run.mode;
        let tangent = (from == Mode::Stick).then(|| Stick::<S>::side_of_guard(event.guard));
        let departure = self.departure(tangent);
        let Some((to, orders)) = next_mode(departure, self.run.options.at_repelling) else {
            self.due = Due::End(Ending::Repelling);
            return Ok(Progress::End(self.summary(Ending::Repelling)));
        };
        self.note_event(to)?;
        (self.run.mode, self.run.orders) = (to, orders);
        self.from = self.run.at;
        self.due = Due::Begin;
        Ok(Progress::Transition(self.transition(
            kind(from, to),
            from,
            event.residual,
        )))
    }

    /// A transition here, into the mode that the run is in now.
    fn transition(&self, kind: TransitionKind, from: Mode, residual: f64) -> Transition<N> {
        let Timed { t, x } = self.run.at;
        Transition {
            t,
            x,
            kind,
            from,
            to: self.run.mode,
            residual,
        }
    }

    /// Counts a transition into `mode`.
    fn note_event(&mut self, mode: Mode) -> Result<(), Error> {
        let Timed { t, x } = &self.run.at;
        let velocity = match mode {
            Mode::Slip(side) => self.system.field(side, *t, components(x)),
            Mode::Stick => sliding_field(self.system, *t, components(x)),
        };
        self.run.note_event(&velocity.into())
    }

    /// Off Σ the side decides; on it, to rounding, the rules.
    fn first_mode(&mut self) -> Option<(Mode, [usize; MOST_GUARDS])> {
        let Timed { t, x } = &self.run.at;
        let h = self.system.boundary(*t, components(x));
        let side = if h < 0.0 { Side::Below } else { Side::Above };
        if !LieDerivatives::new(self.system, side, *t, x, self.slack()).on_boundary() {
            return Some((Mode::Slip(side), [0; MOST_GUARDS]));
        }
        next_mode(self.departure(None), self.run.options.at_repelling)
    }

    /// A state this near to where it should be is there: a thousandth of what error control lets pass.
    fn slack(&self) -> f64 {
        1e-3 * self.run.options.atol
    }

    /// What a point of Σ leads to. `tangent` names the side whose normal component is known to vanish: a stick phase has
    /// just ended there.
    fn departure(&mut self, tangent: Option<Side>) -> Departure {
        let (slack, Timed { t, x }) = (self.slack(), self.run.at);
        let mut of = |side| {
            let leading = Leading::new(self.system, side, t, &x, slack, tangent == Some(side));
            self.run.counters.field_calls += leading.calls;
            leading
        };
        departure(of(Side::Below), of(Side::Above))
    }
}

impl<S, const N: usize> Integration<'_, S, N> {
    /// The time reached.
    pub fn t(&self) -> f64 {
        self.run.at.t
    }

    /// The state reached.
    pub fn x(&self) -> &State<N> {
        &self.run.at.x
    }

    /// The mode that the next step is taken in.
    pub fn mode(&self) -> Mode {
        self.run.mode
    }

    /// The last step, with the solution over it; of no length before the first.
    #[inline(always)]
    pub fn last_step(&self) -> StepRecord<N> {
        self.run.last_step()
    }

    /// The phase under way as far as it has come; `None` between phases.
    pub fn phase(&self) -> Option<Phase<N>> {
        let is_open = !matches!(self.due, Due::Switch | Due::End(_));
        (is_open && self.from.t < self.run.at.t).then(|| self.phase_so_far())
    }

    /// The work done so far.
    pub fn counters(&self) -> &Counters {
        &self.run.counters
    }

    fn phase_so_far(&self) -> Phase<N> {
        let (from, to) = (&self.from, &self.run.at);
        Phase {
            mode: self.run.mode,
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

/// Sign of the contact function; where it is zero, of its rate along the mean of the two fields.
fn contact_sign<S: Filippov<N>, const N: usize>(system: &S, at: &Timed<N>) -> f64 {
    let x = components(&at.x);
    let below = system.field(Side::Below, at.t, x);
    let above = system.field(Side::Above, at.t, x);
    let path = std::array::from_fn(|i| Dual::new(x[i], 0.5 * (below[i] + above[i])));
    match system.contact(Dual::new(at.t, 1.0), &path) {
        Some(contact) if contact.re < 0.0 || contact.re == 0.0 && contact.eps < 0.0 => -1.0,
        _ => 1.0,
    }
}
