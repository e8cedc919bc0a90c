//! Errors of the time of one event over the step, and their order.

use crate::numbers::ROUNDING;
use crate::paper::listing::PRINTED_STEP;
use crate::paper::published::HALF_DIGIT;
use numerics::PowerLaw;
use stickslip::{Error, Side};

/// Tolerance of the exact orbits. Single Hénon steps are compared with them, so that it is ten
/// times finer than that of other accurate solutions.
pub(super) const EXACT_TOLERANCE: f64 = 1e-14;
/// Steps (s) at which orders are measured: their errors are well above rounding.
pub(super) const STEPS: [f64; 5] = [1.6e-2, 1.13e-2, 8e-3, 5.7e-3, 4e-3];
/// Fractions of a step at which the event comes. The largest error counts.
const STEP_FRACTIONS: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];

/// Errors of the time of one event.
#[derive(Clone, Debug, PartialEq)]
pub struct EventErrors {
    /// Method that located the event.
    pub method: &'static str,
    /// The side from which the orbit comes, or to which it is released.
    pub side: Side,
    /// Steps and errors (s), the largest over the fractions of the step.
    pub errors: Vec<(f64, f64)>,
    /// Slope of log error against log step.
    pub order: f64,
    /// Error at the printed step (s).
    pub at_printed_step: f64,
}

impl EventErrors {
    /// Measures errors of times that `locate` returns for a step and the fraction of it at which
    /// the event comes. The orbit comes to the event from a side or is released to one.
    pub(super) fn measure(
        method: &'static str,
        (side, t): (Side, f64),
        locate: impl Fn(f64, f64) -> Result<f64, Error>,
    ) -> Result<EventErrors, Error> {
        // A missing event counts as an infinite error.
        let error = |h: f64| {
            STEP_FRACTIONS
                .into_iter()
                .try_fold(0.0, |worst: f64, part| {
                    let off = (locate(h, part)? - t).abs();
                    let off = if off.is_nan() { f64::INFINITY } else { off };
                    Ok::<f64, Error>(worst.max(off))
                })
        };
        let errors = STEPS.into_iter().map(|h| Ok((h, error(h)?)));
        let errors = errors.collect::<Result<Vec<_>, Error>>()?;
        Ok(EventErrors {
            method,
            side,
            order: PowerLaw::through(errors.iter().copied()).exponent,
            errors,
            at_printed_step: error(PRINTED_STEP)?,
        })
    }

    /// Whether all errors are accumulated rounding of the times, which has no order.
    pub fn is_exact(&self) -> bool {
        self.at_printed_step <= ROUNDING && self.errors.iter().all(|(_, error)| *error <= ROUNDING)
    }

    /// "High accuracy": at the printed step the error is less than half a unit of the last printed
    /// digit.
    pub fn is_accurate(&self) -> bool {
        self.at_printed_step < HALF_DIGIT
    }

    /// One line of evidence.
    pub fn line(&self) -> String {
        let side = match self.side {
            Side::Below => "below",
            Side::Above => "above",
        };
        let (order, off) = (self.order, self.at_printed_step);
        let errors = if self.is_exact() {
            format!("exact to rounding at all steps down to h = {PRINTED_STEP:e} s")
        } else if !off.is_finite() {
            format!("no event time at h = {PRINTED_STEP:e} s, a slope is infinite")
        } else {
            format!("order {order:.2}, event time off by {off:.1e} s at h = {PRINTED_STEP:e} s")
        };
        format!("{} {side}: {errors}", self.method)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(error: impl Fn(f64, f64) -> f64) -> EventErrors {
        EventErrors::measure("a test", (Side::Below, 0.0), |h, part| Ok(error(h, part))).unwrap()
    }

    #[test]
    fn accuracy_asks_for_size_alone() {
        assert!(of(|h, _| 0.4 * h).is_accurate() && !of(|h, _| 0.6 * h).is_accurate());
        assert!(!of(|_, _| f64::NAN).is_accurate());
        assert!(of(|_, _| 0.0).is_accurate() && of(|_, _| 1e-16).is_exact());
        // The largest error over the fractions counts.
        assert!(!of(|h, part| h * (1.0 - part)).is_accurate());
        let lost = |_, part| if part > 0.8 { f64::NAN } else { 0.0 };
        assert!(!of(lost).is_accurate());
    }
}
