//! The uncertainty of a guard at a state.

use numerics::bisect;

use super::flow::{Flow, seeded};
use super::options::Options;
use crate::dual::Dual;
use crate::ode::{Timed, Tolerance};
use crate::system::components;

/// Uncertainty of guard `i` at a state, from that of the state: by the tolerance of the
/// integration, and by rounding alone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Uncertainty {
    pub by_tolerance: f64,
    pub by_rounding: f64,
}

/// Rounding of a computed state or time, relative to its size: 64 units in the last place. Chosen
/// above what the operations of a step and of a user's function usually accumulate.
pub(crate) const STATE_ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Rounding of a difference of large computed numbers, relative to these. Chosen far above
/// [`STATE_ROUNDING`], and far below any effect that a user means.
pub(crate) const RELATIVE_ROUNDING: f64 = 1e-12;

/// Part of the tolerance below which a guard, or a distance from Σ, is zero. Chosen: events are
/// located a thousand times more precisely than steps.
pub(crate) const EVENT_PRECISION: f64 = 1e-3;

/// Largest difference, in tolerances, between a series and what it represents. The slope of a
/// series of order p has p times the error of a step, and p is at most 24.
pub(crate) const SERIES_DEFECT: f64 = 30.0;

impl Uncertainty {
    /// The size beyond which a guard differs from its series.
    pub(crate) fn series_defect(&self) -> f64 {
        self.by_rounding + SERIES_DEFECT * self.by_tolerance
    }

    /// The size below which the guard is zero.
    pub(crate) fn zero(&self) -> f64 {
        self.by_rounding + EVENT_PRECISION * self.by_tolerance
    }

    /// The effect of one unit in the last place of state and time.
    pub(crate) fn of_one_unit(&self) -> f64 {
        self.by_rounding * (f64::EPSILON / STATE_ROUNDING)
    }
}

/// Uncertainty of guard `i` at a state.
pub(crate) fn uncertainty<F: Flow<N>, const N: usize>(
    flow: &F,
    i: usize,
    at: &Timed<N>,
    tolerance: &Tolerance<N>,
) -> Uncertainty {
    let of = (flow.dimension(), tolerance);
    let [one] = propagate(at, of, |t, x| [flow.guard(i, t, x)]);
    one
}

/// Whether both sides of the boundary along which a mode slides lead towards it, to within the
/// precision of an event, in a step from a place to another. A slide cannot pass a two-fold, behind
/// which they lead apart. A step may where friction itself changes its sign, with a normal force:
/// what that force does there ends the mode.
pub(crate) fn attracts<F: Flow<N>, const N: usize>(
    flow: &F,
    (from, at): (&Timed<N>, &Timed<N>),
    options: &Options,
) -> bool {
    let is_within = || {
        let of = (flow.dimension(), &options.tolerance());
        let [blur] = propagate(at, of, |t, x| [flow.attraction(t, x)]);
        flow.attraction(at.t, components(&at.x)) >= -blur.zero()
    };
    let attraction: f64 = flow.attraction(at.t, components(&at.x));
    let vanishes_between = || {
        // From 1 to 2, so that bisection ends after the digits of a double.
        let between = |place: f64| Timed {
            t: from.t + (place - 1.0) * (at.t - from.t),
            x: from.x + (at.x - from.x) * (place - 1.0),
        };
        let leads_apart = |place: f64| {
            let Timed { t, x } = between(place);
            let attraction: f64 = flow.attraction(t, components(&x));
            attraction < 0.0
        };
        flow.friction_vanishes(from, &between(bisect(1.0, 2.0, leads_apart)))
    };
    attraction >= 0.0 || is_within() || flow.may_hide_two_fold() && vanishes_between()
}

/// Size of a change over an error of one sign or the other, 0 or 1: a root of the distance from a
/// boundary has values on one side of it alone.
pub(super) fn on_one_side(change: impl Fn(usize) -> f64) -> f64 {
    let first = change(0).abs();
    if first.is_nan() {
        change(1).abs()
    } else {
        first
    }
}

/// Uncertainties of all `G` guards at a state.
pub(crate) fn uncertainties<F: Flow<N>, const N: usize, const G: usize>(
    flow: &F,
    at: &Timed<N>,
    tolerance: &Tolerance<N>,
) -> [Uncertainty; G] {
    let of = (flow.dimension(), tolerance);
    propagate(at, of, |t, x| flow.field_and_guards(t, x).1)
}

/// Uncertainties of functions of the first `dimension` components of the state.
#[inline(always)]
pub(crate) fn propagate<const N: usize, const G: usize>(
    at: &Timed<N>,
    (dimension, tolerance): (usize, &Tolerance<N>),
    guards: impl Fn(Dual<f64>, &[Dual<f64>; N]) -> [Dual<f64>; G],
) -> [Uncertainty; G] {
    let mut blurs = [Uncertainty {
        by_tolerance: 0.0,
        by_rounding: 0.0,
    }; G];
    // Direction N is time, which the tolerance does not affect.
    for direction in (0..dimension).chain([N]) {
        let (t, x) = seeded(at, direction);
        let here = guards(t, &x);
        let size = if direction < N { at.x[direction] } else { at.t }.abs();
        let error = match direction < N {
            true => tolerance.allowed(direction, size),
            false => 0.0,
        };
        // The slope of a root at zero is infinite, and its change over the error is not.
        let is_steep = |guard: &Dual<f64>| direction < N && guard.eps.is_infinite();
        let beside = here.iter().any(is_steep).then(|| {
            [error, -error].map(|error| {
                let mut there = *at;
                there.x[direction] += error;
                let (t, x) = seeded(&there, direction);
                guards(t, &x)
            })
        });
        for (i, (blur, guard)) in blurs.iter_mut().zip(&here).enumerate() {
            match beside.filter(|_| is_steep(guard)) {
                Some(beside) => {
                    let change = on_one_side(|side| beside[side][i].re - guard.re);
                    blur.by_tolerance += change;
                    // Rounding of a state that is zero is none.
                    let rounded = if size == 0.0 { 0.0 } else { change };
                    blur.by_rounding += rounded / STATE_ROUNDING;
                }
                None => {
                    let slope = guard.eps.abs();
                    blur.by_tolerance += slope * error;
                    blur.by_rounding += slope * size;
                }
            }
        }
    }
    for blur in &mut blurs {
        blur.by_rounding *= STATE_ROUNDING;
    }
    blurs
}
