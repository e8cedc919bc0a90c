//! Errors once, times in alternating rounds.

use std::hint::black_box;
use std::process::{Command, Stdio};
use std::time::Instant;

use super::child::{Answer, Peers};
use super::compare::most_accurate;
use super::error::PeersError;
use super::event::{Event, error};
use super::problem::{Problem, SOLVERS, Solver};
use super::row::Row;
use crate::numbers::median;

/// A sample is the mean over as many calls as take this long (s), thousands of times the clock's
/// resolution.
const BATCH: f64 = 5e-3;
/// A row that has taken longer than this (s) gets no further rounds once it has `ENOUGH`: a median
/// of three leaves an outlier out.
const PATIENCE: f64 = 10.0;
const ENOUGH: usize = 3;

/// Who is timed for a row.
enum Timed {
    Ours(&'static Solver, f64),
    Theirs(usize),
    Nobody,
}

/// Everything measured on one problem but whole processes, one after the other in every round.
///
/// # Errors
/// A problem without reference, peers that do not answer. A solver that fails on a problem only
/// gets a note.
pub fn problem(
    problem: &Problem,
    rounds: u32,
    peers: Option<&mut Peers>,
    versions: &mut Vec<(String, String)>,
) -> Result<Vec<Row>, PeersError> {
    let reference = problem.reference()?;
    let mut entries = ours(problem, &reference)?;
    let mut peers = peers;
    if let Some(peers) = &mut peers {
        for answer in peers.ask(&format!("prepare {}", problem.name))? {
            match answer {
                Answer::Version(package, number) => versions.push((package, number)),
                Answer::Curve(index, row, events) => {
                    let row = judged(row, &events, &reference);
                    entries.push((row, Timed::Theirs(index)));
                }
                Answer::Cannot(row) => entries.push((row, Timed::Nobody)),
                Answer::Seconds(..) | Answer::Done => {}
            }
        }
    }
    for _ in 0..rounds {
        for (row, timed) in &mut entries {
            let spent: f64 = row.seconds.iter().map(|seconds| seconds.max(BATCH)).sum();
            if row.seconds.len() >= ENOUGH && spent > PATIENCE {
                continue;
            }
            row.seconds.push(match (&timed, &mut peers) {
                (Timed::Ours(solver, tolerance), _) => time(problem, solver, *tolerance)?,
                (Timed::Theirs(index), Some(peers)) => peers.time(*index, BATCH)?,
                _ => continue,
            });
        }
    }
    let named = |(row, _)| Row {
        problem: problem.name,
        ..row
    };
    Ok(entries.into_iter().map(named).collect())
}

fn ours(problem: &Problem, reference: &[Event]) -> Result<Vec<(Row, Timed)>, PeersError> {
    let mut entries = Vec::new();
    for solver in SOLVERS {
        let ready = solver.ready(problem)?;
        for &tolerance in solver.tolerances {
            let row = Row {
                solver: solver.name.into(),
                setting: "rtol = atol".into(),
                tolerance: Some(tolerance),
                // Compiled before it ever started.
                compile: Some(0.0),
                ..Row::default()
            };
            let mut events = Vec::new();
            let solved = ready.solve(&solver.options(tolerance), &mut events);
            entries.push(match solved {
                Ok(()) => {
                    let timed = Timed::Ours(solver, tolerance);
                    (judged(row, &events, reference), timed)
                }
                Err(error) => {
                    let note = format!("failed: {error}");
                    (Row { note, ..row }, Timed::Nobody)
                }
            });
        }
    }
    Ok(entries)
}

/// The row with its events compared with those of the reference.
fn judged(mut row: Row, events: &[Event], reference: &[Event]) -> Row {
    row.events = Some(events.len());
    match error(events, reference) {
        Ok(error) => row.error = Some(error),
        Err(note) => row.note = note,
    }
    row
}

/// Seconds per run of ours.
fn time(problem: &Problem, solver: &Solver, tolerance: f64) -> Result<f64, PeersError> {
    let (ready, options) = (solver.ready(problem)?, solver.options(tolerance));
    let mut events = Vec::new();
    let begin = Instant::now();
    let mut calls = 0_u32;
    loop {
        black_box(&ready).solve(black_box(&options), &mut events)?;
        black_box(&events);
        calls += 1;
        let spent = begin.elapsed().as_secs_f64();
        if spent >= BATCH {
            return Ok(spent / f64::from(calls));
        }
    }
}

/// Times whole processes, each of which starts, compiles and solves once, for the most accurate row
/// of every solver, in alternation.
///
/// # Errors
/// [`PeersError::Start`], [`PeersError::Process`].
pub fn processes(
    rows: &mut [Row],
    is_timed: impl Fn(&Row) -> bool,
    rounds: u32,
    command: impl Fn(&Row) -> Option<Command>,
) -> Result<(), PeersError> {
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

fn time_process(command: &mut Command) -> Result<f64, PeersError> {
    let begin = Instant::now();
    let status = command
        .stdout(Stdio::null())
        .status()
        .map_err(|source| PeersError::Start {
            program: command.get_program().into(),
            source,
        })?;
    let spent = begin.elapsed().as_secs_f64();
    if status.success() {
        Ok(spent)
    } else {
        let command = format!("{command:?}");
        Err(PeersError::Process { command, status })
    }
}
