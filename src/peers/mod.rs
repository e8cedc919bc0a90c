//! The program `peers`: work and precision of our solvers beside other common ones, on problems
//! with known event times.

mod child;
mod compare;
mod draw;
mod error;
mod event;
mod measure;
mod problem;
mod report;
mod row;

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use clap::{Args, Parser, Subcommand};

use crate::terminal;
use crate::text::joined;
use output::Artifact;

use child::Peers;
use error::PeersError;
use event::Event;
use problem::{Problem, SOLVERS, Solver, problems};
use row::Row;

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
    command: Option<Single>,

    #[command(flatten)]
    all: All,
}

/// What is done without measuring.
#[derive(Debug, Subcommand)]
enum Single {
    /// Solve one problem once and print its events: what is timed as a whole process
    One(One),
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
struct One {
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
struct All {
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

/// Everything the program does. Exit code 0 on success, 1 if something failed, 2 for a wrong
/// command line.
pub fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let outcome = match &arguments.command {
        Some(Single::One(one)) => solve_one(one),
        Some(Single::Redraw(folders)) => redraw(folders),
        None => run(&arguments.all),
    };
    terminal::finish("report", outcome)
}

/// Measures, compares, draws and writes; returns the text to print.
///
/// # Errors
/// Whatever one of these runs into. Files are written last, so an error leaves none behind.
fn run(all: &All) -> Result<String, PeersError> {
    let chosen = match &all.problems[..] {
        [] => problems()?,
        chosen => chosen.to_vec(),
    };
    // Reported before the long computation.
    for folder in [&all.folders.report_dir, &all.folders.figures_dir] {
        output::write_all(folder, &[])?;
    }
    let start = |python: &PathBuf| Peers::start(python, &all.scripts, &all.numbers);
    let mut peers = all.python.as_ref().map(start).transpose()?;
    let mut versions = Vec::new();
    let mut rows = Vec::new();
    for problem in &chosen {
        terminal::note(&format!("measuring {}", problem.name));
        let peers = peers.as_mut();
        rows.extend(measure::problem(problem, all.rounds, peers, &mut versions)?);
    }
    drop(peers);
    if all.process_rounds > 0 {
        terminal::note("timing whole processes");
        let ours = std::env::current_exe().map_err(|source| PeersError::Start {
            program: "peers".into(),
            source,
        })?;
        let is_timed = |row: &Row| {
            let mut names = all.process_problems.iter().map(|one| one.name);
            names.any(|name| name == row.problem)
        };
        let command = |row: &Row| once(all, &ours, row);
        measure::processes(&mut rows, is_timed, all.process_rounds, command)?;
    }
    let names: Vec<&str> = SOLVERS.iter().map(|solver| solver.name).collect();
    let text = report::text(&rows, &names, &head(all, &versions));
    let written = write(all, &rows, &text, &chosen)?;
    Ok(text + &written)
}

/// The process that solves the problem of a row once by its solver, if there is one here.
fn once(all: &All, ours: &Path, row: &Row) -> Option<Command> {
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

fn head(all: &All, versions: &[(String, String)]) -> String {
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

fn write(all: &All, rows: &[Row], text: &str, problems: &[Problem]) -> Result<String, PeersError> {
    let table = row::csv(rows);
    // From the digits that the table has, so that picture and README can be written from it again.
    let rows = row::read(&table, problems)?;
    let svg = draw::draw(&rows, problems)?;
    let tables = [
        Artifact::text("bench.csv", table),
        Artifact::text("bench.txt", text),
    ];
    let mut paths = output::write_all(&all.folders.report_dir, &tables)?;
    let picture = Artifact::text("bench.svg", svg);
    paths.extend(output::write_all(&all.folders.figures_dir, &[picture])?);
    // A part of the problems, or ours alone, says nothing of the table there.
    if all.problems.is_empty() && all.python.is_some() {
        paths.extend(write_page(&all.folders, &rows)?);
    }
    Ok(output::listing(&paths))
}

/// The figure from the table of an earlier run: after a change of the drawing nothing need be
/// measured again.
fn redraw(folders: &Folders) -> Result<String, PeersError> {
    let path = folders.report_dir.join("bench.csv");
    let table = std::fs::read_to_string(&path).map_err(|source| PeersError::Input {
        path: path.clone(),
        source,
    })?;
    let all = problems()?;
    let rows = row::read(&table, &all)?;
    let is_measured = |problem: &Problem| rows.iter().any(|row| row.problem == problem.name);
    let measured: Vec<Problem> = all.into_iter().filter(is_measured).collect();
    let picture = Artifact::text("bench.svg", draw::draw(&rows, &measured)?);
    let mut paths = output::write_all(&folders.figures_dir, &[picture])?;
    paths.extend(write_page(folders, &rows)?);
    Ok(output::listing(&paths))
}

/// The page of speeds gets the measurements that are written into the project's own folder of
/// tables.
fn write_page(folders: &Folders, rows: &[Row]) -> Result<Vec<PathBuf>, PeersError> {
    let top = Path::new("");
    let text = std::fs::read_to_string(top.join(SPEED_PAGE)).ok();
    let new = text.and_then(|text| report::MARKS.put(&text, &report::block(rows, OURS)));
    match new.filter(|_| folders.report_dir == Path::new(TABLES)) {
        Some(new) => Ok(output::write_all(top, &[Artifact::text(SPEED_PAGE, new)])?),
        None => Ok(Vec::new()),
    }
}

const SPEED_PAGE: &str = "docs/speed.md";
/// Where the project keeps its tables, and the default of `--report-dir`.
const TABLES: &str = "report";
/// The solver of ours that the page of speeds compares with.
const OURS: &str = "stickslip Taylor";

fn solve_one(one: &One) -> Result<String, PeersError> {
    let mut events = Vec::new();
    let options = one.solver.options(one.tolerance);
    let ready = one.solver.ready(&one.problem)?;
    ready.solve(&options, &mut events)?;
    let line = |event: &Event| format!("{:?},{:e}\n", event.kind, event.t).to_lowercase();
    Ok(events.iter().map(line).collect())
}
