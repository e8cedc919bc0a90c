//! One generic Runge–Kutta step.

use super::linear::Linear;
use super::tableau::{MAX_STAGES, RungeKutta};
use crate::interval::Interval;
use crate::scalar::Scalar;
use crate::system::State;

/// The slopes of one step and the state at its end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stages<V> {
    /// Slopes. Slot `stages` (the slope at the end) and the slots after it are filled by
    /// [`dense_slopes`].
    pub(crate) k: [V; MAX_STAGES],
    /// State at the end of the step.
    pub(crate) end: V,
}

impl<const N: usize> Stages<State<N>> {
    /// A box that contains the state throughout a step of method `M` from `x` over `h`. The step's
    /// error must be within the tolerance, and the slope at its end filled in. The box is not
    /// finite where the step is not.
    ///
    /// The deviation from the chord is the integral of `h ẋ` minus the rise. It is zero at both
    /// ends, so it is at most half the maximum of its integrand. That is known at the stages; the
    /// bound is doubled for values between the stages and for their errors.
    #[inline(always)]
    pub(crate) fn enclosure<M: RungeKutta>(&self, x: &State<N>, h: f64) -> [Interval; N] {
        let (mut bend, mut sum) = ([0.0; N], [0.0; N]);
        for slope in &self.k[..=M::COEFFICIENTS.stages] {
            for i in 0..N {
                let off = (h * slope[i] - (self.end[i] - x[i])).abs();
                bend[i] = if off > bend[i] { off } else { bend[i] };
                // Comparisons ignore NaN; a sum does not.
                sum[i] += off;
            }
        }
        let mut enclosure = [Interval::new(0.0, 0.0); N];
        for (i, enclosure) in enclosure.iter_mut().enumerate() {
            let rise = self.end[i] - x[i];
            let radius = if sum[i].is_finite() {
                bend[i]
            } else {
                f64::NAN
            };
            *enclosure = Interval::around(x[i] + 0.5 * rise, 0.5 * rise.abs() + radius);
        }
        enclosure
    }
}

/// Writes one block for every stage index, so that the compiler sees each row of the tableau as
/// constants: zeros vanish and loops unroll.
macro_rules! for_each_stage {
    ($body:ident) => {
        $body!(1);
        $body!(2);
        $body!(3);
        $body!(4);
        $body!(5);
        $body!(6);
        $body!(7);
        $body!(8);
        $body!(9);
        $body!(10);
        $body!(11);
        $body!(12);
        $body!(13);
        $body!(14);
        $body!(15);
    };
}
pub(crate) use for_each_stage;

/// One step of method `M` from `(t, x)` with slope `k0 = f(t, x)` over `h`. Calls `f` `stages − 1`
/// times.
///
/// The newest slope is added last in every stage. All other terms are ready before it, so the chain
/// of dependent operations is hardly longer than the calls of `f`.
#[inline(always)]
pub(crate) fn stages<M: RungeKutta, T: Scalar, V: Linear<T>>(
    f: &mut impl FnMut(T, &V) -> V,
    t: T,
    x: &V,
    k0: V,
    h: T,
) -> Stages<V> {
    let mut k = [V::zero(); MAX_STAGES];
    k[0] = k0;
    macro_rules! stage {
        ($i:literal) => {
            if $i < M::COEFFICIENTS.stages {
                let at = combine::<T, V, $i>(x, &k, &M::COEFFICIENTS.a[$i], h);
                k[$i] = f(t + h * M::COEFFICIENTS.c[$i], &at);
            }
        };
    }
    for_each_stage!(stage);
    let increment = weigh(&k, &M::COEFFICIENTS.b);
    Stages {
        k,
        end: x.add_scaled(h, &increment),
    }
}

/// State at the end of one step of method `M` from `(t, x)` with slope `k0 = f(t, x)` over `h`.
/// Calls `f` `stages − 1` times, as a dynamic call: such steps are rare, and compiled once.
#[inline(never)]
pub fn step_end<M: RungeKutta, V: Linear<f64>>(
    f: &mut dyn FnMut(f64, &V) -> V,
    t: f64,
    x: &V,
    k0: V,
    h: f64,
) -> V {
    stages::<M, f64, V>(&mut |t, x| f(t, x), t, x, k0, h).end
}

/// Fills in the slope at the end of the step and the further slopes of the dense output.
#[inline(always)]
pub(crate) fn dense_slopes<M: RungeKutta, T: Scalar, V: Linear<T>>(
    f: &mut impl FnMut(T, &V) -> V,
    t: T,
    x: &V,
    h: T,
    step: &mut Stages<V>,
) {
    step.k[M::COEFFICIENTS.stages] = f(t + h, &step.end);
    further_slopes::<M, T, V>(f, t, x, h, step);
}

