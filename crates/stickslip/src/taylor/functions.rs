//! What each function's next coefficient is (Griewank & Walther, *Evaluating Derivatives*, 2008, Ch. 13).

use super::jet::{Coefficient, Jet, Straight};
use super::row::{Lanes, lanes};
use crate::math;
use crate::scalar::Scalar;

use Jet::Line;

/// A function of a number, `whole` of what has a row and `value` of a constant.
#[inline(always)]
fn function<'a, const L: usize>(
    a: Jet<'a, L>,
    value: impl Fn(f64) -> f64,
    whole: impl Fn(Coefficient<'a, L>) -> Jet<'a, L>,
) -> Jet<'a, L> {
    match a.in_row() {
        Ok(a) => whole(a),
        Err(a) => Jet::constant(value(a)),
    }
}

impl<'a, const L: usize> Coefficient<'a, L> {
    /// The newest coefficient of `f(a)` where `f' = g(a)`: `g` has the row `g`, and `value` is `f`.
    #[inline(always)]
    fn integral(self, slope: usize, g: usize, value: impl Fn(f64) -> f64) -> Lanes<L> {
        let (pass, a) = (self.pass, self.newest);
        if pass.order == 0 {
            return lanes(|l| value(a[l]));
        }
        let (inner, of_a, g0) = (pass.convolution(slope, g), pass.slope(a), pass.at(g, 0));
        pass.integral(lanes(|l| inner[l] + of_a[l] * g0[l]))
    }

    /// `f(a)` where `f' = 1/b`.
    #[inline(always)]
    fn over(self, b: Self, value: impl Fn(f64) -> f64) -> Jet<'a, L> {
        let (pass, a) = (self.pass, self.newest);
        if pass.order == 0 {
            pass.keep([0.0; L]);
            return pass.result(lanes(|l| value(a[l])));
        }
        let (inner, of_a, b0) = (
            pass.convolution(pass.next(), b.row),
            pass.slope(a),
            b.first(),
        );
        let slope = lanes(|l| (of_a[l] - inner[l]) / b0[l]);
        pass.keep(slope);
        pass.result(pass.integral(slope))
    }

    /// `f(a)` where `f' = 1 + sign f²`.
    #[inline(always)]
    fn tangent(self, sign: f64, value: impl Fn(f64) -> f64) -> Jet<'a, L> {
        let pass = self.pass;
        let slope = self.keep_slope();
        let (tangent, rate) = (pass.next(), pass.next() + 1);
        let newest = self.integral(slope, rate, value);
        let result = pass.result(newest);
        let of_square = if pass.order == 0 {
            lanes(|l| 1.0 + sign * (newest[l] * newest[l]))
        } else {
            let (inner, t0) = (pass.convolution(tangent, tangent), pass.at(tangent, 0));
            lanes(|l| sign * (inner[l] + 2.0 * t0[l] * newest[l]))
        };
        pass.keep(of_square);
        result
    }

    /// Two functions of which each is the slope of the other, but for the sign of the second's.
    #[inline(always)]
    fn pair(
        self,
        sign: f64,
        first: impl Fn(f64) -> f64,
        second: impl Fn(f64) -> f64,
    ) -> (Jet<'a, L>, Jet<'a, L>) {
        let pass = self.pass;
        let slope = self.keep_slope();
        let (one, other) = (pass.next(), pass.next() + 1);
        let sign = if pass.order == 0 { 1.0 } else { sign };
        let of_one = self.integral(slope, other, first);
        let of_other = self.integral(slope, one, second);
        let results = (pass.result(of_one), lanes(|l| sign * of_other[l]));
        (results.0, pass.result(results.1))
    }

    /// A real power.
    #[inline(always)]
    fn power(self, p: f64) -> Jet<'a, L> {
        let (pass, a) = (self.pass, self.newest);
        let slope = self.keep_slope();
        let (of_power, power) = (pass.next(), pass.next() + 1);
        if pass.order == 0 {
            pass.keep([0.0; L]);
            return pass.result(lanes(|l| math::pow(a[l], p)));
        }
        // a · s y' = p y · s a'
        let (up, down) = (
            pass.convolution(slope, power),
            pass.convolution(self.row, of_power),
        );
        let (of_a, a0, y0) = (pass.slope(a), self.first(), pass.at(power, 0));
        let newest = lanes(|l| (p * (up[l] + of_a[l] * y0[l]) - down[l]) / a0[l]);
        pass.keep(newest);
        pass.result(pass.integral(newest))
    }

    /// Keeps the coefficients of `s a'(s)`.
    #[inline(always)]
    fn keep_slope(self) -> usize {
        self.pass.keep(self.pass.slope(self.newest))
    }
}

