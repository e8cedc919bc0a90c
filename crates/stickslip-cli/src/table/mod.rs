//! Tables of numbers from text files and NumPy arrays.

mod npy;
mod record;
mod rows;
mod time;

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use stickslip::error::readable;
use stickslip_model::text_table::TextTable;

pub use record::{MeasuredRecord, parse_record, read_record};
use rows::Rows;
pub use stickslip_model::text_table::TableError;

/// Maximum number of values that are read: 1 GiB.
const MOST_VALUES: usize = 1 << 27;
/// Values count as repeated if they differ by at most this fraction of the range of their column.
/// This allows for the rounding of a function of time.
const REPEAT_TOLERANCE: f64 = 1e-9;

/// Least fraction of distinct values in a column without rounding. Values from an attractor nearly
/// all differ; with fewer distinct ones a typical value occurs twice.
const DISTINCT_FRACTION: f64 = 0.5;

/// The columns chosen from a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NumberTable {
    /// Name of the input, for messages.
    pub input: String,
    /// Names, or numbers counted from 1.
    pub names: Vec<String>,
    /// Values, row after row.
    pub values: Vec<f64>,
    /// Time between two rows.
    pub dt: f64,
    /// The column from which `dt` was determined, if it was not given.
    pub time: Option<String>,
    /// Notes on automatic choices.
    pub notes: Vec<String>,
}

/// A column whose values are rounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// The column, counted from 0.
    pub column: usize,
    /// Number of distinct values.
    pub values: usize,
    /// Common divisor of all differences of the values, if there is one.
    pub step: Option<f64>,
}

/// Reads the columns `wanted` (numbers from 1, or names; empty for all but a time column) of
/// `path`, or of standard input for `-`. `report` is called with the number of bytes read and their
/// total.
///
/// Columns are separated by commas, semicolons, tabs or spaces, whichever the first lines use. If
/// something else separates columns, a comma between digits is a decimal comma. Lines that start
/// with `#` or `%` are skipped. The first line, or a comment directly above the numbers, may
/// contain names. A NumPy array (`.npy`) has no names. A column named `t` or `time`, or else one
/// whose name ends in the word `time`, is not a coordinate. It determines the time between two
/// rows, or is compared with `dt` if that is given. Without names, an evenly spaced first column is
/// also the time, and one that rises unevenly is an error. Constant columns are left out.
///
/// # Errors
/// Input that is not a complete table of finite numbers, with line and column; a time
/// between rows that is neither given nor determined.
pub fn read(
    path: &Path,
    wanted: &[String],
    dt: Option<f64>,
    report: &dyn Fn(usize, usize),
) -> Result<NumberTable, TableError> {
    if path == Path::new("-") {
        let input = "standard input".to_owned();
        return parse(input, std::io::stdin().lock(), wanted, dt);
    }
    let input = path.display().to_string();
    let file = File::open(path).map_err(|source| TableError::read(&input, source))?;
    let total = file.metadata().map_or(0, |metadata| metadata.len());
    let reader = ProgressReader {
        file,
        done: 0,
        total,
        report,
    };
    parse(input, BufReader::new(reader), wanted, dt)
}

/// A file that reports how much of it was read.
struct ProgressReader<'a> {
    file: File,
    done: u64,
    total: u64,
    report: &'a dyn Fn(usize, usize),
}

impl Read for ProgressReader<'_> {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        let count = self.file.read(into)?;
        self.done += count as u64;
        // The length of a pipe is unknown.
        if self.total > 0 {
            (self.report)(self.done as usize, self.total as usize);
        }
        Ok(count)
    }
}

