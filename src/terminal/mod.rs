//! What all programs do on a terminal: the only place that prints, decides on an exit code and draws how far a program is.

mod ending;
#[cfg_attr(
    not(feature = "report"),
    expect(dead_code, reason = "the figures count nothing")
)]
mod progress;

use std::io::Write;

pub(crate) use ending::{ProgramError, finish};
pub(crate) use progress::Progress;

/// A line on standard error; where nobody reads it any more, nothing is lost with it.
pub(crate) fn note(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}
