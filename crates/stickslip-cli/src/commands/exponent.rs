//! The largest Lyapunov exponent of an attractor.

use serde::{Deserialize, Serialize};
use stickslip::Options;
use stickslip::analysis::{Exponent, SpectrumOptions, lyapunov_spectrum};
use stickslip_kernels::kernel::Outcome;

use crate::render::Table;
use stickslip_kernels::file::System;

/// Exponents of an orbit nearer to zero than so many of their standard errors are zero.
const ERRORS: f64 = 3.0;

/// An exponent of a periodic orbit is zero to about this, whatever its standard error.
const ROUNDING: f64 = 1e-6;

/// A largest Lyapunov exponent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Largest {
    /// A number.
    Finite { value: f64, std_error: f64 },
    /// Stick takes all directions to zero.
    Annihilated,
    /// There is no orbit to measure, or it could not be followed.
    Unmeasured,
}

impl Largest {
    /// Whether it is zero within its error.
    pub(super) fn is_zero(&self) -> bool {
        match *self {
            Largest::Finite { value, std_error } => {
                value.abs() <= (ERRORS * std_error).max(ROUNDING)
            }
            _ => false,
        }
    }

    /// Adds value and standard error to a table; they are empty where there is none.
    pub(super) fn columns<'a, R>(
        table: Table<'a, R>,
        of: impl Fn(&R) -> Self + Copy + 'a,
    ) -> Table<'a, R> {
        let fields = move |row: &R| match of(row) {
            Largest::Finite { value, std_error } => (Some(value), Some(std_error)),
            Largest::Annihilated => (Some(f64::NEG_INFINITY), None),
            Largest::Unmeasured => (None, None),
        };
        table
            .column("lambda1", move |row| fields(row).0)
            .column("std_error", move |row| fields(row).1)
    }

    /// Measured on an attractor from where the orbit has come to it; not measured where there is none.
    pub(super) fn on(system: &System, outcome: &Outcome, duration: f64, options: &Options) -> Self {
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

#[cfg(test)]
mod tests {
    use super::super::sweeping::{from_content, to_content};
    use super::*;

    #[test]
    fn numbers_without_bound_are_read_again() {
        for number in [
            0.1,
            -0.0,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::MIN_POSITIVE,
        ] {
            let one = Largest::Finite {
                value: number,
                std_error: -number,
            };
            let read: Largest = from_content(&to_content(&one).unwrap()).unwrap();
            assert_eq!(read, one);
        }
        let undefined: f64 = from_content(&to_content(&f64::NAN).unwrap()).unwrap();
        assert!(undefined.is_nan());
    }
}
