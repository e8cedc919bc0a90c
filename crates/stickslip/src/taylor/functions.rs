//! Recurrences for the next coefficient of each elementary function (Griewank & Walther,
//! *Evaluating Derivatives*, 2008, Ch. 13).

use super::jet::{Coefficient, Jet, LinearJet};
use super::row::{Lanes, lanes};
use crate::math;
use crate::scalar::Scalar;

use Jet::Linear;

/// A function that is constant to rounding beyond some bound. Its series there does not show where
/// that range ends. So the bound is treated as a comparison, which ends the step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Flat {
    HyperbolicTangent,
    ErrorFunction,
    Exponential,
}

impl Flat {
    /// The bound that the number lies beyond, if any.
    #[inline(always)]
    fn bound_before(self, a: f64) -> Option<f64> {
        let (low, high) = match self {
            // At this bound the function differs from 1 by 15 units in the last place.
            Flat::HyperbolicTangent => (-17.0, 17.0),
            Flat::ErrorFunction => (-5.57, 5.57),
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
        let (sweep, a) = (self.sweep, self.newest);
        let (inner, of_a, g0) = (sweep.convolution(slope, g), sweep.slope(a), sweep.at(g, 0));
        sweep.integral(lanes(|l| inner[l] + of_a[l] * g0[l]))
    }

    /// `f(a)` where `f' = 1/b`.
    #[inline(always)]
    fn over(self, b: Self, value: impl Fn(f64) -> f64) -> Jet<'a, L> {
        let (sweep, a) = (self.sweep, self.newest);
        if sweep.order == 0 {
            sweep.store_next([0.0; L]);
            return sweep.result(lanes(|l| value(a[l])));
        }
        let (inner, of_a, b0) = (
            sweep.convolution(sweep.next_row(), b.row),
            sweep.slope(a),
            b.first(),
        );
        let slope = lanes(|l| (of_a[l] - inner[l]) / b0[l]);
        sweep.store_next(slope);
        sweep.result(sweep.integral(slope))
    }

    /// `f(a)` where `f' = 1 + sign f²`.
    #[inline(always)]
    fn tangent(self, sign: f64, value: impl Fn(f64) -> f64) -> Jet<'a, L> {
        let sweep = self.sweep;
        let slope = self.store_slope();
        let (tangent, rate) = (sweep.next_row(), sweep.next_row() + 1);
        let newest = if sweep.order == 0 {
            lanes(|l| value(self.newest[l]))
        } else {
            self.integral(slope, rate)
        };
        let result = sweep.result(newest);
        let of_square = if sweep.order == 0 {
            lanes(|l| 1.0 + sign * (newest[l] * newest[l]))
        } else {
            let (inner, t0) = (sweep.convolution(tangent, tangent), sweep.at(tangent, 0));
            lanes(|l| sign * (inner[l] + 2.0 * t0[l] * newest[l]))
        };
        sweep.store_next(of_square);
        result
    }

    /// The error function, whose slope is `2/√π exp(−a²)`.
    #[inline(always)]
    fn error_function(self) -> Jet<'a, L> {
        let (sweep, a) = (self.sweep, self.newest);
        let slope = self.store_slope();
        let of_exponent = if sweep.order == 0 {
            [0.0; L]
        } else {
            let (inner, a0) = (sweep.convolution(self.row, self.row), self.first());
            sweep.slope(lanes(|l| -(inner[l] + 2.0 * a0[l] * a[l])))
        };
        let exponent = sweep.store_next(of_exponent);
        let rate = sweep.next_row() + 1;
        let newest = if sweep.order == 0 {
            lanes(|l| math::erf(a[l]))
        } else {
            self.integral(slope, rate)
        };
        let result = sweep.result(newest);
        let of_rate = if sweep.order == 0 {
            lanes(|l| math::ERF_SLOPE * math::exp(-(a[l] * a[l])))
        } else {
            let (inner, g0) = (sweep.convolution(exponent, rate), sweep.at(rate, 0));
            sweep.integral(lanes(|l| inner[l] + of_exponent[l] * g0[l]))
        };
        sweep.store_next(of_rate);
        result
    }

    /// Two functions, each the derivative of the other up to the sign of the second's.
    #[inline(always)]
    fn pair(self, sign: f64, both: impl Fn(f64) -> (f64, f64)) -> (Jet<'a, L>, Jet<'a, L>) {
        let sweep = self.sweep;
        let slope = self.store_slope();
        if sweep.order == 0 {
            return sweep.results(self.newest, both);
        }
        let (one, other) = (sweep.next_row(), sweep.next_row() + 1);
        let of_one = unless_overflowed(self.integral(slope, other), sweep.at(one, 0));
        let of_other = unless_overflowed(self.integral(slope, one), sweep.at(other, 0));
        let results = (sweep.result(of_one), lanes(|l| sign * of_other[l]));
        (results.0, sweep.result(results.1))
    }

    #[inline(always)]
    fn exponential(self) -> Jet<'a, L> {
        let sweep = self.sweep;
        let slope = self.store_slope();
        sweep.result(if sweep.order == 0 {
            lanes(|l| math::exp(self.newest[l]))
        } else {
            unless_overflowed(
                self.integral(slope, sweep.next_row()),
                sweep.at(sweep.next_row(), 0),
            )
        })
    }

    #[inline(always)]
    fn root(self) -> Jet<'a, L> {
        let (sweep, newest) = (self.sweep, self.newest);
        if sweep.order == 0 {
            return sweep.result(lanes(|l| newest[l].sqrt()));
        }
        let root = sweep.next_row();
        let (inner, r0) = (sweep.convolution(root, root), sweep.at(root, 0));
        sweep.result(lanes(|l| part(newest[l] - inner[l], 2.0 * r0[l])))
    }

    /// A real power.
    #[inline(always)]
    fn power(self, p: f64) -> Jet<'a, L> {
        let (sweep, a) = (self.sweep, self.newest);
        let slope = self.store_slope();
        let (of_power, power) = (sweep.next_row(), sweep.next_row() + 1);
        if sweep.order == 0 {
            sweep.store_next([0.0; L]);
            return sweep.result(lanes(|l| math::pow(a[l], p)));
        }
        // a · s y' = p y · s a'
        let (up, down) = (
            sweep.convolution(slope, power),
            sweep.convolution(self.row, of_power),
        );
        let (of_a, a0, y0) = (sweep.slope(a), self.first(), sweep.at(power, 0));
        let newest = lanes(|l| part(p * (up[l] + of_a[l] * y0[l]) - down[l], a0[l]));
        sweep.store_next(newest);
        sweep.result(sweep.integral(newest))
    }

    /// Stores the coefficients of `s a'(s)`.
    #[inline(always)]
    fn store_slope(self) -> usize {
        self.sweep.store_next(self.sweep.slope(self.newest))
    }
}

