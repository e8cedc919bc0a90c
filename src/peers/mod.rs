//! The program `peers`: work–precision measurements of our solvers and other common ones, on
//! problems with known event times.

mod child;
mod compare;
mod draw;
mod event;
mod measure;
mod measurement;
mod problem;
mod report;

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use clap::{Args, Parser, Subcommand};

use crate::terminal::{self, ProgramError};
use crate::text::joined;
use output::Artifact;

use child::{PeerProcess, not_started};
use event::Event;
use measurement::Measurement;
use problem::{Problem, SOLVERS, Solver, problems};

const ABOUT: &str = "Error of event times against run time, for our solvers and, given a Python \
    that has them, for SciPy, numba, heyoka and pydiffsol, all in one run on one machine.";

const AFTER: &str = "\
Files written:
  bench.csv  solver,problem,setting,tolerance,error,events,median_s,min_s,compile_s,process_s,note
  bench.txt  what is printed: ratios of times at equal error, times of whole processes
  bench.svg  the work-precision figure
  docs/speed.md  its table of speeds, when all problems were measured beside peers \
    into the default folders

An error is the largest of all event times, against references of 30 digits (data/references). \
    A run that finds other events
than the reference has failed, and says so in its note. Times are medians of rounds in \
    which all solvers take turns, warm;
compilation is told separately.

Examples:
  peers
  peers --python target/peers-venv/bin/python
  peers redraw
  peers --rounds 3 --process-rounds 0 --problems decay,forced --report-dir out --figures-dir out";

/// Arguments of the program.
#[derive(Debug, Parser)]
#[command(
    name = "peers",
    version,
    about = ABOUT,
    after_help = AFTER,
    args_conflicts_with_subcommands = true
)]
struct Arguments {
    #[command(subcommand)]
    command: Option<PeersCommand>,

    #[command(flatten)]
    all: MeasureArguments,
}

/// What is done without measuring.
#[derive(Debug, Subcommand)]
enum PeersCommand {
    /// Solve one problem once and print its events: what is timed as a whole process
    One(SolveArguments),
    /// Draw bench.svg anew from bench.csv, without measuring
    Redraw(Folders),
}

/// Where the files are.
#[derive(Debug, Args)]
struct Folders {
    /// Folder for bench.csv and bench.txt; made if it does not exist
    #[arg(long, value_name = "DIR", default_value = "report")]
    pub report_dir: PathBuf,

    /// Folder for bench.svg; made if it does not exist
    #[arg(long, value_name = "DIR", default_value = "figures")]
    pub figures_dir: PathBuf,
}

#[derive(Debug, Args)]
struct SolveArguments {
    /// Problem
    #[arg(long, value_parser = Problem::named)]
    problem: Problem,

    /// Solver
    #[arg(long, default_value = SOLVERS[0].name, value_parser = Solver::named)]
    solver: &'static Solver,

    /// Relative and absolute tolerance
    #[arg(long, default_value_t = 1e-12)]
    tolerance: f64,
}

/// Measuring everything.
#[derive(Debug, Args)]
struct MeasureArguments {
    /// Rounds in which every solver is timed at every setting
    #[arg(
        long,
        value_name = "COUNT",
        default_value_t = 21,
        value_parser = clap::value_parser!(u32).range(1..)
    )]
    pub rounds: u32,

    /// Rounds in which whole processes are timed; 0 to leave them out
    #[arg(long, value_name = "COUNT", default_value_t = 5)]
    pub process_rounds: u32,

    /// Problems of which whole processes are timed
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        default_value = "belt_sensitive,bracket",
        value_parser = Problem::named
    )]
    pub process_problems: Vec<Problem>,

    /// Problems [default: all]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = Problem::named)]
    pub problems: Vec<Problem>,

    /// Python that has the packages of requirements.txt; without it ours alone are measured
    #[arg(long, value_name = "PATH")]
    pub python: Option<PathBuf>,

    /// Folder of peers.py and one.py
    #[arg(long, value_name = "DIR", default_value = "benches/peers")]
    pub scripts: PathBuf,

    /// The problems' numbers, for the peers
    #[arg(
        long,
        value_name = "FILE",
        default_value = "data/references/problems.json"
    )]
    pub numbers: PathBuf,

    /// Where the files go.
    #[command(flatten)]
    pub folders: Folders,
}

/// The program. Exit code 0 on success, 1 on failure, 2 for a wrong command line.
pub fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let outcome = match &arguments.command {
        Some(PeersCommand::One(one)) => solve_one(one),
        Some(PeersCommand::Redraw(folders)) => redraw(folders),
        None => run(&arguments.all),
    };
    terminal::finish("report", outcome)
}

/// Measures, compares, draws and writes; returns the text to print.
///
/// # Errors
/// The error of the step that fails. Files are written last, so an error leaves none behind.
fn run(all: &MeasureArguments) -> Result<String, ProgramError> {
    let chosen = match &all.problems[..] {
        [] => problems()?,
        chosen => chosen.to_vec(),
    };
    // Reported before the long computation.
    terminal::write(&all.folders.report_dir, &[], REPORT_DIR)?;
    terminal::write(&all.folders.figures_dir, &[], FIGURES_DIR)?;
    let start = |python: &PathBuf| PeerProcess::start(python, &all.scripts, &all.numbers);
    let mut peers = all.python.as_ref().map(start).transpose()?;
    let mut versions = Vec::new();
    let mut rows = Vec::new();
    for problem in &chosen {
        terminal::print_note(&format!("measuring {}", problem.name));
        let peers = peers.as_mut();
        rows.extend(measure::problem(problem, all.rounds, peers, &mut versions)?);
    }
    drop(peers);
    if all.process_rounds > 0 {
        terminal::print_note("timing whole processes");
        let ours = std::env::current_exe();
        let ours = ours.map_err(|error| not_started("peers".as_ref(), error))?;
        let is_timed = |row: &Measurement| {
            let mut names = all.process_problems.iter().map(|one| one.name);
            names.any(|name| name == row.problem)
        };
        let command = |row: &Measurement| whole_process_command(all, &ours, row);
        measure::processes(&mut rows, is_timed, all.process_rounds, command)?;
    }
    let names: Vec<&str> = SOLVERS.iter().map(|solver| solver.name).collect();
    let text = report::text(&rows, &names, &head(all, &versions));
    let written = write(all, &rows, &text, &chosen)?;
    Ok(text + &written)
}