/// [`read`] from the content of a file.
///
/// # Errors
/// As [`read`].
pub fn parse(
    input: String,
    mut source: impl BufRead,
    wanted: &[String],
    dt: Option<f64>,
) -> Result<NumberTable, TableError> {
    if npy::is_array(&mut source) {
        return npy::read(input, source, wanted, dt);
    }
    let mut text = TextTable::new(&input, source)?;
    let mut rows = Rows::new(&input, text.columns, text.names.take(), wanted)?;
    while let Some((line, cells)) = text.row()? {
        rows.push(line, &cells, &text.dialect)?;
    }
    let mut table = rows.finish(dt)?;
    table.notes.append(&mut text.notes);
    table.notes.extend(text.gap().map(|line| {
        format!(
            "line {line} is blank, and the numbers behind it are read as the same series: cut the \
                file there if they are another one"
        )
    }));
    Ok(table)
}

impl NumberTable {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.values.len() / self.names.len().max(1)
    }

    /// The values of a column, counted from 0.
    pub fn column(&self, column: usize) -> impl DoubleEndedIterator<Item = f64> + Clone + '_ {
        let values = self.values.iter().copied().skip(column);
        values.step_by(self.names.len())
    }

    /// Minimum and maximum of a column.
    pub fn range(&self, column: usize) -> (f64, f64) {
        self.column(column)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
                (low.min(v), high.max(v))
            })
    }

    /// Columns whose values rise or fall evenly from row to row, with their step. A time or an
    /// index does so, a recurrent state does not.
    pub fn even_columns(&self) -> impl Iterator<Item = (usize, f64)> {
        (0..self.names.len())
            .filter_map(|column| Some((column, time::even_step(self.column(column))?)))
    }

    /// The smallest period of the rows, if they contain it at least twice.
    pub fn period(&self) -> Option<usize> {
        let (columns, rows) = (self.names.len(), self.rows());
        let allowed: Vec<f64> = (0..columns)
            .map(|column| self.range(column))
            .map(|(low, high)| REPEAT_TOLERANCE * (high - low))
            .collect();
        let state = |row: usize| &self.values[row * columns..][..columns];
        let agree = |row: usize, other: usize| {
            let pairs = state(row).iter().zip(state(other));
            pairs
                .zip(&allowed)
                .all(|((a, b), allowed)| (a - b).abs() <= *allowed)
        };
        // For each row, the length of the longest suffix of the rows up to it that is also a prefix
        // (Knuth, Morris and Pratt, SIAM J. Comput. 6, 323, 1977).
        let mut borders = vec![0; rows];
        for row in 1..rows {
            let mut border = borders[row - 1];
            while border > 0 && !agree(border, row) {
                border = borders[border - 1];
            }
            borders[row] = border + usize::from(agree(border, row));
        }
        let period = rows - borders.last()?;
        (2 * period <= rows).then_some(period)
    }

    /// The first column whose values lie on a grid. Periodic or constant values do not count.
    pub fn grid(&self) -> Option<Grid> {
        if self.period().is_some() {
            return None;
        }
        (0..self.names.len()).find_map(|column| {
            let mut values: Vec<f64> = self.column(column).collect();
            values.dedup();
            let rows = values.len();
            values.sort_by(f64::total_cmp);
            values.dedup();
            ((values.len() as f64) < DISTINCT_FRACTION * rows as f64).then(|| Grid {
                column,
                values: values.len(),
                step: time::common_step(&values),
            })
        })
    }

    fn leave_out(&mut self, column: usize) {
        let columns = self.names.len();
        let mut at = 0;
        self.values.retain(|_| {
            at += 1;
            (at - 1) % columns != column
        });
        self.names.remove(column);
    }

    /// Leaves out constant columns, which do not distinguish neighbours. If all are constant, they
    /// stay and the estimator reports it.
    fn leave_out_constants(&mut self) {
        let is_constant = |column: &usize| self.range(*column).0 == self.range(*column).1;
        let constant: Vec<usize> = (0..self.names.len()).filter(is_constant).collect();
        if constant.len() == self.names.len() {
            return;
        }
        for &column in constant.iter().rev() {
            self.notes.push(format!(
                "column {} is {} in every row and is left out",
                self.names[column],
                readable(self.values[column])
            ));
            self.leave_out(column);
        }
    }
}

#[cfg(test)]
mod tests;
