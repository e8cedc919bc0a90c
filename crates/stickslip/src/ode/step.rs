//! One generic Runge–Kutta step.

use super::linear::Linear;
use super::tableau::{MAX_STAGES, RungeKutta};
use crate::scalar::Scalar;

/// The slopes of one step and the state that they lead to.
#[derive(Clone, Copy, Debug)]
pub struct Stages<V> {
    /// Slopes; slot `stages` (the slope at the end) and those behind it are filled by [`dense_slopes`].
    pub k: [V; MAX_STAGES],
    /// State at the end of the step.
    pub end: V,
}

/// Writes out one block for every stage index, so that the compiler sees each row of the tableau as constants:
/// zeros vanish, loops unroll, nothing is looked up at run time.
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

/// One step of method `M` from `(t, x)` with slope `k0 = f(t, x)` over `h`; calls `f` `stages − 1` times.
///
/// The newest slope is added last in every stage: all else is ready before it, and the chain of dependent
/// operations is hardly longer than that of the calls to `f` themselves.
#[inline(always)]
pub fn stages<M: RungeKutta, T: Scalar, V: Linear<T>>(
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

/// Fills in the slope at the end of the step and the further slopes that the dense output needs.
#[inline(always)]
pub fn dense_slopes<M: RungeKutta, T: Scalar, V: Linear<T>>(
    f: &mut impl FnMut(T, &V) -> V,
    t: T,
    x: &V,
    h: T,
    step: &mut Stages<V>,
) {
    let first = M::COEFFICIENTS.stages;
    step.k[first] = f(t + h, &step.end);
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
