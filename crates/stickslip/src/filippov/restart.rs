//! Restarts of an integration that are not its own events: at jumps of the state and kinks of
//! inputs.

use super::integration::{Due, Integration};
use super::observer::Transition;
use super::options::Options;
use super::pile_up::{GeometricSeries, PileUpDetector};
use super::switched::{Next, Switched, UseFlow, Velocity};
use super::taylor::MAX_GROWTH;
use crate::error::Error;
use crate::ode::Timed;
use crate::orbit::Ending;
use crate::system::{Mode, State, components};

impl<S: Switched<N, G>, const N: usize, const G: usize> Integration<'_, S, N, G> {
    /// Cuts the last step at a state inside it, where the run ends.
    pub(crate) fn stop_at(&mut self, at: Timed<N>) {
        self.run.at = at;
        self.run.last.1 = at;
        self.pile_up.follow_cut(&self.run);
        self.due = Due::PhaseEnd(Ending::Stopped);
    }

    /// Goes on from a state that differs from the present one by errors.
    pub(crate) fn move_to(&mut self, x: State<N>) {
        if let Due::Begin | Due::Step | Due::AfterStep = self.due {
            self.run.at.x = x;
            self.due = Due::Begin;
        }
    }

    /// Sets the end time of the run. Behind an earlier one an input moves the state again.
    pub(crate) fn end_at(&mut self, t_end: f64) {
        self.has_inputs |= t_end < self.run.t_end;
        self.run.t_end = t_end;
    }

    /// Whether the end time is reached and nothing else is to be reported first.
    pub(crate) fn is_at_end(&self) -> bool {
        let goes_on = matches!(self.due, Due::Begin | Due::Step | Due::AfterStep);
        goes_on && self.run.at.t >= self.run.t_end
    }

    /// Whether the end of a phase is reported next.
    pub(crate) fn ends_phase(&self) -> bool {
        matches!(self.due, Due::PhaseEnd(_))
    }

    /// Errors of a component of the state within the tolerance.
    pub(crate) fn slack(&self) -> f64 {
        self.run.slack()
    }

    /// The present moment.
    pub(crate) fn at(&self) -> Timed<N> {
        self.run.at
    }

    /// Options of the run.
    pub(crate) fn options(&self) -> &Options {
        &self.run.options
    }

    /// Number of states of the system.
    pub(crate) fn states(&self) -> usize {
        self.run.states
    }

    /// Whether the run has ended, or ends next.
    pub(crate) fn has_ended(&self) -> bool {
        matches!(self.due, Due::End(_))
    }

    /// Whether it stays in its mode regardless of the guards.
    pub(crate) fn is_prescribed(&self) -> bool {
        self.run.is_prescribed
    }

    /// Numbers jumps from here on: the system has so many contacts, and its type may have more.
    /// `rests` pairs each jump that comes to rest where it accumulates with the jump that follows.
    pub(crate) fn number_jumps_from(&mut self, contacts: usize, rests: Vec<(usize, usize)>) {
        self.contacts = contacts;
        self.rests = rests;
    }

    /// Ends the step to an accumulation point of jumps, where others follow: their numbers.
    pub(crate) fn take_landing(&mut self) -> Option<Vec<usize>> {
        let (_, numbers) = self.landing.take()?;
        self.due = Due::PhaseEnd(Ending::Stopped);
        self.pile_up = PileUpDetector::new(&self.run.at, self.mode, S::of_contacts);
        Some(numbers)
    }

    /// Continues from another state at the same time, or ends there. The mode is decided as at a
    /// start. This counts as a transition of a contact with that number.
    ///
    /// # Errors
    /// Those of [`Integration::new`], and of [`Integration::step`] about too many transitions.
    pub(crate) fn restart_at(
        &mut self,
        number: usize,
        x: State<N>,
        ending: Option<Ending>,
    ) -> Result<(), Error> {
        self.run.at.x = x;
        // The motion after a jump may be as fast as the last step was short.
        let (from, to) = &self.run.last;
        self.run.h = self.run.h.min(MAX_GROWTH * (to.t - from.t));
        self.begin_phase();
        let from = self.mode;
        self.decide_mode()?;
        // Where contacts and jumps accumulate, rounding would decide that a contact sticks.
        let begins_to_stick = |&contact: &usize| {
            let [before, after] = [&from, &self.mode].map(|modes| S::of_contacts(modes)[contact]);
            before != Mode::Stick && after == Mode::Stick
        };
        let sticking: Vec<usize> = (0..self.contacts).filter(begins_to_stick).collect();
        if ending.is_none()
            && let Some(series) = self.series_reached_of(&sticking)
        {
            self.mode = self.pile_up.mode_after(self.run.at.t).unwrap_or(from);
            self.due = self.resolve_pile_up(Some(series))?;
            return Ok(());
        }
        // A jump that recurs at the same time belongs to a pile-up.
        if self.pile_up.is_last(number, self.run.at.t) {
            return self.end_pile_up();
        }
        match self.record_event(number, self.mode) {
            Err(Error::EventPileUp { .. }) if !self.pile_up.shrinks(&self.run.options) => {
                self.due = self.resolve_pile_up(self.pile_up.series())?;
            }
            // A clock may trigger jumps of a state that does not move.
            Err(Error::EventPileUp { .. }) | Ok(()) => {}
            Err(other) => return Err(other),
        }
        if let Some(ending) = ending {
            self.due = Due::End(ending);
        }
        Ok(())
    }

    /// Ends the run, or goes on in stick, if the transitions form a series with this jump that ends
    /// here.
    ///
    /// # Errors
    /// [`Error::EventPileUp`].
    pub(crate) fn end_accumulation_of(&mut self, jump: usize) -> Result<(), Error> {
        if let Some(series) = self.series_reached_of(&[jump]) {
            self.due = self.resolve_pile_up(Some(series))?;
        }
        Ok(())
    }

    /// The series of the last transitions, if it ends here and has one of these contacts or jumps.
    fn series_reached_of(&self, any: &[usize]) -> Option<GeometricSeries<N>> {
        if any.is_empty() {
            return None;
        }
        let (t, options) = (self.run.at.t, &self.run.options);
        let series = self.pile_up.series_reached_at(t, options);
        series.filter(|series| any.iter().any(|one| series.contacts.contains(one)))
    }

    /// Continues where the field jumps at this time. The state may differ in the values that inputs
    /// hold. Returns the transition, if a contact changes its mode.
    ///
    /// # Errors
    /// Those of [`Integration::new`].
    pub(crate) fn restart_at_kink(
        &mut self,
        x: State<N>,
    ) -> Result<Option<Transition<N, S::Mode>>, Error> {
        self.run.at.x = x;
        let from = self.mode;
        if self.run.is_prescribed {
            self.due = Due::Begin;
            return Ok(None);
        }
        self.decide_mode()?;
        let modes = [&from, &self.mode].map(S::of_contacts);
        let Some(contact) = modes[0].iter().zip(modes[1]).position(|(a, b)| a != b) else {
            return Ok(None);
        };
        self.record_event(contact, self.mode)?;
        Ok(Some(self.change_of(contact, from, 0.0)))
    }

    /// Work with the flow of the present mode.
    pub(crate) fn with_flow<U: UseFlow<N>>(&self, work: U) -> U::Output {
        self.system.with_flow(self.mode, self.branch, work)
    }

    /// The velocity at the present state.
    pub(crate) fn velocity(&self) -> State<N> {
        let Timed { t, x } = self.run.at;
        let velocity = Velocity(t, components(&x));
        State::from(self.with_flow(velocity))
    }

    /// Largest motion of the state where the next step begins: onto the manifold of a stick.
    pub(crate) fn distance_to_settle(&self) -> f64 {
        match S::of_contacts(&self.mode).contains(&Mode::Stick) {
            true => self.run.slack(),
            false => 0.0,
        }
    }

    /// Goes to the point where the last transitions accumulate.
    ///
    /// # Errors
    /// [`Error::EventPileUp`] if nothing holds there.
    pub(crate) fn end_pile_up(&mut self) -> Result<(), Error> {
        self.due = self.resolve_pile_up(self.pile_up.series())?;
        Ok(())
    }

    /// Whether the last transitions form a series with this jump, whose end is not past.
    pub(crate) fn is_in_series(&self, jump: usize) -> bool {
        let series = self.pile_up.series();
        series.is_some_and(|series| {
            series.contacts.contains(&jump) && series.at.t + series.uncertainty >= self.run.at.t
        })
    }

    /// Begins a phase at the present state.
    pub(crate) fn begin_phase(&mut self) {
        self.run.from = self.run.at;
    }

    /// Decides the mode as at a start.
    fn decide_mode(&mut self) -> Result<(), Error> {
        if self.run.at.t < self.run.t_end {
            let (at, t_end) = (self.run.at, self.run.t_end);
            self.system.check(&at, t_end, &self.run.options)?;
        }
        self.due = match self.system.first_mode(&mut self.run)? {
            Next::Mode(mode, orders) => {
                self.mode = mode;
                self.run.orders = orders;
                Due::Begin
            }
            Next::End(ending) => Due::End(ending),
        };
        self.branch = self.system.branch(self.mode, &self.run.at);
        Ok(())
    }
}
