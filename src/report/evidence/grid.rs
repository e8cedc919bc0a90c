//! The starts from which the stated model and the listing are followed.

use stickslip::error::Error;
use stickslip::filippov::{Options, solve};
use stickslip::models::ForcedOscillator;
use stickslip::orbit::Orbit;
use stickslip::system::State;

/// Starts in position and in velocity.
const STARTS: (u32, u32) = (13, 9);
/// Outermost of them (m, m/s).
const REACH: [f64; 2] = [1.2, 2.0];
/// Forcing periods that each is followed over: stick phases occur on the way only.
pub(super) const FOLLOWED: f64 = 10.0;
pub(super) const TOLERANCE: f64 = 1e-13;
/// Beyond 10 m or 10 m/s the softening spring drives the body away for good.
pub(super) const ESCAPE: f64 = 10.0;

/// The starts, none of them at the belt's speed.
pub(super) fn starts() -> Vec<State<2>> {
    let part = |k: u32, of: u32| 2.0 * f64::from(k) / f64::from(of - 1) - 1.0;
    (0..STARTS.0)
        .flat_map(|i| {
            (0..STARTS.1).map(move |j| {
                State::from([REACH[0] * part(i, STARTS.0), REACH[1] * part(j, STARTS.1)])
            })
        })
        .collect()
}

/// The orbit from `(t0, x)` over [`FOLLOWED`] forcing periods, as far as it goes before it escapes.
pub(super) fn follow(model: &ForcedOscillator, t0: f64, x: State<2>) -> Result<Orbit<2>, Error> {
    let options = Options::tol(TOLERANCE).escape(ESCAPE);
    match solve(model, t0, x, t0 + FOLLOWED * model.period(), &options) {
        Ok(orbit) => Ok(orbit),
        Err(failure) if matches!(failure.error, Error::Escaped { .. }) => Ok(*failure.reached),
        Err(failure) => Err(failure.into()),
    }
}
