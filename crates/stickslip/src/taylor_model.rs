//! Taylor models as a number type: a function over an interval as a polynomial, and a bound of what
//! the polynomial misses (Makino & Berz, *Int. J. Pure Appl. Math.* 4 (2003) 379).

use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::interval::Interval;
use crate::math;
use crate::scalar::Scalar;
use crate::system::State;
use crate::taylor::MAX_COEFFICIENTS;

/// A function of `u` between −1 and 1.
///
/// If it is not defined throughout, or has no bound here, `rest` is infinite or NaN. If a function
/// branches and the range does not decide, the result holds for one branch only; see
/// [`Interval::decided`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TaylorModel {
    /// Coefficients of the powers of `u`.
    pub c: [f64; MAX_COEFFICIENTS],
    /// Largest distance from the polynomial.
    pub rest: f64,
}

/// Rounding of an operation, relative to the sizes of the coefficients of its operands. Chosen: a
/// coefficient is a sum of 25 products, whose roundings rarely add up to more.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

impl TaylorModel {
    /// Sum of the sizes of the coefficients from a power on.
    #[inline(always)]
    fn size_from(&self, power: usize) -> f64 {
        self.c[power..].iter().map(|c| c.abs()).sum()
    }

    /// A bound of the values.
    pub(crate) fn size(&self) -> f64 {
        self.size_from(0) + self.rest
    }

    /// The solution of a step with these coefficients, over a part of it about a middle.
    pub(crate) fn along<const N: usize>(
        coefficients: &[State<N>],
        middle: f64,
        half: f64,
    ) -> [Self; N] {
        std::array::from_fn(|i| {
            let mut x = TaylorModel::constant(0.0);
            for (c, of_state) in x.c.iter_mut().zip(coefficients) {
                *c = of_state[i];
            }
            let rounding = ROUNDING * x.size_from(0);
            x.shift(middle);
            let mut power = 1.0;
            for c in &mut x.c {
                *c *= power;
                power *= half;
            }
            x.with_rest(rounding)
        })
    }

    /// Coefficients of the powers of `(u + 1)/2`: the fraction of the interval from its start on.
    pub(crate) fn powers_of_fraction(mut self) -> [f64; MAX_COEFFICIENTS] {
        self.shift(-1.0);
        let mut power = 1.0;
        for c in &mut self.c {
            *c *= power;
            power *= 2.0;
        }
        self.c
    }

    /// Makes the powers those of the distance from a place, by repeated synthetic division.
    fn shift(&mut self, place: f64) {
        for first in 0..MAX_COEFFICIENTS - 1 {
            for k in (first..MAX_COEFFICIENTS - 1).rev() {
                self.c[k] += place * self.c[k + 1];
            }
        }
    }

    /// Bounds of the values.
    pub(crate) fn range(&self) -> Interval {
        Interval::around(self.c[0], self.size_from(1) + self.rest)
    }

    /// The least size of the values; zero if they may vanish.
    fn least(&self) -> f64 {
        (self.c[0].abs() - self.size_from(1) - self.rest).max(0.0)
    }

    /// Nothing is known.
    fn unknown(self) -> Self {
        TaylorModel {
            rest: f64::NAN,
            ..self
        }
    }

    /// With the rounding of a sum, or of a product with a constant.
    #[inline(always)]
    fn rounded(self) -> Self {
        let rounding = f64::EPSILON * self.size_from(0);
        self.with_rest(rounding)
    }

    fn with_rest(self, more: f64) -> Self {
        TaylorModel {
            rest: self.rest + more,
            ..self
        }
    }

    /// The polynomial alone.
    fn polynomial(self) -> Self {
        TaylorModel { rest: 0.0, ..self }
    }

    /// The slope of the polynomial.
    fn slope(&self) -> Self {
        let mut slope = TaylorModel::constant(0.0);
        for k in 1..MAX_COEFFICIENTS {
            slope.c[k - 1] = k as f64 * self.c[k];
        }
        slope
    }

