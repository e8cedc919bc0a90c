//! `stickslip simulate`: an orbit, its phases and its transitions.

use serde_json::{Map, json};
use stickslip::dynamics::{Passage, Section, Summary};
use stickslip::error::{Point, readable};
use stickslip::{Ending, Error};

use super::arguments::{PreparedRun, RunArguments};
use super::recording::{self, KINDS, Occurrence, Recording, direction_name};
use super::trajectory::{self, transitions};
use crate::failure::{Failure, in_words};
use crate::render::{CommandOutput, Report, Table, by_state};
use stickslip_kernels::file::System;

/// Integrate an orbit: phases of slip and stick, transitions, crossings of the section
///
/// Writes phases.csv, transitions.csv, steps.csv (and section.csv, if the file has a section),
/// portrait.svg and history.svg.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Time at the end; default as in the file
    #[arg(long, value_name = "TIME", visible_alias = "until")]
    t_end: Option<f64>,
    #[command(flatten)]
    run: RunArguments,
}

pub(super) fn run(arguments: &Arguments) -> Result<CommandOutput, Failure> {
    arguments
        .run
        .with_report(|prepared| followed(prepared, arguments.t_end))
}

fn followed(prepared: &PreparedRun, t_end: Option<f64>) -> Result<Report, Failure> {
    let PreparedRun {
        system,
        options,
        t,
        x,
    } = prepared;
    let t_end = t_end.or(system.built.t_end).ok_or_else(|| {
        Failure::Usage("the end time is missing; give --t-end, or `end` in [time]".into())
    })?;
    let (recording, outcome) = Recording::of(system, (*t, x), t_end, options);
    let failure = match &outcome {
        // If the run ends at its start, where the future is not unique, there is nothing to draw.
        Ok(ended) if ended.t == *t => {
            let x = Point::from(&ended.x);
            return Err(Error::NoUniqueFuture { t: *t, x }.into());
        }
        Ok(_) => None,
        // The orbit up to an error is written, unless it has no length.
        Err(error) if recording.points.len() > 1 => Some(in_words(error, system)),
        Err(error) => return Err(error.clone().into()),
    };
    let mut report = report(system, &recording, outcome.ok().as_ref());
    trajectory::put(system, &recording, &mut report)?;
    let steps = Table::new()
        .column("t", |at: &&recording::Point| at.t)
        .state(system, "", |at| at.x.clone());
    // Only at the ends of steps is the solution as accurate as the run.
    let ends = recording.points.iter().filter(|point| point.ends_step);
    report.table(steps.csv("steps", ends)?);
    let passages = Table::new()
        .column("t", |at: &&Passage| at.t)
        .column("direction", |at| direction_name(at.direction))
        .state(system, "", |at| at.x.clone());
    if system.section() != Section::None {
        report.table(passages.csv("section", &recording.passages)?);
    }
    report.field("section", passages.json(&recording.passages));
    report.field("error", &failure).failure(failure);
    Ok(report)
}

/// How a run ended, in words.
fn ending(ended: Option<&Summary>) -> &'static str {
    match ended.map(|ended| ended.ending) {
        Some(Ending::EndTime) => "end time",
        Some(Ending::Repelling) => "no unique future: the boundary repels",
        Some(Ending::TwoFold(_)) => "no unique future: a two-fold",
        Some(Ending::Shrunk) => "shrunk to a point of the boundary",
        Some(Ending::Stopped) => "stopped",
        Some(Ending::Failed) | None => "failed",
    }
}

/// The jump that ended the run, if one did.
fn stopped_by(system: &System, recording: &Recording, ended: Option<&Summary>) -> Option<String> {
    ended.filter(|ended| ended.ending == Ending::Stopped)?;
    recording.transitions.last().map(|last| last.of(system))
}

/// Number of transitions of each kind. Contacts, jumps or inputs are counted separately if there
/// are several.
fn counts(system: &System, recording: &Recording) -> Vec<String> {
    let mut counts: Vec<((usize, String), usize)> = Vec::new();
    for at in &recording.transitions {
        let kind = KINDS.iter().position(|kind| *kind == at.kind(system));
        let kind = kind.unwrap_or(KINDS.len());
        let is_of_contact =
            matches!(at, Occurrence::Transition(at) if at.contact < system.contacts());
        let of = match is_of_contact && system.contacts() == 1 {
            true => String::new(),
            false => at.of(system),
        };
        let of = (kind, of);
        match counts.iter_mut().find(|(known, _)| *known == of) {
            Some((_, count)) => *count += 1,
            None => counts.push((of, 1)),
        }
    }
    // A stable sort keeps the order of appearance within a kind.
    counts.sort_by_key(|((kind, _), _)| *kind);
    let words = counts.into_iter().map(|((kind, of), count)| {
        let kind = KINDS.get(kind).copied().unwrap_or_default();
        format!("{count} × {kind} {of}").trim_end().to_owned()
    });
    words.collect()
}

fn report(system: &System, recording: &Recording, ended: Option<&Summary>) -> Report {
    let points = &recording.points;
    let [from, to] =
        [points.first(), points.last()].map(|point| point.map_or(f64::NAN, |point| point.t));
    let (begin, end) = (readable(from), readable(to));
    let (ending, by) = (ending(ended), stopped_by(system, recording, ended));
    let words = by
        .as_ref()
        .map_or(ending.to_owned(), |jump| format!("{ending} by {jump}"));
    let mut report = Report::of(system, format!("t = {begin} to {end} ({words})"));
    report
        .field("t_start", from)
        .field("t_end", to)
        .field("ending", ending)
        .field("stopped_by", by);

    let phases = recording.phases.len();
    report.line("phases", phases).field("phases", phases);

    let counts = counts(system, recording);
    let counts = match &counts[..] {
        [] => "none".to_owned(),
        counts => counts.join(", "),
    };
    report.line("transitions", counts).field(
        "transitions",
        transitions(system).json(&recording.transitions),
    );

    let mut all = Map::new();
    for (number, contact) in system.file.contacts.iter().enumerate() {
        let sticks = recording.sticks_of(number);
        let total = sticks.iter().fold(0.0, |sum, (from, to)| sum + (to - from));
        let name = match system.contacts() {
            1 => String::new(),
            _ => format!(" of {}", contact.name),
        };
        let share = 100.0 * total / (to - from);
        let times = sticks.len();
        report.line(
            "stick",
            format!("{times} times{name}, {total:.6} in all, {share:.1} % of the time"),
        );
        all.insert(contact.name.clone(), json!(sticks));
    }
    report.field("sticks", all);

    // No point is recorded after a jump that ends the run.
    let last = ended.map(|ended| &ended.x);
    let last = last.or(points.last().map(|point| &point.x));
    if let Some(last) = last {
        let states = system.file.states.iter().zip(last);
        let states = states.map(|(state, &x)| format!("{} = {}", state.name, readable(x)));
        let states: Vec<String> = states.collect();
        report.line("state at end", states.join(", "));
    }
    report.field("x_end", last.map(|x| by_state(system, x.as_slice())));

    report.field("doubtful", &recording.doubt);
    report.lines("doubtful", recording.doubt.clone());

    if let Some(ended) = ended {
        let counters = &ended.counters;
        let (steps, rejected, calls) = (counters.steps, counters.rejected, counters.field_calls);
        report.line(
            "work",
            format!("{steps} steps, {rejected} rejected, {calls} calls of the field"),
        );
    }
    report
}
