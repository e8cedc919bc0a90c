//! A whole orbit with the user's own events.

use super::{EventFunctions, Watched, WatchedProgress};
use crate::filippov::integration::Integration;
use crate::filippov::options::Options;
use crate::filippov::solve::{Failure, store};
use crate::filippov::switched::Switched;
use crate::orbit::Orbit;
use crate::system::IntoState;

/// [`crate::solve`], with the zeros of the user's own functions: see [`EventFunctions`], and
/// [`crate::EventSearch`] for a run that keeps nothing. The orbit ends at the first terminal event.
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
) -> Result<Orbit<N, S::Mode>, Failure<Orbit<N, S::Mode>>>
where
    S: Switched<N, G>,
    V: EventFunctions<N>,
{
    let x0 = x0.into_state();
    let mut orbit = Orbit::before_first_step(t0, x0);
    let mut watched = match Integration::new(system, t0, x0, t_end, options) {
        Ok(integration) => Watched::new(integration, events),
        Err(error) => return Err(Failure::new(error, orbit)),
    };
    loop {
        let progress = match watched.step() {
            Ok(WatchedProgress::Event(event)) => {
                orbit.events.push(event);
                continue;
            }
            Ok(WatchedProgress::Progress(progress)) => Ok(progress),
            Err(error) => Err(error),
        };
        match store(&mut orbit, watched.integration_mut(), progress) {
            Ok(false) => {}
            Ok(true) => return Ok(orbit),
            Err(error) => return Err(Failure::new(error, orbit)),
        }
    }
}
