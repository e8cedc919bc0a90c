//! A number that evaluates its own recurrence. It holds its newest Taylor coefficient and the
//! location of its earlier ones.

use std::fmt;
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::row::{Lanes, lanes, product, quotient};
use super::sweep::Sweep;
use crate::scalar::Scalar;

use Jet::{Linear, One, Series, Zero};

/// A number in one sweep through a function.
///
/// Numbers that are constant or linear in time need no row, and operations on them are folded. Zero
/// and one are variants of their own, known without a look at the value. So derivatives of dual
/// numbers that are zero or one cost nothing.
///
/// The compiler must see which variant a number is, so that operations are inlined. In builds with
/// debug assertions the longest are not: to compile them at each place takes most of a build.
#[derive(Clone, Copy)]
pub(crate) enum Jet<'a, const L: usize> {
    Zero,
    One,
    Linear(LinearJet<'a, L>),
    Series(Coefficient<'a, L>),
}

/// A number that is linear in time. Without a sweep it is constant.
#[derive(Clone, Copy)]
pub(crate) struct LinearJet<'a, const L: usize> {
    pub(super) value: Lanes<L>,
    pub(super) slope: Lanes<L>,
    pub(super) sweep: Option<&'a Sweep<'a, L>>,
}

/// The newest coefficient of a number, and the number's row.
#[derive(Clone, Copy)]
pub(crate) struct Coefficient<'a, const L: usize> {
    pub(super) newest: Lanes<L>,
    pub(super) row: usize,
    /// Whether the coefficient is stored in its row. It is stored when an operation first needs the
    /// earlier coefficients, which a sum does not.
    is_stored: bool,
    /// Whether the number is linear in state and time.
    pub(super) is_linear: bool,
    pub(super) sweep: &'a Sweep<'a, L>,
}

impl<const L: usize> fmt::Debug for Jet<'_, L> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Zero => write!(f, "0"),
            One => write!(f, "1"),
            Linear(LinearJet { value, slope, .. }) => write!(f, "{value:?} + {slope:?} s"),
            Series(a) => write!(f, "… + {:?} s^{}", a.newest, a.sweep.order),
        }
    }
}

impl<'a, const L: usize> LinearJet<'a, L> {
    #[inline(always)]
    pub(super) fn constant(value: f64) -> Self {
        LinearJet {
            value: [value; L],
            slope: [0.0; L],
            sweep: None,
        }
    }

    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        LinearJet {
            value: lanes(|l| f(self.value[l])),
            slope: lanes(|l| f(self.slope[l])),
            ..self
        }
    }

    #[inline(always)]
    fn newest(self, order: usize) -> Lanes<L> {
        match order {
            0 => self.value,
            1 => self.slope,
            _ => [0.0; L],
        }
    }
}

