//! What a run carries from step to step, and what can go wrong with a step.

use super::event::Event;
use super::flow::Flow;
use super::leaving::has_left;
use super::observer::StepRecord;
use super::options::Options;
use super::switched::Switched;
use crate::error::{Error, Point};
use crate::ode::control::first_step;
use crate::ode::{Dense, Timed};
use crate::orbit::Counters;
use crate::system::State;

/// Steps shorter than this part of the time no longer move it.
pub(crate) const SHORTEST: f64 = 4.0 * f64::EPSILON;

/// What a run carries from step to step, whatever makes the steps.
pub struct Run<const N: usize, const G: usize> {
    pub options: Options,
    /// How many of the type's states the system has.
    pub states: usize,
    pub counters: Counters,
    pub t_end: f64,
    /// Next step to try; 0 until the first is chosen. It is kept over events: the new field is usually as fast as the
    /// old, and error control corrects it where it is not.
    pub h: f64,
    /// Where the phase under way began.
    pub from: Timed<N>,
    /// Where the last step ended.
    pub at: Timed<N>,
    /// How many derivatives of each guard vanish where it was last zero and has not left that yet; 0 elsewhere.
    pub orders: [usize; G],
    /// The last step's start and end (which [`Run::at`] leaves when a stick phase begins on Σ), and the solution over it.
    pub last: (Timed<N>, Timed<N>),
    pub dense: Dense<N>,
    /// Whether the step before was asked for: then the next one gets its dense output at once, and so does the first.
    pub wants_dense: bool,
    /// The last event.
    pub event: Option<Event<N>>,
    /// Whether the mode is kept, whatever its guards do.
    pub is_held: bool,
}

/// What came of a try to step.
#[derive(Clone, Copy)]
pub enum Trial {
    /// It was only prepared, or rejected: another try follows.
    NoStep,
    /// A step was taken, the run's last one now.
    Step,
    /// A step was taken that ends at an event, the run's last one now.
    Event,
}

impl<const N: usize, const G: usize> Run<N, G> {
    /// A run of a system of so many states that has yet to begin.
    ///
    /// # Errors
    /// Those of a run that cannot begin.
    pub(crate) fn checked<S: Switched<N, G>>(
        system: &S,
        (start, states): (Timed<N>, usize),
        t_end: f64,
        options: &Options,
    ) -> Result<Self, Error> {
        system.check(&start, t_end, options)?;
        let run = Run {
            options: *options,
            states,
            counters: Counters::default(),
            t_end,
            h: 0.0,
            at: start,
            from: start,
            orders: [0; G],
            last: (start, start),
            dense: Dense::resting(start.t, start.x),
            wants_dense: true,
            event: None,
            is_held: false,
        };
        run.check_escape()?;
        Ok(run)
    }

    /// Takes the step to `at`, and the event there, as the last one.
    #[inline(always)]
    pub(crate) fn accept(&mut self, at: Timed<N>, event: Option<&Event<N>>) -> Trial {
        self.last = (self.at, at);
        self.at = at;
        // Nothing is moved that is not there: this is done once a step.
        let Some(event) = event else {
            return Trial::Step;
        };
        self.event = Some(*event);
        Trial::Event
    }

    /// The last step, in this mode; of no length before the first.
    #[inline(always)]
    pub(crate) fn last_step<K>(&self, mode: K) -> StepRecord<N, K> {
        let (from, to) = self.last;
        StepRecord {
            mode,
            t_start: from.t,
            t_end: to.t,
            x_start: from.x,
            x_end: to.x,
            dense: self.dense,
        }
    }

    /// The first step to try from `(t, x)`.
    pub(crate) fn choose_first_step(
        &self,
        field: &mut dyn FnMut(f64, &State<N>) -> State<N>,
        t: f64,
        x: &State<N>,
        slope: &State<N>,
    ) -> f64 {
        let longest = self.options.longest_step.min(self.t_end - t);
        if let Some(step) = self.options.fixed_step().or(self.options.first_step) {
            return step.min(longest);
        }
        // A state that is nearly zero asks for less than moves the time, though nothing is singular there.
        let chosen = first_step(
            field,
            t,
            x,
            slope,
            (&self.options.tolerance(), self.states),
            longest,
        );
        chosen.max(2.0 * SHORTEST * t.abs())
    }

    /// Length of the next step and whether it ends at the end time: a last step is stretched a little rather than followed by
    /// one of rounding's length.
    #[inline(always)]
    pub(crate) fn next_step(&self) -> (f64, bool) {
        let (t, h) = (self.at.t, self.h.min(self.options.longest_step));
        if t + 1.01 * h >= self.t_end {
            (self.t_end - t, true)
        } else {
            (h, false)
        }
    }

    /// Whether a step no longer moves the time.
    #[inline(always)]
    pub(crate) fn is_too_short(&self, h: f64, is_last: bool) -> bool {
        !is_last && h <= SHORTEST * self.at.t.abs() || h < f64::MIN_POSITIVE
    }

    /// The step shrank until time no longer moves.
    pub(crate) fn collapse(&self, slope: &State<N>, step: f64) -> Error {
        if slope.iter().any(|v| !v.is_finite()) {
            return self.non_finite(step);
        }
        Error::StepCollapse {
            t: self.at.t,
            x: Point::from(&self.at.x),
            step,
            rtol: self.options.rtol,
            atol: self.options.atol,
        }
    }

    /// The state is no number at the end of a step.
    pub(crate) fn non_finite(&self, step: f64) -> Error {
        let (t, x) = (self.at.t, Point::from(&self.at.x));
        Error::NonFinite { t, x, step }
    }

    /// Shortens the next step after one on which the field was not defined throughout.
    pub(crate) fn reject_undefined(&mut self, step: f64) -> Result<(), Error> {
        if self.options.fixed_step().is_some() {
            return Err(self.non_finite(step));
        }
        self.counters.rejected += 1;
        self.h = 0.1 * step;
        Ok(())
    }

    /// A state this near to where it should be is there: a thousandth of what error control lets pass.
    pub(crate) fn slack(&self) -> f64 {
        1e-3 * self.options.atol
    }

    pub(crate) fn check_escape(&self) -> Result<(), Error> {
        let bound = self.options.escape;
        let mut states = self.at.x.iter().take(self.states);
        if states.all(|v| v.abs() <= bound) {
            return Ok(());
        }
        Err(Error::Escaped {
            t: self.at.t,
            x: Point::from(&self.at.x),
            bound,
        })
    }

    #[inline(always)]
    pub(crate) fn check_steps(&self) -> Result<(), Error> {
        self.check_most(self.counters.steps, self.options.most_steps, "most_steps")
    }

    #[inline(always)]
    fn check_most(&self, count: u64, most: u64, name: &'static str) -> Result<(), Error> {
        if count <= most {
            return Ok(());
        }
        let Timed { t, x } = &self.at;
        let x = Point::from(x);
        Err(Error::TooMany {
            name,
            most,
            t: *t,
            x,
        })
    }

    /// Counts a transition.
    pub(crate) fn note_event(&mut self) -> Result<(), Error> {
        self.counters.events += 1;
        self.check_most(
            self.counters.events,
            self.options.most_events,
            "most_events",
        )
    }

    /// Notes which guards have left their zero by now.
    pub(crate) fn note_departures<F: Flow<N>>(&mut self, flow: &F) {
        for &guard in F::GUARDS {
            let departs = self.orders[guard] > 0;
            if departs && has_left::<F, N>(flow, guard, &self.at, &self.options) {
                self.orders[guard] = 0;
            }
        }
    }
}