/// A quotient that is zero where both are: a root, or a power, of zero stays zero.
#[inline(always)]
fn part(of: f64, by: f64) -> f64 {
    if of == 0.0 && by == 0.0 { 0.0 } else { of / by }
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
        if let Some(sweep) = self.sweep() {
            for a in &a0[1..] {
                if flat.bound_before(*a) != bound {
                    sweep.lanes_differ.set(true);
                }
            }
        }
        bound
    }

    #[inline(always)]
    fn check_flat(self, flat: Flat) {
        if let Some(bound) = self.bound_before(flat) {
            self.exceeds(Self::constant(bound));
        }
    }

    /// The hyperbolic sine and cosine, without the comparison where 1 is lost beside them.
    #[inline(always)]
    pub(super) fn sinh_cosh_unchecked(self) -> (Self, Self) {
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
    pub(super) fn tanh_unchecked(self) -> Self {
        match self.in_row() {
            Ok(a) => a.tangent(-1.0, math::tanh),
            Err(a) => Self::constant(math::tanh(a)),
        }
    }

    /// The error function, without the comparison at its bound.
    #[inline(always)]
    pub(super) fn erf_unchecked(self) -> Self {
        match self.in_row() {
            Ok(a) => a.error_function(),
            Err(a) => Self::constant(math::erf(a)),
        }
    }

    /// The exponential function, without the comparison at its bound.
    #[inline(always)]
    pub(super) fn exp_unchecked(self) -> Self {
        match self.in_row() {
            Ok(a) => a.exponential(),
            Err(a) => Self::constant(math::exp(a)),
        }
    }
}

impl<const L: usize> Scalar for Jet<'_, L> {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Linear(LinearJet::constant(value))
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
        if let Some(sweep) = self.sweep() {
            sweep.value_read.set(true);
        }
        self.first()[0]
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn exceeds(self, other: Self) -> bool {
        let (a0, b0) = (self.first(), other.first());
        let exceeds = a0[0] > b0[0];
        let Some(sweep) = self.sweep().or(other.sweep()) else {
            return exceeds;
        };
        for l in 1..L {
            if (a0[l] > b0[l]) != exceeds {
                sweep.lanes_differ.set(true);
            }
        }
        self.choose(other, exceeds);
        exceeds
    }
    #[inline(always)]
    fn vanishes(self) -> bool {
        self.is_zero()
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
        if let Linear(LinearJet {
            value,
            slope,
            sweep: Some(sweep),
        }) = self
        {
            if sweep.order == 0 {
                return sweep.results(value, math::sin_cos);
            }
            let (sine, last) = (sweep.next_row(), sweep.order - 1);
            let (s, c) = (sweep.at(sine, last), sweep.at(sine + 1, last));
            let of_sine = sweep.integral(lanes(|l| slope[l] * c[l]));
            let of_cosine = sweep.integral(lanes(|l| -slope[l] * s[l]));
            return (sweep.result(of_sine), sweep.result(of_cosine));
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
    fn erf(self) -> Self {
        self.check_flat(Flat::ErrorFunction);
        self.erf_unchecked()
    }
    #[inline(always)]
    fn sinh(self) -> Self {
        self.check_flat(Flat::Exponential);
        self.sinh_cosh_unchecked().0
    }
    #[inline(always)]
    fn cosh(self) -> Self {
        self.check_flat(Flat::Exponential);
        self.sinh_cosh_unchecked().1
    }
    #[inline(always)]
    fn tanh(self) -> Self {
        self.check_flat(Flat::HyperbolicTangent);
        self.tanh_unchecked()
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
        self.check_flat(Flat::Exponential);
        self.exp_unchecked()
    }
    #[inline(always)]
    fn ln(self) -> Self {
        match self.in_row() {
            Ok(a) => a.over(a, math::ln),
            Err(a) => Self::constant(math::ln(a)),
        }
    }
}
