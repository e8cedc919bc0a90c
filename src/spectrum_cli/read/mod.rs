//! A table of numbers from a text file or an array of numpy.

mod dialect;
mod layout;
mod lines;
mod npy;
mod period;
mod time;

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use super::error::SpectrumError;
use crate::terminal::patiently;
use stickslip::analysis::data_spectrum::MAX_COLUMNS;
use stickslip::error::readable;

use dialect::Dialect;
use layout::{Layout, Row};
use lines::{Line, Lines};
use time::Clock;

/// Lines from which the separator is sensed,
const SAMPLE: usize = 64;
/// as long as they have fewer bytes.
const SAMPLE_BYTES: usize = 1 << 24;
/// Fewer values than this go on evenly by chance.
const TELLING: usize = 10;
/// Bytes that are read at a time.
const BUFFER: usize = 1 << 16;
/// Most numbers that are read: 1 GiB of them.
const MOST: usize = 1 << 27;

/// The columns chosen from a file.
#[derive(Clone, Debug, PartialEq)]
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

/// Reads the columns `wanted` (numbers counted from 1, or names; none for all but a time column) of `path`, `-` for standard
/// input.
///
/// Columns are separated by commas, semicolons, tabs or spaces, whichever the first lines use; a comma between digits is a decimal comma where
/// something else separates. Lines that start with `#` or `%` are skipped; the first line, or a comment right above the numbers, may hold names. An array of
/// numpy (`.npy`) has no names. A column named `t` or `time` is no coordinate: without `dt` it says what the time between two rows is, and
/// else is held against it. Without names a first column that goes on evenly is the time, too, and an
/// error if it has gaps. A column that is constant is left out.
///
/// # Errors
/// Everything that is not a complete table of finite numbers, with line and column; a time between rows that is neither given nor found.
pub fn read(path: &Path, wanted: &[String], dt: Option<f64>) -> Result<Table, SpectrumError> {
    let stdin = path == Path::new("-");
    let input = if stdin {
        "standard input".to_owned()
    } else {
        path.display().to_string()
    };
    if stdin {
        return parse(input, std::io::stdin().lock(), wanted, dt);
    }
    let file = File::open(path).map_err(|source| SpectrumError::Read {
        input: input.clone(),
        source,
    })?;
    let total = file.metadata().map_or(0, |metadata| metadata.len());
    patiently(" MiB read, {eta} left", |report| {
        let counted = Counted {
            file,
            done: 0,
            total,
            report,
        };
        parse(input, BufReader::with_capacity(BUFFER, counted), wanted, dt)
    })
}

/// A file that tells how much of it was read.
struct Counted<'a> {
    file: File,
    done: u64,
    total: u64,
    /// Takes both in MiB.
    report: &'a dyn Fn(usize, usize),
}

impl Read for Counted<'_> {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        let count = self.file.read(into)?;
        self.done += count as u64;
        // A pipe does not say how long it is.
        if self.total > 0 {
            (self.report)((self.done >> 20) as usize, (self.total >> 20) as usize);
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
) -> Result<Table, SpectrumError> {
    if npy::is_array(&mut source) {
        return npy::read(input, source, wanted, dt);
    }
    let mut lines = Lines::new(&input, source)?;
    let (mut sample, mut comment) = (Vec::new(), None);
    let mut bytes = 0;
    while sample.len() < SAMPLE && bytes < SAMPLE_BYTES {
        match lines.next()? {
            Some(Line::Content(number, text)) => {
                bytes += text.len();
                sample.push((number, text.to_owned()));
            }
            // The last one above the numbers.
            Some(Line::Comment(text)) if sample.is_empty() => comment = Some(text),
            Some(Line::Comment(_)) => {}
            None => break,
        }
    }
    let dialect = Dialect::sense(sample.iter().map(|(_, text)| text.as_str()));
    let Some((line, first)) = sample.first() else {
        return Err(SpectrumError::Empty { input });
    };
    let decimal = dialect.doubt().map_err(|cause| SpectrumError::Text {
        input: input.clone(),
        line: *line,
        cause: cause.to_owned(),
    })?;
    let cells = dialect.cells(first);
    // A header is a first line in which nothing is a number.
    let is_header = cells.iter().all(|cell| dialect.number(cell).is_none());
    let header = if is_header {
        Some(cells.clone())
    } else {
        comment
            .as_deref()
            .and_then(|text| dialect.header(text, cells.len()))
    };
    let layout = Layout::new(&input, cells.len(), header, wanted)?;
    let mut table = Rows::new(&layout);
    for (number, text) in sample.iter().skip(usize::from(is_header)) {
        table.push(*number, &dialect.cells(text), &dialect)?;
    }
    while let Some(line) = lines.next()? {
        if let Line::Content(number, text) = line {
            table.push(number, &dialect.cells(text), &dialect)?;
        }
    }
    let mut table = table.finish(dt)?;
    table.notes.extend(decimal.map(str::to_owned));
    table.notes.extend(lines.gap().map(|line| {
        format!(
            "line {line} is blank, and the numbers behind it are read as the same series: cut the file there if they are another one"
        )
    }));
    Ok(table)
}

/// The rows read so far.
struct Rows<'a> {
    layout: &'a Layout<'a>,
    values: Vec<f64>,
    clock: Clock,
}

impl<'a> Rows<'a> {
    fn new(layout: &'a Layout<'a>) -> Self {
        Rows {
            layout,
            values: Vec::new(),
            clock: Clock::default(),
        }
    }

