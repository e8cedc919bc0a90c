//! A number that evaluates its own recurrence. It holds its newest Taylor coefficient and the
//! location of its earlier ones.

use std::fmt;
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::pass::Pass;
use super::row::{Lanes, lanes, product, quotient};
use crate::scalar::Scalar;

use Jet::{Line, One, Series, Zero};

/// A number in one pass through a function.
///
/// Numbers that are constant or linear in time need no row, and operations on them are folded. Zero
/// and one are variants of their own, known without a look at the value. So derivatives of dual
/// numbers that are zero or one cost nothing.
#[derive(Clone, Copy)]
pub(crate) enum Jet<'a, const L: usize> {
    Zero,
    One,
    Line(Straight<'a, L>),
    Series(Coefficient<'a, L>),
}

/// A number that is linear in time. Without a pass it is constant.
#[derive(Clone, Copy)]
pub(crate) struct Straight<'a, const L: usize> {
    pub(super) value: Lanes<L>,
    pub(super) slope: Lanes<L>,
    pub(super) pass: Option<&'a Pass<'a, L>>,
}

/// The newest coefficient of a number, and the number's row.
#[derive(Clone, Copy)]
pub(crate) struct Coefficient<'a, const L: usize> {
    pub(super) newest: Lanes<L>,
    pub(super) row: usize,
    /// Whether the coefficient is stored in its row. It is stored when an operation first needs the
    /// earlier coefficients, which a sum does not.
    is_kept: bool,
    /// Whether the number is linear in state and time.
    pub(super) is_linear: bool,
    pub(super) pass: &'a Pass<'a, L>,
}

impl<const L: usize> fmt::Debug for Jet<'_, L> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Zero => write!(f, "0"),
            One => write!(f, "1"),
            Line(Straight { value, slope, .. }) => write!(f, "{value:?} + {slope:?} s"),
            Series(a) => write!(f, "… + {:?} s^{}", a.newest, a.pass.order),
        }
    }
}

