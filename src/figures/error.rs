//! What can go wrong between a figure's data and its files.

use std::path::PathBuf;

use crate::paper::published::PublishedError;
use crate::terminal::ProgramError;

/// Failure of computing, drawing or writing a figure. Every variant says what was being done, with
/// which values, and what to do about it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FigureError {
    /// The computation behind the figure failed.
    #[error("cannot compute {figure}: {source}")]
    Compute {
        /// Name of the figure, as in `fig06`.
        figure: &'static str,
        /// The computation's own error.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The table of what the paper publishes is not sound.
    #[error(transparent)]
    Published(#[from] PublishedError),
    /// The drawing failed.
    #[error(transparent)]
    Plot(#[from] plot::PlotError),
    /// The folder for the output cannot be made.
    #[error("cannot create folder {}: {source}; choose another with --out-dir", path.display())]
    CreateDir {
        /// The folder.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A file cannot be written.
    #[error(
        "cannot write {}: {source}; check that the folder is writable and the disk not full, or choose another \
         with --out-dir",
        path.display()
    )]
    Write {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The rows do not fit into a CSV file.
    #[error("cannot put the rows into CSV: {0}")]
    Csv(#[from] csv::Error),
    /// `--png` was asked of a program built without it.
    #[error(
        "this program was built without PNG output; rebuild it with `cargo build -p stickslip-replication --profile figures --no-default-features --features png`"
    )]
    PngNotBuilt,
    /// The SVG cannot be turned into a PNG.
    #[error("cannot render the SVG as PNG: {0}")]
    Png(String),
}

impl ProgramError for FigureError {}