/// Fills in the slopes that only the dense output needs. The slope at the end of the step must be
/// known.
#[inline(always)]
pub(crate) fn further_slopes<M: RungeKutta, T: Scalar, V: Linear<T>>(
    f: &mut impl FnMut(T, &V) -> V,
    t: T,
    x: &V,
    h: T,
    step: &mut Stages<V>,
) {
    macro_rules! stage {
        ($i:literal) => {
            if $i > M::COEFFICIENTS.stages
                && $i <= M::COEFFICIENTS.stages + M::COEFFICIENTS.dense_stages
            {
                let at = combine::<T, V, $i>(x, &step.k, &M::COEFFICIENTS.a[$i], h);
                step.k[$i] = f(t + h * M::COEFFICIENTS.c[$i], &at);
            }
        };
    }
    for_each_stage!(stage);
}

/// `x + Σ_{j < I} (h a_j) k_j`, oldest slope first.
#[inline(always)]
fn combine<T: Scalar, V: Linear<T>, const I: usize>(
    x: &V,
    k: &[V; MAX_STAGES],
    a: &[f64; MAX_STAGES],
    h: T,
) -> V {
    let mut sum = *x;
    for j in 0..I {
        if a[j] != 0.0 {
            sum = sum.add_scaled(h * a[j], &k[j]);
        }
    }
    sum
}

/// `Σ_j w_j k_j`, zero weights left out.
#[inline(always)]
pub(super) fn weigh<T: Scalar, V: Linear<T>>(k: &[V; MAX_STAGES], w: &[f64; MAX_STAGES]) -> V {
    let mut sum = V::zero();
    for j in 0..MAX_STAGES {
        if w[j] != 0.0 {
            sum = sum.add_scaled(T::constant(w[j]), &k[j]);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;
    use crate::ode::control::squared_error;
    use crate::ode::{Dop853, Tolerance};
    use numerics::SplitMix;

    /// The solution at 64 points of a step from time 0, by steps of that length.
    fn solution(
        field: &mut impl FnMut(f64, &State<2>) -> State<2>,
        x: State<2>,
        h: f64,
    ) -> impl Iterator<Item = State<2>> {
        let part = h / 64.0;
        let mut at = x;
        (0..64).map(move |k| {
            let t = f64::from(k) * part;
            let slope = field(t, &at);
            at = stages::<Dop853, f64, _>(field, t, &at, slope, part).end;
            at
        })
    }

    /// Steps as long as error control allows, for a forced spring that hardens or softens. In a
    /// million and a half of them the solution used less than two fifths of the margin; the test
    /// requires half. (At tolerances above 1e-2 the step itself may err by more than any margin.)
    #[test]
    fn the_solution_stays_within_the_reach_of_a_step_within_the_tolerance() {
        let mut draw = SplitMix::new(853);
        for _ in 0..4000 {
            let x = State::from([draw.between(-2.0, 2.0), draw.between(-2.0, 2.0)]);
            let (hardening, damping) = (draw.between(-0.3, 3.0), draw.between(-1.0, 1.0));
            let (force, rate) = (draw.between(0.0, 3.0), draw.between(0.1, 6.0));
            let phase = draw.between(0.0, 6.3);
            let tol = math::pow(10.0, draw.between(-12.0, -2.0));
            let mut field = |t: f64, x: &State<2>| {
                let spring = -x[0] * (1.0 + hardening * x[0] * x[0]) - damping * x[1];
                State::from([x[1], spring + force * math::cos(rate * t + phase)])
            };
            let slope = field(0.0, &x);
            let tolerance = Tolerance {
                rtol: tol,
                atol: [tol; 2],
            };
            let mut h = 4.0;
            let mut step = loop {
                let step = stages::<Dop853, f64, _>(&mut field, 0.0, &x, slope, h);
                if squared_error::<Dop853, 2>(&step, &x, h, (&tolerance, 2)) <= 1.0 {
                    break step;
                }
                h *= 0.9;
            };
            step.k[12] = field(h, &step.end);
            let enclosure = step.enclosure::<Dop853>(&x, h);
            for at in solution(&mut field, x, h) {
                for i in 0..2 {
                    let (middle, way) = (0.5 * (x[i] + step.end[i]), (step.end[i] - x[i]).abs());
                    let room = 0.5 * (enclosure[i].high - enclosure[i].low - way);
                    let outside = (at[i] - middle).abs() - 0.5 * way;
                    assert!(
                        outside <= 0.5 * room + 1e-14,
                        "{outside:e} of {room:e}, {tol:e}"
                    );
                }
            }
        }
    }

    #[test]
    fn what_is_not_finite_reaches_nowhere() {
        let x = State::from([0.0]);
        let mut step = stages::<Dop853, f64, _>(&mut |_, _| x, 0.0, &x, x, 1.0);
        step.k[5][0] = f64::NAN;
        assert!(step.enclosure::<Dop853>(&x, 1.0)[0].low.is_nan());
    }
}
