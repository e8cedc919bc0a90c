//! The command line shared by all figure programs.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser};

use super::{FigureSpec, curves, rows};
use crate::paper::published::Claims;
use crate::terminal::{self, ProgramError};
use output::Artifact;
use output::terminal::with_spinner;

const OPTION: &str = "--out-dir";

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

/// A figure program: parses the command line, computes, draws, writes the files and prints the
/// numbers.
///
/// Exit code 0 on success, 1 on failure (`error: …` on standard error), 2 for a wrong command line.
pub fn main<D>(figure: &FigureSpec<D>) -> ExitCode {
    let matches = command(figure).get_matches();
    let arguments = match Arguments::from_arg_matches(&matches) {
        Ok(arguments) => arguments,
        Err(error) => error.exit(),
    };
    let what = format!("computing {}", figure.name);
    terminal::finish(with_spinner(&what, |_| run(figure, &arguments)))
}

/// The figure's command: name, help, examples.
fn command<D>(figure: &FigureSpec<D>) -> clap::Command {
    let name = figure.name;
    Arguments::command()
        .name(name)
        .about(figure.title)
        .long_about(format!("{}\n\n{}", figure.title, figure.about))
        .after_help(format!(
            "Files written:\n  \
             {name}.svg  the figure\n  \
             {name}.csv  the numbers behind it: id,reading,value,published,unit,agrees\n\
             \x20            and status where rows have one\n  \
             {name}.png  the figure again, with --png\n  \
             curves/{name}.csv  the curves in it, with the axes of each panel\n\n\
             agrees: whether the value is the published one to its printed digits (a statement: \
             whether it holds).\n\
             NO in the table is false in the file. It is empty where the paper says nothing.\n\n\
             Examples:\n  \
             {name}\n  \
             {name} --out-dir build/figures --png"
        ))
}

/// Computes, draws and writes a figure; returns the text for the terminal.
///
/// # Errors
/// The error of the step that fails. Files are written last, so an error leaves none behind, but
/// perhaps an empty folder.
pub fn run<D>(figure: &FigureSpec<D>, arguments: &Arguments) -> Result<String, ProgramError> {
    if arguments.png && !cfg!(feature = "png") {
        // Reported before the long computation.
        let remedy = "cargo build -p stickslip-replication --features png";
        let built = "this program was built without PNG output";
        return Err(format!("{built}; rebuild it with `{remedy}`").into());
    }
    // So is a folder that cannot be written to.
    terminal::write(&arguments.out_dir, &[], OPTION)?;
    let claims = Claims::committed()?;
    let data = figure.compute()?;
    let rows = (figure.numbers)(&data);
    let picture = (figure.draw)(&data)?;
    let svg = picture.render()?;
    let rendered = arguments.png.then(|| output::png(&svg)).transpose()?;
    let name = |extension| format!("{}.{extension}", figure.name);
    let mut artifacts = vec![
        Artifact::text(name("svg"), svg),
        Artifact::text(name("csv"), rows::csv(&rows, claims)),
    ];
    let curves = [Artifact::text(name("csv"), curves::table(&picture))];
    artifacts.extend(rendered.map(|bytes| Artifact {
        name: name("png"),
        bytes,
    }));
    let mut paths = terminal::write(&arguments.out_dir, &artifacts, OPTION)?;
    let folder = arguments.out_dir.join("curves");
    paths.extend(terminal::write(&folder, &curves, OPTION)?);
    Ok(format!(
        "{}\n\n{}\n{}",
        figure.title,
        rows::table(&rows, claims),
        output::listing(&paths)
    ))
}
