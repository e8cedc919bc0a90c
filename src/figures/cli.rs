//! The command line all figure programs share.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser};

use super::FigureError;
use super::FigureSpec;
use super::output::{self, Artifact};
use super::rows;
use crate::paper::published::Claims;
use crate::terminal;

/// Arguments of a figure program.
#[derive(Debug, Parser)]
#[command(version)]
pub struct Arguments {
    /// Folder for the files; made if it does not exist
    #[arg(
        long,
        value_name = "DIR",
        default_value = "figures",
        visible_alias = "out"
    )]
    pub out_dir: PathBuf,

    /// Also write a PNG, at twice the nominal size (needs a build with `--features png`)
    #[arg(long)]
    pub png: bool,
}

/// Everything a figure program does: parses the command line, computes, draws, writes, prints the
/// numbers.
///
/// Exit code 0 on success, 1 if something failed (`error: …` on standard error), 2 for a wrong
/// command line.
pub fn main<F: FigureSpec>() -> ExitCode {
    let matches = command::<F>().get_matches();
    let arguments = match Arguments::from_arg_matches(&matches) {
        Ok(arguments) => arguments,
        Err(error) => error.exit(),
    };
    let progress = terminal::spinner(format!("computing {}", F::NAME));
    let outcome = run::<F>(&arguments);
    progress.finish_and_clear();
    terminal::finish("table", outcome)
}

/// The figure's command: name, help, examples.
fn command<F: FigureSpec>() -> clap::Command {
    let name = F::NAME;
    Arguments::command()
        .name(name)
        .about(F::TITLE)
        .long_about(format!("{}\n\n{}", F::TITLE, F::ABOUT))
        .after_help(format!(
            "Files written:\n  \
             {name}.svg  the figure\n  \
             {name}.csv  the numbers behind it: id,reading,value,published,unit,agrees and status where rows have one\n  \
             {name}.png  the figure again, with --png\n\n\
             agrees: whether the value is the published one to its printed digits (a statement: whether it holds); NO in the table is\n\
             false in the file, and empty is where the paper says nothing.\n\n\
             Examples:\n  \
             {name}\n  \
             {name} --out-dir build/figures --png"
        ))
}

/// Computes, draws and writes a figure; returns the text for the terminal.
///
/// # Errors
/// Whatever computing, drawing and writing run into. Files are written last, so an error leaves
/// none behind.
pub fn run<F: FigureSpec>(arguments: &Arguments) -> Result<String, FigureError> {
    if arguments.png && !cfg!(feature = "png") {
        // Said before a long computation, not after it.
        return Err(FigureError::PngNotBuilt);
    }
    let claims = Claims::committed()?;
    let data = F::compute()?;
    let rows = F::numbers(&data);
    let svg = F::draw(&data)?;
    let rendered = arguments.png.then(|| ::output::png(&svg)).transpose()?;
    let mut artifacts = vec![
        artifact::<F>("svg", svg.into_bytes()),
        artifact::<F>("csv", rows::csv(&rows, claims)?.into_bytes()),
    ];
    artifacts.extend(rendered.map(|bytes| artifact::<F>("png", bytes)));
    let paths = output::write_all(&arguments.out_dir, &artifacts)?;
    Ok(format!(
        "{}\n\n{}\n{}",
        F::TITLE,
        rows::table(&rows, claims),
        output::listing(&paths)
    ))
}

fn artifact<F: FigureSpec>(extension: &str, bytes: Vec<u8>) -> Artifact {
    Artifact {
        name: format!("{}.{extension}", F::NAME),
        bytes,
    }
}
