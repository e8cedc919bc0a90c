//! Files that are either complete or not there, with what to do about it where they cannot be.

use std::path::{Path, PathBuf};

use output::{PngError, WriteError};

use crate::paper::published::PublishedError;
use crate::terminal::ProgramError;
pub use output::{Artifact, listing};

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

impl From<WriteError> for FigureError {
    fn from(error: WriteError) -> Self {
        match error {
            WriteError::Folder { path, source } => Self::CreateDir { path, source },
            WriteError::File { path, source } => Self::Write { path, source },
        }
    }
}

impl From<PngError> for FigureError {
    fn from(error: PngError) -> Self {
        match error {
            PngError::NotBuilt => Self::PngNotBuilt,
            PngError::Rendering(reason) => Self::Png(reason),
        }
    }
}

/// As [`output::write_all`].
///
/// # Errors
/// [`FigureError::CreateDir`], [`FigureError::Write`], each with the path and the cause.
pub fn write_all(folder: &Path, artifacts: &[Artifact]) -> Result<Vec<PathBuf>, FigureError> {
    Ok(output::write_all(folder, artifacts)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_written_is_told_with_the_option_that_helps() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let error = write_all(&file.path().join("sub"), &[]).unwrap_err();
        assert!(error.to_string().contains("--out-dir"));
    }
}
