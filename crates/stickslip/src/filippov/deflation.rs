//! Deflation of a guard that is zero at the start of a step. Without it, a phase that starts on Σ
//! or at a tangent point would end at once.

use super::flow::Flow;
use super::options::Options;
use super::uncertainty::uncertainty;
use crate::ode::Timed;

/// Parts of a step at which a guard is checked for a rise above rounding. Chosen: a guard
/// that rises is hardly zero at all three.
pub(crate) const RISE_CHECKS: [f64; 3] = [1.0, 0.5, 0.25];

/// A guard whose zero at the start of the step is divided out: `(g − g₀ − …)/s^order` has the
/// guard's other zeros and none at the start. If no derivative exceeds its rounding, both fields
/// lie along Σ. The guard then ends the mode where it falls below its uncertainty.
pub(crate) struct DeflatedGuard {
    /// Number of derivatives, from the value on, that vanish at the start.
    order: usize,
    /// Uncertainty of the guard, which is added to it, if no derivative leads away from zero; else
    /// 0.
    pub(crate) offset: f64,
    /// Taylor coefficients of the guard in `s` at the start of the step.
    start: [f64; 4],
}

impl DeflatedGuard {
    /// The guard without its Taylor polynomial below the order, which is rounding.
    fn remainder(&self, s: f64, guard: f64) -> f64 {
        let mut rest = guard;
        let mut power = 1.0;
        for coefficient in &self.start[..self.order] {
            rest -= coefficient * power;
            power *= s;
        }
        rest
    }

    /// The deflated guard at the part `s` of the step.
    pub(crate) fn value(&self, s: f64, guard: impl FnOnce() -> f64) -> f64 {
        if self.offset > 0.0 {
            return guard() + self.offset;
        }
        if s == 0.0 {
            return self.start[self.order];
        }
        let power = (0..self.order).fold(1.0, |power, _| power * s);
        self.remainder(s, guard()) / power
    }
}

/// The guard of a step of length `h` that starts at a zero of that order. `None` if the step is too
/// short for the guard to rise above rounding; such a step contains no event.
pub(crate) fn deflate<F: Flow<N>, const N: usize>(
    flow: &F,
    guard: usize,
    at: &Timed<N>,
    (h, order): (f64, usize),
    options: &Options,
    on_step: impl Fn(f64) -> f64,
) -> Option<DeflatedGuard> {
    let [g, rate, bend, third] = flow.jet(guard, at.t, &at.x);
    let order = order.min(3);
    let mut start = DeflatedGuard {
        order,
        offset: 0.0,
        start: [g, rate * h, 0.5 * bend * h * h, third * h * h * h / 6.0],
    };
    let blur = uncertainty(flow, guard, at, &options.tolerance());
    let floor = blur.by_rounding;
    let rises = RISE_CHECKS
        .iter()
        .any(|&s| start.remainder(s, on_step(s)).abs() > floor);
    if start.start[order].abs() <= floor {
        start.offset = blur.zero().max(f64::MIN_POSITIVE);
    }
    rises.then_some(start)
}

/// Whether a guard that is zero at the start of the phase exceeds its rounding at a state.
pub(crate) fn has_left_zero<F: Flow<N>, const N: usize>(
    flow: &F,
    i: usize,
    at: &Timed<N>,
    options: &Options,
) -> bool {
    let floor = uncertainty(flow, i, at, &options.tolerance()).by_rounding;
    flow.guard_at(i, at.t, &at.x) > 4.0 * floor
}
