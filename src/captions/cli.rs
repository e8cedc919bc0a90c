//! The program `captions`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;

use super::{DRAWS, compute, rows};
use crate::figures::block_and_bracket::SETS;
use crate::terminal::{self, ProgramError};
use crate::text::joined;
use output::Artifact;
use output::terminal::DelayedProgressBar;

const ABOUT: &str = "Moves each number of the captions of Figs. 10-12 within the rounding of its \
    last decimal and computes exponents and class again, 200 times a figure.";

/// Arguments of the program.
#[derive(Debug, Parser)]
#[command(name = "captions", version, about = ABOUT)]
pub struct Arguments {
    /// Folder for captions.csv; made if it does not exist
    #[arg(
        long,
        value_name = "DIR",
        default_value = "golden",
        visible_alias = "out"
    )]
    pub out_dir: PathBuf,
}

/// The program. Exit code 0 on success, 1 on failure, 2 for a wrong command line.
pub fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let bar = DelayedProgressBar::new("{bar:40} {pos}/{len} spectra, {elapsed}");
    let outcome = run(&arguments, &|| bar.one_more(rows()));
    bar.clear();
    terminal::finish(outcome)
}

fn run(arguments: &Arguments, tick: &(dyn Fn() + Sync)) -> Result<String, ProgramError> {
    // An unwritable folder is reported before the long computation.
    terminal::write(&arguments.out_dir, &[], "--out-dir")?;
    let table = compute(tick)?;
    let file = Artifact::text("captions.csv", table.csv());
    let paths = terminal::write(&arguments.out_dir, &[file], "--out-dir")?;
    let mut text = String::new();
    for (figure, set) in SETS.iter().enumerate() {
        let classes = table.classes(figure).into_iter();
        let classes = joined(
            classes.map(|(class, count)| format!("{class} {count}")),
            ", ",
        );
        text += &format!("{}: of {DRAWS} draws {classes}\n", set.figure.name());
        for k in 0..4 {
            let Some(budget) = table.budget(figure, k) else {
                continue;
            };
            let (least, largest, solver) = (budget.least, budget.largest, budget.solver);
            text += &format!(
                "  lambda {} from {least:.5} to {largest:.5}; solver {solver:.1e}\n",
                k + 1
            );
        }
    }
    Ok(format!("{text}\n{}", output::listing(&paths)))
}
