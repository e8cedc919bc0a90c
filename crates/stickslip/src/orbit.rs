//! The result of a run: phases, transitions, and the solution at any time.

use crate::error::{Error, Point};
use crate::filippov::{EventRecord, Phase, StepRecord, Transition, Visibility};
use crate::system::{Mode, Side, State};

/// Work of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Steps accepted (an event cuts one short and counts as one).
    pub steps: u64,
    /// Steps rejected by error control.
    pub rejected: u64,
    /// Calls of the user's field, on any scalar, by steps, event location and the switching rules.
    /// Samples of the guards in stick do not count. With [`crate::Method::Taylor`]: one for every
    /// order of every series, and the rules. The call that checks each step and those of location
    /// do not count.
    pub field_calls: u64,
    /// Transitions.
    pub events: u64,
    /// Searches for the exact place of an event.
    pub locations: u64,
}

/// Ways to a two-fold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Approach {
    /// Sliding on Σ.
    Sliding,
    /// Crossings that accumulate.
    Crossings,
}

/// A two-fold at which a run has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TwoFold {
    /// Visibility of the tangency of the field below.
    pub below: Visibility,
    /// Visibility of the tangency of the field above.
    pub above: Visibility,
    /// Way of the orbit to it.
    pub approach: Approach,
}

impl TwoFold {
    /// Visibility of the tangency of the field of `side`.
    pub fn visibility(&self, side: Side) -> Visibility {
        match side {
            Side::Below => self.below,
            Side::Above => self.above,
        }
    }
}

/// Reason for the end of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// The end time was reached.
    EndTime,
    /// Σ repels at the last state: both fields lead away and the future is not unique
    /// (see [`crate::AtRepelling`]).
    Repelling,
    /// The orbit has reached a two-fold, where both fields are tangent to Σ and the future is not
    /// unique (see [`crate::AtRepelling`]).
    TwoFold(TwoFold),
    /// The orbit has shrunk to a point of Σ, where time does not move it. It circles there without
    /// end, and each phase moves the state by less, below the tolerance.
    Shrunk,
    /// The observer stopped the run, or a terminal event did
    /// ([`crate::EventFunctions::is_terminal`]).
    Stopped,
    /// The run failed; the orbit is what it computed before (see [`crate::Failure`]).
    Failed,
}

impl Ending {
    /// Whether the run ended because its future is not unique.
    pub fn is_ambiguous(self) -> bool {
        matches!(self, Ending::Repelling | Ending::TwoFold(_))
    }

    /// Whether the orbit cannot continue, though nothing stopped it.
    pub fn is_final(self) -> bool {
        self.is_ambiguous() || self == Ending::Shrunk
    }
}

/// End of a streamed run of a system of `N` states.
pub type Summary<const N: usize> = SummaryOf<State<N>>;

/// End of a streamed run; `X` is a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SummaryOf<X> {
    /// Reason for the end.
    pub ending: Ending,
    /// Last time.
    pub t: f64,
    /// Last state.
    pub x: X,
    /// Work done.
    pub counters: Counters,
}

impl<X> SummaryOf<X> {
    /// The error of an analysis that needs the orbit to continue after this ending.
    pub(crate) fn no_future_error(&self) -> Error
    where
        for<'x> Point: From<&'x X>,
    {
        let (t, x) = (self.t, Point::from(&self.x));
        match self.ending {
            Ending::Shrunk => Error::Shrunk { t, x },
            Ending::Stopped => Error::Stopped { t, x },
            _ => Error::NoUniqueFuture { t, x },
        }
    }

    /// Summary of a run that failed before its first step.
    pub(crate) fn before_first_step(t: f64, x: X) -> Self {
        SummaryOf {
            ending: Ending::Failed,
            t,
            x,
            counters: Counters::default(),
        }
    }
}

