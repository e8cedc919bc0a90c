//! Files that are complete or not there.

use std::io::{self, Write};
use std::path::Path;

use output::{WriteError, place, stage};

use super::error::SweepError;

/// Whether a file could not be read because there is none; a file in the place of a folder above it is told when the folder is made.
pub(super) fn is_absent(error: &io::Error) -> bool {
    use io::ErrorKind::{NotADirectory, NotFound};
    matches!(error.kind(), NotFound | NotADirectory)
}

impl From<WriteError> for SweepError {
    fn from(error: WriteError) -> Self {
        match error {
            WriteError::Folder { path, source } => Self::CreateFolder { path, source },
            WriteError::File { path, source } => Self::Write { path, source },
        }
    }
}

/// Writes `path` by way of a temporary file in `staging`, on the same file system, so that it is never seen unfinished.
///
/// # Errors
/// [`SweepError::Write`], also if `content` fails; the temporary file is then removed, and what was at `path` before stays.
pub(super) fn write(
    path: &Path,
    staging: &Path,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), SweepError> {
    let staged = stage(staging, content).map_err(SweepError::write(path))?;
    place(staged, path).map_err(SweepError::write(path))
}

/// Writes a table or another file that need not fit into memory, by way of a temporary file in `staging`: `content` writes
/// it bit by bit, and it appears under its name when it is complete. Both folders must exist.
///
/// # Errors
/// Those of `content`; [`SweepError::Write`]. What was at `path` before then stays.
pub fn write_whole<E: From<SweepError>>(
    path: &Path,
    staging: &Path,
    content: impl FnOnce(&mut dyn Write) -> Result<(), E>,
) -> Result<(), E> {
    let failed = SweepError::write(path);
    let mut of_content = Ok(());
    let staged = stage(staging, |file| {
        of_content = content(file);
        Ok(())
    });
    of_content?;
    let placed = staged.and_then(|file| place(file, path));
    placed.map_err(failed)?;
    Ok(())
}

/// As [`write`], but what is there already stays: whoever is first has written the file. Whether it was this call.
///
/// # Errors
/// [`SweepError::Write`].
pub(super) fn write_once(path: &Path, staging: &Path, bytes: &[u8]) -> Result<bool, SweepError> {
    let staged = stage(staging, |file| file.write_all(bytes)).map_err(SweepError::write(path))?;
    match staged.persist_noclobber(path) {
        Ok(_) => Ok(true),
        Err(error) if error.error.kind() == io::ErrorKind::AlreadyExists => Ok(false),
        Err(error) => Err(SweepError::write(path)(error.error)),
    }
}
