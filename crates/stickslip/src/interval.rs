//! Intervals as a number type: bounds of a function over a range of arguments.

use std::cell::Cell;
use std::f64::consts::PI;
use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::scalar::Scalar;

/// All numbers between `low` and `high`. A function of intervals gives an interval that holds all
/// its values (Moore 1966), usually a wider one. Bounds are not rounded outward: callers leave a
/// margin for rounding.
///
/// If a result is undefined for some argument, its bounds are NaN and every comparison with them
/// fails. If a function branches and the range does not decide, the result holds for one branch
/// only; see [`Interval::decided`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Lower bound.
    pub low: f64,
    /// Upper bound.
    pub high: f64,
}

const UNDEFINED: Interval = Interval {
    low: f64::NAN,
    high: f64::NAN,
};

thread_local! {
    /// Whether a branch was taken that the range did not decide.
    static UNDECIDED: Cell<bool> = const { Cell::new(false) };
}

impl Interval {
    /// The result of `compute`, unless it branched where a range did not decide.
    #[inline(always)]
    pub fn decided<R>(compute: impl FnOnce() -> R) -> Option<R> {
        UNDECIDED.set(false);
        let result = compute();
        (!UNDECIDED.get()).then_some(result)
    }

    /// The image of two ranges under a function that does not fall in either.
    fn rising_in_both(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let bounds = [self.low, self.high, other.low, other.high];
        // The standard library's min and max would prefer a number to a NaN.
        if bounds.iter().any(|bound| bound.is_nan()) {
            return UNDEFINED;
        }
        Interval::new(f(self.low, other.low), f(self.high, other.high))
    }

    /// All numbers between two.
    #[inline(always)]
    pub fn new(low: f64, high: f64) -> Self {
        Interval { low, high }
    }

    /// All numbers within a radius of one.
    #[inline(always)]
    pub fn around(middle: f64, radius: f64) -> Self {
        Interval::new(middle - radius, middle + radius)
    }

    /// The image under a function that does not fall.
    fn rising(self, f: impl Fn(f64) -> f64) -> Self {
        Interval::new(f(self.low), f(self.high))
    }

    /// The part below a bound, if there is one.
    fn up_to(self, bound: Option<&f64>) -> Self {
        let high = bound.map_or(self.high, |bound| f64::min(self.high, *bound));
        Interval { high, ..self }
    }

