//! Error of event times against run time of the compiled solver, and the figure of all solvers.
//! `benches/bench.py` runs it beside the peers.
//!
//! ```text
//! bench PROBLEM                   solver,tolerance,seconds,steps,events, all tolerances
//! bench PROBLEM SOLVER TOLERANCE  kind,time of each event: what is timed as a whole process
//! bench draw TABLE FOLDER         draws report/bench.csv as bench.svg
//! ```

mod figure;
mod problems;

use std::error::Error;
use std::hint::black_box;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use output::Artifact;
use problems::{Event, Problem};
use stickslip::{Method, Options};

/// The solvers.
const SOLVERS: [(&str, Method); 2] = [
    ("stickslip Taylor", Method::Taylor),
    ("stickslip Dop853", Method::Dop853),
];
/// The last one is for series only: rounding limits the accuracy of Runge–Kutta steps.
const TOLERANCES: [f64; 12] = [
    1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-14, 1e-15,
];
/// A time is the mean over as many calls as take this long (s). That is thousands of times the
/// clock's resolution.
const SAMPLE_TIME: f64 = 5e-3;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(|one| &**one).collect();
    let outcome = match arguments[..] {
        ["draw", table, folder] => draw(table, folder),
        [problem] => measure(problem),
        [problem, solver, tolerance] => solve(problem, solver, tolerance),
        _ => Err(
            "give a problem; or problem, solver and tolerance; or draw, table and folder".into(),
        ),
    };
    match outcome {
        Ok(text) => {
            print!("{text}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn measure(name: &str) -> Result<String, Box<dyn Error>> {
    let problem = Problem::named(name)?;
    let mut text = String::from("solver,tolerance,seconds,steps,events\n");
    for (solver, method) in SOLVERS {
        let count = TOLERANCES.len() - usize::from(method == Method::Dop853);
        for tolerance in &TOLERANCES[..count] {
            let options = Options::tol(*tolerance).method(method);
            let (mut events, mut calls, begin) = (Vec::new(), 0_u32, Instant::now());
            let (seconds, steps) = loop {
                let steps = black_box(&problem).solve(black_box(&options), &mut events)?;
                black_box(&events);
                calls += 1;
                let spent = begin.elapsed().as_secs_f64();
                if spent >= SAMPLE_TIME {
                    break (spent / f64::from(calls), steps);
                }
            };
            let events: Vec<String> = events
                .iter()
                .map(|(kind, t)| format!("{kind}@{t:e}"))
                .collect();
            let events = events.join(";");
            text += &format!("{solver},{tolerance:e},{seconds:e},{steps},{events}\n");
        }
    }
    Ok(text)
}

fn solve(name: &str, solver: &str, tolerance: &str) -> Result<String, Box<dyn Error>> {
    let method = SOLVERS.iter().find(|one| one.0 == solver);
    let (_, method) = method.ok_or_else(|| format!("no solver '{solver}'"))?;
    let options = Options::tol(tolerance.parse()?).method(*method);
    let mut events = Vec::new();
    Problem::named(name)?.solve(&options, &mut events)?;
    let line = |(kind, t): &Event| format!("{kind},{t:e}\n");
    Ok(events.iter().map(line).collect())
}

fn draw(table: &str, folder: &str) -> Result<String, Box<dyn Error>> {
    let text = std::fs::read_to_string(table).map_err(|error| format!("{table}: {error}"))?;
    let figure = Artifact::text("bench.svg", figure::draw(&text)?);
    Ok(output::listing(&output::write_all(
        Path::new(folder),
        &[figure],
    )?))
}
