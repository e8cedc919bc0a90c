//! Intervals as a number type: where a function may be over a whole range of arguments.

use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::scalar::Scalar;

/// All numbers between `low` and `high`. A function run on intervals gives an interval that holds all its values (Moore 1966),
/// mostly a wider one. Bounds are not rounded outward: they are for questions that leave room for rounding.
///
/// Where a result is not defined for all arguments its bounds are not numbers, and every comparison with them fails.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Interval {
    pub low: f64,
    pub high: f64,
}

const NOWHERE: Interval = Interval {
    low: f64::NAN,
    high: f64::NAN,
};

impl Interval {
    #[inline(always)]
    pub fn new(low: f64, high: f64) -> Self {
        Interval { low, high }
    }

    #[inline(always)]
    pub fn around(middle: f64, radius: f64) -> Self {
        Interval::new(middle - radius, middle + radius)
    }

    /// The image under a function that does not fall.
    fn rising(self, f: impl Fn(f64) -> f64) -> Self {
        Interval::new(f(self.low), f(self.high))
    }

    /// The image under a function of values between −1 and 1 and slopes no steeper.
    fn wave(self, f: impl Fn(f64) -> f64) -> Self {
        let middle = f(self.value());
        let radius = 0.5 * (self.high - self.low);
        Interval::new((middle - radius).max(-1.0), (middle + radius).min(1.0))
    }
}

impl Neg for Interval {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Interval::new(-self.high, -self.low)
    }
}
impl Add for Interval {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Interval::new(self.low + other.low, self.high + other.high)
    }
}
impl Sub for Interval {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Interval::new(self.low - other.high, self.high - other.low)
    }
}
impl Mul for Interval {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let products = [
            self.low * other.low,
            self.low * other.high,
            self.high * other.low,
            self.high * other.high,
        ];
        // The library's min and max would take a number over what is none.
        if products.iter().any(|p| p.is_nan()) {
            return NOWHERE;
        }
        let (mut low, mut high) = (products[0], products[0]);
        for p in &products[1..] {
            low = if *p < low { *p } else { low };
            high = if *p > high { *p } else { high };
        }
        Interval { low, high }
    }
}
impl Div for Interval {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        if other.low > 0.0 || other.high < 0.0 {
            self * Interval::new(1.0 / other.high, 1.0 / other.low)
        } else {
            NOWHERE
        }
    }
}
impl Add<f64> for Interval {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: f64) -> Self {
        Interval::new(self.low + other, self.high + other)
    }
}
impl Sub<f64> for Interval {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: f64) -> Self {
        Interval::new(self.low - other, self.high - other)
    }
}
impl Mul<f64> for Interval {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        let (one, two) = (self.low * other, self.high * other);
        if other < 0.0 {
            Interval::new(two, one)
        } else {
            Interval::new(one, two)
        }
    }
}
impl Div<f64> for Interval {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: f64) -> Self {
        self * (1.0 / other)
    }
}

impl Scalar for Interval {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Interval::new(value, value)
    }
    /// The middle.
    #[inline(always)]
    fn value(self) -> f64 {
        0.5 * (self.low + self.high)
    }
    fn sin(self) -> Self {
        self.wave(Scalar::sin)
    }
    fn cos(self) -> Self {
        self.wave(Scalar::cos)
    }
    fn sqrt(self) -> Self {
        self.rising(Scalar::sqrt)
    }
    fn exp(self) -> Self {
        self.rising(Scalar::exp)
    }
    fn ln(self) -> Self {
        self.rising(Scalar::ln)
    }
    fn max(self, other: Self) -> Self {
        Interval::new(
            Scalar::max(self.low, other.low),
            Scalar::max(self.high, other.high),
        )
    }
    fn min(self, other: Self) -> Self {
        Interval::new(
            Scalar::min(self.low, other.low),
            Scalar::min(self.high, other.high),
        )
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Everything that a scalar can do.
    fn everything<T: Scalar>(x: T, y: T) -> [T; 9] {
        [
            x * y - y / (x * x + 1.5),
            Scalar::sin(x * 2.0) + Scalar::cos(-y),
            Scalar::exp(x / 3.0) * y,
            Scalar::sqrt(x * x + 0.1) - 4.0,
            Scalar::ln(y * y + 0.2),
            Scalar::powi(x, 3) + Scalar::powi(y + 5.0, -2),
            Scalar::max(x, y) * -2.0,
            Scalar::min(x, y) / -0.5,
            T::constant(0.3) - x,
        ]
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn the_image_holds_every_value(
            middle in prop::array::uniform2(-2.0..2.0),
            radius in prop::array::uniform2(0.0..1.0),
            place in prop::array::uniform2(-1.0..1.0),
        ) {
            let ranges = [0, 1].map(|i| Interval::around(middle[i], radius[i]));
            let inside: [f64; 2] = [0, 1].map(|i| middle[i] + place[i] * radius[i]);
            let images = everything(ranges[0], ranges[1]);
            for (image, value) in images.iter().zip(everything(inside[0], inside[1])) {
                let room = 1e-13 * (1.0 + value.abs());
                // Bounds that are not numbers exclude nothing.
                prop_assert!(!(value + room < image.low || image.high < value - room));
            }
        }
    }

    #[test]
    fn what_is_not_defined_everywhere_is_no_interval() {
        let across = Interval::new(-1.0, 1.0);
        for none in [
            Interval::constant(1.0) / across,
            Scalar::ln(across),
            Scalar::sqrt(across),
        ] {
            assert!(none.low.is_nan(), "{none:?}");
        }
    }
}
