//! Files that are either complete or not there, with what to do about it where they cannot be.

use std::path::{Path, PathBuf};

pub use output::Artifact;
use output::{PngError, WriteError};

/// A table with a heading, as CSV. Numbers are written so that they read back to the last bit.
///
/// # Errors
/// [`OutputError::Csv`] where a row has not as many fields as the heading.
pub fn csv_table(
    name: impl Into<String>,
    heading: &[String],
    rows: impl IntoIterator<Item = Vec<String>>,
) -> Result<Artifact, OutputError> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(heading)?;
    for row in rows {
        writer.write_record(&row)?;
    }
    let bytes = writer.into_inner().map_err(|error| error.into_error());
    let bytes = bytes.map_err(|error| OutputError::Csv(error.into()))?;
    let name = name.into();
    Ok(Artifact { name, bytes })
}

/// Failure of making or writing files.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The folder cannot be made.
    #[error("cannot create folder {}: {source}; choose another with --out", path.display())]
    CreateDir {
        /// The folder.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A file cannot be written.
    #[error(
        "cannot write {}: {source}; check that the folder is writable and the disk not full, or choose another with --out",
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
    /// The drawing failed.
    #[error(transparent)]
    Plot(#[from] plot::PlotError),
    /// `--png` was asked of a program built without it.
    #[error(
        "this program was built without PNG output (--no-default-features); rebuild it with `cargo build --release -p stickslip-cli`"
    )]
    PngNotBuilt,
    /// The SVG cannot be turned into a PNG.
    #[error("cannot render the SVG as PNG: {0}")]
    Png(String),
}

impl From<WriteError> for OutputError {
    fn from(error: WriteError) -> Self {
        match error {
            WriteError::Folder { path, source } => Self::CreateDir { path, source },
            WriteError::File { path, source } => Self::Write { path, source },
        }
    }
}

impl From<PngError> for OutputError {
    fn from(error: PngError) -> Self {
        match error {
            PngError::NotBuilt => Self::PngNotBuilt,
            PngError::Rendering(reason) => Self::Png(reason),
        }
    }
}

/// As [`output::write_all_by`].
///
/// # Errors
/// [`OutputError::Write`].
pub fn write_all_by(
    staging: &Path,
    folder: &Path,
    artifacts: &[Artifact],
) -> Result<Vec<PathBuf>, OutputError> {
    Ok(output::write_all_by(staging, folder, artifacts)?)
}

/// As [`output::write_all`].
///
/// # Errors
/// [`OutputError::CreateDir`], [`OutputError::Write`].
pub fn write_all(folder: &Path, artifacts: &[Artifact]) -> Result<Vec<PathBuf>, OutputError> {
    Ok(output::write_all(folder, artifacts)?)
}

/// As [`output::png`].
///
/// # Errors
/// [`OutputError::Png`], [`OutputError::PngNotBuilt`].
pub fn png(svg: &str) -> Result<Vec<u8>, OutputError> {
    Ok(output::png(svg)?)
}
