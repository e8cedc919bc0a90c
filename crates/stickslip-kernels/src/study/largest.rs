//! The largest Lyapunov exponent of an attractor.

use serde::{Deserialize, Serialize};
use stickslip::Options;
use stickslip::analysis::{Exponent, SpectrumOptions, largest_exponent};

use crate::file::System;
use crate::kernel::Outcome;

/// An exponent below this many standard errors counts as zero: with normal errors, 0.3 % of zero
/// exponents are missed.
const ZERO_WITHIN_ERRORS: f64 = 3.0;

/// Error of an exponent on a periodic orbit, which its standard error may not show. It is chosen:
/// the exponents of such orbits were accurate to about this.
const PERIODIC_EXPONENT_ERROR: f64 = 1e-6;

/// A largest Lyapunov exponent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Largest {
    /// A finite exponent.
    Finite {
        /// The exponent.
        value: f64,
        /// Its standard error.
        std_error: f64,
    },
    /// Stick annihilates all directions.
    Annihilated,
    /// There is no orbit to measure, or it could not be followed.
    Unmeasured,
}

impl Largest {
    /// Whether it is zero within its error.
    pub fn is_zero(&self) -> bool {
        match *self {
            Largest::Finite { value, std_error } => {
                value.abs() <= (ZERO_WITHIN_ERRORS * std_error).max(PERIODIC_EXPONENT_ERROR)
            }
            _ => false,
        }
    }

    /// Exponent, its standard error and its uncertainty ([`Exponent::uncertainty`]) after a
    /// measurement over this time. An infinite exponent has no error, and an exponent that is not
    /// measured has no value.
    pub fn numbers(&self, duration: f64) -> [Option<f64>; 3] {
        match *self {
            Largest::Finite { value, std_error } => {
                let exponent = Exponent::Finite { value, std_error };
                [value, std_error, exponent.uncertainty(duration)].map(Some)
            }
            Largest::Annihilated => [Some(f64::NEG_INFINITY), None, None],
            Largest::Unmeasured => [None; 3],
        }
    }

    /// Measures the exponent on an attractor that an orbit has reached. It is not measured if there
    /// is no attractor.
    pub fn on(system: &System, outcome: &Outcome, duration: f64, options: &Options) -> Self {
        if outcome.points.is_empty() {
            return Largest::Unmeasured;
        }
        let (t, x) = &outcome.left_at;
        // The orbit is on the attractor already; only the tangent vector has to align.
        let settings = SpectrumOptions::over(0.1 * duration, duration).solver(*options);
        match largest_exponent(system.dynamics(), (*t, x.as_slice()), &settings) {
            Ok(Exponent::Finite { value, std_error }) => Largest::Finite { value, std_error },
            Ok(Exponent::Annihilated) => Largest::Annihilated,
            Err(_) => Largest::Unmeasured,
        }
    }
}
