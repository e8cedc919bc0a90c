//! One sweep through a function: one order of every number in it.

use std::cell::Cell;

use super::inverse;
use super::row::{CoefficientRow, Lanes, lanes};

/// Number of rows that there are at least, whose places the compiler knows. Chosen: few fields of
/// two or three states need more. Further rows are looked up.
pub(crate) const MIN_ROWS: usize = 32;

/// Storage of the coefficients: all rows, and the first of them.
///
/// The first rows are a separate field so that they can be an argument of a function that is not
/// inlined. Writing through an argument changes no local variable. So the compiler can evaluate the
/// counters of a sweep, and with them the row of each number.
#[derive(Clone, Copy, Debug)]
pub struct CoefficientRows<'a, const L: usize> {
    pub(crate) first: &'a [CoefficientRow<L>; MIN_ROWS],
    pub(crate) all: &'a [CoefficientRow<L>],
}

/// Storage that the numbers of one sweep share, above all for their earlier coefficients. Every
/// sweep assigns rows in the same order, so that each number gets the same row. If everything is
/// inlined, the compiler knows the rows and no look-up remains.
///
/// Numbers take rows from the front, comparisons from the back.
#[derive(Debug)]
pub(crate) struct Sweep<'a, const L: usize> {
    /// The first rows; their number is known to the compiler.
    first: &'a [CoefficientRow<L>; MIN_ROWS],
    rows: &'a [CoefficientRow<L>],
    pub(super) order: usize,
    pub(super) rows_taken: Cell<usize>,
    pub(super) choices: Cell<usize>,
    /// Whether a comparison has an operand that is not linear in state and time.
    pub(super) choices_nonlinear: Cell<bool>,
    /// Whether a value was read. The series may then hold only at the point of expansion.
    pub(super) value_read: Cell<bool>,
    /// Whether a comparison differs between lanes, so that they must be expanded one by one.
    pub(super) lanes_differ: Cell<bool>,
    /// Whether there was a division by an overflowed number.
    pub(super) overflowed: Cell<bool>,
}

impl<'a, const L: usize> Sweep<'a, L> {
    #[inline(always)]
    pub(super) fn new(rows: CoefficientRows<'a, L>, order: usize) -> Self {
        Sweep {
            first: rows.first,
            rows: rows.all,
            order,
            rows_taken: Cell::new(0),
            choices: Cell::new(0),
            choices_nonlinear: Cell::new(false),
            value_read: Cell::new(false),
            lanes_differ: Cell::new(false),
            overflowed: Cell::new(false),
        }
    }

    #[inline(always)]
    fn row(&self, row: usize) -> Option<&'a CoefficientRow<L>> {
        if row < MIN_ROWS {
            Some(&self.first[row])
        } else {
            self.rows.get(row)
        }
    }

    /// Stores a coefficient of this order in the next row. It is dropped if there is no room, which
    /// the first sweep reports.
    #[inline(always)]
    pub(super) fn store_next(&self, newest: Lanes<L>) -> usize {
        let row = self.take_row();
        self.store(row, newest);
        row
    }

    /// Takes the next row.
    #[inline(always)]
    pub(super) fn take_row(&self) -> usize {
        let row = self.rows_taken.get();
        self.rows_taken.set(row + 1);
        row
    }

    /// Stores a coefficient of this order in a row.
    #[inline(always)]
    pub(super) fn store(&self, row: usize, newest: Lanes<L>) {
        if let Some(row) = self.row(row) {
            row.set(self.order, newest);
        }
    }

    /// The row that will be taken next.
    #[inline(always)]
    pub(super) fn next_row(&self) -> usize {
        self.rows_taken.get()
    }

    /// Stores the difference between the chosen and the rejected operand of a comparison.
    #[inline(always)]
    pub(super) fn choose(&self, ahead: Lanes<L>) {
        let choice = self.choices.get();
        self.choices.set(choice + 1);
        if let Some(row) = self.rows.iter().nth_back(choice) {
            row.set(self.order, ahead);
        }
    }

    /// Coefficient `k` of a row.
    #[inline(always)]
    pub(super) fn at(&self, row: usize, k: usize) -> Lanes<L> {
        self.row(row).map_or([f64::NAN; L], |row| row.at(k))
    }

    /// The newest coefficient of the product of two rows, without the terms that have a coefficient
    /// 0.
    #[inline(always)]
    pub(super) fn convolution(&self, a: usize, b: usize) -> Lanes<L> {
        match (self.row(a), self.row(b)) {
            (Some(row), Some(_)) if a == b => row.square(self.order),
            (Some(a), Some(b)) => a.convolution(b, self.order),
            _ => [f64::NAN; L],
        }
    }

    /// The newest coefficient of an integral, from that of `s` times its integrand.
    #[inline(always)]
    pub(super) fn integral(&self, slope: Lanes<L>) -> Lanes<L> {
        let per_order = inverse(self.order);
        lanes(|l| slope[l] * per_order)
    }

    /// The newest coefficient of `s` times the derivative of a number.
    #[inline(always)]
    pub(super) fn slope(&self, newest: Lanes<L>) -> Lanes<L> {
        lanes(|l| newest[l] * self.order as f64)
    }
}
