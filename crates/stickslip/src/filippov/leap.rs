//! Where an integration goes on otherwise than by its own events: at jumps, and at kinks of inputs.

use super::integration::{Due, Integration};
use super::observer::Transition;
use super::switched::{Switched, Velocity};
use super::taylor::GROW_MOST;
use crate::error::Error;
use crate::ode::Timed;
use crate::orbit::Ending;
use crate::system::{State, components};

impl<S: Switched<N, G>, const N: usize, const G: usize> Integration<'_, S, N, G> {
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
}
