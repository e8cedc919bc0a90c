//! `stickslip simulate`: an orbit, its phases and its transitions.

use std::fmt::Write;

use serde_json::json;
use stickslip::error::readable;
use stickslip::{Ending, Error, TransitionKind};

use super::arguments::{Ready, RunArguments};
use super::recording::{Recording, kind_name};
use super::told::told;
use super::{Failure, Found, figures, tables};
use crate::terminal::{Patience, Said};
use stickslip_kernels::file::System;
use stickslip_kernels::kernel::{Ended, Run};

/// Follow an orbit: phases of slip and stick, transitions, passages of the section
///
/// Writes phases.csv, transitions.csv, steps.csv (and section.csv, if the file has a section), portrait.svg and history.svg.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Time at the end; default as in the file
    #[arg(long, value_name = "TIME")]
    t_end: Option<f64>,
    #[command(flatten)]
    run: RunArguments,
}

pub(super) fn run(arguments: &Arguments) -> Result<Said, Failure> {
    arguments
        .run
        .answered(|ready| followed(ready, arguments.t_end))
}

fn followed(ready: &Ready, t_end: Option<f64>) -> Result<Found, Failure> {
    let Ready {
        system,
        options,
        t,
        x,
    } = ready;
    let t_end = t_end.or(system.built.t_end).ok_or_else(|| {
        Failure::Usage("when does the run end? Give --t-end, or `end` in [time] of the file".into())
    })?;
    let mut recording = Recording::new(*t, x, t_end, Patience::new("integrating"));
    let run = Run {
        t: *t,
        x,
        t_end,
        options,
    };
    let outcome = system.kernel().run(&run, system.section(), &mut recording);
    recording.close();
    let failure = match &outcome {
        // At a start whose future is not unique there is nothing to draw.
        Ok(ended) if ended.t == *t => {
            let x = stickslip::error::Point(ended.x.clone());
            return Err(Failure::from(Error::NoUniqueFuture { t: *t, x }).of(system));
        }
        Ok(_) => None,
        // What was reached is worth having; where nothing was, there is nothing to write.
        Err(error) if recording.points.len() > 1 => Some(told(error, system)),
        Err(error) => return Err(error.clone().into()),
    };
    found(system, &recording, outcome.ok().as_ref(), failure)
}

fn found(
    system: &System,
    recording: &Recording,
    ended: Option<&Ended>,
    failure: Option<String>,
) -> Result<Found, Failure> {
    let mut tables = vec![
        tables::phases("phases", system, &recording.phases)?,
        tables::transitions("transitions", system, &recording.transitions)?,
        tables::steps("steps", system, recording)?,
    ];
    if system.section().is_some() {
        tables.push(tables::passages("section", system, &recording.passages)?);
    }
    let mut figures = vec![("history".to_owned(), figures::history(system, recording)?)];
    if system.states() > 1 {
        figures.push(("portrait".to_owned(), figures::portrait(system, recording)?));
    }
    Ok(Found {
        summary: summary(system, recording, ended),
        json: json(system, recording, ended, failure.as_deref()),
        tables,
        figures,
        failure,
    })
}

/// How a run ended, in words.
fn ending(ended: Option<&Ended>) -> &'static str {
    match ended.map(|ended| ended.ending) {
        Some(Ending::EndTime) => "end time",
        Some(Ending::Repelling) => "no unique future: the boundary repels",
        Some(Ending::TwoFold(_)) => "no unique future: a two-fold",
        Some(Ending::Shrunk) => "shrunk to a point of the boundary",
        Some(Ending::Stopped) => "stopped",
        Some(Ending::Failed) | None => "failed",
    }
}

/// Transition kinds in the order in which they are counted.
const KINDS: [TransitionKind; 6] = [
    TransitionKind::StickEntry,
    TransitionKind::StickExit,
    TransitionKind::Crossing,
    TransitionKind::Touch,
    TransitionKind::ContactLoss,
    TransitionKind::ContactGain,
];

fn count(recording: &Recording, kind: TransitionKind) -> usize {
    let transitions = recording.transitions.iter();
    transitions.filter(|at| at.kind == kind).count()
}

fn span(recording: &Recording) -> (f64, f64) {
    let time = |point: Option<&super::recording::Point>| point.map_or(f64::NAN, |point| point.t);
    (
        time(recording.points.first()),
        time(recording.points.last()),
    )
}

fn summary(system: &System, recording: &Recording, ended: Option<&Ended>) -> String {
    let (from, to) = span(recording);
    let mut text = format!(
        "{}: t = {} to {} ({})\n",
        system.file.name,
        readable(from),
        readable(to),
        ending(ended)
    );
    let transitions: Vec<String> = KINDS
        .iter()
        .map(|&kind| (kind, count(recording, kind)))
        .filter(|&(_, count)| count > 0)
        .map(|(kind, count)| format!("{count} × {}", kind_name(kind)))
        .collect();
    let transitions = if transitions.is_empty() {
        "none".to_owned()
    } else {
        transitions.join(", ")
    };
    // Writing into a text cannot fail.
    let _ = writeln!(text, "  phases       {}", recording.phases.len());
    let _ = writeln!(text, "  transitions  {transitions}");
    for (number, contact) in system.file.contacts.iter().enumerate() {
        let sticks = recording.sticks_of(number);
        let total = sticks.iter().fold(0.0, |sum, (from, to)| sum + (to - from));
        let name = if system.contacts() == 1 {
            String::new()
        } else {
            format!(" of {}", contact.name)
        };
        let share = 100.0 * total / (to - from);
        let _ = writeln!(
            text,
            "  stick        {} times{name}, {total:.6} in all, {share:.1} % of the time",
            sticks.len()
        );
    }
    if let Some(last) = recording.points.last() {
        let states = system.file.states.iter().zip(&last.x);
        let states: Vec<String> = states
            .map(|(state, &x)| format!("{} = {}", state.name, readable(x)))
            .collect();
        let _ = writeln!(text, "  state at end {}", states.join(", "));
    }
    if let Some(ended) = ended {
        let counters = &ended.counters;
        let _ = writeln!(
            text,
            "  work         {} steps, {} rejected, {} calls of the field",
            counters.steps, counters.rejected, counters.field_calls
        );
    }
    text
}

fn json(
    system: &System,
    recording: &Recording,
    ended: Option<&Ended>,
    failure: Option<&str>,
) -> serde_json::Value {
    let (from, to) = span(recording);
    let contacts = system.file.contacts.iter().enumerate();
    let sticks: serde_json::Map<String, serde_json::Value> = contacts
        .map(|(number, contact)| (contact.name.clone(), json!(recording.sticks_of(number))))
        .collect();
    let transitions = recording.transitions.iter().map(|at| {
        json!({
            "t": at.t,
            "kind": kind_name(at.kind),
            "contact": tables::contact_name(system, at.contact),
            "from": tables::letters(&at.from),
            "to": tables::letters(&at.to),
            "x": tables::state_json(system, &at.x),
        })
    });
    let transitions: Vec<serde_json::Value> = transitions.collect();
    let passages = recording.passages.iter();
    let passages: Vec<serde_json::Value> = passages
        .map(|at| json!({ "t": at.t, "x": tables::state_json(system, &at.x) }))
        .collect();
    let end = recording
        .points
        .last()
        .map(|point| tables::state_json(system, &point.x));
    json!({
        "system": tables::system_json(system),
        "t_start": from,
        "t_end": to,
        "ending": ending(ended),
        "error": failure,
        "x_end": end,
        "phases": recording.phases.len(),
        "transitions": transitions,
        "sticks": sticks,
        "section": passages,
    })
}