impl<'a, const L: usize> Straight<'a, L> {
    #[inline(always)]
    pub(super) fn constant(value: f64) -> Self {
        Straight {
            value: [value; L],
            slope: [0.0; L],
            pass: None,
        }
    }

    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Straight {
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

impl<'a, const L: usize> Pass<'a, L> {
    /// A new number with a row of its own.
    #[inline(always)]
    pub(super) fn number(&'a self, newest: Lanes<L>, is_linear: bool) -> Jet<'a, L> {
        Series(Coefficient {
            newest,
            row: self.take(),
            is_kept: false,
            is_linear,
            pass: self,
        })
    }

    /// A number that is computed already at this order.
    #[inline(always)]
    pub(super) fn known(&'a self, row: usize) -> Jet<'a, L> {
        Series(Coefficient {
            newest: self.at(row, self.order),
            row,
            is_kept: true,
            is_linear: false,
            pass: self,
        })
    }

    /// A component of the state.
    #[inline(always)]
    pub(super) fn state(&'a self, newest: Lanes<L>) -> Jet<'a, L> {
        Series(Coefficient {
            newest,
            row: self.keep(newest),
            is_kept: true,
            is_linear: true,
            pass: self,
        })
    }

    /// A new number that is not linear in state and time, and whose recurrence needs its own
    /// earlier coefficients.
    #[inline(always)]
    pub(super) fn result(&'a self, newest: Lanes<L>) -> Jet<'a, L> {
        Series(Coefficient {
            newest,
            row: self.keep(newest),
            is_kept: true,
            is_linear: false,
            pass: self,
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
    fn kept(self) -> Self {
        if !self.is_kept {
            self.pass.put(self.row, self.newest);
        }
        Coefficient {
            is_kept: true,
            ..self
        }
    }

    /// The value of a number that is stored.
    #[inline(always)]
    pub(super) fn first(self) -> Lanes<L> {
        if self.pass.order == 0 {
            self.newest
        } else {
            self.pass.at(self.row, 0)
        }
    }

    #[inline(always)]
    fn times(self, other: Self) -> Jet<'a, L> {
        let (this, other) = (self.kept(), other.kept());
        let (pass, a, b) = (this.pass, this.newest, other.newest);
        let newest = if pass.order == 0 {
            lanes(|l| a[l] * b[l])
        } else {
            let inner = pass.convolution(this.row, other.row);
            product(inner, (this.first(), a), (other.first(), b))
        };
        pass.number(newest, false)
    }

    #[inline(always)]
    fn times_line(self, line: Straight<'a, L>) -> Jet<'a, L> {
        let (pass, a) = (self.pass, self.newest);
        let product = lanes(|l| a[l] * line.value[l]);
        if line.pass.is_none() {
            return pass.number(product, self.is_linear);
        }
        let row = self.kept().row;
        let newest = if pass.order == 0 {
            product
        } else {
            let last = pass.at(row, pass.order - 1);
            lanes(|l| last[l] * line.slope[l] + product[l])
        };
        pass.number(newest, false)
    }

    /// `a/self`, where `a` has the newest coefficient `a`.
    #[inline(always)]
    fn divides(self, a: Lanes<L>) -> Jet<'a, L> {
        let (pass, b) = (self.pass, self.newest);
        let newest = if pass.order == 0 {
            if b.iter().any(|b| b.is_infinite()) {
                pass.overflowed.set(true);
            }
            lanes(|l| a[l] / b[l])
        } else {
            let row = pass.next();
            let inner = pass.convolution(self.row, row);
            quotient(inner, a, (self.first(), b), pass.at(row, 0))
        };
        pass.result(newest)
    }
}

impl<'a, const L: usize> Jet<'a, L> {
    /// The number as a linear function of time; zero if it has a row.
    #[inline(always)]
    pub(super) fn line(self) -> Straight<'a, L> {
        match self {
            Line(a) => a,
            One => Straight::constant(1.0),
            Zero | Series(_) => Straight::constant(0.0),
        }
    }

    /// The pass that the number belongs to; `None` for a constant.
    #[inline(always)]
    pub(super) fn pass(self) -> Option<&'a Pass<'a, L>> {
        match self {
            Series(a) => Some(a.pass),
            Zero | One | Line(_) => self.line().pass,
        }
    }

    #[inline(always)]
    pub(super) fn newest(self, order: usize) -> Lanes<L> {
        match self {
            Series(a) => a.newest,
            Zero | One | Line(_) => self.line().newest(order),
        }
    }

    /// The value in every lane.
    #[inline(always)]
    pub(super) fn first(self) -> Lanes<L> {
        match self {
            Series(a) => a.kept().first(),
            Zero | One | Line(_) => self.line().value,
        }
    }

    /// The number with a row of its own, or its value if it is constant.
    #[inline(always)]
    pub(super) fn in_row(self) -> Result<Coefficient<'a, L>, f64> {
        if let Series(a) = self {
            return Ok(a.kept());
        }
        let line = self.line();
        let pass = line.pass.ok_or(line.value[0])?;
        let newest = line.newest(pass.order);
        Ok(Coefficient {
            newest,
            row: pass.keep(newest),
            is_kept: true,
            is_linear: true,
            pass,
        })
    }

    /// Stores the coefficient in its row.
    #[inline(always)]
    pub(super) fn keep(self) {
        if let Series(a) = self {
            a.kept();
        }
    }

    /// Whether it is linear in state and time.
    #[inline(always)]
    pub(super) fn is_linear(self) -> bool {
        match self {
            Series(a) => a.is_linear,
            Zero | One | Line(_) => true,
        }
    }

    /// The number itself, marked as linear in state and time or not.
    #[inline(always)]
    pub(super) fn linear(self, is_linear: bool) -> Self {
        match self {
            Series(a) => Series(Coefficient { is_linear, ..a }),
            Zero | One | Line(_) => self,
        }
    }

    /// Stores the difference between the chosen and the rejected number of a comparison.
    #[inline(always)]
    pub(super) fn choose(self, other: Self, exceeds: bool) {
        if let Some(pass) = self.pass().or(other.pass()) {
            let (a, b) = (self.newest(pass.order), other.newest(pass.order));
            if !(self.is_linear() && other.is_linear()) {
                pass.choices_bend.set(true);
            }
            pass.choose(lanes(|l| if exceeds { a[l] - b[l] } else { b[l] - a[l] }));
        }
    }

    /// Whether the number is zero in the first lane.
    #[inline(always)]
    pub(super) fn is_zero(self) -> bool {
        // The value is read only if some lane is zero.
        self.first().contains(&0.0) && self.value() == 0.0
    }

    /// A sum or difference. Above order 1 the result does not depend on a linear summand.
    #[inline(always)]
    fn combined(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        match (self, other) {
            (Series(a), Series(b)) => {
                let newest = lanes(|l| f(a.newest[l], b.newest[l]));
                a.pass.number(newest, a.is_linear && b.is_linear)
            }
            (Series(a), _) => {
                let newest = if a.pass.order < 2 {
                    let b = other.line().newest(a.pass.order);
                    lanes(|l| f(a.newest[l], b[l]))
                } else {
                    a.newest
                };
                a.pass.number(newest, a.is_linear)
            }
            (_, Series(b)) => {
                let a = self.line().newest(b.pass.order);
                b.pass.number(lanes(|l| f(a[l], b.newest[l])), b.is_linear)
            }
            _ => {
                let (a, b) = (self.line(), other.line());
                Line(Straight {
                    value: lanes(|l| f(a.value[l], b.value[l])),
                    slope: lanes(|l| f(a.slope[l], b.slope[l])),
                    pass: a.pass.or(b.pass),
                })
            }
        }
    }

    /// A product with a constant, or a quotient by one.
    #[inline(always)]
    fn scaled(self, f: impl Fn(f64) -> f64) -> Self {
        match self {
            Zero => Zero,
            Series(a) => a.pass.number(lanes(|l| f(a.newest[l])), a.is_linear),
            One | Line(_) => Line(self.line().map(f)),
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
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        match (self, other) {
            (Zero, _) | (_, Zero) => Zero,
            (One, a) | (a, One) => a,
            (Series(a), Series(b)) => a.times(b),
            (Series(a), Line(b)) | (Line(b), Series(a)) => a.times_line(b),
            (
                Line(a),
                Line(Straight {
                    value, pass: None, ..
                }),
            ) => Line(a.map(|a| a * value[0])),
            (Line(_), Line(b)) => match self.in_row() {
                Ok(a) => a.times_line(b),
                Err(a) => other * a,
            },
        }
    }
}

impl<const L: usize> Div for Jet<'_, L> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        match (self, other) {
            (Zero, _) => Zero,
            (a, One) => a,
            _ => match other.in_row() {
                Ok(b) => b.divides(self.newest(b.pass.order)),
                Err(b) => self / b,
            },
        }
    }
}

impl<const L: usize> Add<f64> for Jet<'_, L> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: f64) -> Self {
        self.combined(Line(Straight::constant(other)), |a, b| a + b)
    }
}

impl<const L: usize> Sub<f64> for Jet<'_, L> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: f64) -> Self {
        self.combined(Line(Straight::constant(other)), |a, b| a - b)
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
                let newest = if a.pass.order == 0 {
                    lanes(|l| a.newest[l] / other)
                } else {
                    // Only the value is divided; the other coefficients use the reciprocal, which
                    // is faster.
                    let inverse = 1.0 / other;
                    lanes(|l| a.newest[l] * inverse)
                };
                a.pass.number(newest, a.is_linear)
            }
            _ => self.scaled(|a| a / other),
        }
    }
}
