//! Errors of series and settings.

/// Reason for which a spectrum cannot be estimated from a series.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DataError {
    /// A series of no columns, or of more than the estimator is built for.
    #[error("the series has {columns} columns: it must have 1 to {max}; choose among them")]
    Columns {
        /// Columns given.
        columns: usize,
        /// Most that are allowed.
        max: usize,
    },
    /// The values do not make complete rows.
    #[error(
        "{values} values do not fill rows of {columns} columns: the last row is not complete; drop \
            it"
    )]
    Incomplete {
        /// Number of values.
        values: usize,
        /// Columns of a row.
        columns: usize,
    },
    /// A value that is not a number: a gap in the series.
    #[error(
        "row {row}, column {column} (counted from 1) is {value}: every value must be finite, as a \
         series with a gap has no step across it; cut the series there or fill the gap"
    )]
    NotFinite {
        /// Row, counted from 1.
        row: usize,
        /// Column, counted from 1.
        column: usize,
        /// The value.
        value: f64,
    },
    /// The series does not vary.
    #[error(
        "all {rows} points are the same to rounding: a series must vary for its neighbourhoods to \
            have a size"
    )]
    Constant {
        /// Number of points.
        rows: usize,
    },
    /// The points are so far apart that distances between them exceed the largest number.
    #[error(
        "row {row}, column {column} (counted from 1) is {value:e}, so far from row 1 that \
         distances between points overflow: keep values below 1e307; multiply all columns by the \
         same small factor, which changes no exponent"
    )]
    Overflow {
        /// Row, counted from 1.
        row: usize,
        /// Column, counted from 1.
        column: usize,
        /// The value.
        value: f64,
    },
    /// Too few points for the requested neighbour counts and windows.
    #[error(
        "{rows} points are too few: {needed} are needed for {neighbours} neighbours outside a \
         Theiler window of {theiler} and a step of {step}, and for 20 reference points; give more \
         points, fewer neighbours, a smaller window or a smaller step"
    )]
    TooFew {
        /// Number of points.
        rows: usize,
        /// Number needed.
        needed: usize,
        /// Neighbours asked for.
        neighbours: usize,
        /// Theiler window.
        theiler: usize,
        /// Step of the chain.
        step: usize,
    },
    /// Delayed values that reach beyond the end of the series.
    #[error(
        "{rows} points are too few for {dimension} values with a delay of {delay}: {needed} are \
         needed; give more points, a smaller delay or a smaller dimension"
    )]
    Span {
        /// Number of points.
        rows: usize,
        /// Points between two values.
        delay: usize,
        /// Number of values.
        dimension: usize,
        /// Number of points needed.
        needed: usize,
    },
    /// More points than the search tree can number.
    #[error("{rows} points are too many: at most {max} can be indexed; thin the series")]
    TooMany {
        /// Number of points.
        rows: usize,
        /// Most that are allowed.
        max: usize,
    },
    /// A setting is not allowed.
    #[error("setting {name} = {} is not allowed: it must be {bound}", readable(*value))]
    Setting {
        /// Name as in [`super::DataSettings`] or [`super::Series`].
        name: &'static str,
        /// Value given.
        value: f64,
        /// Allowed values, in words and numbers.
        bound: String,
    },
    /// The watcher of the progress stopped the computation.
    #[error("the computation was stopped")]
    Stopped,
    /// The Fourier transform failed.
    #[error("cannot transform {rows} points: {cause}; please report this")]
    Transform {
        /// Number of points.
        rows: usize,
        /// The message of the transform's crate.
        cause: String,
    },
}

impl DataError {
    /// Converts an error about delayed values, each of which spans `span` more rows, to counts of
    /// rows.
    pub fn in_rows(mut self, span: usize) -> Self {
        if let DataError::TooFew { rows, needed, .. } = &mut self {
            *rows += span;
            *needed = needed.saturating_add(span);
        }
        self
    }
}

/// A number for messages, with twelve significant digits at most. Very large and very small ones
/// have an exponent; zero has no sign.
pub(crate) fn readable(value: f64) -> String {
    let rounded: f64 = format!("{value:.11e}").parse().unwrap_or(value);
    if rounded == 0.0 {
        "0".to_owned()
    } else if (1e-4..1e6).contains(&rounded.abs()) {
        format!("{rounded}")
    } else {
        format!("{rounded:e}")
    }
}