impl<const L: usize> Scalar for Jet<'_, L> {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Line(Straight::constant(value))
    }
    #[inline(always)]
    fn zero() -> Self {
        Jet::Zero
    }
    #[inline(always)]
    fn one() -> Self {
        Jet::One
    }
    #[inline(always)]
    fn is_same(self, other: Self) -> bool {
        matches!((self, other), (Jet::Series(a), Jet::Series(b)) if a.row == b.row)
    }
    /// That of the first lane.
    #[inline(always)]
    fn value(self) -> f64 {
        if let Some(pass) = self.pass() {
            pass.value_read.set(true);
        }
        self.first()[0]
    }
    #[inline(always)]
    fn exceeds(self, other: Self) -> bool {
        let (a0, b0) = (self.first(), other.first());
        let exceeds = a0[0] > b0[0];
        let Some(pass) = self.pass().or(other.pass()) else {
            return exceeds;
        };
        for l in 1..L {
            if (a0[l] > b0[l]) != exceeds {
                pass.divided.set(true);
            }
        }
        self.choose(other, exceeds);
        exceeds
    }
    #[inline(always)]
    fn divided_or(self, by: Self, otherwise: f64) -> Self {
        if by.is_zero() {
            return Self::constant(otherwise);
        }
        self / by
    }
    #[inline(always)]
    fn recip(self) -> Self {
        Jet::One / self
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        if let Line(Straight {
            value,
            slope,
            pass: Some(pass),
        }) = self
        {
            let sine = pass.next();
            let (of_sine, of_cosine) = if pass.order == 0 {
                (
                    lanes(|l| math::sin(value[l])),
                    lanes(|l| math::cos(value[l])),
                )
            } else {
                let last = pass.order - 1;
                let (s, c) = (pass.at(sine, last), pass.at(sine + 1, last));
                (
                    pass.integral(lanes(|l| slope[l] * c[l])),
                    pass.integral(lanes(|l| -slope[l] * s[l])),
                )
            };
            return (pass.result(of_sine), pass.result(of_cosine));
        }
        match self.in_row() {
            Ok(a) => a.pair(-1.0, math::sin, math::cos),
            Err(a) => (Self::constant(math::sin(a)), Self::constant(math::cos(a))),
        }
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
        function(self, math::tan, |a| a.tangent(1.0, math::tan))
    }
    #[inline(always)]
    fn atan(self) -> Self {
        function(self, math::atan, |a| match (self * self + 1.0).in_row() {
            Ok(b) => a.over(b, math::atan),
            Err(_) => self,
        })
    }
    #[inline(always)]
    fn sinh(self) -> Self {
        function(self, math::sinh, |a| a.pair(1.0, math::sinh, math::cosh).0)
    }
    #[inline(always)]
    fn cosh(self) -> Self {
        function(self, math::cosh, |a| a.pair(1.0, math::sinh, math::cosh).1)
    }
    #[inline(always)]
    fn tanh(self) -> Self {
        function(self, math::tanh, |a| a.tangent(-1.0, math::tanh))
    }
    #[inline(always)]
    fn powf(self, p: f64) -> Self {
        function(self, |a| math::pow(a, p), |a| a.power(p))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        function(self, f64::sqrt, |a| {
            let (pass, newest) = (a.pass, a.newest);
            if pass.order == 0 {
                return pass.result(lanes(|l| newest[l].sqrt()));
            }
            let root = pass.next();
            let (inner, r0) = (pass.convolution(root, root), pass.at(root, 0));
            pass.result(lanes(|l| (newest[l] - inner[l]) / (2.0 * r0[l])))
        })
    }
    #[inline(always)]
    fn exp(self) -> Self {
        function(self, math::exp, |a| {
            let slope = a.keep_slope();
            a.pass.result(a.integral(slope, a.pass.next(), math::exp))
        })
    }
    #[inline(always)]
    fn ln(self) -> Self {
        function(self, math::ln, |a| a.over(a, math::ln))
    }
}