    /// The polynomials `f` and `g` of `u` with `f' = a p'` and `g' = b p'`, where the rules give
    /// `a` and `b` from `f` and `g`, up to the highest power. Then a bound of what `f' − a p'` and
    /// `g' − b p'` integrate to.
    fn pair(&self, [f0, g0]: [f64; 2], [a, b]: [fn(f64, f64) -> f64; 2]) -> ([Self; 2], f64) {
        let slope = self.slope();
        let [mut f, mut g] = [f0, g0].map(TaylorModel::constant);
        for k in 1..MAX_COEFFICIENTS {
            let [mut of_f, mut of_g] = [0.0; 2];
            for j in 0..k {
                of_f += slope.c[j] * a(f.c[k - 1 - j], g.c[k - 1 - j]);
                of_g += slope.c[j] * b(f.c[k - 1 - j], g.c[k - 1 - j]);
            }
            let per_power = 1.0 / k as f64;
            (f.c[k], g.c[k]) = (of_f * per_power, of_g * per_power);
        }
        let beyond = |of: &Self| beyond(&slope.c, &of.c, MAX_COEFFICIENTS - 1);
        let defect = (beyond(&f) + beyond(&g)) / MAX_COEFFICIENTS as f64;
        let rounding = ROUNDING * (1.0 + slope.size()) * (f.size() + g.size());
        ([f, g], defect + rounding)
    }

    /// A function from its value and its slope: `slope` gives that of the argument.
    fn integral(self, value: impl Fn(f64) -> f64, slope: impl Fn(Self) -> Self) -> Self {
        let polynomial = self.polynomial();
        let rate = slope(polynomial) * polynomial.slope();
        let mut integral = TaylorModel::constant(value(self.c[0]));
        for k in 1..MAX_COEFFICIENTS {
            integral.c[k] = rate.c[k - 1] / k as f64;
        }
        let last = rate.c[MAX_COEFFICIENTS - 1].abs() / MAX_COEFFICIENTS as f64;
        let of_rest = match self.rest {
            0.0 => 0.0,
            rest => slope(self).size() * rest,
        };
        integral.with_rest(rate.rest + last + of_rest + ROUNDING * integral.size())
    }
}

/// `Σ |a_i b_j|` over `i + j ≥ power`.
#[inline(always)]
fn beyond(a: &[f64; MAX_COEFFICIENTS], b: &[f64; MAX_COEFFICIENTS], power: usize) -> f64 {
    // The sum over j ≥ power − i grows with i.
    let mut from: f64 = b.iter().skip(power + 1).map(|b| b.abs()).sum();
    let mut sum = 0.0;
    for (i, a) in a.iter().enumerate() {
        if let Some(j) = power.checked_sub(i)
            && j < MAX_COEFFICIENTS
        {
            from += b[j].abs();
        }
        sum += a.abs() * from;
    }
    sum
}

impl Neg for TaylorModel {
    type Output = Self;
    #[inline(always)]
    fn neg(mut self) -> Self {
        self.c = self.c.map(|c| -c);
        self
    }
}

impl Add for TaylorModel {
    type Output = Self;
    #[inline(always)]
    fn add(mut self, other: Self) -> Self {
        for (c, other) in self.c.iter_mut().zip(other.c) {
            *c += other;
        }
        self.with_rest(other.rest).rounded()
    }
}

impl Sub for TaylorModel {
    type Output = Self;
    #[inline(always)]
    fn sub(mut self, other: Self) -> Self {
        for (c, other) in self.c.iter_mut().zip(other.c) {
            *c -= other;
        }
        self.with_rest(other.rest).rounded()
    }
}

impl Mul for TaylorModel {
    type Output = Self;
    #[inline(never)]
    fn mul(self, other: Self) -> Self {
        let mut c = [0.0; MAX_COEFFICIENTS];
        for (i, a) in self.c.iter().enumerate() {
            for (c, b) in c[i..].iter_mut().zip(&other.c) {
                *c += a * b;
            }
        }
        let [one, two] = [&self, &other].map(|of| of.size_from(0));
        let rest = beyond(&self.c, &other.c, MAX_COEFFICIENTS)
            + one * other.rest
            + two * self.rest
            + self.rest * other.rest
            + ROUNDING * one * two;
        TaylorModel { c, rest }
    }
}

impl Div for TaylorModel {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let inverse = other.recip();
        self.mul(inverse)
    }
}

