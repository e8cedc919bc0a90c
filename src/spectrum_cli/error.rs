//! What can go wrong between a file and its spectrum.

use std::path::PathBuf;

use crate::figures::FigureError;
use crate::terminal::ProgramError;
use stickslip::analysis::data_spectrum::DataError;
use stickslip::error::readable;

/// Failure of the program `spectrum`.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SpectrumError {
    /// The input cannot be read.
    #[error(
        "cannot read {input}: {source}; give the path of a text file of numbers or a .npy array, or - for standard input"
    )]
    Read {
        /// Path, or `standard input`.
        input: String,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The input is a file of another kind.
    #[error("{input} {what}; {remedy}")]
    Foreign {
        /// Path, or `standard input`.
        input: String,
        /// What it is.
        what: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// A line that cannot be read as text, or not be kept.
    #[error("{input}, line {line}: {cause}")]
    Text {
        /// Path, or `standard input`.
        input: String,
        /// Line, counted from 1.
        line: u64,
        /// What is wrong, and what to do.
        cause: String,
    },
    /// An array of numpy that is no series.
    #[error("{input} is a .npy array, but {cause}")]
    Array {
        /// Path, or `standard input`.
        input: String,
        /// What is wrong, and what to do.
        cause: String,
    },
    /// Nothing says how far apart the rows are in time.
    #[error(
        "--dt is missing, and {input} has no column named t or time beside those used: give the time between two lines, 1 for a map"
    )]
    NoTime {
        /// Path, or `standard input`.
        input: String,
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
    /// All numbers in one line.
    #[error(
        "{input} has one row of {columns} numbers, and a row is a state: write each state in a line of its own, of a single column each number"
    )]
    OneRow {
        /// Path, or `standard input`.
        input: String,
        /// Numbers in the row.
        columns: usize,
    },
    /// A column that does not exist.
    #[error("--columns: '{wanted}' is no column of {input}; it has {available}")]
    Column {
        /// Path, or `standard input`.
        input: String,
        /// What was asked for.
        wanted: String,
        /// What there is.
        available: String,
    },
    /// The only column is the time.
    #[error(
        "the only column of {input}, {column}, was skipped as the time: give a file with the columns of the state too, or \
         --columns {column} if this is the state"
    )]
    OnlyTime {
        /// Path, or `standard input`.
        input: String,
        /// Name of the column.
        column: String,
    },
    /// A first column without a name that may be a time, but not that of these rows.
    #[error(
        "{input}: column {column} goes on by {} from row to row, as a time does, {but}, or --columns {all} if it is part of the state",
        readable(*step)
    )]
    LikeATime {
        /// Path, or `standard input`.
        input: String,
        /// Name of the column.
        column: String,
        /// Its step.
        step: f64,
        /// What speaks against it, and what to do.
        but: String,
        /// All columns, as an option takes them.
        all: String,
    },
    /// A name that several columns have.
    #[error(
        "--columns: '{wanted}' is ambiguous, columns {numbers} of {input} are called so; give the number instead"
    )]
    Ambiguous {
        /// Path, or `standard input`.
        input: String,
        /// What was asked for.
        wanted: String,
        /// Numbers of the columns, counted from 1.
        numbers: String,
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
         as --neighbours {count}-{twice}, or no --eps", twice = count.saturating_mul(2)
    )]
    EpsWithCount {
        /// The count given.
        count: usize,
    },
    /// The estimator refused.
    #[error(transparent)]
    Data(DataError),
    /// The estimator refused what an option says.
    #[error("{flag} = {} is not allowed: it must be {bound}", readable(*value))]
    Option {
        /// The option.
        flag: &'static str,
        /// Value given.
        value: f64,
        /// What is allowed, in words and numbers.
        bound: String,
    },
    /// The folder for the picture, or the picture, cannot be written.
    #[error("cannot write {}: {source}; choose another folder with --out", path.display())]
    Output {
        /// The folder or the file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The picture could not be drawn.
    #[error(transparent)]
    Figure(FigureError),
    /// The numbers could not be put into JSON.
    #[error("cannot write JSON: {0}")]
    Json(#[from] serde_json::Error),
}

impl ProgramError for SpectrumError {
    fn is_usage(&self) -> bool {
        matches!(
            self,
            Self::Column { .. }
                | Self::Ambiguous { .. }
                | Self::Twice { .. }
                | Self::EpsWithCount { .. }
                | Self::NoTime { .. }
                | Self::Option { .. }
                // The defaults never reach over the end of a series.
                | Self::Data(DataError::Span { .. })
        )
    }
}

impl From<DataError> for SpectrumError {
    /// Puts the option in the place of the setting's name.
    fn from(error: DataError) -> Self {
        match error {
            DataError::Setting { name, value, bound } => Self::Option {
                flag: flag(name),
                value,
                bound,
            },
            other => Self::Data(other),
        }
    }
}

impl From<FigureError> for SpectrumError {
    /// The figures' programs call their folder by another option.
    fn from(error: FigureError) -> Self {
        match error {
            FigureError::CreateDir { path, source } | FigureError::Write { path, source } => {
                Self::Output { path, source }
            }
            other => Self::Figure(other),
        }
    }
}

/// The option behind a setting. `min` and `max` are the two ends of one.
fn flag(name: &'static str) -> &'static str {
    match name {
        "dt" => "--dt",
        "eps" => "--eps",
        "min" => "--neighbours, minimum",
        "max" => "--neighbours, maximum",
        "neighbours" => "--neighbours",
        "step" => "--step",
        "stride" => "--stride",
        "rank_tolerance" => "--rank-tolerance",
        "ridge" => "--ridge",
        "fixed_rank" => "--rank",
        "references" => "--references",
        "surrogates" => "--surrogates",
        "delay" => "--delay",
        "dimension" => "--dimension",
        other => other,
    }
}
