//! The series of a solution, order by order.

use super::inverse;
use super::jet::{Coefficient, Jet};
use super::pass::{AT_ONCE, Pass, Rows};
use super::row::{Lanes, Row, lanes};
use crate::scalar::Scalar;

/// Coefficients of everything that a field and its watched functions compute. Each is scaled by the
/// power of a step length, so that none overflows. The state's components are the first rows.
#[derive(Debug, Default)]
pub(crate) struct Series<const L: usize> {
    rows: Vec<Row<L>>,
}

/// A field, and functions that are evaluated along its solutions.
pub(crate) trait Functions<const N: usize, const W: usize> {
    fn at<T: Scalar>(&self, t: T, x: &[T; N]) -> ([T; N], [T; W]);
}

/// A function of the solution that is not constant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Watched {
    /// The function's row.
    pub row: usize,
    /// Whether it is linear in state and time.
    pub is_linear: bool,
}

/// Description of an expansion.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Expansion<const W: usize> {
    /// The watched functions; `None` for constant ones.
    pub watched: [Option<Watched>; W],
    /// Number of comparisons that the expansion depends on.
    pub choices: usize,
    /// Whether a comparison has an operand that is not linear in state and time.
    pub choices_bend: bool,
    /// Whether values were read. The series may then hold only at the point of expansion.
    pub value_read: bool,
    /// Whether the lanes cannot be expanded together.
    pub divided: bool,
    /// Whether there was a division by an overflowed number. A coefficient that is NaN then stays
    /// NaN over a shorter step.
    pub overflowed: bool,
}

impl<const W: usize> Default for Expansion<W> {
    fn default() -> Self {
        Expansion {
            watched: [None; W],
            choices: 0,
            choices_bend: false,
            value_read: false,
            divided: false,
            overflowed: false,
        }
    }
}

impl<const W: usize> Expansion<W> {
    /// [`Series::choices`], among all rows.
    #[inline(always)]
    pub(crate) fn choices_among<'r, const L: usize>(&self, rows: &'r [Row<L>]) -> &'r [Row<L>] {
        &rows[rows.len() - self.choices..]
    }
}

impl<const L: usize> Series<L> {
    #[cold]
    #[inline(never)]
    fn make_room(&mut self, rows: usize) {
        self.rows.resize(rows, Row::new());
    }

    /// Calls a function that expands into rows or returns the number of rows it needs.
    #[inline(always)]
    pub(crate) fn expand_by<R>(
        &mut self,
        mut expand: impl FnMut(Rows<'_, L>) -> Result<R, usize>,
    ) -> R {
        loop {
            let all = self.rows.as_slice();
            let expanded = match all.first_chunk() {
                Some(first) => expand(Rows { first, all }),
                None => Err(AT_ONCE),
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
) -> [Option<Watched>; W] {
    let mut rows = [None; W];
    for (row, function) in rows.iter_mut().zip(functions) {
        if let Ok(Coefficient {
            row: place,
            is_linear,
            ..
        }) = function.in_row()
        {
            *row = Some(Watched {
                row: place,
                is_linear,
            });
        }
    }
    rows
}

/// Description of an expansion from its last pass, or the number of rows it takes.
#[inline(always)]
pub(super) fn outcome<const L: usize, const W: usize>(
    pass: &Pass<'_, L>,
    watched: [Option<Watched>; W],
    room: usize,
) -> Result<Expansion<W>, usize> {
    let (taken, choices) = (pass.taken.get(), pass.choices.get());
    if taken + choices > room {
        return Err(taken + choices);
    }
    Ok(Expansion {
        watched,
        choices,
        choices_bend: pass.choices_bend.get(),
        value_read: pass.value_read.get(),
        divided: pass.divided.get(),
        overflowed: pass.overflowed.get(),
    })
}

/// Computes the series to `order` of the solution through `x` at `t`, and of functions of it, in
/// units of time `h`. Returns the required number of rows if there are too few.
#[inline(always)]
pub(crate) fn in_rows<F: Functions<N, W>, const L: usize, const N: usize, const W: usize>(
    into: Rows<'_, L>,
    (t, h): (Lanes<L>, Lanes<L>),
    x: &[Lanes<L>; N],
    order: usize,
    functions: &F,
) -> Result<Expansion<W>, usize> {
    let mut newest = *x;
    let mut k = 0;
    let mut overflowed = false;
    loop {
        let pass = Pass::new(into, k);
        // Plain loops, because the standard library's array functions are not always inlined.
        let mut state = [Jet::Zero; N];
        for (number, newest) in state.iter_mut().zip(newest) {
            *number = pass.state(newest);
        }
        let (field, watched) = functions.at(pass.time(t, h), &state);
        let expansion = outcome(&pass, watched_rows(watched), into.all.len())?;
        // Only the first pass computes values.
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
            let slope = slope.newest(pass.order);
            *newest = lanes(|l| slope[l] * (h[l] * per_order));
        }
    }
}

impl<const L: usize> Series<L> {
    /// All rows.
    #[inline(always)]
    pub(crate) fn rows(&self) -> &[Row<L>] {
        &self.rows
    }

    /// The rows of the differences between the chosen and the rejected operand of comparisons.
    #[inline(always)]
    pub(crate) fn choices<const W: usize>(&self, expansion: &Expansion<W>) -> &[Row<L>] {
        expansion.choices_among(&self.rows)
    }
}
