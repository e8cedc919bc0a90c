//! Dual numbers with several directions: one value that all derivatives share.

use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::math::ERF_SLOPE;
use crate::scalar::Scalar;
use crate::taylor::row::{Lanes, lanes};

/// A value and its first derivatives along `W` directions. Each derivative has the bits that it has
/// in a [`crate::scalar::Dual`] of its own.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Duals<const W: usize> {
    /// Value.
    pub re: f64,
    /// First derivatives, one for each direction.
    pub eps: Lanes<W>,
}

impl<const W: usize> Duals<W> {
    /// Derivatives of the product with another number.
    #[inline(always)]
    fn of_product(&self, other: &Self) -> Lanes<W> {
        lanes(|l| self.eps[l] * other.re + other.eps[l] * self.re)
    }

    /// Derivatives of the quotient by another number, which has this reciprocal.
    #[inline(always)]
    fn of_quotient(&self, other: &Self, inverse: f64) -> Lanes<W> {
        let is_nothing = other.re.is_infinite();
        lanes(|l| match is_nothing {
            true => 0.0,
            false => (self.eps[l] * other.re - other.eps[l] * self.re) * inverse * inverse,
        })
    }

    /// Adds a multiple of another number.
    #[inline(always)]
    pub(crate) fn add_scaled(&mut self, factor: f64, other: &Self) {
        self.re += factor * other.re;
        for l in 0..W {
            self.eps[l] += factor * other.eps[l];
        }
    }

    /// `f ∘ x` from the value of `f` and its derivative at `x.re`.
    #[inline(always)]
    fn compose(self, [f0, f1]: [f64; 2]) -> Self {
        let is_flat = self.re.is_infinite() || f0.is_infinite();
        let eps = lanes(|l| if is_flat { 0.0 } else { f1 * self.eps[l] });
        Duals { re: f0, eps }
    }
}

impl<const W: usize> Neg for Duals<W> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        let eps = lanes(|l| -self.eps[l]);
        Duals { re: -self.re, eps }
    }
}

impl<const W: usize> Add for Duals<W> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let eps = lanes(|l| self.eps[l] + other.eps[l]);
        let re = self.re + other.re;
        Duals { re, eps }
    }
}

impl<const W: usize> Sub for Duals<W> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let eps = lanes(|l| self.eps[l] - other.eps[l]);
        let re = self.re - other.re;
        Duals { re, eps }
    }
}

impl<const W: usize> Mul for Duals<W> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let re = self.re * other.re;
        let eps = self.of_product(&other);
        Duals { re, eps }
    }
}

impl<const W: usize> Div for Duals<W> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let inverse = 1.0 / other.re;
        let eps = self.of_quotient(&other, inverse);
        let re = self.re * inverse;
        Duals { re, eps }
    }
}

impl<const W: usize> Add<f64> for Duals<W> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: f64) -> Self {
        let re = self.re + other;
        Duals { re, ..self }
    }
}

impl<const W: usize> Sub<f64> for Duals<W> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: f64) -> Self {
        let re = self.re - other;
        Duals { re, ..self }
    }
}

impl<const W: usize> Mul<f64> for Duals<W> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        let eps = lanes(|l| self.eps[l] * other);
        let re = self.re * other;
        Duals { re, eps }
    }
}

impl<const W: usize> Div<f64> for Duals<W> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: f64) -> Self {
        let eps = lanes(|l| self.eps[l] / other);
        let re = self.re / other;
        Duals { re, eps }
    }
}

