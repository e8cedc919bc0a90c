//! How well a guard can be known at a state.

use crate::dual::Dual;

use super::flow::Flow;
use crate::ode::{Timed, Tolerance};

/// How well guard `i` is known at a state, given how well the state is: by the tolerance of the integration, and by
/// rounding alone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Uncertainty {
    pub by_tolerance: f64,
    pub by_rounding: f64,
}

/// Units in the last place by which rounding is taken to blur state and time.
const ULPS: f64 = 64.0;

pub(crate) fn uncertainty<F: Flow<N>, const N: usize>(
    flow: &F,
    i: usize,
    at: &Timed<N>,
    tolerance: &Tolerance,
) -> Uncertainty {
    let (mut by_tolerance, mut by_rounding) = (0.0, 0.0);
    // Direction N is time, which no tolerance blurs.
    for direction in 0..=N {
        let seed = |at: usize| f64::from(u8::from(at == direction));
        let x = std::array::from_fn(|k| Dual::new(at.x[k], seed(k)));
        let slope = flow.guard(i, Dual::new(at.t, seed(N)), &x).eps.abs();
        if direction < N {
            let size = at.x[direction].abs();
            by_tolerance += slope * (tolerance.atol + tolerance.rtol * size);
            by_rounding += slope * size;
        } else {
            by_rounding += slope * at.t.abs();
        }
    }
    by_rounding *= ULPS * f64::EPSILON;
    Uncertainty {
        by_tolerance,
        by_rounding,
    }
}
