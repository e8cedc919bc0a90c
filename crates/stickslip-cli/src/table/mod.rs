//! Tables of numbers from text files and arrays of numpy.

mod dialect;
mod lines;
mod npy;
mod rows;
mod time;

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use stickslip::error::readable;

use dialect::Dialect;
use lines::Lines;
use rows::Rows;

/// Lines from which the separator is sensed.
const SAMPLE: usize = 64;
/// Most numbers that are read: 1 GiB of them.
const MOST: usize = 1 << 27;
/// Values are the same again where they differ by no more than this part of their column's range:
/// the rounding of a function of the time.
const REPEAT: f64 = 1e-9;

/// Values drawn from an attractor nearly all differ: where fewer different ones than this part are
/// left, the typical value is met twice.
const DIFFERENT: f64 = 0.5;

/// The columns chosen from a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Where it comes from, for messages.
    pub input: String,
    /// Names, or numbers counted from 1.
    pub names: Vec<String>,
    /// Values, row after row.
    pub values: Vec<f64>,
    /// Time between two rows.
    pub dt: f64,
    /// The column that says so, if `dt` was not given.
    pub time: Option<String>,
    /// What was done that was not asked for.
    pub notes: Vec<String>,
}

/// A column whose values are rounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// The column, counted from 0.
    pub column: usize,
    /// How many different values it has.
    pub values: usize,
    /// What all their distances are multiples of; none if they are multiples of nothing.
    pub step: Option<f64>,
}

/// Why there is no table.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// The input cannot be read.
    #[error(
        "cannot read {input}: {source}; give the path of a text file of numbers or a .npy array, \
            or - for standard input"
    )]
    Read {
        /// Path, or `standard input`.
        input: String,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The file has not what was asked of it: the columns, or a time between two rows.
    #[error("{0}")]
    Request(String),
    /// The file is no table of finite numbers: where, and what to do.
    #[error("{0}")]
    File(String),
}

impl TableError {
    fn read(input: &str, source: std::io::Error) -> Self {
        let input = input.to_owned();
        TableError::Read { input, source }
    }

    fn empty(input: &str) -> Self {
        TableError::File(format!(
            "{input} holds no data: at least one row of numbers is needed"
        ))
    }
}

/// Reads the columns `wanted` (numbers counted from 1, or names; none for all but a time column) of
/// `path`, `-` for standard input. `report` gets the bytes read and their total.
///
/// Columns are separated by commas, semicolons, tabs or spaces, whichever the first lines use; a
/// comma between digits is a decimal comma where something else separates. Lines that start with
/// `#` or `%` are skipped; the first line, or a comment right above the numbers, may hold names. An
/// array of numpy (`.npy`) has no names. A column named `t` or `time` is no coordinate: without
/// `dt` it says what the time between two rows is, and else is held against it. Without names a
/// first column that goes on evenly is the time, too, and one that rises unevenly is an error. A
/// column that is constant is left out.
///
/// # Errors
/// Everything that is not a complete table of finite numbers, with line and column; a time between
/// rows that is neither given nor found.
pub fn read(
    path: &Path,
    wanted: &[String],
    dt: Option<f64>,
    report: &dyn Fn(usize, usize),
) -> Result<Table, TableError> {
    if path == Path::new("-") {
        let input = "standard input".to_owned();
        return parse(input, std::io::stdin().lock(), wanted, dt);
    }
    let input = path.display().to_string();
    let file = File::open(path).map_err(|source| TableError::read(&input, source))?;
    let total = file.metadata().map_or(0, |metadata| metadata.len());
    let counted = Counted {
        file,
        done: 0,
        total,
        report,
    };
    parse(input, BufReader::new(counted), wanted, dt)
}

/// A file that tells how much of it was read.
struct Counted<'a> {
    file: File,
    done: u64,
    total: u64,
    report: &'a dyn Fn(usize, usize),
}

