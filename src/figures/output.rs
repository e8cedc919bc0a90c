//! Files that are either complete or not there.

use std::io::Write;
use std::path::{Path, PathBuf};

use super::error::FigureError;

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

/// Writes all files into `folder`, which is made if it is missing, and returns their paths. Each file first
/// gets a temporary name and is renamed when complete, so that a reader never sees half of one; nothing is
/// renamed before everything is on disk.
///
/// # Errors
/// [`FigureError::CreateDir`], [`FigureError::Write`], each with the path and the cause. Temporary files are
/// removed.
pub fn write_all(folder: &Path, artifacts: &[Artifact]) -> Result<Vec<PathBuf>, FigureError> {
    std::fs::create_dir_all(folder).map_err(|source| FigureError::CreateDir {
        path: folder.to_owned(),
        // The system says no more than that something of this name exists.
        source: if folder.is_file() {
            std::io::Error::new(source.kind(), "it is a file, not a folder")
        } else {
            source
        },
    })?;
    let mut staged = Vec::with_capacity(artifacts.len());
    for artifact in artifacts {
        let path = folder.join(&artifact.name);
        let file = stage(folder, &artifact.bytes).map_err(|source| FigureError::Write {
            path: path.clone(),
            source,
        })?;
        staged.push((path, file));
    }
    let mut written = Vec::with_capacity(staged.len());
    for (path, file) in staged {
        file.persist(&path).map_err(|error| FigureError::Write {
            path: path.clone(),
            source: error.error,
        })?;
        written.push(path);
    }
    Ok(written)
}

/// What a program says of the files it has written, a line for each.
pub fn listing(paths: &[PathBuf]) -> String {
    let line = |path: &PathBuf| format!("wrote {}\n", Path::display(path));
    paths.iter().map(line).collect()
}

fn stage(folder: &Path, bytes: &[u8]) -> std::io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    // Temporary files are private by default; a figure is to be read by everyone the umask lets.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(folder)?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    Ok(file)
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
            assert_eq!(std::fs::read(&paths[0]).unwrap(), b"text");
        }
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1);
    }

    #[test]
    fn a_target_that_cannot_be_replaced_is_named_and_leaves_nothing_behind() {
        let top = tempfile::tempdir().unwrap();
        std::fs::create_dir(top.path().join("x.txt")).unwrap();
        let error = write_all(top.path(), &[artifact("x.txt")]).unwrap_err();
        assert!(error.to_string().contains("x.txt"));
        assert_eq!(std::fs::read_dir(top.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_folder_below_a_file_is_refused() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let error = write_all(&file.path().join("sub"), &[artifact("x")]).unwrap_err();
        assert!(error.to_string().contains("--out-dir"));
        let error = write_all(file.path(), &[artifact("x")]).unwrap_err();
        assert!(error.to_string().contains("is a file, not a folder"));
    }
}
