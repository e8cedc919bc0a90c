//! The largest Lyapunov exponent of an attractor, where it could be measured.

use stickslip::analysis::{Attractor, Exponent, SpectrumOptions};
use stickslip::{Error, Options};

use crate::file::System;

/// An exponent below this many standard errors counts as zero: with normal errors, 0.3 % of zero
/// exponents are missed.
const ZERO_WITHIN_ERRORS: f64 = 3.0;

/// Error of an exponent on a periodic orbit, which its standard error may not show. It is chosen:
/// the exponents of such orbits were accurate to about this.
const PERIODIC_EXPONENT_ERROR: f64 = 1e-6;

/// Whether an exponent is zero within its error.
pub fn is_zero(largest: Exponent) -> bool {
    largest.std_error().is_some_and(|std_error| {
        largest.value().abs() <= (ZERO_WITHIN_ERRORS * std_error).max(PERIODIC_EXPONENT_ERROR)
    })
}

/// Exponent, its standard error and its uncertainty ([`Exponent::uncertainty`]) after a measurement
/// over this time. An infinite exponent has no error, and an exponent that is not measured has no
/// value.
pub fn numbers(largest: Option<Exponent>, duration: f64) -> [Option<f64>; 3] {
    let std_error = largest.as_ref().and_then(Exponent::std_error);
    let uncertainty = largest.filter(|_| std_error.is_some());
    [
        largest.as_ref().map(Exponent::value),
        std_error,
        uncertainty.map(|exponent| exponent.uncertainty(duration)),
    ]
}

/// Measures the exponent on an attractor that an orbit has reached; `None` if there is no
/// attractor.
///
/// # Errors
/// Those of [`Exponent::largest`]: the orbit could not be followed, or has no derivative.
pub fn on(
    system: &System,
    reached: &Attractor,
    duration: f64,
    options: &Options,
) -> Result<Option<Exponent>, Error> {
    if !reached.kind.is_attractor() {
        return Ok(None);
    }
    // The orbit is on the attractor already; only the tangent vector has to align.
    let settings = SpectrumOptions::over(0.1 * duration, duration).solver(*options);
    Exponent::largest(system.dynamics(), (reached.t, &reached.x), &settings).map(Some)
}
