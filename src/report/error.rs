//! Why the report could not be made.

use crate::figures::FigureError;
use crate::paper::listing::ListingError;
use crate::paper::published::PublishedError;
use crate::readings::ReadingsError;
use crate::terminal::ProgramError;
use stickslip::error::Error;
use stickslip::filippov::Failure;

/// What failed on the way to the report.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A figure, or a file that could not be written.
    #[error(transparent)]
    Figure(#[from] FigureError),
    /// The solver.
    #[error("cannot make the ledger: {0}")]
    Solver(#[from] Error),
    /// The listing cannot run.
    #[error("cannot make the ledger: {0}")]
    Listing(#[from] ListingError),
    /// The table of claims is not sound.
    #[error("cannot make the ledger: {0}")]
    Published(#[from] PublishedError),
    /// The committed search over readings is not whole.
    #[error("cannot make the ledger: {0}")]
    Readings(#[from] ReadingsError),
}

impl ProgramError for ReportError {}

impl<R> From<Failure<R>> for ReportError {
    fn from(failure: Failure<R>) -> ReportError {
        ReportError::Solver(failure.error)
    }
}
