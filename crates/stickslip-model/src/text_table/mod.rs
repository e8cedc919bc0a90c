//! Tables of numbers in text files, as other programs write them.

mod dialect;
mod lines;

use std::io::BufRead;

use csv::StringRecord;

pub use dialect::Dialect;
use lines::Lines;

/// Number of lines from which the separator is detected. It is chosen: a header and comments are
/// shorter.
const SAMPLED_LINES: usize = 64;

/// Reason for which there is no table.
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
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The file lacks a requested column, or a time between two rows.
    #[error("{0}")]
    Request(String),
    /// The file is not a table of finite numbers. The message has the place and a remedy.
    #[error("{0}")]
    File(String),
}

impl TableError {
    /// The input cannot be read.
    pub fn read(input: &str, source: std::io::Error) -> Self {
        let input = input.to_owned();
        TableError::Read { input, source }
    }

    /// Error for a table without rows.
    pub fn empty(input: &str) -> Self {
        TableError::File(format!(
            "{input} holds no data: at least one row of numbers is needed"
        ))
    }
}

/// A text of rows of numbers, read line by line.
pub struct TextTable<'i, R> {
    /// Separators and number format.
    pub dialect: Dialect,
    /// Notes on how the text is read, where that is not certain.
    pub notes: Vec<String>,
    /// Number of columns in the first line.
    pub columns: usize,
    /// Names of the columns, from a first line without numbers or the comment above the numbers.
    pub names: Option<Vec<String>>,
    /// The lines read ahead.
    sample: std::vec::IntoIter<(u64, String)>,
    /// Line of the first row.
    first_row: u64,
    lines: Lines<'i, R>,
}

impl<'i, R: BufRead> TextTable<'i, R> {
    /// Detects the format from the first lines; `input` is what messages call the text.
    ///
    /// # Errors
    /// [`TableError`] for a text without numbers, or whose columns cannot be distinguished.
    pub fn new(input: &'i str, source: R) -> Result<Self, TableError> {
        let mut lines = Lines::new(input, source)?;
        let mut sample: Vec<(u64, String)> = Vec::new();
        while sample.len() < SAMPLED_LINES
            && let Some((number, text)) = lines.next()?
        {
            sample.push((number, text.to_owned()));
        }
        let Some((line, _)) = sample.first() else {
            return Err(TableError::empty(input));
        };
        let (dialect, note) = Dialect::sense(sample.iter().map(|(_, text)| text.as_str()))
            .map_err(|cause| TableError::File(format!("{input}, line {line}: {cause}")))?;
        let mut cells = dialect.cells(&sample[0].1);
        let mut notes: Vec<String> = note.map(str::to_owned).into_iter().collect();
        if let Some(header) = Header::of(&sample, &dialect) {
            let Header { names, rows, .. } = header;
            notes.push(format!(
                "line {} is read as names of columns, and of the lines down to {} nothing else",
                sample[names].0,
                sample[rows - 1].0
            ));
            // Names of columns without numbers may follow, as of comments.
            let named = dialect.cells(&sample[names].1);
            cells = named.iter().take(header.columns).collect();
            sample.drain(1..rows);
        }
        let columns = cells.len();
        // A header is a first line without numbers.
        let is_header = cells.iter().all(|cell| dialect.number(cell).is_none());
        let header = if is_header {
            Some(cells)
        } else {
            let comment = lines.comment.as_deref();
            comment.and_then(|text| dialect.header(text, columns))
        };
        let mut sample = sample.into_iter();
        if is_header {
            sample.next();
        }
        let first_row = sample.as_slice().first().map_or(0, |row| row.0);
        Ok(TextTable {
            dialect,
            notes,
            columns,
            names: header.map(|names| names.iter().map(str::to_owned).collect()),
            sample,
            first_row,
            lines,
        })
    }

    /// The cells of the next row, with the number of its line.
    ///
    /// # Errors
    /// [`TableError`] for a line that is no text.
    pub fn row(&mut self) -> Result<Option<(u64, StringRecord)>, TableError> {
        if let Some((number, text)) = self.sample.next() {
            let cells = self.dialect.cells(&text);
            return Ok(Some((number, self.within_columns(cells))));
        }
        let next = self.lines.next()?;
        let next = next.map(|(number, text)| (number, self.dialect.cells(text)));
        Ok(next.map(|(number, cells)| (number, self.within_columns(cells))))
    }

    /// The cells of a row without empty ones behind the columns, as of comments.
    fn within_columns(&self, mut cells: StringRecord) -> StringRecord {
        if cells.iter().skip(self.columns).all(str::is_empty) {
            cells.truncate(self.columns);
        }
        cells
    }

    /// Number of the first blank line between rows. Lines of a header may be apart.
    pub fn gap(&self) -> Option<u64> {
        self.lines.gap.filter(|line| *line > self.first_row)
    }
}

/// A header of several lines: the line of names and the first row of numbers, counted from 0, and
/// the number of columns there.
struct Header {
    names: usize,
    rows: usize,
    columns: usize,
}

impl Header {
    /// The header, where lines stand above the names or a line of units below them. Both have no
    /// number and a cell for each column; above units, all columns have names. The last cells of a
    /// row may be empty, as those of comments are.
    fn of(sample: &[(u64, String)], dialect: &Dialect) -> Option<Self> {
        let cells = |at: usize| Some(dialect.cells(&sample.get(at)?.1));
        let is_number = |cell: &&str| dialect.number(cell).is_some();
        let numbers = |row: StringRecord| {
            let filled = (0..row.len()).rposition(|k| !row[k].is_empty())? + 1;
            row.iter()
                .take(filled)
                .all(|cell| is_number(&cell))
                .then_some(filled)
        };
        let lines = sample.iter().map(|(_, line)| numbers(dialect.cells(line)));
        let (rows, columns) = lines.enumerate().find_map(|(k, n)| Some((k, n?)))?;
        let above = |distance: usize| {
            let line = rows.checked_sub(distance).and_then(cells)?;
            let is_text = line.len() >= columns && !line.iter().any(|c| is_number(&c));
            is_text.then_some(line)
        };
        above(1)?;
        let has_names = |line: StringRecord| line.iter().take(columns).all(|name| !name.is_empty());
        let below = if above(2).is_some_and(has_names) {
            2
        } else {
            1
        };
        let names = rows - below;
        (rows > 1).then_some(Header {
            names,
            rows,
            columns,
        })
    }
}