impl<'a, const L: usize> Sweep<'a, L> {
    /// Time.
    #[inline(always)]
    pub(super) fn time(&'a self, t: Lanes<L>, h: Lanes<L>) -> Jet<'a, L> {
        Linear(LinearJet {
            value: t,
            slope: h,
            sweep: Some(self),
        })
    }

    /// A new number with a row of its own.
    #[inline(always)]
    pub(super) fn number(&'a self, newest: Lanes<L>, is_linear: bool) -> Jet<'a, L> {
        Series(Coefficient {
            newest,
            row: self.take_row(),
            is_stored: false,
            is_linear,
            sweep: self,
        })
    }

    /// A number that is computed already at this order.
    #[inline(always)]
    pub(super) fn stored_number(&'a self, row: usize) -> Jet<'a, L> {
        Series(Coefficient {
            newest: self.at(row, self.order),
            row,
            is_stored: true,
            is_linear: false,
            sweep: self,
        })
    }

    /// A component of the state.
    #[inline(always)]
    pub(super) fn state(&'a self, newest: Lanes<L>) -> Jet<'a, L> {
        Series(Coefficient {
            newest,
            row: self.store_next(newest),
            is_stored: true,
            is_linear: true,
            sweep: self,
        })
    }

    /// A new number that is not linear in state and time, and whose recurrence needs its own
    /// earlier coefficients.
    #[inline(always)]
    pub(super) fn result(&'a self, newest: Lanes<L>) -> Jet<'a, L> {
        Series(Coefficient {
            newest,
            row: self.store_next(newest),
            is_stored: true,
            is_linear: false,
            sweep: self,
        })
    }

    /// Two such numbers whose values are computed together.
    #[inline(always)]
    pub(super) fn results(
        &'a self,
        of: Lanes<L>,
        both: impl Fn(f64) -> (f64, f64),
    ) -> (Jet<'a, L>, Jet<'a, L>) {
        let mut one = [0.0; L];
        let other = lanes(|l| {
            let values = both(of[l]);
            one[l] = values.0;
            values.1
        });
        (self.result(one), self.result(other))
    }
}

impl<'a, const L: usize> Coefficient<'a, L> {
    /// The number itself, with its coefficient stored in its row.
    #[inline(always)]
    fn stored(self) -> Self {
        if !self.is_stored {
            self.sweep.store(self.row, self.newest);
        }
        Coefficient {
            is_stored: true,
            ..self
        }
    }

    /// The value of a number that is stored.
    #[inline(always)]
    pub(super) fn first(self) -> Lanes<L> {
        if self.sweep.order == 0 {
            self.newest
        } else {
            self.sweep.at(self.row, 0)
        }
    }

    #[inline(always)]
    fn times(self, other: Self) -> Jet<'a, L> {
        let (this, other) = (self.stored(), other.stored());
        let (sweep, a, b) = (this.sweep, this.newest, other.newest);
        let newest = if sweep.order == 0 {
            lanes(|l| a[l] * b[l])
        } else {
            let inner = sweep.convolution(this.row, other.row);
            product(inner, (this.first(), a), (other.first(), b))
        };
        sweep.number(newest, false)
    }

    #[inline(always)]
    fn times_linear(self, linear: LinearJet<'a, L>) -> Jet<'a, L> {
        let (sweep, a) = (self.sweep, self.newest);
        let product = lanes(|l| a[l] * linear.value[l]);
        if linear.sweep.is_none() {
            return sweep.number(product, self.is_linear);
        }
        let row = self.stored().row;
        let newest = if sweep.order == 0 {
            product
        } else {
            let last = sweep.at(row, sweep.order - 1);
            lanes(|l| last[l] * linear.slope[l] + product[l])
        };
        sweep.number(newest, false)
    }

    /// `a/self`, where `a` has the newest coefficient `a`.
    #[inline(always)]
    fn divides(self, a: Lanes<L>) -> Jet<'a, L> {
        let (sweep, b) = (self.sweep, self.newest);
        let newest = if sweep.order == 0 {
            if b.iter().any(|b| b.is_infinite()) {
                sweep.overflowed.set(true);
            }
            lanes(|l| a[l] / b[l])
        } else {
            let row = sweep.next_row();
            let inner = sweep.convolution(self.row, row);
            quotient(inner, a, (self.first(), b), sweep.at(row, 0))
        };
        sweep.result(newest)
    }
}

impl<'a, const L: usize> Jet<'a, L> {
    /// The number as a linear function of time; zero if it has a row.
    #[inline(always)]
    pub(super) fn as_linear(self) -> LinearJet<'a, L> {
        match self {
            Linear(a) => a,
            One => LinearJet::constant(1.0),
            Zero | Series(_) => LinearJet::constant(0.0),
        }
    }

    /// The sweep that the number belongs to; `None` for a constant.
    #[inline(always)]
    pub(super) fn sweep(self) -> Option<&'a Sweep<'a, L>> {
        match self {
            Series(a) => Some(a.sweep),
            Zero | One | Linear(_) => self.as_linear().sweep,
        }
    }

    #[inline(always)]
    pub(super) fn newest(self, order: usize) -> Lanes<L> {
        match self {
            Series(a) => a.newest,
            Zero | One | Linear(_) => self.as_linear().newest(order),
        }
    }

    /// The value in every lane.
    #[inline(always)]
    pub(super) fn first(self) -> Lanes<L> {
        match self {
            Series(a) => a.stored().first(),
            Zero | One | Linear(_) => self.as_linear().value,
        }
    }

    /// The number with a row of its own, or its value if it is constant.
    #[inline(always)]
    pub(super) fn in_row(self) -> Result<Coefficient<'a, L>, f64> {
        if let Series(a) = self {
            return Ok(a.stored());
        }
        let linear = self.as_linear();
        let sweep = linear.sweep.ok_or(linear.value[0])?;
        let newest = linear.newest(sweep.order);
        Ok(Coefficient {
            newest,
            row: sweep.store_next(newest),
            is_stored: true,
            is_linear: true,
            sweep,
        })
    }

    /// Stores the coefficient in its row.
    #[inline(always)]
    pub(super) fn store(self) {
        if let Series(a) = self {
            a.stored();
        }
    }

    /// Whether it is linear in state and time.
    #[inline(always)]
    pub(super) fn is_linear(self) -> bool {
        match self {
            Series(a) => a.is_linear,
            Zero | One | Linear(_) => true,
        }
    }

    /// The number itself, marked as linear in state and time or not.
    #[inline(always)]
    pub(super) fn with_linearity(self, is_linear: bool) -> Self {
        match self {
            Series(a) => Series(Coefficient { is_linear, ..a }),
            Zero | One | Linear(_) => self,
        }
    }

    /// Stores the difference between the chosen and the rejected number of a comparison.
    #[inline(always)]
    pub(super) fn choose(self, other: Self, exceeds: bool) {
        if let Some(sweep) = self.sweep().or(other.sweep()) {
            let (a, b) = (self.newest(sweep.order), other.newest(sweep.order));
            if !(self.is_linear() && other.is_linear()) {
                sweep.choices_nonlinear.set(true);
            }
            sweep.choose(lanes(|l| if exceeds { a[l] - b[l] } else { b[l] - a[l] }));
        }
    }

    /// Whether the number is zero in the first lane.
    #[inline(always)]
    pub(super) fn is_zero(self) -> bool {
        // The value is read only if some lane is zero.
        self.first().contains(&0.0) && self.value() == 0.0
    }

    /// A sum or difference. Above order 1 the result does not depend on a linear summand.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn combined(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        match (self, other) {
            (Series(a), Series(b)) => {
                let newest = lanes(|l| f(a.newest[l], b.newest[l]));
                a.sweep.number(newest, a.is_linear && b.is_linear)
            }
            (Series(a), _) => {
                let newest = if a.sweep.order < 2 {
                    let b = other.as_linear().newest(a.sweep.order);
                    lanes(|l| f(a.newest[l], b[l]))
                } else {
                    a.newest
                };
                a.sweep.number(newest, a.is_linear)
            }
            (_, Series(b)) => {
                let a = self.as_linear().newest(b.sweep.order);
                b.sweep.number(lanes(|l| f(a[l], b.newest[l])), b.is_linear)
            }
            _ => {
                let (a, b) = (self.as_linear(), other.as_linear());
                Linear(LinearJet {
                    value: lanes(|l| f(a.value[l], b.value[l])),
                    slope: lanes(|l| f(a.slope[l], b.slope[l])),
                    sweep: a.sweep.or(b.sweep),
                })
            }
        }
    }