impl Add<f64> for TaylorModel {
    type Output = Self;
    #[inline(always)]
    fn add(mut self, other: f64) -> Self {
        self.c[0] += other;
        let rounding = f64::EPSILON * self.c[0].abs();
        self.with_rest(rounding)
    }
}

impl Sub<f64> for TaylorModel {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: f64) -> Self {
        self + -other
    }
}

impl Mul<f64> for TaylorModel {
    type Output = Self;
    #[inline(always)]
    fn mul(mut self, other: f64) -> Self {
        self.c = self.c.map(|c| c * other);
        self.rest *= other.abs();
        self.rounded()
    }
}

impl Div<f64> for TaylorModel {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: f64) -> Self {
        self * (1.0 / other)
    }
}

impl Scalar for TaylorModel {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        let mut c = [0.0; MAX_COEFFICIENTS];
        c[0] = value;
        TaylorModel { c, rest: 0.0 }
    }

    /// The middle. A branch on it is undecided by the rest.
    fn value(self) -> f64 {
        self.range().value()
    }

    fn exceeds(self, other: Self) -> bool {
        let difference = (self - other).range();
        difference.exceeds(Interval::constant(0.0))
    }

    fn divided_or(self, by: Self, otherwise: f64) -> Self {
        match by == Self::constant(0.0) {
            true => Self::constant(otherwise),
            false => self / by,
        }
    }

    fn recip(self) -> Self {
        let least = self.least();
        if least.is_nan() || least <= 0.0 {
            return self.unknown();
        }
        let first = 1.0 / self.c[0];
        let mut q = TaylorModel::constant(first);
        for k in 1..MAX_COEFFICIENTS {
            let sum: f64 = (1..=k).map(|j| self.c[j] * q.c[k - j]).sum();
            q.c[k] = -first * sum;
        }
        let size = q.size_from(0);
        let defect = beyond(&self.c, &q.c, MAX_COEFFICIENTS)
            + self.rest * size
            + ROUNDING * self.size_from(0) * size;
        q.with_rest(defect / least)
    }

    fn sqrt(self) -> Self {
        let root = self.c[0].sqrt();
        let least = self.least();
        if root.is_nan() || least.is_nan() || least <= 0.0 {
            return self.unknown();
        }
        let mut r = TaylorModel::constant(root);
        for k in 1..MAX_COEFFICIENTS {
            let sum: f64 = (1..k).map(|j| r.c[j] * r.c[k - j]).sum();
            r.c[k] = (self.c[k] - sum) / (2.0 * root);
        }
        // The root of the function, plus that of the polynomial, is no less than the former.
        if r.least() <= 0.0 {
            return self.unknown();
        }
        let size = r.size_from(0);
        let defect = beyond(&r.c, &r.c, MAX_COEFFICIENTS) + self.rest + ROUNDING * size * size;
        r.with_rest(defect / least.sqrt())
    }

    fn sin_cos(self) -> (Self, Self) {
        let (sine, cosine) = math::sin_cos(self.c[0]);
        // What is missing turns with the pair, and does not grow.
        let ([sine, cosine], defect) = self.pair([sine, cosine], [|_, c| c, |s, _| -s]);
        let rest = defect + self.rest;
        (sine.with_rest(rest), cosine.with_rest(rest))
    }
    fn sin(self) -> Self {
        self.sin_cos().0
    }
    fn cos(self) -> Self {
        self.sin_cos().1
    }
    fn tan(self) -> Self {
        let (sine, cosine) = self.sin_cos();
        sine / cosine
    }

    fn exp(self) -> Self {
        let ([exponential, _], defect) =
            self.pair([math::exp(self.c[0]), 0.0], [|e, _| e, |_, _| 0.0]);
        // From one place to another it grows by this factor at most.
        let reach = self.size_from(1);
        let of_rest = math::exp(self.c[0] + reach + self.rest) * self.rest;
        exponential.with_rest(math::exp(2.0 * reach) * defect + of_rest)
    }
    fn sinh(self) -> Self {
        (self.exp() - (-self).exp()) * 0.5
    }
    fn cosh(self) -> Self {
        (self.exp() + (-self).exp()) * 0.5
    }
    fn tanh(self) -> Self {
        -((self * 2.0).exp() + 1.0).recip() * 2.0 + 1.0
    }

    fn atan(self) -> Self {
        self.integral(math::atan, |x| (x * x + 1.0).recip())
    }
    fn ln(self) -> Self {
        self.integral(math::ln, Scalar::recip)
    }
    fn erf(self) -> Self {
        self.integral(math::erf, |x| (-(x * x)).exp() * math::ERF_SLOPE)
    }
    fn powf(self, p: f64) -> Self {
        (self.ln() * p).exp()
    }
}

