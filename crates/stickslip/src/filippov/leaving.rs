//! Leaving a zero of a guard, so that a phase that starts on Σ or at a tangent point does not end
//! at once.

use super::flow::Flow;
use super::options::Options;
use super::uncertainty::uncertainty;
use crate::ode::Timed;

/// Part of a step at which a guard must stand clear of rounding.
pub(crate) const RISES: [f64; 3] = [1.0, 0.5, 0.25];

/// A guard that leaves its zero at the start of the step. The zero is divided out: `(g − g₀ −
/// …)/s^order` has the guard's other zeros and none at the start. If no derivative stands out, both
/// fields lie along Σ. The guard then ends the mode where it falls below its uncertainty.
pub(crate) struct Leaving {
    /// Number of derivatives, from the value on, that vanish at the start.
    order: usize,
    /// Uncertainty of the guard if no derivative leads away from zero, else 0. It is added to the
    /// guard.
    pub(crate) flat: f64,
    /// Taylor coefficients of the guard in `s` at the start of the step.
    start: [f64; 4],
}

impl Leaving {
    /// The guard without the rounding at the start.
    fn risen(&self, s: f64, guard: f64) -> f64 {
        let mut rest = guard;
        let mut power = 1.0;
        for coefficient in &self.start[..self.order] {
            rest -= coefficient * power;
            power *= s;
        }
        rest
    }

    pub(crate) fn value(&self, s: f64, guard: impl FnOnce() -> f64) -> f64 {
        if self.flat > 0.0 {
            return guard() + self.flat;
        }
        if s == 0.0 {
            return self.start[self.order];
        }
        let power = (0..self.order).fold(1.0, |power, _| power * s);
        self.risen(s, guard()) / power
    }
}

/// Taylor coefficients of the guard at a start from its own zero, over a step of length `h`. `None`
/// if the step is too short for the guard to rise out of rounding; such a step holds no event.
pub(crate) fn leaving<F: Flow<N>, const N: usize>(
    flow: &F,
    guard: usize,
    at: &Timed<N>,
    (h, order): (f64, usize),
    options: &Options,
    on_step: impl Fn(f64) -> f64,
) -> Option<Leaving> {
    let [g, rate, bend, third] = flow.jet(guard, at.t, &at.x);
    let order = order.min(3);
    let mut start = Leaving {
        order,
        flat: 0.0,
        start: [g, rate * h, 0.5 * bend * h * h, third * h * h * h / 6.0],
    };
    let blur = uncertainty(flow, guard, at, &options.tolerance());
    let floor = blur.by_rounding;
    let rises = RISES
        .iter()
        .any(|&s| start.risen(s, on_step(s)).abs() > floor);
    if start.start[order].abs() <= floor {
        start.flat = blur.zero().max(f64::MIN_POSITIVE);
    }
    rises.then_some(start)
}

/// Whether a guard that was zero at the start of the phase now stands clear of zero.
pub(crate) fn has_left<F: Flow<N>, const N: usize>(
    flow: &F,
    i: usize,
    at: &Timed<N>,
    options: &Options,
) -> bool {
    let floor = uncertainty(flow, i, at, &options.tolerance()).by_rounding;
    flow.guard_at(i, at.t, &at.x) > 4.0 * floor
}