    /// A product with a constant, or a quotient by one.
    #[inline(always)]
    fn scaled(self, f: impl Fn(f64) -> f64) -> Self {
        match self {
            Zero => Zero,
            Series(a) => a.sweep.number(lanes(|l| f(a.newest[l])), a.is_linear),
            One | Linear(_) => Linear(self.as_linear().map(f)),
        }
    }
}

impl<const L: usize> Neg for Jet<'_, L> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.scaled(|a| -a)
    }
}

impl<const L: usize> Add for Jet<'_, L> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        match (self, other) {
            (Zero, a) | (a, Zero) => a,
            _ => self.combined(other, |a, b| a + b),
        }
    }
}

impl<const L: usize> Sub for Jet<'_, L> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        match (self, other) {
            (a, Zero) => a,
            (Zero, b) => -b,
            // Terms common to both sides of a boundary cancel exactly.
            (a, b) if a.is_same(b) => Zero,
            _ => self.combined(other, |a, b| a - b),
        }
    }
}

impl<const L: usize> Mul for Jet<'_, L> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul(self, other: Self) -> Self {
        match (self, other) {
            (Zero, _) | (_, Zero) => Zero,
            (One, a) | (a, One) => a,
            (Series(a), Series(b)) => a.times(b),
            (Series(a), Linear(b)) | (Linear(b), Series(a)) => a.times_linear(b),
            (
                Linear(a),
                Linear(LinearJet {
                    value, sweep: None, ..
                }),
            ) => Linear(a.map(|a| a * value[0])),
            (Linear(_), Linear(b)) => match self.in_row() {
                Ok(a) => a.times_linear(b),
                Err(a) => other * a,
            },
        }
    }
}

impl<const L: usize> Div for Jet<'_, L> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn div(self, other: Self) -> Self {
        match (self, other) {
            (Zero, _) => Zero,
            (a, One) => a,
            _ => match other.in_row() {
                Ok(b) => b.divides(self.newest(b.sweep.order)),
                Err(b) => self / b,
            },
        }
    }
}

impl<const L: usize> Add<f64> for Jet<'_, L> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: f64) -> Self {
        self.combined(Linear(LinearJet::constant(other)), |a, b| a + b)
    }
}

impl<const L: usize> Sub<f64> for Jet<'_, L> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: f64) -> Self {
        self.combined(Linear(LinearJet::constant(other)), |a, b| a - b)
    }
}

impl<const L: usize> Mul<f64> for Jet<'_, L> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        self.scaled(|a| a * other)
    }
}

impl<const L: usize> Div<f64> for Jet<'_, L> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: f64) -> Self {
        match self {
            Series(a) => {
                let newest = if a.sweep.order == 0 {
                    lanes(|l| a.newest[l] / other)
                } else {
                    // Only the value is divided; the other coefficients use the reciprocal, which
                    // is faster.
                    let inverse = 1.0 / other;
                    lanes(|l| a.newest[l] * inverse)
                };
                a.sweep.number(newest, a.is_linear)
            }
            _ => self.scaled(|a| a / other),
        }
    }
}
