//! The peers: a process that solves the same problems with other people's solvers and answers line
//! by line, so that rounds of theirs and of ours alternate.
//!
//! Commands, one a line: `prepare PROBLEM`, `time INDEX SECONDS`. Answers, any number of lines and
//! then `done`: `version,PACKAGE,NUMBER` (to the first command),
//! `curve,INDEX,SOLVER,SETTING,TOLERANCE,COMPILE_S,EVENTS`,
//! `cannot,SOLVER,SETTING,TOLERANCE,REASON`, and to the second `seconds,INDEX,PER_CALL`.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use super::error::PeersError;
use super::event::Event;
use super::row::Row;

/// A line of an answer.
#[derive(Clone, Debug, PartialEq)]
pub enum Answer {
    /// A package in use, and its version.
    Version(String, String),
    /// A solver with a setting, run once: the number by which it is timed, its row as far as it is
    /// known, the events it found.
    Curve(usize, Row, Vec<Event>),
    /// A solver that cannot solve the problem, or did not.
    Cannot(Row),
    /// Time of a call (s), and of which curve.
    Seconds(usize, f64),
    /// End of the answer.
    Done,
}

/// Reads a line.
///
/// # Errors
/// What is wrong with it, in words.
pub fn parse(line: &str) -> Result<Answer, String> {
    let cells = |count: usize| -> Result<Vec<&str>, String> {
        let cells: Vec<&str> = line.splitn(count, ',').collect();
        let found = cells.len();
        let is_due = (found == count).then_some(cells);
        is_due.ok_or_else(|| format!("{count} cells are due, there are {found}"))
    };
    match line.split(',').next() {
        Some("version") => {
            let cells = cells(3)?;
            Ok(Answer::Version(cells[1].into(), cells[2].into()))
        }
        Some("curve") => {
            let cells = cells(7)?;
            let row = Row {
                solver: cells[2].into(),
                setting: cells[3].into(),
                tolerance: Some(positive(cells[4])?),
                compile: Some(seconds(cells[5])?),
                ..Row::default()
            };
            let events = cells[6].split(';').filter(|event| !event.is_empty());
            let events = events.map(str::parse).collect::<Result<_, _>>()?;
            Ok(Answer::Curve(index(cells[1])?, row, events))
        }
        Some("cannot") => {
            let cells = cells(5)?;
            let tolerance = (!cells[3].is_empty()).then(|| positive(cells[3]));
            Ok(Answer::Cannot(Row {
                solver: cells[1].into(),
                setting: cells[2].into(),
                tolerance: tolerance.transpose()?,
                note: cells[4].into(),
                ..Row::default()
            }))
        }
        Some("seconds") => {
            let cells = cells(3)?;
            Ok(Answer::Seconds(index(cells[1])?, positive(cells[2])?))
        }
        Some("done") if line == "done" => Ok(Answer::Done),
        _ => Err("it is neither version, curve, cannot, seconds nor done".into()),
    }
}

fn index(text: &str) -> Result<usize, String> {
    text.parse().map_err(|_| format!("'{text}' is no index"))
}

fn positive(text: &str) -> Result<f64, String> {
    let allowed = Some(number(text)?).filter(|value| *value > 0.0);
    allowed.ok_or_else(|| format!("{text} is not greater than 0"))
}

fn seconds(text: &str) -> Result<f64, String> {
    let allowed = Some(number(text)?).filter(|value| *value >= 0.0);
    allowed.ok_or_else(|| format!("{text} s is a time before its start"))
}

fn number(text: &str) -> Result<f64, String> {
    let value = text.parse().ok().filter(|value: &f64| value.is_finite());
    value.ok_or_else(|| format!("'{text}' is no finite number"))
}

/// The running process; it ends when this is dropped.
#[derive(Debug)]
pub struct Peers {
    child: Child,
    input: Option<ChildStdin>,
    output: BufReader<ChildStdout>,
    line: usize,
}

impl Peers {
    /// Starts `python` with the script `peers.py` in `scripts`; the problems are read from
    /// `problems`.
    ///
    /// # Errors
    /// [`PeersError::Start`].
    pub fn start(python: &Path, scripts: &Path, problems: &Path) -> Result<Self, PeersError> {
        let failed = |source| PeersError::Start {
            program: python.to_owned(),
            source,
        };
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
        Ok(Peers {
            child,
            input: Some(input),
            output: BufReader::new(output),
            line: 0,
        })
    }

    /// Sends a command and returns the answer.
    ///
    /// # Errors
    /// [`PeersError::Ended`], [`PeersError::Answer`].
    pub fn ask(&mut self, command: &str) -> Result<Vec<Answer>, PeersError> {
        let ended = |cause: String| PeersError::Ended {
            command: command.into(),
            cause,
        };
        if let Some(input) = &mut self.input {
            writeln!(input, "{command}")
                .and_then(|()| input.flush())
                .map_err(|error| ended(error.to_string()))?;
        }
        let mut answers = Vec::new();
        loop {
            let mut text = String::new();
            let read = self.output.read_line(&mut text);
            if read.map_err(|error| ended(error.to_string()))? == 0 {
                return Err(ended("it closed its output".into()));
            }
            self.line += 1;
            let text = text.trim_end();
            match parse(text) {
                Ok(Answer::Done) => return Ok(answers),
                Ok(answer) => answers.push(answer),
                Err(cause) => return Err(self.wrong(text.into(), cause)),
            }
        }
    }

    /// Time of a call of a curve (s), from as many calls as take about `batch` seconds.
    ///
    /// # Errors
    /// As [`Peers::ask`].
    pub fn time(&mut self, curve: usize, batch: f64) -> Result<f64, PeersError> {
        let command = format!("time {curve} {batch}");
        match self.ask(&command)?[..] {
            [Answer::Seconds(index, seconds)] if index == curve => Ok(seconds),
            ref other => {
                let cause = format!("one line 'seconds,{curve},…' is due");
                Err(self.wrong(format!("{other:?}"), cause))
            }
        }
    }

    fn wrong(&self, text: String, cause: String) -> PeersError {
        let line = self.line;
        PeersError::Answer { line, text, cause }
    }
}

impl Drop for Peers {
    fn drop(&mut self) {
        // The end of its input is its sign to leave.
        self.input = None;
        if self.child.wait().is_err() {
            // It is gone already; there is nobody to tell.
        }
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
    fn what_is_no_answer_is_refused_with_its_fault() {
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
