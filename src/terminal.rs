//! Output shared by all programs of the replication: results, errors, files, exit codes.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use output::Artifact;
use output::terminal;

/// Failure of a program: the error of a part, or a message with the value and the remedy.
pub type ProgramError = Box<dyn std::error::Error + Send + Sync>;

/// Writes files into a folder, which `option` chooses, and returns their paths.
///
/// # Errors
/// That of [`output::write_all`], with the option that helps.
pub(crate) fn write(
    folder: &Path,
    files: &[Artifact],
    option: &str,
) -> Result<Vec<PathBuf>, ProgramError> {
    output::write_all(folder, files)
        .map_err(|error| format!("{error}; check the disk, or choose another with {option}").into())
}

/// Prints a program's result or its error.
///
/// Exit code 0 on success, 1 on failure (`error: …` on standard error). For a wrong command line,
/// clap has already printed a message and exited with code 2.
pub(crate) fn finish(outcome: Result<String, ProgramError>) -> ExitCode {
    match outcome {
        Ok(text) => terminal::finish(&text, None),
        Err(error) => terminal::finish("", Some((&error, 1))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_write_error_names_the_option_that_helps() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let error = write(&file.path().join("sub"), &[], "--out-dir").unwrap_err();
        assert!(error.to_string().contains("--out-dir"));
    }
}
