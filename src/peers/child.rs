//! A process that solves the same problems with other solvers. It answers line by line, so that
//! rounds of both programs alternate.
//!
//! Commands, one per line: `prepare PROBLEM`, `time INDEX SECONDS`. An answer is any number of
//! lines and then `done`. The first command is answered by `version,PACKAGE,NUMBER`,
//! `curve,INDEX,SOLVER,SETTING,TOLERANCE,COMPILE_S,EVENTS` and
//! `cannot,SOLVER,SETTING,TOLERANCE,REASON`; the second by `seconds,INDEX,PER_CALL`.

use std::ffi::OsStr;
use std::fmt::Display;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use super::event::Event;
use super::measurement::Measurement;
use crate::terminal::ProgramError;

/// A line of an answer.
#[derive(Clone, Debug, PartialEq)]
pub enum Answer {
    /// A package in use and its version.
    Version(String, String),
    /// A solver with a setting, run once: the index by which it is timed, its row so far, and its
    /// events.
    Curve(usize, Measurement, Vec<Event>),
    /// A solver that cannot solve the problem, or failed.
    Cannot(Measurement),
    /// Index of a curve and time of a call (s).
    Seconds(usize, f64),
    /// End of the answer.
    Done,
}

/// Parses a line.
///
/// # Errors
/// A description of the fault.
pub fn parse(line: &str) -> Result<Answer, String> {
    let count = match line.split(',').next() {
        Some("version" | "seconds") => 3,
        Some("cannot") => 5,
        Some("curve") => 7,
        _ => 1,
    };
    let cells: Vec<&str> = line.splitn(count, ',').collect();
    match cells[..] {
        ["version", package, number] => Ok(Answer::Version(package.into(), number.into())),
        ["curve", index, solver, setting, tolerance, compile, events] => {
            let row = Measurement {
                solver: solver.into(),
                setting: setting.into(),
                tolerance: Some(positive(tolerance)?),
                compile: Some(number(
                    compile,
                    |s| s >= 0.0,
                    " s is a time before its start",
                )?),
                ..Measurement::default()
            };
            let events = events.split(';').filter(|event| !event.is_empty());
            let events = events.map(str::parse).collect::<Result<_, _>>()?;
            Ok(Answer::Curve(parse_index(index)?, row, events))
        }
        ["cannot", solver, setting, tolerance, reason] => {
            let tolerance = (!tolerance.is_empty()).then(|| positive(tolerance));
            Ok(Answer::Cannot(Measurement {
                solver: solver.into(),
                setting: setting.into(),
                tolerance: tolerance.transpose()?,
                note: reason.into(),
                ..Measurement::default()
            }))
        }
        ["seconds", index, seconds] => Ok(Answer::Seconds(parse_index(index)?, positive(seconds)?)),
        ["done"] => Ok(Answer::Done),
        _ if count == 1 => Err("it is neither version, curve, cannot, seconds nor done".into()),
        _ => {
            let given = cells.len();
            Err(format!("{count} cells are due, there are {given}"))
        }
    }
}

fn parse_index(text: &str) -> Result<usize, String> {
    text.parse().map_err(|_| format!("'{text}' is no index"))
}

fn positive(text: &str) -> Result<f64, String> {
    number(text, |value| value > 0.0, " is not greater than 0")
}

/// A finite number that is allowed, or a description of the fault.
fn number(text: &str, is_allowed: fn(f64) -> bool, fault: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && is_allowed(value) => Ok(value),
        Ok(value) if value.is_finite() => Err(format!("{text}{fault}")),
        _ => Err(format!("'{text}' is no finite number")),
    }
}

/// The running process. It ends when this is dropped.
#[derive(Debug)]
pub struct PeerProcess {
    child: Child,
    input: Option<ChildStdin>,
    output: BufReader<ChildStdout>,
    line: usize,
}

impl PeerProcess {
    /// Starts `python` with the script `peers.py` in `scripts`. The problems are read from
    /// `problems`.
    ///
    /// # Errors
    /// A program that cannot be started.
    pub fn start(python: &Path, scripts: &Path, problems: &Path) -> Result<Self, ProgramError> {
        let failed = |error| not_started(python.as_os_str(), error);
        let mut child = Command::new(python)
            .arg(scripts.join("peers.py"))
            .arg(problems)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(failed)?;
        let no_pipe = || failed(std::io::Error::other("no pipe to it"));
        let input = child.stdin.take().ok_or_else(no_pipe)?;
        let output = child.stdout.take().ok_or_else(no_pipe)?;
        Ok(PeerProcess {
            child,
            input: Some(input),
            output: BufReader::new(output),
            line: 0,
        })
    }

