//! Errors of the program `peers`.

use std::path::PathBuf;

use output::WriteError;

/// Failure of the program `peers`.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PeersError {
    /// A reference file does not have the format that its generator writes.
    #[error(
        "reference of {problem}, line {line}: {cause}; run data/references/generate.py {problem}"
    )]
    Reference {
        /// Problem.
        problem: &'static str,
        /// Line, counted from 1.
        line: usize,
        /// The fault.
        cause: String,
    },
    /// A model of a problem has a parameter that is not allowed.
    #[error(transparent)]
    Model(#[from] stickslip::Error),
    /// Our solver failed on a problem.
    #[error("{problem} at tolerance {tolerance:e}: {source}")]
    Solve {
        /// Problem.
        problem: &'static str,
        /// Tolerance.
        tolerance: f64,
        /// The solver's error.
        source: stickslip::Error,
    },
    /// A problem that cannot be written as formulas.
    #[error("problem {problem} branches on values, which formulas cannot say")]
    Formulas {
        /// Problem.
        problem: &'static str,
    },
    /// A program cannot be started.
    #[error(
        "cannot start {}: {source}; check --python, or leave it out to measure without peers",
        program.display()
    )]
    Start {
        /// The program.
        program: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The peers' process ended or its pipe broke.
    #[error(
        "the peers' process ended while '{command}' was under way ({cause}); its own message \
            stands above"
    )]
    Ended {
        /// The command.
        command: String,
        /// How the end was noticed.
        cause: String,
    },
    /// The peers' process printed a line that is not an answer.
    #[error("line {line} of the peers' process, '{text}': {cause}")]
    Answer {
        /// Line of its output, counted from 1.
        line: usize,
        /// The line.
        text: String,
        /// The fault.
        cause: String,
    },
    /// A timed process failed.
    #[error("'{command}' failed with {status}; run it by hand to see why")]
    Process {
        /// The command line.
        command: String,
        /// Its exit status.
        status: std::process::ExitStatus,
    },
    /// The figure cannot be drawn.
    #[error(transparent)]
    Plot(#[from] plot::PlotError),
    /// A file cannot be read.
    #[error("cannot read {}: {source}; choose its folder with --report-dir", path.display())]
    Input {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A table of measurements does not have the format that this program writes.
    #[error("bench.csv, line {line}: {cause}; measure again with `peers`")]
    Table {
        /// Line, counted from 1.
        line: usize,
        /// The fault.
        cause: String,
    },
    /// A file or its folder cannot be written.
    #[error("{0}; choose folders that can be written to with --report-dir and --figures-dir")]
    Write(#[from] WriteError),
}
