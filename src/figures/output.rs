//! Files that are either complete or not there, with what to do about it where they cannot be.

use std::path::{Path, PathBuf};

use output::{PngError, WriteError};

use super::error::FigureError;
pub use output::{Artifact, listing};

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
