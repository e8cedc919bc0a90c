//! The command line: what can be asked, and what follows from each question.

mod arguments;
mod attractors;
mod basin;
mod bifurcation;
mod check;
mod continuation;
mod exponent;
mod extremes;
mod figures;
mod lyapunov;
mod map;
mod merge;
mod new;
mod orbit;
mod range;
mod recording;
mod search;
mod simulate;
mod spectrum;
mod sweeping;
mod tables;
mod tangents;
mod told;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Arg, CommandFactory, FromArgMatches, Parser, Subcommand};
use stickslip_series::DataError;

use crate::file::FileError;
use crate::output::{Artifact, OutputError, png, write_all_by};
use crate::sweep::SweepError;
use crate::system::{SettingError, System};
use crate::table::TableError;
use crate::terminal::{Said, finish};
use arguments::OutputArguments;
use told::{told, told_of_any};

/// Dry-friction systems from files: orbits with exact transitions between slip and stick, tangent points, periodic orbits, Lyapunov spectra
#[derive(Debug, Parser)]
#[command(name = "stickslip", version, after_help = AFTER_HELP)]
struct CommandLine {
    #[command(subcommand)]
    command: Command,
}

const AFTER_HELP: &str = "\
Begin with:
  stickslip new my-system.toml         write an example with comments
  stickslip check my-system.toml       see what was understood
  stickslip simulate my-system.toml    phases and transitions, with figures

Wherever a FILE is asked for, the name of a shipped model will do: belt, forced, bracket, leine, basins, den-hartog.";

#[derive(Debug, Subcommand)]
enum Command {
    Basin(basin::Arguments),
    Bifurcation(bifurcation::Arguments),
    Map(map::Arguments),
    Merge(merge::Arguments),
    New(new::Arguments),
    Check(check::Arguments),
    Continue(continuation::Arguments),
    Simulate(simulate::Arguments),
    Tangents(tangents::Arguments),
    Orbit(orbit::Arguments),
    Lyapunov(lyapunov::Arguments),
    Spectrum(spectrum::Arguments),
}

/// The command line. What follows an option is its value, also where it begins with a hyphen as a negative number does; but for the folder,
/// which would be named after an option if its own name were forgotten.
fn parsed() -> CommandLine {
    let may_be_negative = |option: Arg| match option.get_action().takes_values() {
        true if !option.is_positional() && option.get_id() != "out" => {
            option.allow_hyphen_values(true)
        }
        _ => option,
    };
    let line = CommandLine::command().mut_subcommands(|command| command.mut_args(may_be_negative));
    CommandLine::from_arg_matches(&line.get_matches()).unwrap_or_else(|error| error.exit())
}

/// Everything the program does.
///
/// Exit code 0 on success, 1 if something failed (`error: …` on standard error), 2 for a wrong command line or file.
pub fn main() -> ExitCode {
    let outcome = match parsed().command {
        Command::Basin(arguments) => basin::run(&arguments),
        Command::Bifurcation(arguments) => bifurcation::run(&arguments),
        Command::Map(arguments) => map::run(&arguments),
        Command::Merge(arguments) => merge::run(&arguments),
        Command::New(arguments) => new::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Continue(arguments) => continuation::run(&arguments),
        Command::Simulate(arguments) => simulate::run(&arguments),
        Command::Tangents(arguments) => tangents::run(&arguments),
        Command::Orbit(arguments) => orbit::run(&arguments),
        Command::Lyapunov(arguments) => lyapunov::run(&arguments),
        Command::Spectrum(arguments) => spectrum::run(&arguments),
    };
    finish(outcome)
}

/// Why a command failed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error(transparent)]
    File(#[from] FileError),
    #[error(transparent)]
    Setting(#[from] SettingError),
    #[error("{0}")]
    Usage(String),
    /// There is an attractor, and it is none that was looked for.
    #[error("{0}")]
    NoPeriodicOrbit(String),
    #[error(transparent)]
    Sweep(#[from] SweepError),
    #[error(transparent)]
    Output(#[from] OutputError),
    #[error(transparent)]
    Table(#[from] TableError),
    #[error(transparent)]
    Series(DataError),
    #[error("{}", told_of_any(.0))]
    Computation(#[from] stickslip::Error),
    /// As [`Failure::Computation`], with the names of the system's contacts.
    #[error("{told}")]
    OfSystem {
        error: stickslip::Error,
        told: String,
    },
}

impl Failure {
    /// Whether the command line or the file is at fault and not the computation or the machine.
    pub(crate) fn is_usage(&self) -> bool {
        match self {
            Failure::File(_) | Failure::Setting(_) | Failure::Usage(_) => true,
            Failure::Sweep(error) => error.is_usage(),
            Failure::Table(error) => matches!(error, TableError::Request(_)),
            Failure::Output(_) | Failure::NoPeriodicOrbit(_) | Failure::Series(_) => false,
            Failure::Computation(error) | Failure::OfSystem { error, .. } => matches!(
                error,
                stickslip::Error::Option { .. } | stickslip::Error::Interval { .. }
            ),
        }
    }

    /// With the names of the contacts, where it speaks of some.
    fn of(self, system: &System) -> Self {
        match self {
            Failure::Computation(error) => Failure::OfSystem {
                told: told(&error, system),
                error,
            },
            other => other,
        }
    }
}

/// What a command has found.
#[derive(Default)]
struct Found {
    /// For people.
    summary: String,
    /// For programs.
    json: serde_json::Value,
    /// Tables.
    tables: Vec<Artifact>,
    /// Names and texts of the figures.
    figures: Vec<(String, String)>,
    /// What went wrong behind what was found all the same.
    failure: Option<String>,
}

impl Found {
    /// Writes the files and says what was found.
    fn written(self, output: &OutputArguments) -> Result<Said, Failure> {
        self.written_besides(Vec::new(), Path::new(&output.out), output)
    }

    /// As [`Found::written`], besides files that are on disk already, and by way of a folder for what is unfinished.
    fn written_besides(
        self,
        there: Vec<PathBuf>,
        staging: &Path,
        output: &OutputArguments,
    ) -> Result<Said, Failure> {
        let mut artifacts = self.tables;
        for (name, svg) in self.figures {
            if output.png {
                artifacts.push(Artifact {
                    name: format!("{name}.png"),
                    bytes: png(&svg)?,
                });
            }
            artifacts.push(Artifact::text(format!("{name}.svg"), svg));
        }
        let mut paths = there;
        paths.extend(write_all_by(staging, Path::new(&output.out), &artifacts)?);
        let paths: Vec<String> = paths
            .iter()
            .map(|path| path.display().to_string())
            .collect();
        let text = if output.json {
            let mut json = self.json;
            if let Some(object) = json.as_object_mut() {
                object.insert("files".to_owned(), paths.into());
            }
            format!("{json:#}\n")
        } else {
            let wrote: String = paths.iter().map(|path| format!("wrote {path}\n")).collect();
            format!("{}\n{wrote}", self.summary)
        };
        Ok(Said {
            text,
            failure: self.failure,
        })
    }
}
