//! What can stop the search.

use std::path::PathBuf;

use crate::figures::FigureError;
use crate::paper::published::PublishedError;

/// Failure of the program `readings`.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadingsError {
    /// A table is there but cannot be read.
    #[error("cannot read {}: {source}; choose another folder with --out", path.display())]
    Read {
        /// The table.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A table is there that this search cannot continue.
    #[error("{} is not a table of this search (its first line must be '{heading}'); move it away or choose another folder with --out", path.display())]
    Foreign {
        /// The table.
        path: PathBuf,
        /// What its first line must be.
        heading: String,
    },
    /// Files cannot be written.
    #[error(transparent)]
    Output(#[from] FigureError),
    /// The published exponents are not there.
    #[error(transparent)]
    Published(#[from] PublishedError),
    /// The threads cannot be started.
    #[error("cannot start {threads} threads: {reason}; give fewer with --threads")]
    Threads {
        /// How many.
        threads: usize,
        /// What the library said.
        reason: String,
    },
}
