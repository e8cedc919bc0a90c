//! What can go wrong between the problems and their figure.

use std::path::PathBuf;

use output::WriteError;

/// Failure of the program `peers`.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PeersError {
    /// A reference file that does not have the form that its generator writes.
    #[error(
        "reference of {problem}, line {line}: {cause}; run data/references/generate.py {problem}"
    )]
    Reference {
        /// Problem.
        problem: &'static str,
        /// Line, counted from 1.
        line: usize,
        /// What is wrong.
        cause: String,
    },
    /// A model of a problem has a parameter that is not allowed.
    #[error(transparent)]
    Model(#[from] stickslip::Error),
    /// The solver failed on a problem that it has to solve.
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
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The peers' process ended or its pipe broke.
    #[error(
        "the peers' process ended while '{command}' was under way ({cause}); its own message \
            stands above"
    )]
    Ended {
        /// What it had been asked.
        command: String,
        /// What was noticed.
        cause: String,
    },
    /// The peers' process said something that is no answer.
    #[error("line {line} of the peers' process, '{text}': {cause}")]
    Answer {
        /// Line of its output, counted from 1.
        line: usize,
        /// The line.
        text: String,
        /// What is wrong with it.
        cause: String,
    },
    /// A whole process that was timed failed.
    #[error("'{command}' failed with {status}; run it by hand to see why")]
    Process {
        /// The command line.
        command: String,
        /// Its exit status.
        status: std::process::ExitStatus,
    },
    /// The figure cannot be made.
    #[error(transparent)]
    Plot(#[from] plot::PlotError),
    /// A file cannot be read.
    #[error("cannot read {}: {source}; choose its folder with --report-dir", path.display())]
    Input {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A table of measurements that does not have the form that this program writes.
    #[error("bench.csv, line {line}: {cause}; measure again with `peers`")]
    Table {
        /// Line, counted from 1.
        line: usize,
        /// What is wrong.
        cause: String,
    },
    /// A file or its folder cannot be written.
    #[error("{0}; choose folders that can be written to with --report-dir and --figures-dir")]
    Write(#[from] WriteError),
}
