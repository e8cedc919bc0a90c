//! An integration whose steps are searched for the user's own events.

use super::crossings::Crossings;
use super::over_step::OverStep;
use super::{EventFunctions, EventRecord};
use crate::error::Error;
use crate::filippov::flow::GUARDS;
use crate::filippov::integration::{Integration, Progress};
use crate::filippov::observer::StepRecord;
use crate::filippov::switched::Switched;
use crate::ode::Timed;
use crate::system::{Mode, State};

/// What happened in an integration that is watched; see [`Watched::step`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Happening<const N: usize, K = Mode> {
    /// What the integration itself has to say.
    Progress(Progress<N, K>),
    /// An event of the user's own in the last step.
    Event(EventRecord<N, K>),
}

/// An integration under way whose steps are searched for the zeros of the user's functions.
///
/// Every step is searched over all its length, as for the solver's own events, by slip and by stick: pairs of zeros within a step are
/// seen however close they lie, down to the accuracy of the dense output. Each is then located on the step itself, to rounding. The
/// motion is the same, to the last bit, as without. The work is not in the [`crate::Counters`].
///
/// ```
/// use stickslip::{Direction, Happening, Integration, Options, Plane, Progress, Watched, models::BeltOscillator};
///
/// let belt = BeltOscillator::default();
/// let integration = Integration::new(&belt, 0.0, [0.5, 1.5], 20.0, &Options::default())?;
/// let section = Plane { point: [0.0, 0.0].into(), normal: [1.0, 0.0].into(), direction: Direction::Rising };
/// let mut watched = Watched::new(integration, &section);
/// let mut times = Vec::new();
/// loop {
///     match watched.step()? {
///         Happening::Event(event) => times.push(event.t),
///         Happening::Progress(Progress::End(_)) => break,
///         Happening::Progress(_) => {}
///     }
/// }
/// assert_eq!(times.len(), 2);
/// # Ok::<(), stickslip::Error>(())
/// ```
pub struct Watched<
    'a,
    S: Switched<N, G>,
    V,
    const N: usize,
    const E: usize,
    const G: usize = GUARDS,
> {
    integration: Integration<'a, S, N, G>,
    events: &'a V,
    /// Sign that each function has had last; 0 where that is not known yet.
    sides: [f64; E],
    /// How large the components of the state have been lately.
    size: State<N>,
    /// What is to be told of the last step, the latest first.
    due: Vec<EventRecord<N, S::Mode>>,
    /// Whether a terminal event ends the run.
    may_end: bool,
}

impl<'a, S, V, const N: usize, const E: usize, const G: usize> Watched<'a, S, V, N, E, G>
where
    S: Switched<N, G>,
    V: EventFunctions<N, E>,
{
    /// Watches `integration` from where it stands.
    pub fn new(integration: Integration<'a, S, N, G>, events: &'a V) -> Self {
        Watched {
            size: integration.x().abs(),
            integration,
            events,
            sides: [0.0; E],
            due: Vec::new(),
            may_end: true,
        }
    }

    /// Goes on behind terminal events, too.
    pub(crate) fn endless(self) -> Self {
        Watched {
            may_end: false,
            ..self
        }
    }

    /// Goes on and says what happened, in order of time: a step, then the events in it, then the end of the phase and the
    /// transition, if the step ends at one. A terminal event ends the step, the phase and, with [`crate::Ending::Stopped`], the run.
    ///
    /// # Errors
    /// Those of [`Integration::step`].
    #[inline]
    pub fn step(&mut self) -> Result<Happening<N, S::Mode>, Error> {
        if let Some(event) = self.due.pop() {
            return Ok(Happening::Event(event));
        }
        let progress = self.integration.step()?;
        // Without functions a step needs no dense output.
        if E > 0
            && let Progress::Step = progress
        {
            self.search();
        }
        Ok(Happening::Progress(progress))
    }

    /// Searches the last step.
    fn search(&mut self) {
        let step = self.integration.last_step();
        // A step of no length holds nothing that the next one does not.
        if step.t_end <= step.t_start {
            return;
        }
        for i in 0..N {
            let now = f64::max(step.x_start[i].abs(), step.x_end[i].abs());
            self.size[i] = now.max(0.5 * self.size[i]);
        }
        let due = &mut self.due;
        for number in 0..E {
            let asked = self.events.direction(number);
            let over = OverStep {
                system: self.integration.system,
                events: self.events,
                number,
                step: &step,
                method: self.integration.run.options.method,
                size: &self.size,
            };
            let side = self.sides[number];
            let mut crossings = Crossings::<S, V, _, N, G, E> { over, side };
            crossings.each(&mut |place, direction| {
                if asked.includes(direction) {
                    due.push(EventRecord {
                        number,
                        t: place.at.t,
                        x: place.at.x,
                        mode: step.mode,
                        direction,
                        rate: place.rate,
                    });
                }
            });
            self.sides[number] = crossings.side;
        }
        due.sort_by(|one, other| (other.t.total_cmp(&one.t)).then(other.number.cmp(&one.number)));
        let (may_end, events) = (self.may_end, self.events);
        let terminal = |event: &EventRecord<N, _>| may_end && events.is_terminal(event.number);
        if let Some(first) = due.iter().rposition(terminal) {
            due.drain(..first);
            let (t, x) = (due[0].t, due[0].x);
            self.integration.stop_at(Timed { t, x });
        }
    }

    /// The integration, for what can be asked of it.
    pub fn integration(&self) -> &Integration<'a, S, N, G> {
        &self.integration
    }

    /// The integration, to be watched no longer, or otherwise.
    pub(crate) fn into_integration(self) -> Integration<'a, S, N, G> {
        self.integration
    }

    /// The last step, which ends at a terminal event, if it has one.
    pub fn last_step(&mut self) -> StepRecord<N, S::Mode> {
        self.integration.last_step()
    }

    pub(super) fn integration_mut(&mut self) -> &mut Integration<'a, S, N, G> {
        &mut self.integration
    }
}
