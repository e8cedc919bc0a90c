//! Reasons for which there is no fit.

use stickslip::Error;
use stickslip::error::readable;

use crate::file::{FileError, SettingError};
use crate::study::NoVariable;

/// Reason for which there is no fit.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FitError {
    /// A parameter cannot be set.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// A formula or a name of an extra parameter is wrong.
    #[error(transparent)]
    File(#[from] FileError),
    /// A name is no unknown, or a discrete state.
    #[error(transparent)]
    NoVariable(#[from] NoVariable),
    /// A request that cannot be answered: the fault and the remedy.
    #[error("{0}")]
    Request(String),
    /// No record has a value.
    #[error("there are no data: give at least one record with a value")]
    NoData,
    /// More unknowns than values.
    #[error(
        "{values} values cannot determine {unknowns} unknowns: measure more than {unknowns}, or \
            fit fewer unknowns"
    )]
    TooFew {
        /// Number of values that are not missing.
        values: usize,
        /// Number of unknowns.
        unknowns: usize,
    },
    /// Times that do not rise, or are not numbers.
    #[error(
        "{record}: the time {}, in row {row}, does not come after the one before it; sort the rows \
            by time, and leave out those that stand twice", readable(*time)
    )]
    Times {
        /// Name of the record.
        record: String,
        /// Row, counted from 1.
        row: usize,
        /// Time there.
        time: f64,
    },
    /// A record begins before the start of the run.
    #[error(
        "{record}: the first time {} is before the start of the run at {}; let the run start no \
            later than the data", readable(*first), readable(*start)
    )]
    BeforeStart {
        /// Name of the record.
        record: String,
        /// First time of the data.
        first: f64,
        /// Start of the run.
        start: f64,
    },
    /// A run outside the tables of measured inputs.
    #[error(
        "{record}: the run from {} to {} leaves the table of an input, which covers {} to {}; \
            leave out rows, or extend the table", readable(span.0), readable(span.1),
            readable(table.0), readable(table.1)
    )]
    OutsideTable {
        /// Name of the record.
        record: String,
        /// Start of the run and last time of the data.
        span: (f64, f64),
        /// Times of the table.
        table: (f64, f64),
    },
    /// An unknown has no effect on what is observed.
    #[error(
        "`{name}` has no effect on what is observed, for the values at which the fit starts: leave \
            it out, observe something else, or start elsewhere"
    )]
    NoEffect {
        /// Name.
        name: String,
    },
    /// The run at the start of the fit fails.
    #[error("{record}: the run with the values at which the fit starts fails: start elsewhere")]
    Start {
        /// Name of the record.
        record: String,
        /// Error of the run.
        #[source]
        cause: Error,
    },
    /// The run at the start of the fit ends before the last time.
    #[error(
        "{record}: the run with the values at which the fit starts ends before the time {} of the \
            data: start elsewhere, or leave out the rows from there on", readable(*t)
    )]
    Ends {
        /// Name of the record.
        record: String,
        /// First time that it does not reach.
        t: f64,
    },
    /// The orbit at the start of the fit has no derivatives.
    #[error(
        "{record}: the run with the values at which the fit starts has no derivatives from one of \
            its events on: start elsewhere"
    )]
    NoDerivatives {
        /// Name of the record.
        record: String,
        /// Loss of the derivatives, with its time and reason.
        #[source]
        cause: Error,
    },
    /// A part of a record has no run or no derivatives, in multiple shooting.
    #[error(
        "{part} has no run with derivatives in multiple shooting: start elsewhere, take another \
            number of segments, or leave them out"
    )]
    Part {
        /// Name of the record, and start and end of the part.
        part: String,
        /// Error of the part's run; none where the run ends before the part does.
        #[source]
        cause: Option<Error>,
    },
    /// No start within the bounds leads to a run.
    #[error("none of {count} starts within the bounds gives a run: narrow the bounds")]
    NoStart {
        /// Number of starts.
        count: usize,
    },
    /// The fit was interrupted.
    #[error("interrupted")]
    Interrupted,
}
