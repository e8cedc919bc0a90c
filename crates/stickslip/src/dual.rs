//! Dual numbers: a value with its derivatives, carried through any function that is written for a
//! [`Scalar`].
//!
//! They are built over any scalar, also over another dual number. The elementary functions come
//! from [`crate::math`], so that derivatives have the same bits on every machine.

use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::math::ERF_SLOPE;
use crate::scalar::Scalar;

/// A value and its first derivative.
///
/// ```
/// use stickslip::Scalar;
/// use stickslip::scalar::Dual;
///
/// let x = Dual::new(3.0, 1.0);
/// assert_eq!((x * x + 1.0).eps, 6.0);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Dual<T> {
    /// Value.
    pub re: T,
    /// First derivative.
    pub eps: T,
}

impl<T> Dual<T> {
    /// The value `re` with the derivative `eps`.
    #[inline(always)]
    pub fn new(re: T, eps: T) -> Self {
        Dual { re, eps }
    }
}

impl<T: Scalar> Dual<T> {
    /// `f ∘ x` from the value of `f` and its derivative at `x.re`.
    #[inline(always)]
    fn compose(self, [f0, f1]: [T; 2]) -> Self {
        let is_flat = self.re.has_overflowed() || f0.has_overflowed();
        let eps = f1 * self.eps;
        Dual::new(f0, if is_flat { T::zero() } else { eps })
    }
}

impl<T: Scalar> Neg for Dual<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Dual::new(-self.re, -self.eps)
    }
}

impl<T: Scalar> Add for Dual<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Dual::new(self.re + other.re, self.eps + other.eps)
    }
}

impl<T: Scalar> Sub for Dual<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Dual::new(self.re - other.re, self.eps - other.eps)
    }
}

impl<T: Scalar> Mul for Dual<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Dual::new(
            self.re * other.re,
            self.eps * other.re + other.eps * self.re,
        )
    }
}

impl<T: Scalar> Div for Dual<T> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let inverse = other.re.recip();
        let eps = (self.eps * other.re - other.eps * self.re) * inverse * inverse;
        let is_nothing = other.re.has_overflowed();
        Dual::new(self.re * inverse, if is_nothing { T::zero() } else { eps })
    }
}

/// A value and its first three derivatives with respect to one variable.
#[derive(Clone, Copy, Debug)]
pub struct Dual3<T> {
    pub re: T,
    pub v1: T,
    pub v2: T,
    pub v3: T,
}

impl<T> Dual3<T> {
    #[inline(always)]
    pub fn new(re: T, v1: T, v2: T, v3: T) -> Self {
        Dual3 { re, v1, v2, v3 }
    }
}

impl<T: Scalar> Dual3<T> {
    /// `f ∘ x` to third order from the values of `f` and its first three derivatives at `x.re` (Faà
    /// di Bruno).
    #[inline(always)]
    fn compose(self, [f0, f1, f2, f3]: [T; 4]) -> Self {
        let is_flat = self.re.has_overflowed() || f0.has_overflowed();
        let unless_flat = |v: T| if is_flat { T::zero() } else { v };
        let Dual3 { v1, v2, v3, .. } = self;
        Dual3::new(
            f0,
            unless_flat(f1 * v1),
            unless_flat(f2 * v1 * v1 + f1 * v2),
            unless_flat(f3 * v1 * v1 * v1 + f2 * v1 * v2 * 3.0 + f1 * v3),
        )
    }
}

impl<T: Scalar> Dual3<T> {
    /// Whether it is zero with all its derivatives.
    fn stays_zero(self) -> bool {
        let Dual3 { re, v1, v2, v3 } = self;
        re.vanishes() && v1.vanishes() && v2.vanishes() && v3.vanishes()
    }
}

impl<T: Scalar> Neg for Dual3<T> {
    type Output = Self;
    fn neg(self) -> Self {
        Dual3::new(-self.re, -self.v1, -self.v2, -self.v3)
    }
}

impl<T: Scalar> Add for Dual3<T> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Dual3::new(
            self.re + other.re,
            self.v1 + other.v1,
            self.v2 + other.v2,
            self.v3 + other.v3,
        )
    }
}

impl<T: Scalar> Sub for Dual3<T> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Dual3::new(
            self.re - other.re,
            self.v1 - other.v1,
            self.v2 - other.v2,
            self.v3 - other.v3,
        )
    }
}

