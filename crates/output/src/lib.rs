//! Output of all programs: files that are either complete or absent, figures as PNG, and what is
//! printed.

mod png;
pub mod terminal;

use std::fs::{self, File};
use std::io::ErrorKind::CrossesDevices;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

pub use png::{PngError, png};

/// A file to be written.
#[derive(Clone, Debug)]
pub struct Artifact {
    /// Name inside the output folder.
    pub name: String,
    /// Content.
    pub bytes: Vec<u8>,
}

impl Artifact {
    /// A file of text.
    pub fn text(name: impl Into<String>, text: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            bytes: text.into().into_bytes(),
        }
    }
}

/// A file or its folder cannot be created. Programs add the remedy, which depends on their options.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The folder cannot be created.
    #[error("cannot create folder {}: {source}", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The file cannot be written.
    #[error("cannot write {}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
}

/// Creates a folder and its parents.
///
/// # Errors
/// [`WriteError::Folder`].
pub fn make_folder(path: &Path) -> Result<(), WriteError> {
    fs::create_dir_all(path).map_err(|source| WriteError::Folder {
        path: path.to_owned(),
        // The operating system reports only that something of this name exists.
        source: if path.is_file() {
            io::Error::new(source.kind(), "it is a file, not a folder")
        } else {
            source
        },
    })
}

/// Writes all files into `folder`, which is created if missing, and returns their paths. Files have
/// temporary names until all are on disk, so that a reader never sees an incomplete one.
///
/// # Errors
/// [`WriteError`]; temporary files are removed.
pub fn write_all(folder: &Path, artifacts: &[Artifact]) -> Result<Vec<PathBuf>, WriteError> {
    write_all_by(folder, folder, artifacts)
}

/// [`write_all`] with temporary files in another folder. A kill may leave unfinished files
/// there.
///
/// # Errors
/// As [`write_all`].
pub fn write_all_by(
    staging: &Path,
    folder: &Path,
    artifacts: &[Artifact],
) -> Result<Vec<PathBuf>, WriteError> {
    make_folder(folder)?;
    let failed = |path: &Path| {
        let path = path.to_owned();
        |source| WriteError::File { path, source }
    };
    let mut staged = Vec::with_capacity(artifacts.len());
    for artifact in artifacts {
        let path = folder.join(&artifact.name);
        let file = stage(staging, |file| file.write_all(&artifact.bytes));
        staged.push((file.map_err(failed(&path))?, path));
    }
    let mut written = Vec::with_capacity(staged.len());
    for (file, path) in staged {
        place(file, &path).map_err(failed(&path))?;
        written.push(path);
    }
    Ok(written)
}

/// Renames a temporary file to `path`. If that is on another file system, a second temporary file
/// is made there.
///
/// # Errors
/// Those of the operating system; the temporary file is removed.
pub fn place(file: NamedTempFile, path: &Path) -> io::Result<()> {
    let error = match file.persist(path) {
        Ok(_) => return Ok(()),
        Err(error) => error,
    };
    let (true, Some(folder)) = (error.error.kind() == CrossesDevices, path.parent()) else {
        return Err(error.error);
    };
    let mut content = File::open(error.file.path())?;
    let there = stage(folder, |file| io::copy(&mut content, file).map(|_| ()))?;
    there.persist(path).map(|_| ()).map_err(|error| error.error)
}

/// Writes a temporary file in `folder` and syncs it to disk. It is removed unless it is renamed.
///
/// # Errors
/// Those of the operating system and of `content`.
pub fn stage(
    folder: &Path,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    // Temporary files are private by default, but results must have the permissions of the umask.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let mut buffered = BufWriter::new(builder.tempfile_in(folder)?);
    content(&mut buffered)?;
    let file = buffered
        .into_inner()
        .map_err(io::IntoInnerError::into_error)?;
    // Without a sync, the name may be on disk before the content.
    file.as_file().sync_all()?;
    Ok(file)
}

/// Lists the files that a program has written, one per line.
pub fn listing(paths: &[PathBuf]) -> String {
    let line = |path: &PathBuf| format!("wrote {}\n", Path::display(path));
    paths.iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn artifact(name: &str) -> Artifact {
        Artifact::text(name, "text")
    }

    #[test]
    fn folders_are_made_and_files_replaced() {
        let top = tempfile::tempdir().unwrap();
        let folder = top.path().join("a/b");
        for _ in 0..2 {
            let paths = write_all(&folder, &[artifact("x.txt")]).unwrap();
            assert_eq!(fs::read(&paths[0]).unwrap(), b"text");
        }
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
    }

    #[test]
    fn a_target_that_cannot_be_replaced_is_named_and_leaves_nothing_behind() {
        let top = tempfile::tempdir().unwrap();
        fs::create_dir(top.path().join("x.txt")).unwrap();
        let error = write_all(top.path(), &[artifact("x.txt")]).unwrap_err();
        assert!(error.to_string().contains("x.txt"));
        assert_eq!(fs::read_dir(top.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_folder_below_a_file_is_refused() {
        let file = NamedTempFile::new().unwrap();
        let error = write_all(&file.path().join("sub"), &[artifact("x")]).unwrap_err();
        assert!(matches!(error, WriteError::Folder { .. }), "{error}");
        let error = write_all(file.path(), &[artifact("x")]).unwrap_err();
        assert!(error.to_string().contains("is a file, not a folder"));
    }
}
