//! Recurrences for the next coefficient of each elementary function (Griewank & Walther,
//! *Evaluating Derivatives*, 2008, Ch. 13).

use super::jet::{Coefficient, Jet, Straight};
use super::row::{Lanes, lanes};
use crate::math;
use crate::scalar::Scalar;

use Jet::Line;

/// A function that is constant to rounding beyond some bound. Its series there does not show where
/// that range ends. So the bound is treated as a comparison, which ends the step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Flat {
    HyperbolicTangent,
    Exponential,
}

impl Flat {
    /// The bound that the number lies beyond, if any.
    #[inline(always)]
    fn bound_before(self, a: f64) -> Option<f64> {
        let (low, high) = match self {
            // At this bound the function differs from 1 by 15 units in the last place.
            Flat::HyperbolicTangent => (-17.0, 17.0),
            // Beyond these bounds the exponential is lost to rounding beside 1, or 1 beside it, as
            // in a logistic function.
            Flat::Exponential => (-37.0, 37.0),
        };
        if a > high {
            Some(high)
        } else {
            (a < low).then_some(low)
        }
    }
}

impl<'a, const L: usize> Coefficient<'a, L> {
    /// The newest coefficient (not the value) of `f(a)` where `f' = g(a)`; `g` is the row of
    /// `g(a)`.
    #[inline(always)]
    fn integral(self, slope: usize, g: usize) -> Lanes<L> {
        let (pass, a) = (self.pass, self.newest);
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
        let newest = if pass.order == 0 {
            lanes(|l| value(self.newest[l]))
        } else {
            self.integral(slope, rate)
        };
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

    /// Two functions, each the derivative of the other up to the sign of the second's.
    #[inline(always)]
    fn pair(self, sign: f64, both: impl Fn(f64) -> (f64, f64)) -> (Jet<'a, L>, Jet<'a, L>) {
        let pass = self.pass;
        let slope = self.keep_slope();
        if pass.order == 0 {
            return pass.results(self.newest, both);
        }
        let (one, other) = (pass.next(), pass.next() + 1);
        let of_one = unless_overflowed(self.integral(slope, other), pass.at(one, 0));
        let of_other = unless_overflowed(self.integral(slope, one), pass.at(other, 0));
        let results = (pass.result(of_one), lanes(|l| sign * of_other[l]));
        (results.0, pass.result(results.1))
    }

    #[inline(always)]
    fn exponential(self) -> Jet<'a, L> {
        let pass = self.pass;
        let slope = self.keep_slope();
        pass.result(if pass.order == 0 {
            lanes(|l| math::exp(self.newest[l]))
        } else {
            unless_overflowed(self.integral(slope, pass.next()), pass.at(pass.next(), 0))
        })
    }

    #[inline(always)]
    fn root(self) -> Jet<'a, L> {
        let (pass, newest) = (self.pass, self.newest);
        if pass.order == 0 {
            return pass.result(lanes(|l| newest[l].sqrt()));
        }
        let root = pass.next();
        let (inner, r0) = (pass.convolution(root, root), pass.at(root, 0));
        pass.result(lanes(|l| (newest[l] - inner[l]) / (2.0 * r0[l])))
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

    /// Stores the coefficients of `s a'(s)`.
    #[inline(always)]
    fn keep_slope(self) -> usize {
        self.pass.keep(self.pass.slope(self.newest))
    }
}

/// The coefficient `newest` of functions with these values, or zero where they have overflowed. A
/// quotient by such a function then stays zero up to the bound of [`Flat::Exponential`].
#[inline(always)]
pub(super) fn unless_overflowed<const L: usize>(newest: Lanes<L>, values: Lanes<L>) -> Lanes<L> {
    lanes(|l| {
        if values[l].is_infinite() {
            0.0
        } else {
            newest[l]
        }
    })
}

fn sinh_cosh(a: f64) -> (f64, f64) {
    (math::sinh(a), math::cosh(a))
}