impl<T: Scalar> Mul for Dual3<T> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let (a, b) = (self, other);
        Dual3::new(
            a.re * b.re,
            a.v1 * b.re + a.re * b.v1,
            a.v2 * b.re + a.v1 * 2.0 * b.v1 + a.re * b.v2,
            a.v3 * b.re + (a.v2 * b.v1 + a.v1 * b.v2) * 3.0 + a.re * b.v3,
        )
    }
}

impl<T: Scalar> Div for Dual3<T> {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        Mul::mul(self, other.recip())
    }
}

/// The operators with a constant, which moves the value of a sum and scales all of a product.
macro_rules! with_constants {
    ($dual:ident, $($derivative:ident),*) => {
        impl<T: Scalar> Add<f64> for $dual<T> {
            type Output = Self;
            #[inline(always)]
            fn add(self, other: f64) -> Self {
                $dual { re: self.re + other, ..self }
            }
        }
        impl<T: Scalar> Sub<f64> for $dual<T> {
            type Output = Self;
            #[inline(always)]
            fn sub(self, other: f64) -> Self {
                $dual { re: self.re - other, ..self }
            }
        }
        impl<T: Scalar> Mul<f64> for $dual<T> {
            type Output = Self;
            #[inline(always)]
            fn mul(self, other: f64) -> Self {
                $dual { re: self.re * other, $($derivative: self.$derivative * other),* }
            }
        }
        impl<T: Scalar> Div<f64> for $dual<T> {
            type Output = Self;
            #[inline(always)]
            fn div(self, other: f64) -> Self {
                $dual { re: self.re / other, $($derivative: self.$derivative / other),* }
            }
        }
    };
}

with_constants!(Dual, eps);
with_constants!(Dual3, v1, v2, v3);

impl<T: Scalar> Scalar for Dual<T> {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Dual::new(T::constant(value), T::zero())
    }
    #[inline(always)]
    fn zero() -> Self {
        Dual::new(T::zero(), T::zero())
    }
    #[inline(always)]
    fn one() -> Self {
        Dual::new(T::one(), T::zero())
    }
    #[inline(always)]
    fn value(self) -> f64 {
        self.re.value()
    }
    #[inline(always)]
    fn has_overflowed(self) -> bool {
        self.re.has_overflowed()
    }
    #[inline(always)]
    fn exceeds(self, other: Self) -> bool {
        self.re.exceeds(other.re)
    }
    #[inline(always)]
    fn recip(self) -> Self {
        let inverse = self.re.recip();
        self.compose([inverse, -inverse * inverse])
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (sine, cosine) = self.re.sin_cos();
        (
            Dual::new(sine, self.eps * cosine),
            Dual::new(cosine, -(self.eps * sine)),
        )
    }
    #[inline(always)]
    fn sin(self) -> Self {
        self.sin_cos().0
    }
    #[inline(always)]
    fn cos(self) -> Self {
        self.sin_cos().1
    }
    #[inline(always)]
    fn tan(self) -> Self {
        let t = self.re.tan();
        self.compose([t, t * t + 1.0])
    }
    #[inline(always)]
    fn atan(self) -> Self {
        self.compose([self.re.atan(), (self.re * self.re + 1.0).recip()])
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        let square = self.re * self.re + x.re * x.re;
        let turn = self.eps * x.re - x.eps * self.re;
        Dual::new(self.re.atan2(x.re), turn / square)
    }
    #[inline(always)]
    fn erf(self) -> Self {
        let slope = (-(self.re * self.re)).exp() * ERF_SLOPE;
        self.compose([self.re.erf(), slope])
    }
    #[inline(always)]
    fn sinh(self) -> Self {
        self.compose([self.re.sinh(), self.re.cosh()])
    }
    #[inline(always)]
    fn cosh(self) -> Self {
        self.compose([self.re.cosh(), self.re.sinh()])
    }
    #[inline(always)]
    fn tanh(self) -> Self {
        let t = self.re.tanh();
        self.compose([t, -(t * t) + 1.0])
    }
    #[inline(always)]
    fn powf(self, p: f64) -> Self {
        if self.re.vanishes() && self.eps.vanishes() {
            return Dual::new(self.re.powf(p), T::zero());
        }
        self.compose([self.re.powf(p), self.re.powf(p - 1.0) * p])
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.re.sqrt();
        let eps = if root.vanishes() && self.eps.vanishes() {
            T::zero()
        } else {
            self.eps / (root * 2.0)
        };
        Dual::new(root, eps)
    }
    #[inline(always)]
    fn exp(self) -> Self {
        let e = self.re.exp();
        self.compose([e, e])
    }
    #[inline(always)]
    fn ln(self) -> Self {
        Dual::new(self.re.ln(), self.eps / self.re)
    }
}

