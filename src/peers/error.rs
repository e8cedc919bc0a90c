//! What can go wrong between the problems and their figure.

use std::path::PathBuf;

use crate::terminal::ProgramError;
use output::WriteError;

/// Failure of the program `peers`.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PeersError {
    /// A name that is in no table.
    #[error("'{name}' is no {what}; there are {known}")]
    Unknown {
        /// What was looked for, such as `problem`.
        what: &'static str,
        /// The name given.
        name: String,
        /// The names in the table.
        known: String,
    },
    /// A number on the command line that is out of its range.
    #[error("--{name} {value} is not allowed; it must be {bound}")]
    Argument {
        /// Name of the argument.
        name: &'static str,
        /// The value given.
        value: f64,
        /// What is allowed.
        bound: &'static str,
    },
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
    /// A program cannot be started.
    #[error("cannot start {}: {source}; check --python, or leave it out to measure without peers", program.display())]
    Start {
        /// The program.
        program: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The peers' process ended or its pipe broke.
    #[error(
        "the peers' process ended while '{command}' was under way ({cause}); its own message stands above"
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
        path: std::path::PathBuf,
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
    /// The rows do not fit into a CSV file.
    #[error("cannot put the rows into CSV: {0}")]
    Csv(#[from] csv::Error),
}

impl ProgramError for PeersError {
    fn is_usage(&self) -> bool {
        matches!(self, Self::Unknown { .. } | Self::Argument { .. })
    }
}