/// The command that solves the problem of a row once with its solver, if there is one here.
fn whole_process_command(
    all: &MeasureArguments,
    ours: &Path,
    row: &Measurement,
) -> Option<Command> {
    let mut command;
    if SOLVERS.iter().any(|solver| solver.name == row.solver) {
        command = Command::new(ours);
        command.arg("one");
    } else {
        command = Command::new(all.python.as_ref()?);
        command.arg(all.scripts.join("one.py")).arg(&all.numbers);
        command.args(["--setting", &row.setting]);
    }
    let tolerance = row.tolerance.unwrap_or_default().to_string();
    command.args(["--problem", row.problem, "--solver", &row.solver]);
    command.args(["--tolerance", &tolerance]);
    Some(command)
}

fn head(all: &MeasureArguments, versions: &[(String, String)]) -> String {
    let named = versions
        .iter()
        .map(|(package, number)| format!("{package} {number}"));
    let beside = match versions {
        [] => "no peers: give --python to measure them too".to_owned(),
        _ => format!("beside {}", joined(named, ", ")),
    };
    let (version, rounds) = (env!("CARGO_PKG_VERSION"), all.rounds);
    format!("stickslip {version} {beside}; medians of {rounds} alternating rounds")
}

fn write(
    all: &MeasureArguments,
    rows: &[Measurement],
    text: &str,
    problems: &[Problem],
) -> Result<String, ProgramError> {
    let table = measurement::csv(rows);
    // The rows as the table has them, so that picture and README can be regenerated from it.
    let rows = measurement::read(&table, problems)?;
    let svg = draw::draw(&rows, problems)?;
    let tables = [
        Artifact::text("bench.csv", table),
        Artifact::text("bench.txt", text),
    ];
    let mut paths = terminal::write(&all.folders.report_dir, &tables, REPORT_DIR)?;
    let picture = Artifact::text("bench.svg", svg);
    paths.extend(terminal::write(
        &all.folders.figures_dir,
        &[picture],
        FIGURES_DIR,
    )?);
    // Some of the problems, or our solvers alone, do not make the whole table.
    if all.problems.is_empty() && all.python.is_some() {
        paths.extend(write_page(&all.folders, &rows)?);
    }
    Ok(output::listing(&paths))
}

/// Draws the figure from the table of an earlier run, without measuring again.
fn redraw(folders: &Folders) -> Result<String, ProgramError> {
    let path = folders.report_dir.join("bench.csv");
    let table = std::fs::read_to_string(&path).map_err(|error| {
        let path = path.display();
        format!("cannot read {path}: {error}; choose its folder with --report-dir")
    })?;
    let all = problems()?;
    let rows = measurement::read(&table, &all)?;
    let is_measured = |problem: &Problem| rows.iter().any(|row| row.problem == problem.name);
    let measured: Vec<Problem> = all.into_iter().filter(is_measured).collect();
    let picture = Artifact::text("bench.svg", draw::draw(&rows, &measured)?);
    let mut paths = terminal::write(&folders.figures_dir, &[picture], FIGURES_DIR)?;
    paths.extend(write_page(folders, &rows)?);
    Ok(output::listing(&paths))
}

/// Updates the page of speeds, if the tables are written into the project's own folder.
fn write_page(folders: &Folders, rows: &[Measurement]) -> Result<Vec<PathBuf>, ProgramError> {
    let top = Path::new("");
    let text = std::fs::read_to_string(top.join(SPEED_PAGE)).ok();
    let new = text.and_then(|text| {
        report::SECTION_MARKERS.replace_section(&text, &report::block(rows, OWN_SOLVER))
    });
    match new.filter(|_| folders.report_dir == Path::new(TABLES)) {
        Some(new) => terminal::write(top, &[Artifact::text(SPEED_PAGE, new)], REPORT_DIR),
        None => Ok(Vec::new()),
    }
}

/// The option that chooses the folder of tables. The page of speeds is written only beside those of
/// the project.
const REPORT_DIR: &str = "--report-dir";
/// The option that chooses the folder of the picture.
const FIGURES_DIR: &str = "--figures-dir";
const SPEED_PAGE: &str = "docs/speed.md";
/// The project's folder of tables, and the default of `--report-dir`.
const TABLES: &str = "report";
/// Our solver in the page of speeds.
const OWN_SOLVER: &str = "stickslip Taylor";

fn solve_one(one: &SolveArguments) -> Result<String, ProgramError> {
    let mut events = Vec::new();
    let options = one.solver.options(one.tolerance);
    let ready = one.solver.ready(&one.problem)?;
    ready.solve(&options, &mut events)?;
    let line = |event: &Event| format!("{:?},{:e}\n", event.kind, event.t).to_lowercase();
    Ok(events.iter().map(line).collect())
}
