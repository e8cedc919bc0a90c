//! The largest Lyapunov exponent of an attractor.

use serde::{Deserialize, Serialize};
use stickslip::Options;
use stickslip::analysis::{Exponent, SpectrumOptions, lyapunov_spectrum};

use crate::file::System;
use crate::kernel::Outcome;

/// Exponents of an orbit nearer to zero than so many of their standard errors are zero.
const ERRORS: f64 = 3.0;

/// An exponent of a periodic orbit is zero to about this, whatever its standard error.
const ROUNDING: f64 = 1e-6;

/// A largest Lyapunov exponent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Largest {
    /// A number.
    Finite {
        /// The exponent.
        value: f64,
        /// Its standard error.
        std_error: f64,
    },
    /// Stick takes all directions to zero.
    Annihilated,
    /// There is no orbit to measure, or it could not be followed.
    Unmeasured,
}

impl Largest {
    /// Whether it is zero within its error.
    pub fn is_zero(&self) -> bool {
        match *self {
            Largest::Finite { value, std_error } => {
                value.abs() <= (ERRORS * std_error).max(ROUNDING)
            }
            _ => false,
        }
    }

    /// Exponent and standard error: an infinite exponent has none, and what is not measured has
    /// neither.
    pub fn numbers(&self) -> (Option<f64>, Option<f64>) {
        match *self {
            Largest::Finite { value, std_error } => (Some(value), Some(std_error)),
            Largest::Annihilated => (Some(f64::NEG_INFINITY), None),
            Largest::Unmeasured => (None, None),
        }
    }

    /// Measured on an attractor from where the orbit has come to it; not measured where there is
    /// none.
    pub fn on(system: &System, outcome: &Outcome, duration: f64, options: &Options) -> Self {
        if outcome.points.is_empty() {
            return Largest::Unmeasured;
        }
        let (t, x) = &outcome.left_at;
        // On the attractor already: only the frame has to turn to it.
        let settings = SpectrumOptions::over(0.1 * duration, duration).solver(*options);
        let spectrum = lyapunov_spectrum(system.dynamics(), (*t, x.as_slice()), &settings).ok();
        match spectrum.as_ref().and_then(|found| found.exponents.first()) {
            Some(&Exponent::Finite { value, std_error }) => Largest::Finite { value, std_error },
            Some(Exponent::Annihilated) => Largest::Annihilated,
            None => Largest::Unmeasured,
        }
    }
}