impl Read for Counted<'_> {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        let count = self.file.read(into)?;
        self.done += count as u64;
        // A pipe does not say how long it is.
        if self.total > 0 {
            (self.report)(self.done as usize, self.total as usize);
        }
        Ok(count)
    }
}

/// As [`read`], from the content of a file.
///
/// # Errors
/// As [`read`].
pub fn parse(
    input: String,
    mut source: impl BufRead,
    wanted: &[String],
    dt: Option<f64>,
) -> Result<Table, TableError> {
    if npy::is_array(&mut source) {
        return npy::read(input, source, wanted, dt);
    }
    let mut lines = Lines::new(&input, source)?;
    let mut sample: Vec<(u64, String)> = Vec::new();
    while sample.len() < SAMPLE
        && let Some((number, text)) = lines.next()?
    {
        sample.push((number, text.to_owned()));
    }
    let Some((line, first)) = sample.first() else {
        return Err(TableError::empty(&input));
    };
    let (dialect, note) = Dialect::sense(sample.iter().map(|(_, text)| text.as_str()))
        .map_err(|cause| TableError::File(format!("{input}, line {line}: {cause}")))?;
    let cells = dialect.cells(first);
    let count = cells.len();
    // A header is a first line in which nothing is a number.
    let is_header = cells.iter().all(|cell| dialect.number(cell).is_none());
    let header = if is_header {
        Some(cells)
    } else {
        let comment = lines.comment.as_deref();
        comment.and_then(|text| dialect.header(text, count))
    };
    let names = header.map(|names| names.iter().map(str::to_owned).collect());
    let mut rows = Rows::new(&input, count, names, wanted)?;
    for (number, text) in sample.iter().skip(usize::from(is_header)) {
        rows.push(*number, &dialect.cells(text), &dialect)?;
    }
    while let Some((number, text)) = lines.next()? {
        rows.push(number, &dialect.cells(text), &dialect)?;
    }
    let mut table = rows.finish(dt)?;
    table.notes.extend(note.map(str::to_owned));
    table.notes.extend(lines.gap.map(|line| {
        format!(
            "line {line} is blank, and the numbers behind it are read as the same series: cut the \
                file there if they are another one"
        )
    }));
    Ok(table)
}

impl Table {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.values.len() / self.names.len().max(1)
    }

    /// The values of a column, counted from 0.
    pub fn column(&self, column: usize) -> impl DoubleEndedIterator<Item = f64> + Clone + '_ {
        let values = self.values.iter().copied().skip(column);
        values.step_by(self.names.len())
    }

    /// The least and the largest value of a column.
    pub fn range(&self, column: usize) -> (f64, f64) {
        self.column(column)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
                (low.min(v), high.max(v))
            })
    }

    /// Columns whose values rise or fall evenly from row to row, as a time or an index does and no
    /// recurrent state, with their step.
    pub fn even_columns(&self) -> impl Iterator<Item = (usize, f64)> {
        (0..self.names.len())
            .filter_map(|column| Some((column, time::even_step(self.column(column))?)))
    }

    /// The smallest number of rows after which all of them come again, twice at least.
    pub fn period(&self) -> Option<usize> {
        let (columns, rows) = (self.names.len(), self.rows());
        let allowed: Vec<f64> = (0..columns)
            .map(|column| self.range(column))
            .map(|(low, high)| REPEAT * (high - low))
            .collect();
        let state = |row: usize| &self.values[row * columns..][..columns];
        let agree = |row: usize, other: usize| {
            let pairs = state(row).iter().zip(state(other));
            pairs
                .zip(&allowed)
                .all(|((a, b), allowed)| (a - b).abs() <= *allowed)
        };
        // The longest end that is a beginning, too, of all rows up to each one (Knuth, Morris and
        // Pratt, SIAM J. Comput. 6, 323, 1977).
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

    /// The first column whose values lie on a grid. What repeats itself or stands still is on none.
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
            ((values.len() as f64) < DIFFERENT * rows as f64).then(|| Grid {
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

    /// A column that does not vary has no neighbours; if none does, it is left to the estimator to
    /// say so.
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
