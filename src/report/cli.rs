//! The program `report`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;

use super::ledger::{Ledger, TICKS};
use super::page::{Report, page};
use super::{draw, readme, tables};
use crate::paper::published::Claims;
use crate::terminal::{self, ProgramError};
use output::terminal::DelayedProgressBar;
use output::{Artifact, listing};

const ABOUT: &str = "Judges every claim of the paper by computation: values under each reading, \
    digits in agreement, verdict, evidence; the matrix of the listing's defects, its convergence, \
    a scan of parameters, the misprints.";

const AFTER: &str = "\
Files written:
  report/index.html        the report, one file that needs nothing else; open it in a browser
  report/claims.csv        every claim with its readings, verdict, evidence and cause
  figures/convergence.svg  the listing as printed for smaller and smaller steps, and .csv
  figures/scan.svg         where starts lead as each parameter of Fig. 8 is changed, and .csv
  README.md                its verdicts, where the folder has a README.md with the marks for it

Exit codes: 0 done, 1 something failed, 2 wrong command line.

Examples:
  report
  report --out-dir build";

/// Arguments of the program.
#[derive(Debug, Parser)]
#[command(name = "report", version, about = ABOUT, after_help = AFTER)]
pub struct Arguments {
    /// Folder in which the folders report and figures are; made if they do not exist
    #[arg(long, value_name = "DIR", default_value = ".", visible_alias = "out")]
    pub out_dir: PathBuf,
}

/// The program. Exit code 0 on success, 1 on failure, 2 for a wrong command line.
pub fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let bar = DelayedProgressBar::new("{bar:40} {pos}/{len} {elapsed}");
    let outcome = run(&arguments, &|| bar.one_more(TICKS as u64));
    bar.clear();
    terminal::finish(outcome.map(|(_, text)| text))
}

/// Computes, writes the files, and returns the ledger and the text for the terminal.
///
/// # Errors
/// That of the part that fails. Folders are created first, so that an unwritable one is reported
/// before the computation. Files are written last.
pub fn run(
    arguments: &Arguments,
    tick: &(dyn Fn() + Sync),
) -> Result<(Ledger, String), ProgramError> {
    // Reported before the long computation.
    for folder in FOLDERS {
        terminal::write(&arguments.out_dir.join(folder), &[], OPTION)?;
    }
    let ledger = Ledger::compute(tick)?;
    let written = write(&ledger, &arguments.out_dir)?;
    let text = summary(&ledger) + &written;
    Ok((ledger, text))
}

/// Draws and writes everything, and lists the files written.
fn write(ledger: &Ledger, folder: &Path) -> Result<String, ProgramError> {
    let published = Claims::committed()?.published_stick_numbers();
    let convergence = draw::convergence(&ledger.convergence, published)?;
    let scan = draw::scan(&ledger.scan)?;
    let figures = [
        Artifact::text("convergence.svg", &*convergence.svg),
        Artifact::text("convergence.csv", tables::convergence(ledger)),
        Artifact::text("scan.svg", &*scan.svg),
        Artifact::text("scan.csv", tables::scan(ledger)),
    ];
    let report = Report {
        ledger,
        convergence,
        scan,
    };
    let pages = [
        Artifact::text("claims.csv", tables::claims(ledger)),
        Artifact::text("index.html", page(&report)),
    ];
    let mut paths = terminal::write(&folder.join(FOLDERS[1]), &figures, OPTION)?;
    if let Some(readme) = new_readme(folder, ledger) {
        let readme = Artifact::text(README, readme);
        paths.extend(terminal::write(folder, &[readme], OPTION)?);
    }
    paths.extend(terminal::write(&folder.join(FOLDERS[0]), &pages, OPTION)?);
    Ok(listing(&paths))
}

/// The folders of the pages and of the figures.
const FOLDERS: [&str; 2] = ["report", "figures"];
const README: &str = "README.md";
/// The option that chooses their folder.
const OPTION: &str = "--out-dir";

/// The README with the present table; `None` if there is no README or it lacks the marks.
fn new_readme(folder: &Path, ledger: &Ledger) -> Option<String> {
    let readme = std::fs::read_to_string(folder.join(README)).ok()?;
    readme::SECTION_MARKERS.replace_section(&readme, &readme::block(ledger))
}

fn summary(ledger: &Ledger) -> String {
    let mut text = format!("{} claims counted\n", ledger.counted());
    for (verdict, count) in ledger.counts() {
        text += &format!("{count:>5} {verdict}\n");
    }
    let read = ledger.errata.iter().filter(|one| one.by_reading.is_some());
    let read = read.count();
    let shown = ledger.errata.iter().filter(|one| one.holds).count() - read;
    text += &format!(
        "\n{}\n\n{}\n\n{}\n\n{} misprints and defects, {shown} borne out by computation, \
         {read} by reading\n\n",
        ledger.matrix.sentence(),
        ledger.convergence.sentence(),
        ledger.scan.sentence(),
        ledger.errata.len()
    );
    text
}
