//! The number type a model is written in: `f64`, or dual numbers when a derivative is wanted.

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

pub use num_dual::Dual;
use num_dual::{Dual3, DualNum};

use crate::math;

/// A real number with the operations that a vector field may use.
///
/// Models are generic over it, so that the library can run the same two functions on `f64` for values
/// and on dual numbers for Jacobians, normal components and Lie derivatives. It asks for little on
/// purpose: any type with arithmetic and these few functions (a recording number, say) can implement it.
///
/// Constants enter through the `f64` operators (`x * 2.0`) or [`Scalar::constant`].
pub trait Scalar:
    Copy
    + Debug
    + PartialEq
    + Send
    + Sync
    + 'static
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
{
    /// The number `value` with no derivative.
    fn constant(value: f64) -> Self;
    /// The value, derivatives dropped; comparisons are made on it.
    fn value(self) -> f64;
    /// Sine (radians).
    fn sin(self) -> Self;
    /// Cosine (radians).
    fn cos(self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// `e^self`.
    fn exp(self) -> Self;
    /// Natural logarithm.
    fn ln(self) -> Self;
    /// Integer power by repeated multiplication.
    fn powi(self, n: i32) -> Self {
        let mut base = self;
        let mut left = n.unsigned_abs();
        let mut product = Self::constant(1.0);
        while left > 0 {
            if left & 1 == 1 {
                product = product * base;
            }
            left >>= 1;
            if left > 0 {
                base = base * base;
            }
        }
        if n < 0 {
            Self::constant(1.0) / product
        } else {
            product
        }
    }
    /// Whether it is the larger by value: the comparison behind [`Scalar::max`] and [`Scalar::min`]. To branch on it is
    /// better than on [`Scalar::value`]: where the answer changes within a step, [`crate::Method::Taylor`] ends the step there.
    fn exceeds(self, other: Self) -> bool {
        self.value() > other.value()
    }
    /// The larger of the two by value.
    fn max(self, other: Self) -> Self {
        if other.exceeds(self) { other } else { self }
    }
    /// The smaller of the two by value.
    fn min(self, other: Self) -> Self {
        if self.exceeds(other) { other } else { self }
    }
    /// The quotient, or the constant `otherwise` where `by` is zero.
    fn divided_or(self, by: Self, otherwise: f64) -> Self {
        if by.value() == 0.0 {
            Self::constant(otherwise)
        } else {
            self / by
        }
    }
}

/// A [`Scalar`] that dual numbers can be built over; `f64` and every dual number of this crate's.
pub trait Differentiable: Scalar + DualNum<Primitive = f64> {}
impl<T: Scalar + DualNum<Primitive = f64>> Differentiable for T {}

impl Scalar for f64 {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn value(self) -> f64 {
        self
    }
    #[inline(always)]
    fn sin(self) -> Self {
        math::sin(self)
    }
    #[inline(always)]
    fn cos(self) -> Self {
        math::cos(self)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn exp(self) -> Self {
        math::exp(self)
    }
    #[inline(always)]
    fn ln(self) -> Self {
        math::ln(self)
    }
}

/// First derivatives. The elementary functions are applied here through [`Scalar`] rather than by the
/// dual number's own methods, because those would call the platform's C library.
impl<T: Differentiable> Scalar for Dual<T> {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Dual::new(T::constant(value), T::constant(0.0))
    }
    #[inline(always)]
    fn value(self) -> f64 {
        self.re.value()
    }
    #[inline(always)]
    fn exceeds(self, other: Self) -> bool {
        self.re.exceeds(other.re)
    }
    #[inline(always)]
    fn sin(self) -> Self {
        Dual::new(Scalar::sin(self.re), self.eps * Scalar::cos(self.re))
    }
    #[inline(always)]
    fn cos(self) -> Self {
        Dual::new(Scalar::cos(self.re), -(self.eps * Scalar::sin(self.re)))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = Scalar::sqrt(self.re);
        Dual::new(root, self.eps / (root * 2.0))
    }
    #[inline(always)]
    fn exp(self) -> Self {
        let e = Scalar::exp(self.re);
        Dual::new(e, self.eps * e)
    }
    #[inline(always)]
    fn ln(self) -> Self {
        Dual::new(Scalar::ln(self.re), self.eps / self.re)
    }
}

/// `f ∘ x` to third order from the values of `f` and its first three derivatives at `x.re`
/// (Faà di Bruno).
#[inline(always)]
fn compose3<T: Differentiable>(x: Dual3<T>, f: [T; 4]) -> Dual3<T> {
    let [f0, f1, f2, f3] = f;
    Dual3::new(
        f0,
        f1 * x.v1,
        f2 * x.v1 * x.v1 + f1 * x.v2,
        f3 * x.v1 * x.v1 * x.v1 + f2 * x.v1 * x.v2 * 3.0 + f1 * x.v3,
    )
}

impl<T: Differentiable> Scalar for Dual3<T> {
    fn constant(value: f64) -> Self {
        let zero = T::constant(0.0);
        Dual3::new(T::constant(value), zero, zero, zero)
    }
    fn value(self) -> f64 {
        self.re.value()
    }
    fn exceeds(self, other: Self) -> bool {
        self.re.exceeds(other.re)
    }
    fn sin(self) -> Self {
        let (s, c) = (Scalar::sin(self.re), Scalar::cos(self.re));
        compose3(self, [s, c, -s, -c])
    }
    fn cos(self) -> Self {
        let (s, c) = (Scalar::sin(self.re), Scalar::cos(self.re));
        compose3(self, [c, -s, -c, s])
    }
    fn sqrt(self) -> Self {
        let root = Scalar::sqrt(self.re);
        let d1 = T::constant(0.5) / root;
        let d2 = -(d1 * 0.5) / self.re;
        let d3 = -(d2 * 1.5) / self.re;
        compose3(self, [root, d1, d2, d3])
    }
    fn exp(self) -> Self {
        let e = Scalar::exp(self.re);
        compose3(self, [e, e, e, e])
    }
    fn ln(self) -> Self {
        let inverse = T::constant(1.0) / self.re;
        let square = inverse * inverse;
        compose3(
            self,
            [
                Scalar::ln(self.re),
                inverse,
                -square,
                square * inverse * 2.0,
            ],
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// f(t) = ln(sqrt(exp(sin t) + cos t + 2)) + t^-3, written once for every scalar.
    fn f<T: Scalar>(t: T) -> T {
        Scalar::ln(Scalar::sqrt(
            Scalar::exp(Scalar::sin(t)) + Scalar::cos(t) + 2.0,
        )) + Scalar::powi(t, -3)
    }

    #[test]
    fn third_order_duals_agree_with_nested_first_order_ones() {
        let t = 0.7;
        let third = f(Dual3::new(t, 1.0, 0.0, 0.0));
        let nested = f(Dual::new(
            Dual::new(Dual::new(t, 1.0), Dual::new(1.0, 0.0)),
            Dual::new(Dual::new(1.0, 0.0), Dual::new(0.0, 0.0)),
        ));
        approx::assert_relative_eq!(third.re, f(t), max_relative = 1e-15);
        approx::assert_relative_eq!(third.v1, nested.re.re.eps, max_relative = 1e-13);
        approx::assert_relative_eq!(third.v2, nested.re.eps.eps, max_relative = 1e-13);
        approx::assert_relative_eq!(third.v3, nested.eps.eps.eps, max_relative = 1e-13);
        let h = 1e-4;
        approx::assert_relative_eq!(
            third.v1,
            (f(t + h) - f(t - h)) / (2.0 * h),
            max_relative = 1e-7
        );
    }

    #[test]
    fn max_and_min_compare_by_value_and_keep_the_derivative() {
        let (a, b) = (Dual::new(1.0, 5.0), Dual::new(2.0, 7.0));
        assert_eq!(Scalar::max(a, b).eps, 7.0);
        assert_eq!(Scalar::min(a, b).eps, 5.0);
    }
}