impl<T: Scalar> Scalar for Dual3<T> {
    fn constant(value: f64) -> Self {
        let zero = T::zero();
        Dual3::new(T::constant(value), zero, zero, zero)
    }
    fn zero() -> Self {
        let zero = T::zero();
        Dual3::new(zero, zero, zero, zero)
    }
    fn one() -> Self {
        let zero = T::zero();
        Dual3::new(T::one(), zero, zero, zero)
    }
    fn value(self) -> f64 {
        self.re.value()
    }
    fn has_overflowed(self) -> bool {
        self.re.has_overflowed()
    }
    fn exceeds(self, other: Self) -> bool {
        self.re.exceeds(other.re)
    }
    fn recip(self) -> Self {
        let f0 = self.re.recip();
        let f1 = -f0 * f0;
        let f2 = -f1 * f0 * 2.0;
        let f3 = -f2 * f0 * 3.0;
        self.compose([f0, f1, f2, f3])
    }
    fn sin(self) -> Self {
        let (s, c) = self.re.sin_cos();
        self.compose([s, c, -s, -c])
    }
    fn cos(self) -> Self {
        let (s, c) = self.re.sin_cos();
        self.compose([c, -s, -c, s])
    }
    fn tan(self) -> Self {
        let t = self.re.tan();
        let square = t * t;
        let f1 = square + 1.0;
        self.compose([t, f1, t * f1 * 2.0, f1 * (square * 3.0 + 1.0) * 2.0])
    }
    fn atan(self) -> Self {
        let x = self.re;
        let f1 = (x * x + 1.0).recip();
        let square = f1 * f1;
        self.compose([
            x.atan(),
            f1,
            x * square * -2.0,
            square * (x * x * f1 * 8.0 - 2.0),
        ])
    }
    fn erf(self) -> Self {
        let x = self.re;
        let square = x * x;
        let f1 = (-square).exp() * ERF_SLOPE;
        self.compose([x.erf(), f1, x * f1 * -2.0, (square * 4.0 - 2.0) * f1])
    }
    fn sinh(self) -> Self {
        let (s, c) = (self.re.sinh(), self.re.cosh());
        self.compose([s, c, s, c])
    }
    fn cosh(self) -> Self {
        let (s, c) = (self.re.sinh(), self.re.cosh());
        self.compose([c, s, c, s])
    }
    fn tanh(self) -> Self {
        let t = self.re.tanh();
        let square = t * t;
        let f1 = -square + 1.0;
        self.compose([t, f1, t * f1 * -2.0, f1 * (square * 3.0 - 1.0) * 2.0])
    }
    fn powf(self, p: f64) -> Self {
        let x = self.re;
        if self.stays_zero() {
            let zero = T::zero();
            return Dual3::new(x.powf(p), zero, zero, zero);
        }
        self.compose([
            x.powf(p),
            x.powf(p - 1.0) * p,
            x.powf(p - 2.0) * (p * (p - 1.0)),
            x.powf(p - 3.0) * (p * (p - 1.0) * (p - 2.0)),
        ])
    }
    fn sqrt(self) -> Self {
        let root = self.re.sqrt();
        if self.stays_zero() {
            let zero = T::zero();
            return Dual3::new(root, zero, zero, zero);
        }
        let d1 = T::constant(0.5) / root;
        let d2 = -(d1 * 0.5) / self.re;
        let d3 = -(d2 * 1.5) / self.re;
        self.compose([root, d1, d2, d3])
    }
    fn exp(self) -> Self {
        let e = self.re.exp();
        self.compose([e, e, e, e])
    }
    fn ln(self) -> Self {
        let inverse = T::constant(1.0) / self.re;
        let square = inverse * inverse;
        self.compose([self.re.ln(), inverse, -square, square * inverse * 2.0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A combination of all functions, for every scalar.
    fn f<T: Scalar>(t: T) -> T {
        let waves = t.sin().exp() + t.cos() + t.tan().atan() + 2.0;
        let others = t.sinh() * t.tanh() - t.cosh() + t.powf(1.7) + (-t.sin()).exp() + (-t).abs();
        let angles = t.sin().atan2(t - 2.0) + (-t).atan2(t * 3.0) + (t * 0.8).erf();
        waves.sqrt().ln() + others + t.powi(-3) + angles
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
