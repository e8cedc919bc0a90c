//! What all programs do on a terminal: the only place that prints, decides on an exit code and draws how far a program is.

mod ending;
mod progress;

pub(crate) use ending::{ProgramError, finish};
pub(crate) use progress::{Progress, patiently};

/// A line on standard error.
pub(crate) fn note(line: &str) {
    eprintln!("{line}");
}
