//! Error norm and step-size control of the adaptive method.

use super::linear::Linear;
use super::step::{Stages, weigh};
use super::tableau::RungeKutta;
use crate::math;
use crate::system::State;

/// Error allowed per step: `atol + rtol · |x|` in every component.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance<const N: usize> {
    /// Relative part.
    pub rtol: f64,
    /// Absolute part of each component, in its units.
    pub atol: [f64; N],
}

impl<const N: usize> Tolerance<N> {
    /// Error that a component of this size may have.
    #[inline(always)]
    pub(crate) fn allowed(&self, component: usize, size: f64) -> f64 {
        self.atol[component] + self.rtol * size
    }
}

/// Smallest factor between a step and the next, as in `dop853.f`.
const MIN_STEP_FACTOR: f64 = 0.333;

/// Largest factor between a step and the next, as in `dop853.f`.
const MAX_STEP_FACTOR: f64 = 6.0;

/// Safety factor on the step that the error estimate allows, as in `dop853.f`.
const STEP_SAFETY: f64 = 0.9;

/// Two estimates of a step's error, over its length.
pub(crate) struct Estimates<V> {
    /// Error estimate of order 5.
    pub fifth: V,
    /// Error estimate of order 3.
    pub third: V,
}

/// Squared error of a step in units of the tolerance, accepted up to 1; not finite where the step
/// is not. It is the mean over the first components, whose number is given; further ones are
/// constant.
///
/// It is squared because the next step waits for it, and a root would take as long as two calls of
/// a small field. It is DOP853's combination of its estimates of orders 5 and 3 (Hairer, Nørsett &
/// Wanner, Eq. II.10.17).
#[inline(always)]
pub(crate) fn squared_error<M: RungeKutta, const N: usize>(
    step: &Stages<State<N>>,
    x0: &State<N>,
    h: f64,
    tolerance: (&Tolerance<N>, usize),
) -> f64 {
    let estimates = M::EMBEDDED.as_ref().map(|embedded| {
        let eighth: State<N> = weigh(&step.k, &M::COEFFICIENTS.b);
        Estimates {
            fifth: weigh(&step.k, &embedded.e5),
            third: eighth.add_scaled(-1.0, &weigh(&step.k, &embedded.third_order)),
        }
    });
    squared_error_of(estimates.as_ref(), [x0, &step.end], h, tolerance)
}

/// [`squared_error`] from the estimates and both ends of a step; NaN where a square overflows.
#[inline(always)]
pub(crate) fn squared_error_of<const N: usize>(
    estimates: Option<&Estimates<State<N>>>,
    [x0, end]: [&State<N>; 2],
    h: f64,
    (tolerance, states): (&Tolerance<N>, usize),
) -> f64 {
    let of_exact = || match end.iter().all(|v| v.is_finite()) {
        true => 0.0,
        false => f64::NAN,
    };
    let Some(Estimates { fifth, third }) = estimates else {
        // A method without an estimate accepts every finite step.
        return of_exact();
    };
    let (mut sum5, mut sum3) = (0.0, 0.0);
    for i in 0..N {
        let scale = tolerance.allowed(i, x0[i].abs().max(end[i].abs()));
        let (e5, e3) = (fifth[i] / scale, third[i] / scale);
        sum5 += e5 * e5;
        sum3 += e3 * e3;
    }
    let denominator = (sum5 + 0.01 * sum3) * states as f64;
    if denominator == 0.0 {
        return of_exact();
    }
    // A quotient by infinity would be the error zero.
    if !denominator.is_finite() {
        return f64::NAN;
    }
    let along = h * sum5;
    along * (along / denominator)
}

/// Factor by which the step changes after a step of this squared error: about `0.9 · error^(-1/8)`,
/// within bounds.
///
/// Every adaptive method here is of order 8. The bits of a positive number, read as an integer,
/// approximate its logarithm, linearly between powers of two. The root is taken there, to within
/// 3 %, in a few integer operations, the same on every machine. Square roots would delay the next
/// step by as much as four calls of a small field.
#[inline(always)]
pub(crate) fn step_factor(squared_error: f64) -> f64 {
    /// Bits of 1, the zero of the logarithm.
    const ONE: i64 = 1.0_f64.to_bits() as i64;
    /// The chords deviate by up to 6 % to one side. Half of that is corrected in the logarithm.
    const MIDDLE: i64 = (0.043 * (1_i64 << 52) as f64) as i64;
    let logarithm = squared_error.to_bits() as i64 - ONE;
    let root = f64::from_bits((ONE - MIDDLE - logarithm / 16) as u64);
    (STEP_SAFETY * root).clamp(MIN_STEP_FACTOR, MAX_STEP_FACTOR)
}

/// A first step for which an explicit Euler step and the change of slope over it stay near 1 %
/// (Hairer, Nørsett & Wanner, Sect. II.4). Calls `f` once.
pub(crate) fn first_step<const N: usize>(
    f: &mut dyn FnMut(f64, &State<N>) -> State<N>,
    t: f64,
    x: &State<N>,
    slope: &State<N>,
    (tolerance, states): (&Tolerance<N>, usize),
    longest: f64,
) -> f64 {
    let norm = |v: &State<N>| {
        let mut sum = 0.0;
        for i in 0..states {
            let q = v[i] / tolerance.allowed(i, x[i].abs());
            sum += q * q;
        }
        (sum / states as f64).sqrt()
    };
    let (size, speed) = (norm(x), norm(slope));
    let guess = if size < 1e-5 || speed < 1e-5 {
        1e-6
    } else {
        0.01 * size / speed
    }
    .min(longest);
    let ahead = f(t + guess, &x.add_scaled(guess, slope));
    let bend = norm(&ahead.add_scaled(-1.0, slope)) / guess;
    let steepest = speed.max(bend);
    let by_slope = if steepest <= 1e-15 {
        (guess * 1e-3).max(1e-6)
    } else {
        math::pow(0.01 / steepest, 1.0 / 8.0)
    };
    let step = (100.0 * guess).min(by_slope).min(longest);
    if step.is_finite() && step > 0.0 {
        step
    } else {
        1e-6_f64.min(longest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_error_whose_squares_overflow_is_small() {
        let tolerance = Tolerance {
            rtol: 0.0,
            atol: [1e-14],
        };
        let of = |exponent: i32| State::from([math::powi(10.0, exponent)]);
        let all = 0..300;
        for (fifth, third) in all.clone().flat_map(|k| all.clone().map(move |l| (k, l))) {
            let estimates = Estimates {
                fifth: of(fifth),
                third: of(third),
            };
            let ends = [&of(0), &of(0)];
            let how = (&tolerance, 1000);
            let error = squared_error_of(Some(&estimates), ends, 1.0, how);
            // The logarithm of e5⁴/(e5² + e3²/100)/1000, with e3 the larger one.
            let exact = 4 * (fifth + 14) - 2 * (third + 14).max(fifth + 14) - 1;
            assert!(
                error > 1.0 || error.is_nan() || exact <= 2,
                "1e{fifth}, 1e{third}: {error:e}, exactly 1e{exact}"
            );
        }
    }
}