    fn push(
        &mut self,
        line: u64,
        cells: &[std::borrow::Cow<'_, str>],
        dialect: &Dialect,
    ) -> Result<(), SpectrumError> {
        let layout = self.layout;
        let row = Row {
            line,
            cells,
            dialect,
        };
        layout.width(&row)?;
        if self.values.len() + layout.columns.len() > MOST {
            return Err(layout.too_long(line, MOST));
        }
        for &column in &layout.columns {
            self.values.push(layout.number(&row, column)?);
        }
        if let Some(column) = layout.time {
            self.clock.push(line, layout.number(&row, column)?);
        }
        Ok(())
    }

    /// The table, with its time sorted out and without constant columns.
    fn finish(self, dt: Option<f64>) -> Result<Table, SpectrumError> {
        let Rows {
            layout,
            values,
            clock,
        } = self;
        if values.is_empty() && clock.is_empty() {
            let input = layout.input.to_owned();
            return Err(SpectrumError::Empty { input });
        }
        if layout.columns.is_empty() {
            return Err(SpectrumError::OnlyTime {
                input: layout.input.to_owned(),
                column: layout.name(layout.time.unwrap_or(0)),
            });
        }
        let columns = layout.columns.len();
        if values.len() == columns && columns > MAX_COLUMNS {
            let input = layout.input.to_owned();
            return Err(SpectrumError::OneRow { input, columns });
        }
        let mut table = Table {
            input: layout.input.to_owned(),
            names: layout.columns.iter().map(|&c| layout.name(c)).collect(),
            values,
            dt: f64::NAN,
            time: None,
            notes: Vec::new(),
        };
        table.dt = match (layout.time, dt) {
            (Some(_), Some(dt)) => {
                match clock.holds(dt).map_err(|gap| layout.gap(gap)) {
                    Err(error) if layout.are_all => return Err(error),
                    // Both were chosen.
                    Err(error) => table.notes.push(format!("--dt is used, although {error}")),
                    Ok(()) => {}
                }
                dt
            }
            (Some(column), None) => {
                table.time = Some(layout.name(column));
                clock.dt().map_err(|gap| layout.gap(gap))?
            }
            (None, given) => table.time_in_first_column(layout, given)?,
        };
        table.leave_out_constants();
        Ok(table)
    }
}

impl Table {
    /// Columns whose values rise or fall evenly from row to row, as a time or an index does and no recurrent state, with their step.
    pub fn even_columns(&self) -> impl Iterator<Item = (usize, f64)> {
        (0..self.names.len())
            .filter_map(|column| Some((column, time::even_step(self.column(column))?)))
    }

    fn column(&self, column: usize) -> impl DoubleEndedIterator<Item = f64> + Clone + '_ {
        self.values
            .iter()
            .copied()
            .skip(column)
            .step_by(self.names.len())
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

    /// Without names and a choice, a first column that goes on evenly is the time.
    fn time_in_first_column(
        &mut self,
        layout: &Layout,
        given: Option<f64>,
    ) -> Result<f64, SpectrumError> {
        let may_be = !layout.has_names() && layout.are_all && self.names.len() > 1;
        let step = may_be.then(|| time::even_step(self.column(0))).flatten();
        let found = step.filter(|&step| step > 0.0);
        if may_be && self.column(0).count() >= TELLING {
            self.unlike_a_time(found, given)?;
        }
        let found = found.filter(|&step| given.is_none_or(|dt| time::agree(step, dt)));
        match (found, given) {
            (Some(step), given) => {
                let dt = given.unwrap_or(step);
                let all: Vec<&str> = self.names.iter().map(String::as_str).collect();
                self.notes.push(format!(
                    "column {} goes on evenly by {} and is taken as the time; --columns {} uses it as a coordinate",
                    self.names[0],
                    readable(step),
                    all.join(",")
                ));
                self.leave_out(0);
                Ok(dt)
            }
            (None, Some(dt)) => Ok(dt),
            (None, None) => Err(SpectrumError::NoTime {
                input: self.input.clone(),
            }),
        }
    }

    /// What speaks against a first column that looks like a time: another step than the one given, or gaps.
    fn unlike_a_time(&self, even: Option<f64>, given: Option<f64>) -> Result<(), SpectrumError> {
        let all: Vec<&str> = self.names.iter().map(String::as_str).collect();
        let error = |step: f64, but: String| {
            Err(SpectrumError::LikeATime {
                input: self.input.clone(),
                column: self.names[0].clone(),
                step,
                but,
                all: all.join(","),
            })
        };
        if let (Some(step), Some(dt)) = (even, given) {
            return if time::agree(step, dt) {
                Ok(())
            } else {
                let [dt, right] = [dt, step].map(readable);
                error(step, format!("while --dt is {dt}: give --dt {right}"))
            };
        }
        match time::first_gap(self.column(0)) {
            Some((step, row)) => {
                let mut values = self.column(0).skip(row - 1).map(readable);
                let [from, to] = [values.next(), values.next()].map(Option::unwrap_or_default);
                let but = format!(
                    "but from {from} to {to} at row {}: cut the file there, as a series must have no gaps",
                    row + 1
                );
                error(step, but)
            }
            None => Ok(()),
        }
    }

    /// A column that does not vary has no neighbours; if none does, it is left to the estimator to say so.
    fn leave_out_constants(&mut self) {
        let is_constant = |column: &usize| {
            let mut values = self.column(*column);
            let first = values.next();
            values.all(|value| Some(value) == first)
        };
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
