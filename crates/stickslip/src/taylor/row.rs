//! The coefficients of one number, order by order.

use std::cell::Cell;

use super::MAX_COEFFICIENTS;

/// One coefficient in each of `L` lanes.
pub(crate) type Lanes<const L: usize> = [f64; L];

/// Builds one coefficient lane by lane. This is a loop over the array, because
/// `std::array::from_fn` is not inlined for many lanes. A counted index is not optimized for one
/// lane (40 % more time on the forced oscillator).
#[inline(always)]
pub(crate) fn lanes<const L: usize>(mut f: impl FnMut(usize) -> f64) -> Lanes<L> {
    let mut out = [0.0; L];
    for (l, out) in out.iter_mut().enumerate() {
        *out = f(l);
    }
    out
}

/// Lanes from the lanes of one coefficient.
#[inline(always)]
pub(crate) fn lanes_of<const L: usize>(a: Lanes<L>, f: impl Fn(f64) -> f64) -> Lanes<L> {
    lanes(|l| f(a[l]))
}

/// The smaller of two numbers, or the first if either is NaN. One instruction, unlike `f64::min`.
#[inline(always)]
pub(crate) fn least(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

/// The larger of two numbers, or the first if either is NaN.
#[inline(always)]
pub(crate) fn largest(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// The newest coefficient of a product, from the first and the newest coefficient of both factors
/// and the sum `inner` over the terms between.
#[inline(always)]
pub(super) fn product<const L: usize>(
    inner: Lanes<L>,
    (a0, a): (Lanes<L>, Lanes<L>),
    (b0, b): (Lanes<L>, Lanes<L>),
) -> Lanes<L> {
    lanes(|l| inner[l] + (a0[l] * b[l] + a[l] * b0[l]))
}

/// The newest coefficient of a quotient with first coefficient `q0`.
#[inline(always)]
pub(super) fn quotient<const L: usize>(
    inner: Lanes<L>,
    a: Lanes<L>,
    (b0, b): (Lanes<L>, Lanes<L>),
    q0: Lanes<L>,
) -> Lanes<L> {
    lanes(|l| (a[l] - inner[l] - b[l] * q0[l]) * (1.0 / b0[l]))
}

/// Storage of one coefficient.
type Cells<const L: usize> = [Cell<f64>; L];

/// The coefficients of one number, by order.
#[derive(Clone, Debug)]
pub(crate) struct CoefficientRow<const L: usize>([Cells<L>; MAX_COEFFICIENTS]);

impl<const L: usize> CoefficientRow<L> {
    pub(crate) fn new() -> Self {
        CoefficientRow([const { [const { Cell::new(0.0) }; L] }; MAX_COEFFICIENTS])
    }

    #[inline(always)]
    pub(crate) fn set(&self, k: usize, value: Lanes<L>) {
        for (cell, value) in self.0[k].iter().zip(value) {
            cell.set(value);
        }
    }

    /// Coefficient `k` in every lane.
    #[inline(always)]
    pub(crate) fn at(&self, k: usize) -> Lanes<L> {
        lanes(|l| self.0[k][l].get())
    }

    /// Coefficient `k` in one lane.
    #[inline(always)]
    pub(crate) fn lane(&self, lane: usize, k: usize) -> f64 {
        self.0[k][lane].get()
    }

    /// `Σ a_j b_{k−j}` over `0 < j < k`: coefficient `k` of the product without the terms that have
    /// a coefficient 0. The sum runs from the middle outwards, so that the newest coefficients are
    /// needed last.
    #[inline(always)]
    pub(super) fn convolution(&self, other: &Self, k: usize) -> Lanes<L> {
        let ((a_low, a_mid, a_high), (b_low, b_mid, b_high)) = (self.halves(k), other.halves(k));
        let mut up: Lanes<L> = lanes(|l| a_mid[l] * b_mid[l]);
        let mut down = [0.0; L];
        let a = a_low.iter().rev().zip(a_high);
        let b = b_low.iter().rev().zip(b_high);
        for ((a_low, a_high), (b_low, b_high)) in a.zip(b) {
            for l in 0..L {
                up[l] += a_low[l].get() * b_high[l].get();
                down[l] += a_high[l].get() * b_low[l].get();
            }
        }
        lanes(|l| up[l] + down[l])
    }

    /// Coefficient of a square.
    #[inline(always)]
    pub(super) fn square(&self, k: usize) -> Lanes<L> {
        let (low, mid, high) = self.halves(k);
        let mut sum = [0.0; L];
        for (low, high) in low.iter().rev().zip(high) {
            for l in 0..L {
                sum[l] += low[l].get() * high[l].get();
            }
        }
        lanes(|l| 2.0 * sum[l] + mid[l] * mid[l])
    }

    /// Coefficients `1 .. k` in two halves, and the middle one, or zero.
    #[inline(always)]
    fn halves(&self, k: usize) -> (&[Cells<L>], Lanes<L>, &[Cells<L>]) {
        let inner = &self.0[1..k.max(1)];
        let half = inner.len() / 2;
        let middle = if inner.len() % 2 == 1 {
            lanes(|l| inner[half][l].get())
        } else {
            [0.0; L]
        };
        (&inner[..half], middle, &inner[inner.len() - half..])
    }
}
