//! Errors of commands, in words for users who do not program.

use stickslip::Error;
use stickslip::error::readable;
use stickslip_model::file::{FileError, Interface, SettingError, System};
use stickslip_series::DataError;

use crate::render::OutputError;
use crate::sweep::SweepError;
use crate::table::TableError;

/// Reason for which a command failed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error(transparent)]
    File(#[from] FileError),
    #[error(transparent)]
    Setting(#[from] SettingError),
    #[error("{0}")]
    Usage(String),
    /// The attractor is not of the kind that was searched.
    #[error("{0}")]
    NoPeriodicOrbit(String),
    /// A fit cannot begin where it should.
    #[error("{0}")]
    Fit(String),
    #[error(transparent)]
    Sweep(#[from] SweepError),
    #[error(transparent)]
    Output(#[from] OutputError),
    #[error(transparent)]
    Table(#[from] TableError),
    #[error(transparent)]
    Series(DataError),
    #[error("{}", CommandLine.words(.0, None))]
    Computation(#[from] Error),
    /// [`Failure::Computation`] with the names of the system's contacts.
    #[error("{words}")]
    OfSystem { error: Error, words: String },
}

impl Failure {
    /// Whether the command line or the file is at fault, rather than the computation or the
    /// machine.
    pub(crate) fn is_usage(&self) -> bool {
        match self {
            Failure::File(_) | Failure::Setting(_) | Failure::Usage(_) => true,
            Failure::Sweep(error) => error.is_usage(),
            Failure::Table(error) => matches!(error, TableError::Request(_)),
            Failure::Output(_)
            | Failure::NoPeriodicOrbit(_)
            | Failure::Fit(_)
            | Failure::Series(_) => false,
            Failure::Computation(error) | Failure::OfSystem { error, .. } => {
                matches!(error, Error::Option { .. } | Error::Interval { .. })
            }
        }
    }

    /// Replaces numbers of contacts by their names.
    pub(crate) fn of(self, system: &System) -> Self {
        match self {
            Failure::Computation(error) => Failure::OfSystem {
                words: in_words(&error, system),
                error,
            },
            other => other,
        }
    }
}

/// An error of the library in words.
pub(crate) fn in_words(error: &Error, system: &System) -> String {
    CommandLine.words(error, Some(system))
}

/// Options as on the command line.
pub(crate) struct CommandLine;

impl Interface for CommandLine {
    fn name(&self, option: &str) -> String {
        let known = [
            ("rtol", "--tol"),
            ("longest", "--until"),
            ("most_points", "--points"),
            ("range", "--parameter"),
        ];
        match known.iter().find(|(name, _)| *name == option) {
            Some((_, given)) => (*given).to_owned(),
            None => format!("--{}", option.replace('_', "-")),
        }
    }

    fn choice(&self, option: &str, words: &[&str]) -> String {
        format!("{} {}", self.name(option), words.join(" or "))
    }

    fn value(&self, option: &str, value: f64) -> String {
        format!("{} {}", self.name(option), readable(value))
    }

    fn nearer(&self) -> &'static str {
        "after a longer --transient or by another --start; the motion may also be quasi-periodic \
         or chaotic, as `stickslip lyapunov` shows"
    }
}