impl<const W: usize> Scalar for Duals<W> {
    #[inline(always)]
    fn constant(re: f64) -> Self {
        let eps = [0.0; W];
        Duals { re, eps }
    }
    #[inline(always)]
    fn value(self) -> f64 {
        self.re
    }
    #[inline(always)]
    fn has_overflowed(self) -> bool {
        self.re.is_infinite()
    }
    #[inline(always)]
    fn recip(self) -> Self {
        let inverse = 1.0 / self.re;
        self.compose([inverse, -inverse * inverse])
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (sine, cosine) = Scalar::sin_cos(self.re);
        let with = |re: f64, eps: Lanes<W>| Duals { re, eps };
        (
            with(sine, lanes(|l| self.eps[l] * cosine)),
            with(cosine, lanes(|l| -(self.eps[l] * sine))),
        )
    }
    fn sin(self) -> Self {
        self.sin_cos().0
    }
    fn cos(self) -> Self {
        self.sin_cos().1
    }
    fn tan(self) -> Self {
        let t = Scalar::tan(self.re);
        self.compose([t, t * t + 1.0])
    }
    fn atan(self) -> Self {
        let inverse = 1.0 / (self.re * self.re + 1.0);
        self.compose([Scalar::atan(self.re), inverse])
    }
    fn atan2(self, x: Self) -> Self {
        let square = self.re * self.re + x.re * x.re;
        let re = Scalar::atan2(self.re, x.re);
        let eps = lanes(|l| (self.eps[l] * x.re - x.eps[l] * self.re) / square);
        Duals { re, eps }
    }
    fn erf(self) -> Self {
        let slope = Scalar::exp(-(self.re * self.re)) * ERF_SLOPE;
        self.compose([Scalar::erf(self.re), slope])
    }
    fn sinh(self) -> Self {
        self.compose([Scalar::sinh(self.re), Scalar::cosh(self.re)])
    }
    fn cosh(self) -> Self {
        self.compose([Scalar::cosh(self.re), Scalar::sinh(self.re)])
    }
    fn tanh(self) -> Self {
        let t = Scalar::tanh(self.re);
        self.compose([t, -(t * t) + 1.0])
    }
    fn powf(self, p: f64) -> Self {
        let slope = Scalar::powf(self.re, p - 1.0) * p;
        self.compose([Scalar::powf(self.re, p), slope])
    }
    fn sqrt(self) -> Self {
        let re = self.re.sqrt();
        let eps = lanes(|l| self.eps[l] / (re * 2.0));
        Duals { re, eps }
    }
    fn exp(self) -> Self {
        let e = Scalar::exp(self.re);
        self.compose([e, e])
    }
    fn ln(self) -> Self {
        let eps = lanes(|l| self.eps[l] / self.re);
        let re = Scalar::ln(self.re);
        Duals { re, eps }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::scalar::Dual;

    /// All operations, for every scalar.
    fn all<T: Scalar>(x: T, y: T) -> [T; 18] {
        let (sine, cosine) = (x * y).sin_cos();
        [
            x + y - (x - 0.3) * 1.7 / 0.9,
            x / y + (y + 2.5).recip(),
            -sine * cosine,
            (x * 0.3).tan(),
            (y - x).atan(),
            x.atan2(y) + (-x).atan2(-y),
            (x * 0.4).erf(),
            x.sinh(),
            y.cosh(),
            (x - y).tanh(),
            x.powf(1.7) + y.powi(-3),
            (x * y).sqrt(),
            (x * 200.0).exp(),
            y.ln(),
            (x - 1.5).abs() + x.max(y) - x.min(y),
            x.divided_or(y - y.value(), 3.0),
            y / ((x * 900.0).exp() + 1.0),
            x.in_pieces(&[1.0, 1.6], |piece, x| x * x * piece as f64),
        ]
    }

    proptest! {
        #![proptest_config(ProptestConfig {
            failure_persistence: None,
            ..ProptestConfig::default()
        })]
        #[test]
        fn each_direction_has_the_bits_of_a_dual_number_of_its_own(
            (x, y) in (0.1..3.0, 0.1..3.0),
            along in prop::array::uniform6(-2.0..2.0),
        ) {
            let [a, b, c, d, e, f] = along;
            let (x_eps, y_eps) = ([a, b, c], [d, e, f]);
            let together = all(Duals { re: x, eps: x_eps }, Duals { re: y, eps: y_eps });
            for l in 0..3 {
                let alone = all(Dual::new(x, x_eps[l]), Dual::new(y, y_eps[l]));
                for (one, other) in alone.iter().zip(&together) {
                    prop_assert_eq!(one.re.to_bits(), other.re.to_bits());
                    prop_assert_eq!(one.eps.to_bits(), other.eps[l].to_bits());
                }
            }
        }
    }
}
