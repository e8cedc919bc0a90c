//! An integration whose steps are searched for the user's own events.

use super::{EventFunctions, EventRecord, EventSearch};
use crate::error::Error;
use crate::filippov::flow::GUARDS;
use crate::filippov::integration::{Integration, Progress};
use crate::filippov::switched::Switched;
use crate::ode::Timed;
use crate::system::Mode;

/// Progress of a watched integration; see [`Watched::step`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum WatchedProgress<const N: usize, K = Mode> {
    /// Progress of the integration itself.
    Progress(Progress<N, K>),
    /// An event of the user's own in the last step.
    Event(EventRecord<N, K>),
}

/// An integration under way whose steps are searched for the zeros of the user's functions.
///
/// Every step is searched over its whole length on its dense output, in slip and in stick. Pairs of
/// zeros within a step are found however close they lie, down to the accuracy of the dense output.
/// Each is then located on the step itself, to rounding. The motion is bit-for-bit the same as
/// without. The [`crate::Counters`] do not contain this work.
pub(super) struct Watched<'a, S: Switched<N, G>, V, const N: usize, const G: usize = GUARDS> {
    integration: Integration<'a, S, N, G>,
    search: EventSearch<'a, S, &'a V, N, G>,
    events: &'a V,
    /// Number of events of the last step that have been reported.
    reported: usize,
}

impl<'a, S, V, const N: usize, const G: usize> Watched<'a, S, V, N, G>
where
    S: Switched<N, G>,
    V: EventFunctions<N>,
{
    /// Watches `integration` from its present state on.
    pub fn new(integration: Integration<'a, S, N, G>, events: &'a V) -> Self {
        Watched {
            search: EventSearch::new(integration.system, events, &integration.run.options),
            integration,
            events,
            reported: 0,
        }
    }

    /// Continues and returns what happened, in order of time. After a step come the events in it,
    /// then the end of the phase and the transition, if the step ends at one. A terminal event ends
    /// the step, the phase and, with [`crate::Ending::Stopped`], the run.
    ///
    /// # Errors
    /// Those of [`Integration::step`].
    #[inline]
    pub fn step(&mut self) -> Result<WatchedProgress<N, S::Mode>, Error> {
        if let Some(event) = self.search.last_events().get(self.reported) {
            self.reported += 1;
            return Ok(WatchedProgress::Event(*event));
        }
        let progress = self.integration.step()?;
        // Without functions a step needs no dense output.
        if self.events.count() > 0
            && let Progress::Step = progress
        {
            self.search.in_step(&self.integration.last_step());
            self.reported = 0;
            self.end_at_terminal();
        }
        Ok(WatchedProgress::Progress(progress))
    }

    fn end_at_terminal(&mut self) {
        let terminal = |event: &EventRecord<N, _>| self.events.is_terminal(event.number);
        let events = self.search.last_events();
        if let Some(first) = events.iter().position(terminal) {
            let EventRecord { t, x, .. } = events[first];
            self.search.truncate(first + 1);
            self.integration.stop_at(Timed { t, x });
        }
    }

    /// The integration itself.
    pub(super) fn integration_mut(&mut self) -> &mut Integration<'a, S, N, G> {
        &mut self.integration
    }
}
