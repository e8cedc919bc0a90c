//! Errors of the search.

use std::path::PathBuf;

use crate::paper::published::PublishedError;
use output::WriteError;

/// Failure of the program `readings`.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadingsError {
    /// An existing table cannot be read.
    #[error("cannot read {}: {source}; choose another folder with --out", path.display())]
    Read {
        /// The table.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// An existing table cannot be continued by this search: it has other settings or another
    /// format.
    #[error("{} is not of this search: its line {line} is '{actual}' and should be \
        '{expected}'; move it away or choose another folder with --out", path.display())]
    OtherSearch {
        /// The table.
        path: PathBuf,
        /// The first line that differs, counted from 1.
        line: usize,
        /// Its content; "nothing" if it is missing.
        actual: String,
        /// Required content.
        expected: String,
    },
    /// The folder for the files, or a file in it, cannot be written.
    #[error("{0}; choose another folder with --out")]
    Write(#[from] WriteError),
    /// The table of claims is malformed.
    #[error(transparent)]
    Published(#[from] PublishedError),
    /// The committed table is not that of the full search.
    #[error(
        "{file} is not the table of the full search: {actual} of {expected} configurations can be \
            read, or they were made with other settings; make it with `make readings`"
    )]
    Incomplete {
        /// The table.
        file: &'static str,
        /// Readable rows.
        actual: usize,
        /// Required rows.
        expected: usize,
    },
    /// The threads cannot be started.
    #[error("cannot start {threads} threads: {reason}; give fewer with --threads")]
    Threads {
        /// Number of threads.
        threads: usize,
        /// The library's message.
        reason: String,
    },
}
