//! The number type of a model: `f64`, or dual numbers if a derivative is needed.

use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

pub use crate::dual::Dual;
pub use crate::interval::Interval;

use crate::math;

/// A real number with the operations that a vector field may use.
///
/// Models are generic over it, so that the library can run the same two functions on several types.
/// Numbers of type `f64` give values, and coefficients give Taylor series. Dual numbers give
/// Jacobians, normal components and Lie derivatives. Any type with arithmetic and these few
/// functions, such as an interval, can implement the trait.
///
/// Constants enter through the `f64` operators (`x * 2.0`) or [`Scalar::constant`]. They stand on
/// the right: the compiler rejects `0.5 * x` and `1.0 - x` with "cannot multiply `f64` by `T`",
/// because a trait cannot require operators of `f64`. Write `x * 0.5`, `-x + 1.0`, and `x.recip()`
/// for `1.0 / x`.
///
/// There is no `signum`: friction has one smooth formula on each [`crate::Side`].
pub trait Scalar:
    Copy
    + Debug
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
    /// The number 0. A type that folds constants knows it without a look at the value.
    #[inline(always)]
    fn zero() -> Self {
        Self::constant(0.0)
    }
    /// The number 1; as [`Scalar::zero`].
    #[inline(always)]
    fn one() -> Self {
        Self::constant(1.0)
    }
    /// The value without derivatives, which comparisons use.
    fn value(self) -> f64;
    /// Sine (radians).
    fn sin(self) -> Self;
    /// Cosine (radians).
    fn cos(self) -> Self;
    /// Sine and cosine, faster than each alone where they share work.
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        (self.sin(), self.cos())
    }
    /// Tangent (radians).
    fn tan(self) -> Self;
    /// Arc tangent in `(-π/2, π/2)`.
    fn atan(self) -> Self;
    /// Angle of the point `(x, self)` in `[-π, π]`. It jumps by 2π where the point crosses the
    /// negative x axis, and has no derivative at the origin. Branches are by [`Scalar::exceeds`].
    fn atan2(self, x: Self) -> Self {
        // In each of four sectors the quotient is at most 1, so that no digits are lost.
        match (self.exceeds(x), self.exceeds(-x)) {
            (false, true) => (self / x).atan(),
            (true, true) => -(x / self).atan() + FRAC_PI_2,
            (false, false) => -(x / self).atan() - FRAC_PI_2,
            (true, false) if Self::zero().exceeds(self) => (self / x).atan() - PI,
            (true, false) => (self / x).atan() + PI,
        }
    }
    /// The error function, `2/√π ∫ exp(−t²) dt` from 0 on.
    fn erf(self) -> Self;
    /// Hyperbolic sine.
    fn sinh(self) -> Self;
    /// Hyperbolic cosine.
    fn cosh(self) -> Self;
    /// Hyperbolic tangent, a smooth sign.
    fn tanh(self) -> Self;
    /// Real power of a positive number.
    fn powf(self, p: f64) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// `e^self`.
    fn exp(self) -> Self;
    /// Natural logarithm.
    fn ln(self) -> Self;
    /// `1/self`: what to write for `1.0 / x`.
    fn recip(self) -> Self {
        Self::one() / self
    }
    /// Integer power by repeated multiplication.
    fn powi(self, n: i32) -> Self {
        let mut base = self;
        let mut left = n.unsigned_abs();
        let mut product = Self::one();
        while left > 0 {
            if left & 1 == 1 {
                product = product * base;
            }
            left >>= 1;
            if left > 0 {
                base = base * base;
            }
        }
        if n < 0 { product.recip() } else { product }
    }
    /// Whether both are certain to be the same number by their origin, whatever their values.
    #[inline(always)]
    fn is_same(self, _other: Self) -> bool {
        false
    }
    /// Whether the value has overflowed. It then carries no derivatives, so that those of `1/x` and
    /// the like are zero there.
    #[inline(always)]
    fn has_overflowed(self) -> bool {
        false
    }
    /// Whether it is the larger by value: the comparison of [`Scalar::max`] and [`Scalar::min`].
    /// Branch on it rather than on [`Scalar::value`]: [`crate::Method::Taylor`] ends a step where
    /// the result changes.
    #[inline(always)]
    fn exceeds(self, other: Self) -> bool {
        self.value() > other.value()
    }
    /// The larger of the two by value.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if other.exceeds(self) { other } else { self }
    }
    /// The smaller of the two by value.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self.exceeds(other) { other } else { self }
    }
    /// The absolute value, by [`Scalar::exceeds`].
    #[inline(always)]
    fn abs(self) -> Self {
        if Self::zero().exceeds(self) {
            -self
        } else {
            self
        }
    }
    /// A continuous function in pieces: `value` of the piece that holds at this number, and of the
    /// number. Piece `k` lies between `cuts[k - 1]` and `cuts[k]`, which rise. The first cut is in
    /// the piece above it, every other one in the piece below. Branches are by [`Scalar::exceeds`].
    #[inline(always)]
    fn in_pieces(self, cuts: &[f64], value: impl Fn(usize, Self) -> Self) -> Self {
        let (mut low, mut high) = (0, cuts.len());
        while low < high {
            let middle = (low + high) / 2;
            let cut = Self::constant(cuts[middle]);
            let is_above = match middle {
                0 => !cut.exceeds(self),
                _ => self.exceeds(cut),
            };
            if is_above {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        value(low, self)
    }
    /// Whether its value is zero; of a series, at its start.
    #[inline(always)]
    fn vanishes(self) -> bool {
        self.value() == 0.0
    }
    /// The quotient, or the constant `otherwise` where `by` is zero.
    #[inline(always)]
    fn divided_or(self, by: Self, otherwise: f64) -> Self {
        if by.value() == 0.0 {
            Self::constant(otherwise)
        } else {
            self / by
        }
    }
}

impl Scalar for f64 {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn has_overflowed(self) -> bool {
        self.is_infinite()
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
    fn sin_cos(self) -> (Self, Self) {
        math::sin_cos(self)
    }
    #[inline(always)]
    fn tan(self) -> Self {
        math::tan(self)
    }
    #[inline(always)]
    fn atan(self) -> Self {
        math::atan(self)
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        math::atan2(self, x)
    }
    #[inline(always)]
    fn erf(self) -> Self {
        math::erf(self)
    }
    #[inline(always)]
    fn sinh(self) -> Self {
        math::sinh(self)
    }
    #[inline(always)]
    fn cosh(self) -> Self {
        math::cosh(self)
    }
    #[inline(always)]
    fn tanh(self) -> Self {
        math::tanh(self)
    }
    #[inline(always)]
    fn powf(self, p: f64) -> Self {
        math::pow(self, p)
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
