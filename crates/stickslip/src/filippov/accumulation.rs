//! Accumulation of transitions: the way to the accumulation point, and what follows.

use super::flow::Flow;
use super::guard::Event;
use super::integration::{Due, Integration, Progress};
use super::options::AtPileUp;
use super::pile_up::GeometricSeries;
use super::root_law::Reached;
use super::switched::{Switched, UseFlow};
use crate::error::{ContactFault, Error};
use crate::ode::{Dense, Dop853, Timed, step_end};
use crate::orbit::Ending;

/// The state to which the motion leads at a time, in one step.
struct StepTo<const N: usize> {
    from: Timed<N>,
    t: f64,
}

impl<const N: usize> UseFlow<N> for StepTo<N> {
    type Output = Timed<N>;

    fn with<F: Flow<N>>(self, flow: &F) -> Timed<N> {
        let (Timed { t, x }, h) = (self.from, self.t - self.from.t);
        let slope = flow.velocity(t, &x);
        let x = step_end::<Dop853, _>(&mut |t, x| flow.velocity(t, x), t, &x, slope, h);
        Timed { t: self.t, x }
    }
}

impl<S: Switched<N, G>, const N: usize, const G: usize> Integration<'_, S, N, G> {
    /// Interprets a failed step: an event that no step resolves, a pile-up or an ending. Otherwise
    /// returns the error.
    #[cold]
    pub(super) fn resolve_failure(&mut self, error: Error) -> Result<Due, Error> {
        let (t, options) = (self.run.at.t, &self.run.options);
        // Near an accumulation point, the tolerance does not separate contacts, and rounding does
        // not separate steps.
        let series = match &error {
            Error::EventPileUp { .. } => return self.resolve_pile_up(self.pile_up.series()),
            Error::StepCollapse { .. } | Error::TimeRounding { .. } => {
                self.pile_up.series_reached_at(t, options)
            }
            Error::Contacts {
                fault: ContactFault::NoUniqueMode { contacts, .. },
                ..
            } => self.pile_up.series_of_contacts(t, contacts),
            _ => None,
        };
        let has_collapsed = matches!(error, Error::StepCollapse { .. });
        if series.is_some() {
            let due = self.resolve_pile_up(series)?;
            if has_collapsed {
                // What follows has nothing to do with such steps.
                self.run.h = 0.0;
            }
            return Ok(due);
        }
        let step = match error {
            Error::StepCollapse { step, .. } | Error::TimeRounding { step, .. } => step,
            _ => return Err(error),
        };
        let mut guard = self.system.guard_at_collapse(&self.run, self.mode);
        if guard.is_none() {
            let run = &self.run;
            guard = (self.system).with_flow(self.mode, self.branch, Reached { run, step });
            if guard.is_some() {
                self.run.h = 0.0;
            }
        }
        if let Some(guard) = guard {
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

    /// Continuation of a pile-up: stick at the accumulation point, an ending, or the error.
    pub(super) fn resolve_pile_up(
        &mut self,
        series: Option<GeometricSeries<N>>,
    ) -> Result<Due, Error> {
        let rest = |series: &GeometricSeries<N>| {
            let of = self.rests.iter();
            let of = of.filter(|(jump, _)| series.contacts.contains(jump));
            let next: Vec<usize> = of.map(|(_, next)| *next).collect();
            (!next.is_empty()).then_some((series.at.t, next))
        };
        if let Some(landing) = series.as_ref().and_then(rest) {
            self.landing = Some(landing);
            return Ok(Due::Accumulation);
        }
        let point = series.as_ref().and_then(|series| {
            // Other jumps hold nothing.
            let contacts = series.contacts.iter().copied();
            let contacts: Vec<usize> = contacts.filter(|one| *one < self.contacts).collect();
            let run = &mut self.run;
            let point = (!contacts.is_empty()).then(|| {
                self.system
                    .stick_at_accumulation(run, self.mode, &contacts, &series.at)
            });
            let point = point.flatten()?;
            let distance = (point.at.x - series.at.x).amax();
            (distance <= series.distance + run.slack()).then_some(point)
        });
        let holds = point.is_some();
        if holds && self.run.options.at_pile_up == AtPileUp::Rest {
            self.sticking_point = point;
            return Ok(Due::Accumulation);
        }
        // A two-fold is approached by crossings alone.
        let has_jumps = self.pile_up.has_one_of(self.contacts..usize::MAX);
        let two_fold = match has_jumps {
            true => None,
            false => self.system.ending_of_pile_up(&self.run, self.mode),
        };
        let shrinks = series.is_none() && self.pile_up.shrinks(&self.run.options);
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

    /// Whether the last step leads to the point where transitions accumulate.
    pub(crate) fn accumulates(&self) -> bool {
        self.sticking_point.is_some() || self.landing.is_some()
    }

    /// The transition at the event after which the run goes to the accumulation point.
    pub(super) fn transition_towards_accumulation(
        &mut self,
        event: &Event<N>,
    ) -> Progress<N, S::Mode> {
        let from = self.mode;
        self.mode = self.pile_up.mode_after(event.at.t).unwrap_or(from);
        self.run.from = self.run.at;
        Progress::Transition(self.change_of(S::contact_of(event.guard), from, event.residual))
    }

    /// The step to the accumulation point, or as far as the run goes.
    pub(super) fn step_to_accumulation(&mut self) -> Progress<N, S::Mode> {
        let from = self.run.at;
        let sticking = self.sticking_point.as_ref();
        let sticking = sticking.map(|point| (point.at, Some(point.contact)));
        // The motion between impacts leads there, and the landing that follows removes what is left
        // of gap and rate. A state that is extrapolated would have the noise of the series in all
        // components.
        let landing = self.landing.as_ref().map(|(t, _)| match *t > from.t {
            true => (self.with_flow(StepTo { from, t: *t }), None),
            false => (from, None),
        });
        let Some((to, contact)) = sticking.or(landing) else {
            return Progress::End(self.summary(Ending::Failed));
        };
        let to = Timed {
            t: to.t.max(from.t),
            ..to
        };
        self.stepper.begin();
        self.run.dense = Dense::straight(&from, &to);
        self.run.counters.steps += 1;
        self.last_mode = self.mode;
        if to.t > self.run.t_end {
            self.landing = None;
            let t = self.run.t_end;
            let x = self.run.dense.at_time(t);
            self.run.accept(Timed { t, x }, None);
            self.due = Due::PhaseEnd(Ending::EndTime);
            return Progress::Step;
        }
        let event = contact.map(|guard| Event {
            guard,
            at: to,
            is_touch: false,
            residual: 0.0,
        });
        self.run.accept(to, event.as_ref());
        self.due = Due::Event;
        Progress::Step
    }
}