    /// Sends a command and returns the answer.
    ///
    /// # Errors
    /// A process that ends; a line that is no answer.
    pub fn ask(&mut self, command: &str) -> Result<Vec<Answer>, ProgramError> {
        let ended = |cause: &dyn Display| {
            format!(
                "the peers' process ended while '{command}' was under way ({cause}); its own \
                 message stands above"
            )
        };
        if let Some(input) = &mut self.input {
            writeln!(input, "{command}")
                .and_then(|()| input.flush())
                .map_err(|error| ended(&error))?;
        }
        let mut answers = Vec::new();
        loop {
            let mut text = String::new();
            let read = self.output.read_line(&mut text);
            if read.map_err(|error| ended(&error))? == 0 {
                return Err(ended(&"it closed its output").into());
            }
            self.line += 1;
            let text = text.trim_end();
            match parse(text) {
                Ok(Answer::Done) => return Ok(answers),
                Ok(answer) => answers.push(answer),
                Err(cause) => return Err(self.malformed_answer(text, &cause)),
            }
        }
    }

    /// Time of a call of a curve (s), averaged over as many calls as take about `batch` seconds.
    ///
    /// # Errors
    /// As [`PeerProcess::ask`].
    pub fn time(&mut self, curve: usize, batch: f64) -> Result<f64, ProgramError> {
        let command = format!("time {curve} {batch}");
        match self.ask(&command)?[..] {
            [Answer::Seconds(index, seconds)] if index == curve => Ok(seconds),
            ref other => {
                let cause = format!("one line 'seconds,{curve},…' is due");
                Err(self.malformed_answer(&format!("{other:?}"), &cause))
            }
        }
    }

    fn malformed_answer(&self, text: &str, cause: &str) -> ProgramError {
        format!(
            "line {} of the peers' process, '{text}': {cause}",
            self.line
        )
        .into()
    }
}

/// The message on a program that cannot be started.
pub fn not_started(program: &OsStr, error: std::io::Error) -> ProgramError {
    let (program, remedy) = (program.display(), "leave it out to measure without peers");
    format!("cannot start {program}: {error}; check --python, or {remedy}").into()
}

impl Drop for PeerProcess {
    fn drop(&mut self) {
        // The process exits at the end of its input.
        self.input = None;
        // If it has already exited, the error does not matter.
        let _ = self.child.wait();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_are_read() {
        let curve = parse("curve,3,heyoka,tol,1e-9,0.25,entry@0.5;exit@1.25");
        let Ok(Answer::Curve(3, row, events)) = curve else {
            panic!("{curve:?}");
        };
        assert_eq!((row.tolerance, row.compile), (Some(1e-9), Some(0.25)));
        assert_eq!((events.len(), events[1].t), (2, 1.25));
        let reason = parse("cannot,diffsol,tsit45,,no, it cannot");
        let Ok(Answer::Cannot(row)) = reason else {
            panic!("{reason:?}");
        };
        assert_eq!((row.tolerance, row.note.as_str()), (None, "no, it cannot"));
        assert_eq!(parse("done"), Ok(Answer::Done));
    }

    #[test]
    fn a_malformed_answer_is_refused_with_its_fault() {
        for (line, fault) in [
            (
                "curve,3,heyoka,tol,1e-9,0.25",
                "7 cells are due, there are 6",
            ),
            ("curve,3,heyoka,tol,tight,0.25,entry@0.5", "'tight'"),
            ("curve,x,heyoka,tol,1e-9,0.25,entry@0.5", "'x' is no index"),
            ("curve,3,heyoka,tol,1e-9,-1,entry@0.5", "-1 s"),
            ("curve,3,heyoka,tol,1e-9,0.25,entry@half", "'half'"),
            ("seconds,3,nan", "'nan'"),
            ("seconds,3,0", "greater than 0"),
            ("Traceback (most recent call last):", "neither"),
            ("done,", "neither"),
            ("", "neither"),
        ] {
            let said = parse(line).unwrap_err();
            assert!(said.contains(fault), "{line}: {said}");
        }
    }
}
