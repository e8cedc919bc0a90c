//! What can go wrong between a file and its spectrum.

use crate::analysis::data_spectrum::DataError;
use crate::figures::FigureError;

/// Failure of the program `spectrum`.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SpectrumError {
    /// The input cannot be read.
    #[error("cannot read {input}: {source}; give the path of a CSV file, or - for standard input")]
    Read {
        /// Path, or `standard input`.
        input: String,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The input is no CSV.
    #[error("{input}{line}: {cause}", line = line.map_or(String::new(), |line| format!(", line {line}")))]
    Csv {
        /// Path, or `standard input`.
        input: String,
        /// Line, counted from 1, if known.
        line: Option<u64>,
        /// What is wrong.
        cause: String,
    },
    /// A cell that is not a finite number.
    #[error("{input}, line {line}, column {column}: {cause}")]
    Cell {
        /// Path, or `standard input`.
        input: String,
        /// Line, counted from 1.
        line: u64,
        /// Column, counted from 1, with its name if it has one.
        column: String,
        /// What is wrong, and what to do.
        cause: String,
    },
    /// There are no rows of numbers.
    #[error("{input} holds no data: at least one row of numbers is needed")]
    Empty {
        /// Path, or `standard input`.
        input: String,
    },
    /// A column that does not exist.
    #[error("--columns: {wanted} is no column of {input}; it has {available}")]
    Column {
        /// Path, or `standard input`.
        input: String,
        /// What was asked for.
        wanted: String,
        /// What there is.
        available: String,
    },
    /// A column asked for twice.
    #[error("--columns: {wanted} is given twice; give every column once")]
    Twice {
        /// What was asked for.
        wanted: String,
    },
    /// Options that exclude one another.
    #[error(
        "--neighbours {count} takes the nearest {count} points and no ball, so that --eps has no meaning; give a range such \
         as --neighbours {count}-{twice}, or no --eps", twice = 2 * count
    )]
    EpsWithCount {
        /// The count given.
        count: usize,
    },
    /// The estimator refused.
    #[error(transparent)]
    Data(#[from] DataError),
    /// The picture could not be drawn or written.
    #[error(transparent)]
    Figure(#[from] FigureError),
    /// The numbers could not be put into JSON.
    #[error("cannot write JSON: {0}")]
    Json(#[from] serde_json::Error),
}

impl SpectrumError {
    /// Whether the command line is at fault (exit code 2) and not the data (1).
    pub fn is_usage(&self) -> bool {
        matches!(
            self,
            Self::Column { .. }
                | Self::Twice { .. }
                | Self::EpsWithCount { .. }
                | Self::Data(DataError::Setting { .. })
        )
    }
}
