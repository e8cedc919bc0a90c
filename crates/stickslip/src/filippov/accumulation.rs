//! Where transitions of an integration accumulate: what follows, and the way there.

use super::event::Event;
use super::integration::{Due, Integration, Progress};
use super::observer::TransitionKind;
use super::options::AtPileUp;
use super::pile_up::Series;
use super::switched::Switched;
use crate::error::Error;
use crate::ode::{Dense, Timed};
use crate::orbit::Ending;

impl<S: Switched<N, G>, const N: usize, const G: usize> Integration<'_, S, N, G> {
    /// What a step that has failed means: an event that no step resolves, a pile-up or an ending;
    /// if it is none, the error.
    #[cold]
    pub(super) fn after(&mut self, error: Error) -> Result<Due, Error> {
        let (t, options) = (self.run.at.t, &self.run.options);
        // Near an accumulation point contacts are not told apart by tolerance any more, nor steps
        // by rounding.
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
    pub(super) fn on_the_way(&mut self, event: &Event<N>) -> Progress<N, S::Mode> {
        let from = self.mode;
        self.mode = self.pile_up.mode_after(event.at.t).unwrap_or(from);
        self.run.from = self.run.at;
        let contact = S::contact_of(event.guard);
        let of = |mode| S::erased(mode, S::CONTACTS).get(contact);
        let kind = TransitionKind::between(of(from), of(self.mode));
        self.transition((kind, contact), from, event.residual)
    }

    /// The step to where transitions accumulate, or as far as the run goes.
    pub(super) fn come_to_rest(&mut self) -> Progress<N, S::Mode> {
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
}
