//! The uncertainty of a guard at a state.

use crate::dual::Dual;

use super::flow::Flow;
use crate::ode::{Timed, Tolerance};

/// Uncertainty of guard `i` at a state, from that of the state: by the tolerance of the
/// integration, and by rounding alone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Uncertainty {
    pub by_tolerance: f64,
    pub by_rounding: f64,
}

/// Fraction of the tolerance's effect below which a guard is zero: events are located a thousand
/// times more precisely than steps.
const OF_TOLERANCE: f64 = 1e-3;

/// A series that differs from its function by so many tolerances does not represent it.
const FAR_OFF: f64 = 30.0;

impl Uncertainty {
    /// The size beyond which a guard differs from its series.
    pub(crate) fn far_off(&self) -> f64 {
        self.by_rounding + FAR_OFF * self.by_tolerance
    }

    /// The size below which the guard is zero.
    pub(crate) fn zero(&self) -> f64 {
        self.by_rounding + OF_TOLERANCE * self.by_tolerance
    }

    /// The effect of one unit in the last place of state and time.
    pub(crate) fn of_one_unit(&self) -> f64 {
        self.by_rounding / ULPS
    }
}

/// Rounding of state and time, in units in the last place.
pub(crate) const ULPS: f64 = 64.0;

pub(crate) fn uncertainty<F: Flow<N>, const N: usize>(
    flow: &F,
    i: usize,
    at: &Timed<N>,
    tolerance: &Tolerance,
) -> Uncertainty {
    let [one] = blur(at, tolerance, |t, x| [flow.guard(i, t, x)]);
    one
}

/// The same of all `G` guards.
pub(crate) fn uncertainties<F: Flow<N>, const N: usize, const G: usize>(
    flow: &F,
    at: &Timed<N>,
    tolerance: &Tolerance,
) -> [Uncertainty; G] {
    blur(at, tolerance, |t, x| flow.field_and_guards(t, x).1)
}

#[inline(always)]
fn blur<const N: usize, const G: usize>(
    at: &Timed<N>,
    tolerance: &Tolerance,
    guards: impl Fn(Dual<f64>, &[Dual<f64>; N]) -> [Dual<f64>; G],
) -> [Uncertainty; G] {
    let mut blurs = [Uncertainty {
        by_tolerance: 0.0,
        by_rounding: 0.0,
    }; G];
    // Direction N is time, which the tolerance does not affect.
    for direction in 0..=N {
        let seed = |at: usize| f64::from(u8::from(at == direction));
        let x = std::array::from_fn(|k| Dual::new(at.x[k], seed(k)));
        let guards = guards(Dual::new(at.t, seed(N)), &x);
        for (blur, guard) in blurs.iter_mut().zip(guards) {
            let slope = guard.eps.abs();
            if direction < N {
                let size = at.x[direction].abs();
                blur.by_tolerance += slope * (tolerance.atol + tolerance.rtol * size);
                blur.by_rounding += slope * size;
            } else {
                blur.by_rounding += slope * at.t.abs();
            }
        }
    }
    for blur in &mut blurs {
        blur.by_rounding *= ULPS * f64::EPSILON;
    }
    blurs
}