/// An orbit: phases and the transitions between them, with the solution of every step.
#[derive(Clone, Debug, PartialEq)]
pub struct Orbit<const N: usize, K = Mode> {
    /// Phases in order of time; a phase ends where the next begins.
    pub phases: Vec<Phase<N, K>>,
    /// Transitions in order of time. Every change of phase has one; most touches change none.
    pub transitions: Vec<Transition<N, K>>,
    /// Events of [`crate::solve_with_events`] in order of time.
    pub events: Vec<EventRecord<N, K>>,
    /// The steps in order of time.
    pub steps: Vec<StepRecord<N, K>>,
    /// Work done.
    pub counters: Counters,
    /// Reason for the end of the run.
    pub ending: Ending,
    /// First time.
    pub t_start: f64,
    /// Last time.
    pub t_end: f64,
    /// State at the start.
    pub x_start: State<N>,
    /// State at the end.
    pub x_end: State<N>,
}

impl<const N: usize, K> Orbit<N, K> {
    /// The orbit of a run before its first step.
    pub(crate) fn before_first_step(t: f64, x: State<N>) -> Self {
        Orbit {
            phases: Vec::new(),
            transitions: Vec::new(),
            events: Vec::new(),
            steps: Vec::new(),
            counters: Counters::default(),
            ending: Ending::Failed,
            t_start: t,
            t_end: t,
            x_start: x,
            x_end: x,
        }
    }

    /// The state at time `t`, from the dense output. At the steps' ends it is as accurate as the
    /// run. Between them it may err by up to some hundred tolerances where those are tight, except
    /// with [`crate::Method::Taylor`].
    ///
    /// # Errors
    /// [`Error::OutsideOrbit`] when the orbit does not cover `t`.
    pub fn at(&self, t: f64) -> Result<State<N>, Error> {
        if !(self.t_start..=self.t_end).contains(&t) {
            let (from, to) = (self.t_start, self.t_end);
            return Err(Error::OutsideOrbit { t, from, to });
        }
        let index = self.steps.partition_point(|step| step.t_end < t);
        Ok(match self.steps.get(index) {
            Some(step) if t == step.t_end => step.x_end,
            Some(step) => step.dense.at_time(t),
            None => self.x_end,
        })
    }

    /// The states at `times`, in any order.
    ///
    /// # Errors
    /// [`Error::OutsideOrbit`] for the first time that the orbit does not cover.
    pub fn sample(&self, times: impl IntoIterator<Item = f64>) -> Result<Vec<State<N>>, Error> {
        times.into_iter().map(|t| self.at(t)).collect()
    }
}

/// Start and end times of sticks. Phases are in order of time, each with whether it is a stick;
/// those that follow one another are one stick.
pub(crate) fn sticks_in(phases: impl Iterator<Item = (bool, f64, f64)>) -> Vec<(f64, f64)> {
    let mut sticks: Vec<(f64, f64)> = Vec::new();
    let mut stuck = false;
    for (sticks_now, t_start, t_end) in phases {
        match sticks.last_mut() {
            Some(last) if sticks_now && stuck => last.1 = t_end,
            _ if sticks_now => sticks.push((t_start, t_end)),
            _ => {}
        }
        stuck = sticks_now;
    }
    sticks
}

impl<const N: usize, const M: usize> Orbit<N, [Mode; M]> {
    /// Start and end times of a contact's sticks, whatever the others do meanwhile; empty for a
    /// contact that does not exist.
    pub fn sticks_of(&self, contact: usize) -> Vec<(f64, f64)> {
        let phases = self.phases.iter();
        sticks_in(phases.map(|phase| {
            let sticks = phase.mode.get(contact) == Some(&Mode::Stick);
            (sticks, phase.t_start, phase.t_end)
        }))
    }
}

impl<const N: usize> Orbit<N> {
    /// The stick phases.
    pub fn sticks(&self) -> impl Iterator<Item = &Phase<N>> {
        self.phases.iter().filter(|phase| phase.mode == Mode::Stick)
    }
}