    /// The image under a function of values between −1 and 1 and slopes no steeper.
    fn wave(self, f: impl Fn(f64) -> f64) -> Self {
        let radius = 0.5 * (self.high - self.low);
        if radius.is_nan() {
            return UNDEFINED;
        }
        let middle = f(0.5 * (self.low + self.high));
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
        // The standard library's min and max would prefer a number to a NaN.
        if products.iter().any(|p| p.is_nan()) {
            return UNDEFINED;
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
            UNDEFINED
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
    /// The middle. A branch on it is undecided by the rest.
    fn value(self) -> f64 {
        if self.low != self.high {
            UNDECIDED.set(true);
        }
        0.5 * (self.low + self.high)
    }
    fn exceeds(self, other: Self) -> bool {
        // A NaN on either side decides nothing.
        let decided = self.low > other.high || self.high <= other.low;
        if !decided {
            UNDECIDED.set(true);
        }
        self.low > other.high
    }
    fn divided_or(self, by: Self, otherwise: f64) -> Self {
        if by.low == 0.0 && by.high == 0.0 {
            Self::constant(otherwise)
        } else {
            self / by
        }
    }
    fn sin(self) -> Self {
        self.wave(Scalar::sin)
    }
    fn cos(self) -> Self {
        self.wave(Scalar::cos)
    }
    fn tan(self) -> Self {
        let (sine, cosine) = self.sin_cos();
        sine / cosine
    }
    fn atan(self) -> Self {
        self.rising(Scalar::atan)
    }
    fn atan2(self, x: Self) -> Self {
        let bounds = [self.low, self.high, x.low, x.high];
        if bounds.iter().any(|bound| bound.is_nan()) {
            return UNDEFINED;
        }
        // The origin or the negative x axis, where the angle jumps.
        if x.low <= 0.0 && self.low <= 0.0 && self.high >= 0.0 {
            return Interval::new(-PI, PI);
        }
        let corners = [(0, 2), (0, 3), (1, 2), (1, 3)];
        let angles = corners.map(|(y, x)| Scalar::atan2(bounds[y], bounds[x]));
        let everywhere = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = angles.iter().fold(everywhere, |(low, high), &angle| {
            (f64::min(low, angle), f64::max(high, angle))
        });
        Interval { low, high }
    }
    fn erf(self) -> Self {
        self.rising(Scalar::erf)
    }
    fn in_pieces(self, cuts: &[f64], value: impl Fn(usize, Self) -> Self) -> Self {
        if self.low.is_nan() || self.high.is_nan() {
            return UNDEFINED;
        }
        let first = cuts.partition_point(|cut| *cut <= self.low);
        let mut hull = value(first, self.up_to(cuts.get(first)));
        for piece in first + 1..=cuts.len() {
            let from = cuts[piece - 1];
            if from > self.high {
                break;
            }
            let part = Interval::new(from, self.high).up_to(cuts.get(piece));
            let image = value(piece, part);
            let bounds = [hull.low, hull.high, image.low, image.high];
            if bounds.iter().any(|bound| bound.is_nan()) {
                return UNDEFINED;
            }
            hull = Interval::new(
                f64::min(bounds[0], bounds[2]),
                f64::max(bounds[1], bounds[3]),
            );
        }
        hull
    }
    fn sinh(self) -> Self {
        self.rising(Scalar::sinh)
    }
    fn cosh(self) -> Self {
        self.abs().rising(Scalar::cosh)
    }
    fn tanh(self) -> Self {
        self.rising(Scalar::tanh)
    }
    fn powf(self, p: f64) -> Self {
        // NaN for a negative number or a NaN.
        if !(self.low >= 0.0 && self.high >= 0.0) {
            return UNDEFINED;
        }
        let image = self.rising(|x| Scalar::powf(x, p));
        if p < 0.0 {
            Interval::new(image.high, image.low)
        } else {
            image
        }
    }
    fn abs(self) -> Self {
        let Interval { low, high } = self;
        if low >= 0.0 {
            self
        } else if high <= 0.0 {
            -self
        } else if low.is_nan() || high.is_nan() {
            UNDEFINED
        } else {
            Interval::new(0.0, f64::max(-low, high))
        }
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
        self.rising_in_both(other, Scalar::max)
    }
    fn min(self, other: Self) -> Self {
        self.rising_in_both(other, Scalar::min)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Every function of a scalar.
    fn everything<T: Scalar>(x: T, y: T) -> [T; 16] {
        // −1 up to −0.5, then a parabola through there up to 1.5, then its end.
        let in_pieces = x.in_pieces(&[-0.5, 1.5], |piece, x| match piece {
            0 => T::constant(-1.0),
            1 => (x - 0.5) * (x - 0.5) - 2.0,
            _ => T::constant(-1.0),
        });
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
            x.tan() - y.atan(),
            x.sinh() * y.cosh(),
            x.tanh() - x.abs(),
            x.powf(2.5) * (y + 5.0).powf(-1.5),
            x.atan2(y) + y.atan2(x + 4.0),
            x.erf() - y.erf(),
            in_pieces,
        ]
    }

    proptest! {
        #![proptest_config(ProptestConfig {
            failure_persistence: None,
            ..ProptestConfig::default()
        })]
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
            Scalar::tan(Interval::new(1.5, 1.6)),
            Scalar::powf(across, 0.5),
            Scalar::min(Interval::constant(5.0), Interval::constant(1.0) / across),
            Scalar::max(Scalar::ln(across), Interval::constant(5.0)),
            Scalar::sin(Scalar::ln(across)),
        ] {
            assert!(none.low.is_nan(), "{none:?}");
        }
    }

    #[test]
    fn a_branch_that_the_range_does_not_decide_is_reported() {
        let (low, high) = (Interval::new(0.0, 1.0), Interval::new(2.0, 3.0));
        let open = Interval::new(0.5, 2.5);
        assert_eq!(Interval::decided(|| high.exceeds(low)), Some(true));
        assert_eq!(Interval::decided(|| low.exceeds(high)), Some(false));
        assert_eq!(Interval::decided(|| open.exceeds(low)), None);
        assert_eq!(Interval::decided(|| open.value()), None);
        assert_eq!(
            Interval::decided(|| Interval::constant(2.0).value()),
            Some(2.0)
        );
    }
}
