//! How a program ends: with its text on standard output, or with an error and an exit code.

use std::fmt::Display;
use std::io::{self, Write};
use std::process::ExitCode;

use super::note;

/// An error that ends a program.
pub(crate) trait ProgramError: Display {
    /// Whether the command line is at fault (exit code 2) and not the data or the machine (1).
    fn is_usage(&self) -> bool {
        false
    }
}

/// Prints what a program has to say, named `what` if that fails, or its error.
///
/// Exit code 0 on success, 1 if something failed (`error: …` on standard error), 2 for a wrong command line.
pub(crate) fn finish<E: ProgramError>(what: &str, outcome: Result<String, E>) -> ExitCode {
    match outcome {
        Ok(text) => end_of_print(what, print(&text)),
        Err(error) => {
            note(&format!("error: {error}"));
            ExitCode::from(if error.is_usage() { 2 } else { 1 })
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
        // Whoever reads may stop reading; files are written all the same.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Err(error) => {
            note(&format!("error: cannot print the {what}: {error}"));
            ExitCode::FAILURE
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, thiserror::Error)]
    #[error("no such thing")]
    struct Wrong {
        usage: bool,
    }

    impl ProgramError for Wrong {
        fn is_usage(&self) -> bool {
            self.usage
        }
    }

    fn same(one: ExitCode, other: u8) {
        // Exit codes can be shown, not compared.
        assert_eq!(format!("{one:?}"), format!("{:?}", ExitCode::from(other)));
    }

    #[test]
    fn the_exit_code_tells_whose_fault_it_was() {
        same(finish("text", Ok::<_, Wrong>(String::new())), 0);
        same(finish("text", Err(Wrong { usage: false })), 1);
        same(finish("text", Err(Wrong { usage: true })), 2);
    }

    #[test]
    fn a_reader_who_stops_reading_is_no_failure() {
        let of = |kind: io::ErrorKind| end_of_print("text", Err(kind.into()));
        same(of(io::ErrorKind::BrokenPipe), 0);
        same(of(io::ErrorKind::StorageFull), 1);
    }
}