impl<const L: usize> Jet<'_, L> {
    /// The bound that the number lies beyond in the range where a function is flat, if any.
    #[inline(always)]
    pub(super) fn bound_before(self, flat: Flat) -> Option<f64> {
        let a0 = self.first();
        let bound = flat.bound_before(a0[0]);
        if let Some(pass) = self.pass() {
            for a in &a0[1..] {
                if flat.bound_before(*a) != bound {
                    pass.divided.set(true);
                }
            }
        }
        bound
    }

    #[inline(always)]
    fn note(self, flat: Flat) {
        if let Some(bound) = self.bound_before(flat) {
            self.exceeds(Self::constant(bound));
        }
    }

    /// The hyperbolic sine and cosine, without the comparison where 1 is lost beside them.
    #[inline(always)]
    pub(super) fn sinh_cosh_alone(self) -> (Self, Self) {
        match self.in_row() {
            Ok(a) => a.pair(1.0, sinh_cosh),
            Err(a) => {
                let (sine, cosine) = sinh_cosh(a);
                (Self::constant(sine), Self::constant(cosine))
            }
        }
    }

    /// The hyperbolic tangent, without the comparison at its bound.
    #[inline(always)]
    pub(super) fn tanh_alone(self) -> Self {
        match self.in_row() {
            Ok(a) => a.tangent(-1.0, math::tanh),
            Err(a) => Self::constant(math::tanh(a)),
        }
    }

    /// The exponential function, without the comparison at its bound.
    #[inline(always)]
    pub(super) fn exp_alone(self) -> Self {
        match self.in_row() {
            Ok(a) => a.exponential(),
            Err(a) => Self::constant(math::exp(a)),
        }
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
    /// The value in the first lane.
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
            if pass.order == 0 {
                return pass.results(value, math::sin_cos);
            }
            let (sine, last) = (pass.next(), pass.order - 1);
            let (s, c) = (pass.at(sine, last), pass.at(sine + 1, last));
            let of_sine = pass.integral(lanes(|l| slope[l] * c[l]));
            let of_cosine = pass.integral(lanes(|l| -slope[l] * s[l]));
            return (pass.result(of_sine), pass.result(of_cosine));
        }
        match self.in_row() {
            Ok(a) => a.pair(-1.0, math::sin_cos),
            Err(a) => {
                let (sine, cosine) = math::sin_cos(a);
                (Self::constant(sine), Self::constant(cosine))
            }
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
        match self.in_row() {
            Ok(a) => a.tangent(1.0, math::tan),
            Err(a) => Self::constant(math::tan(a)),
        }
    }
    #[inline(always)]
    fn atan(self) -> Self {
        match (self.in_row(), (self * self + 1.0).in_row()) {
            (Ok(a), Ok(b)) => a.over(b, math::atan),
            (Err(a), _) => Self::constant(math::atan(a)),
            (Ok(_), Err(_)) => self,
        }
    }
    #[inline(always)]
    fn sinh(self) -> Self {
        self.note(Flat::Exponential);
        self.sinh_cosh_alone().0
    }
    #[inline(always)]
    fn cosh(self) -> Self {
        self.note(Flat::Exponential);
        self.sinh_cosh_alone().1
    }
    #[inline(always)]
    fn tanh(self) -> Self {
        self.note(Flat::HyperbolicTangent);
        self.tanh_alone()
    }
    #[inline(always)]
    fn powf(self, p: f64) -> Self {
        match self.in_row() {
            Ok(a) => a.power(p),
            Err(a) => Self::constant(math::pow(a, p)),
        }
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        match self.in_row() {
            Ok(a) => a.root(),
            Err(a) => Self::constant(a.sqrt()),
        }
    }
    #[inline(always)]
    fn exp(self) -> Self {
        self.note(Flat::Exponential);
        self.exp_alone()
    }
    #[inline(always)]
    fn ln(self) -> Self {
        match self.in_row() {
            Ok(a) => a.over(a, math::ln),
            Err(a) => Self::constant(math::ln(a)),
        }
    }
}
