//! A whole orbit with the user's own events.

use super::{EventFunctions, EventRecord, Watched, WatchedProgress};
use crate::filippov::integration::Integration;
use crate::filippov::options::Options;
use crate::filippov::solve::{Failure, store};
use crate::filippov::switched::Switched;
use crate::orbit::Orbit;
use crate::system::{IntoState, Mode};

/// An orbit, and the events that were watched for along it.
#[derive(Clone, Debug, PartialEq)]
pub struct OrbitWithEvents<const N: usize, K = Mode> {
    /// The orbit, up to the first terminal event.
    pub orbit: Orbit<N, K>,
    /// The events in order of time.
    pub events: Vec<EventRecord<N, K>>,
}

/// [`crate::solve`], with the zeros of the user's own functions: see [`EventFunctions`], and
/// [`crate::EventSearch`] for a run that keeps nothing.
///
/// # Errors
/// As [`crate::solve`]; [`Failure::partial`] is the orbit up to the failure with its events.
pub fn solve_with_events<S, V, const N: usize, const G: usize>(
    system: &S,
    events: &V,
    t0: f64,
    x0: impl IntoState<N>,
    t_end: f64,
    options: &Options,
) -> Result<OrbitWithEvents<N, S::Mode>, Failure<OrbitWithEvents<N, S::Mode>>>
where
    S: Switched<N, G>,
    V: EventFunctions<N>,
{
    let x0 = x0.into_state();
    let mut outcome = OrbitWithEvents {
        orbit: Orbit::before_first_step(t0, x0),
        events: Vec::new(),
    };
    let mut watched = match Integration::new(system, t0, x0, t_end, options) {
        Ok(integration) => Watched::new(integration, events),
        Err(error) => return Err(Failure::new(error, outcome)),
    };
    loop {
        let progress = match watched.step() {
            Ok(WatchedProgress::Event(event)) => {
                outcome.events.push(event);
                continue;
            }
            Ok(WatchedProgress::Progress(progress)) => Ok(progress),
            Err(error) => Err(error),
        };
        match store(&mut outcome.orbit, watched.integration_mut(), progress) {
            Ok(false) => {}
            Ok(true) => return Ok(outcome),
            Err(error) => return Err(Failure::new(error, outcome)),
        }
    }
}