#[cfg(test)]
mod tests {
    use numerics::SplitMix;

    use super::*;

    /// Every function of a scalar.
    fn everything<T: Scalar>(x: T, y: T) -> [T; 14] {
        [
            x * y - y / (x * x + 1.5),
            Scalar::sin(x * 2.0) + Scalar::cos(-y),
            Scalar::exp(x / 3.0) * y,
            Scalar::sqrt(x * x + 0.3) - 4.0,
            Scalar::ln(y * y + 0.4),
            Scalar::powi(x, 3) + Scalar::powi(y + 5.0, -2),
            Scalar::powf(x * x + 1.0, 1.5),
            Scalar::tan(x * 0.3),
            Scalar::atan(y - x),
            Scalar::erf(x),
            Scalar::sinh(x) - Scalar::cosh(y),
            Scalar::tanh(x + y),
            Scalar::abs(x + 9.0) + Scalar::max(x, y + 8.0),
            Scalar::atan2(y + 3.0, x - 7.0),
        ]
    }

    #[test]
    fn the_function_is_within_the_rest_of_the_polynomial_and_of_its_powers_from_the_start() {
        let mut draw = SplitMix::new(1963);
        let (mut near, mut all) = (0, 0);
        for _ in 0..200 {
            let size = draw.between(0.01, 0.6);
            let mut model = || {
                let mut model = TaylorModel::constant(draw.between(-1.0, 1.0));
                let mut power = 1.0;
                for c in &mut model.c[1..] {
                    power *= size;
                    *c = power * draw.between(-1.0, 1.0);
                }
                model
            };
            let (x, y) = (model(), model());
            let models = Interval::decided(|| everything(x, y)).expect("no branch is open");
            for i in 0..=40 {
                let u = f64::from(i) / 20.0 - 1.0;
                let at = |c: &[f64]| c.iter().rev().fold(0.0, |sum, c| sum * u + c);
                let values = everything(at(&x.c), at(&y.c));
                for (number, (model, value)) in models.iter().zip(values).enumerate() {
                    all += 1;
                    near += u32::from(model.rest < 1e-9);
                    if model.rest.is_nan() {
                        continue;
                    }
                    let off = (at(&model.c) - value).abs();
                    assert!(off <= model.rest, "{number}, {u}: {off:e} {:e}", model.rest);
                    let fraction = 0.5 * (u + 1.0);
                    let powers_of_fraction = model.powers_of_fraction();
                    let again = powers_of_fraction
                        .iter()
                        .rev()
                        .fold(0.0, |sum, c| sum * fraction + c);
                    // The powers of `2w − 1` have coefficients of up to `3^k` in all.
                    let grown = model.c.iter().rev().fold(0.0, |sum, c| sum * 3.0 + c.abs());
                    assert!((again - at(&model.c)).abs() < 1e-14 * grown);
                    let range = model.range();
                    assert!(range.low <= value && value <= range.high);
                }
            }
        }
        assert!(2 * near > all, "{near} of {all}");
    }

    #[test]
    fn what_is_not_defined_throughout_has_no_rest() {
        let mut x = TaylorModel::constant(0.5);
        x.c[1] = 0.6;
        for undefined in [x.recip(), x.sqrt(), x.ln(), x.powf(0.3)] {
            assert!(undefined.rest.is_nan());
        }
        assert_eq!(Interval::decided(|| x.abs()), None);
        let rest = |x: TaylorModel| (x.with_rest(1e-3).sin().rest, x.sin().rest);
        let (with, without) = rest(x);
        assert!((with - without - 1e-3).abs() < 1e-15);
    }
}
