//! The series of a solution, order by order.

use super::inverse;
use super::jet::{Coefficient, Jet};
use super::row::{CoefficientRow, Lanes, lanes};
use super::sweep::{CoefficientRows, MIN_ROWS, Sweep};
use crate::scalar::Scalar;

/// Coefficients of everything that a field and its watched functions compute. Each is scaled by the
/// power of a step length, so that none overflows. The state's components are the first rows.
#[derive(Debug, Default)]
pub(crate) struct Series<const L: usize> {
    rows: Vec<CoefficientRow<L>>,
}

/// A field, and functions that are evaluated along its solutions.
pub(crate) trait Functions<const N: usize, const W: usize> {
    fn at<T: Scalar>(&self, t: T, x: &[T; N]) -> ([T; N], [T; W]);

    /// [`Functions::at`] a state of which the components that do not move are numbers like others.
    #[inline(always)]
    fn at_held<T: Scalar>(&self, t: T, x: &[T; N]) -> ([T; N], [T; W]) {
        self.at(t, x)
    }

    /// Number of components of the state that move. The others are constants of the functions.
    fn dimension(&self) -> usize {
        N
    }
}

/// A function of the solution that is not constant.
#[derive(Clone, Copy, Debug)]
pub struct WatchedRow {
    /// The function's row.
    pub row: usize,
    /// Whether it is linear in state and time.
    pub is_linear: bool,
}

/// Description of an expansion.
#[derive(Clone, Copy, Debug)]
pub struct Expansion<const W: usize> {
    /// The watched functions; `None` for constant ones.
    pub watched: [Option<WatchedRow>; W],
    /// Number of comparisons that the expansion depends on.
    pub choices: usize,
    /// Whether a comparison has an operand that is not linear in state and time.
    pub choices_nonlinear: bool,
    /// Whether values were read. The series may then hold only at the point of expansion.
    pub value_read: bool,
    /// Whether the lanes cannot be expanded together.
    pub lanes_differ: bool,
    /// Whether there was a division by an overflowed number. A coefficient that is NaN then stays
    /// NaN over a shorter step.
    pub overflowed: bool,
}

impl<const W: usize> Default for Expansion<W> {
    fn default() -> Self {
        Expansion {
            watched: [None; W],
            choices: 0,
            choices_nonlinear: false,
            value_read: false,
            lanes_differ: false,
            overflowed: false,
        }
    }
}

impl<const W: usize> Expansion<W> {
    /// [`Series::choices`], among all rows.
    #[inline(always)]
    pub(crate) fn choices_among<'r, const L: usize>(
        &self,
        rows: &'r [CoefficientRow<L>],
    ) -> &'r [CoefficientRow<L>] {
        &rows[rows.len() - self.choices..]
    }
}

impl<const L: usize> Series<L> {
    #[cold]
    #[inline(never)]
    fn make_room(&mut self, rows: usize) {
        self.rows.resize(rows, CoefficientRow::new());
    }

    /// Calls a function that expands into rows or returns the number of rows it needs.
    #[inline(always)]
    pub(crate) fn expand_by<R>(
        &mut self,
        mut expand: impl FnMut(CoefficientRows<'_, L>) -> Result<R, usize>,
    ) -> R {
        loop {
            let all = self.rows.as_slice();
            let expanded = match all.first_chunk() {
                Some(first) => expand(CoefficientRows { first, all }),
                None => Err(MIN_ROWS),
            };
            match expanded {
                Ok(expanded) => return expanded,
                Err(needed) => self.make_room(needed),
            }
        }
    }
}

/// The rows of the watched functions that are not constant.
#[inline(always)]
pub(super) fn watched_rows<const L: usize, const W: usize>(
    functions: [Jet<'_, L>; W],
) -> [Option<WatchedRow>; W] {
    let mut rows = [None; W];
    for (row, function) in rows.iter_mut().zip(functions) {
        if let Ok(Coefficient {
            row: place,
            is_linear,
            ..
        }) = function.in_row()
        {
            *row = Some(WatchedRow {
                row: place,
                is_linear,
            });
        }
    }
    rows
}

/// Description of an expansion from its last sweep, or the number of rows it takes.
#[inline(always)]
pub(super) fn outcome<const L: usize, const W: usize>(
    sweep: &Sweep<'_, L>,
    watched: [Option<WatchedRow>; W],
    room: usize,
) -> Result<Expansion<W>, usize> {
    let (taken, choices) = (sweep.rows_taken.get(), sweep.choices.get());
    if taken + choices > room {
        return Err(taken + choices);
    }
    Ok(Expansion {
        watched,
        choices,
        choices_nonlinear: sweep.choices_nonlinear.get(),
        value_read: sweep.value_read.get(),
        lanes_differ: sweep.lanes_differ.get(),
        overflowed: sweep.overflowed.get(),
    })
}

/// Computes the series to `order` of the solution through `x` at `t`, and of functions of it, in
/// units of time `h`. Returns the required number of rows if there are too few.
#[inline(always)]
pub(crate) fn in_rows<F: Functions<N, W>, const L: usize, const N: usize, const W: usize>(
    into: CoefficientRows<'_, L>,
    (t, h): (Lanes<L>, Lanes<L>),
    x: &[Lanes<L>; N],
    order: usize,
    functions: &F,
) -> Result<Expansion<W>, usize> {
    let mut newest = *x;
    let mut k = 0;
    let mut overflowed = false;
    loop {
        let sweep = Sweep::new(into, k);
        // Plain loops, because the standard library's array functions are not always inlined.
        let mut state = [Jet::Zero; N];
        for (number, newest) in state.iter_mut().zip(newest) {
            *number = sweep.state(newest);
        }
        let (field, watched) = functions.at(sweep.time(t, h), &state);
        let expansion = outcome(&sweep, watched_rows(watched), into.all.len())?;
        // Only the first sweep computes values.
        overflowed |= expansion.overflowed;
        if k == order {
            return Ok(Expansion {
                overflowed,
                ..expansion
            });
        }
        k += 1;
        let per_order = inverse(k);
        for (newest, slope) in newest.iter_mut().zip(&field) {
            let slope = slope.newest(sweep.order);
            *newest = lanes(|l| slope[l] * (h[l] * per_order));
        }
    }
}

impl<const L: usize> Series<L> {
    /// All rows.
    #[inline(always)]
    pub(crate) fn rows(&self) -> &[CoefficientRow<L>] {
        &self.rows
    }

    /// The rows of the differences between the chosen and the rejected operand of comparisons.
    #[inline(always)]
    pub(crate) fn choices<const W: usize>(&self, expansion: &Expansion<W>) -> &[CoefficientRow<L>] {
        expansion.choices_among(&self.rows)
    }
}
