//! The command line and its commands.

mod arguments;
mod attractors;
mod basin;
mod bifurcation;
mod changes;
mod check;
mod continuation;
mod derivatives;
mod exponent;
mod figures;
mod fit;
mod lyapunov;
mod map;
mod merge;
mod new;
mod orbit;
mod range;
mod recording;
mod resume;
mod search;
mod simulate;
mod spectrum;
mod starts;
mod sweeping;
mod tangents;
mod trajectory;

use std::process::ExitCode;

use clap::{Arg, CommandFactory, FromArgMatches, Parser, Subcommand};

use output::terminal::finish;

/// Dry-friction systems from files: orbits with exact transitions between slip and stick, tangent
/// points, periodic orbits, Lyapunov spectra, fits to records, and spectra of measured series
#[derive(Debug, Parser)]
#[command(name = "stickslip", version, after_help = AFTER_HELP, max_term_width = 100)]
struct ProgramArguments {
    #[command(subcommand)]
    command: Command,
}

const AFTER_HELP: &str = "\
Begin with:
  stickslip new my-system.toml         write an example with comments
  stickslip check my-system.toml       show how it is read
  stickslip simulate my-system.toml    phases and transitions, with figures

Wherever the FILE of a system is asked for, the name of a shipped model will do: belt, forced, \
bracket, leine, basins, den-hartog.";

#[derive(Debug, Subcommand)]
enum Command {
    Basin(basin::Arguments),
    Bifurcation(bifurcation::Arguments),
    Map(map::Arguments),
    Merge(merge::Arguments),
    New(new::Arguments),
    Check(check::Arguments),
    Continue(continuation::Arguments),
    Fit(fit::Arguments),
    Simulate(simulate::Arguments),
    Tangents(tangents::Arguments),
    Orbit(orbit::Arguments),
    Lyapunov(lyapunov::Arguments),
    Spectrum(spectrum::Arguments),
}

/// Parses the command line.
///
/// The value of an option may begin with a hyphen, as a negative number does. The name of the
/// folder may not: otherwise a forgotten name would give a folder named after the next option.
/// Unless it is given, each command has a folder of its own, so that none overwrites the files of
/// another.
fn parsed() -> ProgramArguments {
    let line = ProgramArguments::command().mut_subcommands(|command| {
        let folder = format!("stickslip-output/{}", command.get_name());
        command.mut_args(|option: Arg| match option.get_id().as_str() {
            "out" if option.get_default_values().is_empty() => option,
            "out" => option.default_value(folder.clone()),
            _ if option.is_positional() || !option.get_action().takes_values() => option,
            _ => option.allow_hyphen_values(true),
        })
    });
    ProgramArguments::from_arg_matches(&line.get_matches()).unwrap_or_else(|error| error.exit())
}

/// Runs the program.
///
/// Exit code 0 on success, 1 if something failed (`error: …` on standard error), 2 for a wrong
/// command line or file of a system.
pub fn main() -> ExitCode {
    let outcome = match parsed().command {
        Command::Basin(arguments) => basin::run(&arguments),
        Command::Bifurcation(arguments) => bifurcation::run(&arguments),
        Command::Map(arguments) => map::run(&arguments),
        Command::Merge(arguments) => merge::run(&arguments),
        Command::New(arguments) => new::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Continue(arguments) => continuation::run(&arguments),
        Command::Fit(arguments) => fit::run(&arguments),
        Command::Simulate(arguments) => simulate::run(&arguments),
        Command::Tangents(arguments) => tangents::run(&arguments),
        Command::Orbit(arguments) => orbit::run(&arguments),
        Command::Lyapunov(arguments) => lyapunov::run(&arguments),
        Command::Spectrum(arguments) => spectrum::run(&arguments),
    };
    match outcome {
        Ok(answer) => {
            let failure = answer.failure.as_ref();
            finish(&answer.text, failure.map(|failure| (failure as _, 1)))
        }
        // 2 for a wrong command line or file of a system.
        Err(failure) => finish("", Some((&failure, if failure.is_usage() { 2 } else { 1 }))),
    }
}
