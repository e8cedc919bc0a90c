//! Errors are measured once, times in alternating rounds.

use std::hint::black_box;
use std::process::{Command, Stdio};
use std::time::Instant;

use super::child::{Answer, PeerProcess, not_started};
use super::compare::most_accurate;
use super::event::{Event, event_time_error};
use super::measurement::Measurement;
use super::problem::{Problem, SOLVERS, Solver};
use crate::numbers::median;
use crate::terminal::ProgramError;

/// A sample is the mean over as many calls as take this long (s). That is thousands of times the
/// clock's resolution.
const SAMPLE_TIME: f64 = 5e-3;
/// A row that has taken longer than this (s) gets no further rounds once it has
/// [`LEAST_ROUNDS`]. The limit keeps a whole measurement within minutes.
const ROW_TIME: f64 = 10.0;
/// A median of three excludes an outlier.
const LEAST_ROUNDS: usize = 3;

/// The solver that is timed for a row.
enum TimedSolver {
    Ours(&'static Solver, f64),
    Theirs(usize),
    Nobody,
}

/// All measurements on one problem except whole processes. The solvers alternate in every round.
///
/// # Errors
/// A problem without reference; peers that do not answer. If a solver fails on a problem, its row
/// gets a note.
pub fn problem(
    problem: &Problem,
    rounds: u32,
    peers: Option<&mut PeerProcess>,
    versions: &mut Vec<(String, String)>,
) -> Result<Vec<Measurement>, ProgramError> {
    let reference = problem.reference()?;
    let mut entries = ours(problem, &reference)?;
    let mut peers = peers;
    if let Some(peers) = &mut peers {
        for answer in peers.ask(&format!("prepare {}", problem.name))? {
            match answer {
                Answer::Version(package, number) => versions.push((package, number)),
                Answer::Curve(index, row, events) => {
                    let row = with_error(row, &events, &reference);
                    entries.push((row, TimedSolver::Theirs(index)));
                }
                Answer::Cannot(row) => entries.push((row, TimedSolver::Nobody)),
                Answer::Seconds(..) | Answer::Done => {}
            }
        }
    }
    for _ in 0..rounds {
        for (row, timed) in &mut entries {
            let spent: f64 = row
                .seconds
                .iter()
                .map(|seconds| seconds.max(SAMPLE_TIME))
                .sum();
            if row.seconds.len() >= LEAST_ROUNDS && spent > ROW_TIME {
                continue;
            }
            row.seconds.push(match (&timed, &mut peers) {
                (TimedSolver::Ours(solver, tolerance), _) => time(problem, solver, *tolerance)?,
                (TimedSolver::Theirs(index), Some(peers)) => peers.time(*index, SAMPLE_TIME)?,
                _ => continue,
            });
        }
    }
    let named = |(row, _)| Measurement {
        problem: problem.name,
        ..row
    };
    Ok(entries.into_iter().map(named).collect())
}

fn ours(
    problem: &Problem,
    reference: &[Event],
) -> Result<Vec<(Measurement, TimedSolver)>, ProgramError> {
    let mut entries = Vec::new();
    for solver in SOLVERS {
        let ready = solver.ready(problem)?;
        for &tolerance in solver.tolerances {
            let row = Measurement {
                solver: solver.name.into(),
                setting: "rtol = atol".into(),
                tolerance: Some(tolerance),
                // Compiled in advance.
                compile: Some(0.0),
                ..Measurement::default()
            };
            let mut events = Vec::new();
            let solved = ready.solve(&solver.options(tolerance), &mut events);
            entries.push(match solved {
                Ok(()) => {
                    let timed = TimedSolver::Ours(solver, tolerance);
                    (with_error(row, &events, reference), timed)
                }
                Err(error) => {
                    let note = format!("failed: {error}");
                    (Measurement { note, ..row }, TimedSolver::Nobody)
                }
            });
        }
    }
    Ok(entries)
}

/// The row with the error of its events against those of the reference.
fn with_error(mut row: Measurement, events: &[Event], reference: &[Event]) -> Measurement {
    row.events = Some(events.len());
    match event_time_error(events, reference) {
        Ok(error) => row.error = Some(error),
        Err(note) => row.note = note,
    }
    row
}

/// Seconds per run of our solver.
fn time(problem: &Problem, solver: &Solver, tolerance: f64) -> Result<f64, ProgramError> {
    let (ready, options) = (solver.ready(problem)?, solver.options(tolerance));
    let mut events = Vec::new();
    let begin = Instant::now();
    let mut calls = 0_u32;
    loop {
        black_box(&ready).solve(black_box(&options), &mut events)?;
        black_box(&events);
        calls += 1;
        let spent = begin.elapsed().as_secs_f64();
        if spent >= SAMPLE_TIME {
            return Ok(spent / f64::from(calls));
        }
    }
}

/// Times whole processes in alternation, for the most accurate row of every solver. Each process
/// starts, compiles and solves once.
///
/// # Errors
/// A process that cannot be started or fails.
pub fn processes(
    rows: &mut [Measurement],
    is_timed: impl Fn(&Measurement) -> bool,
    rounds: u32,
    command: impl Fn(&Measurement) -> Option<Command>,
) -> Result<(), ProgramError> {
    let mut best = most_accurate(rows);
    best.retain(|&i| is_timed(&rows[i]) && rows[i].error.is_some());
    let mut samples = vec![Vec::new(); best.len()];
    for _ in 0..rounds {
        for (samples, &i) in samples.iter_mut().zip(&best) {
            if let Some(mut command) = command(&rows[i]) {
                samples.push(time_process(&mut command)?);
            }
        }
    }
    for (samples, i) in samples.iter().zip(best) {
        rows[i].process = median(samples);
    }
    Ok(())
}

fn time_process(command: &mut Command) -> Result<f64, ProgramError> {
    let begin = Instant::now();
    let status = command
        .stdout(Stdio::null())
        .status()
        .map_err(|error| not_started(command.get_program(), error))?;
    let spent = begin.elapsed().as_secs_f64();
    match status.success() {
        true => Ok(spent),
        false => {
            Err(format!("'{command:?}' failed with {status}; run it by hand to see why").into())
        }
    }
}
