//! Errors of the search.

use std::path::PathBuf;

use crate::paper::published::PublishedError;
use output::WriteError;

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
    /// A table is there that this search cannot continue: of other settings, or none of readings.
    #[error("{} is not of this search: its line {line} is '{found}' and should be '{wanted}'; move \
        it away or choose another folder with --out", path.display())]
    OtherSearch {
        /// The table.
        path: PathBuf,
        /// The first line that differs, counted from 1.
        line: usize,
        /// What it says; "nothing" if it is not there.
        found: String,
        /// What it must say.
        wanted: String,
    },
    /// The folder for the files, or a file in it, cannot be written.
    #[error("{0}; choose another folder with --out")]
    Write(#[from] WriteError),
    /// The published exponents are not there.
    #[error(transparent)]
    Published(#[from] PublishedError),
    /// The committed table is not that of the full search.
    #[error(
        "{file} is not the table of the full search: {found} of {wanted} configurations can be \
            read, or they were made with other settings; make it with `make readings`"
    )]
    Incomplete {
        /// The table.
        file: &'static str,
        /// Rows that can be read.
        found: usize,
        /// Rows that it must have.
        wanted: usize,
    },
    /// The threads cannot be started.
    #[error("cannot start {threads} threads: {reason}; give fewer with --threads")]
    Threads {
        /// How many.
        threads: usize,
        /// What the library said.
        reason: String,
    },
}
