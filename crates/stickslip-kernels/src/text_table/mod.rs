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

    /// There is no row.
    pub fn empty(input: &str) -> Self {
        TableError::File(format!(
            "{input} holds no data: at least one row of numbers is needed"
        ))
    }
}

/// A text of rows of numbers, read line by line.
pub struct TextTable<'i, R> {
    /// How columns are separated and numbers written.
    pub dialect: Dialect,
    /// A note on how commas are read, where that is not certain.
    pub note: Option<&'static str>,
    /// Number of columns in the first line.
    pub columns: usize,
    /// Their names, from a first line without numbers or the comment above the numbers.
    pub names: Option<Vec<String>>,
    /// The lines read ahead.
    sample: std::vec::IntoIter<(u64, String)>,
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
        let Some((line, first)) = sample.first() else {
            return Err(TableError::empty(input));
        };
        let (dialect, note) = Dialect::sense(sample.iter().map(|(_, text)| text.as_str()))
            .map_err(|cause| TableError::File(format!("{input}, line {line}: {cause}")))?;
        let cells = dialect.cells(first);
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
        Ok(TextTable {
            dialect,
            note,
            columns,
            names: header.map(|names| names.iter().map(str::to_owned).collect()),
            sample,
            lines,
        })
    }

    /// The cells of the next row, with the number of its line.
    ///
    /// # Errors
    /// [`TableError`] for a line that is no text.
    pub fn row(&mut self) -> Result<Option<(u64, StringRecord)>, TableError> {
        if let Some((number, text)) = self.sample.next() {
            return Ok(Some((number, self.dialect.cells(&text))));
        }
        let next = self.lines.next()?;
        Ok(next.map(|(number, text)| (number, self.dialect.cells(text))))
    }

    /// Number of the first blank line between rows.
    pub fn gap(&self) -> Option<u64> {
        self.lines.gap
    }
}
