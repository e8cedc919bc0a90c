//! Output shared by all programs of the replication: results, errors, files, exit codes, progress.

use std::fmt::Display;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use indicatif::ProgressBar;
use indicatif::ProgressStyle;
use output::Artifact;

/// What ends a program: the error of a part, or a message with the value and the remedy.
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

/// Prints a program's result or its error. `what` names the result if printing fails.
///
/// Exit code 0 on success, 1 on failure (`error: …` on standard error). For a wrong command line,
/// clap has already printed a message and exited with code 2.
pub(crate) fn finish(what: &str, outcome: Result<String, impl Display>) -> ExitCode {
    match outcome {
        Ok(text) => end_of_print(what, print(&text)),
        Err(error) => {
            print_note(&format!("error: {error}"));
            ExitCode::FAILURE
        }
    }
}

fn print(text: &str) -> io::Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes())?;
    out.flush()
}

fn end_of_print(what: &str, printed: io::Result<()>) -> ExitCode {
    match printed {
        Ok(()) => ExitCode::SUCCESS,
        // The reader may close the pipe early; files are written all the same.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Err(error) => {
            print_note(&format!("error: cannot print the {what}: {error}"));
            ExitCode::FAILURE
        }
    }
}

/// Prints a line on standard error. Failure is ignored: nobody reads it then.
pub(crate) fn print_note(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// A spinner, shown only in a terminal. Clearing it removes it.
pub(crate) fn spinner(message: String) -> ProgressBar {
    let spinner = ProgressBar::new_spinner().with_message(message);
    spinner.enable_steady_tick(Duration::from_millis(120));
    spinner
}

/// A progress bar with a count, shown only in a terminal. `text` is an indicatif template.
pub(crate) fn bar(total: usize, text: &str) -> ProgressBar {
    let bar = ProgressBar::new(total as u64);
    match ProgressStyle::with_template(&format!("{{bar:40}} {{pos}}/{{len}}{text}")) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn same(one: ExitCode, other: u8) {
        // Exit codes can be formatted but not compared.
        assert_eq!(format!("{one:?}"), format!("{:?}", ExitCode::from(other)));
    }

    #[test]
    fn the_exit_code_says_whether_something_failed() {
        same(finish("text", Ok::<_, &str>(String::new())), 0);
        same(finish("text", Err("no such thing")), 1);
    }

    #[test]
    fn a_write_error_names_the_option_that_helps() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let error = write(&file.path().join("sub"), &[], "--out-dir").unwrap_err();
        assert!(error.to_string().contains("--out-dir"));
    }

    #[test]
    fn a_reader_who_stops_reading_is_no_failure() {
        let of = |kind: io::ErrorKind| end_of_print("text", Err(kind.into()));
        same(of(io::ErrorKind::BrokenPipe), 0);
        same(of(io::ErrorKind::StorageFull), 1);
    }
}
