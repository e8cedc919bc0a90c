//! `stickslip simulate`: an orbit, its phases and its transitions.

use std::path::PathBuf;

use serde_json::{Map, json};
use stickslip::dynamics::{Passage, RunMemory, Summary};
use stickslip::error::{Point, readable};
use stickslip::{Ending, Error};

use super::arguments::{PreparedRun, RunArguments};
use super::derivatives;
use super::recording::{KINDS, Recording, Row, Wanted, direction_name, kind_of, source_of};
use super::resume::End;
use super::starts;
use super::trajectory::{self, numbered, transitions};
use crate::failure::{Failure, in_words};
use crate::render::{CommandOutput, Report, Table, by_state};
use stickslip_model::file::System;

/// Integrate an orbit: phases of slip and stick, transitions, crossings of the section
///
/// Writes phases.csv, transitions.csv, steps.csv (and section.csv, if the file has a section),
/// portrait.svg, history.svg, and end.json, from which --resume goes on if the run reached its end.
/// With --starts the tables are those of all orbits, and there is no end.json.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Time at the end; default as in the file
    #[arg(long, value_name = "TIME", visible_alias = "until")]
    t_end: Option<f64>,
    /// Go on from the end of another run: its end.json, or the folder with it
    ///
    /// System and options are those of that run, and the end is later. The end has the bits of a
    /// single run.
    #[arg(long, value_name = "PATH", conflicts_with_all = ["start", "t_start"])]
    resume: Option<PathBuf>,
    /// Follow an orbit from each row of a table, whose columns are states and parameters by name
    ///
    /// States that are no column start as they do without the table. orbits.csv has the end of each
    /// orbit, and the other tables have a column `orbit`, counted from 1. An orbit that fails keeps
    /// the others. No figures are drawn.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["resume", "derivatives"])]
    starts: Option<String>,
    /// Also write the derivatives of states and times of events by these parameters, start values
    /// of states, or the time of the start, which is t0: derivatives.csv, with a row for each of
    /// steps.csv, event_derivatives.csv, with one for each transition, and section_derivatives.csv
    #[arg(long, value_name = "NAME,...", conflicts_with = "resume")]
    derivatives: Option<String>,
    /// Draw no figures
    #[arg(long)]
    no_figures: bool,
    /// Write no steps.csv
    #[arg(long)]
    no_steps: bool,
    /// Also write and draw a formula of states, parameters, inputs, time, reactions of stops and
    /// friction of contacts, as in --observe "heat = belt.force*v": a column of steps.csv and a
    /// panel of history.svg. Repeatable. The reactions themselves are there without it
    #[arg(long, value_name = "NAME=FORMULA")]
    observe: Vec<String>,
    #[command(flatten)]
    run: RunArguments,
}

pub(super) fn run(arguments: &Arguments) -> Result<CommandOutput, Failure> {
    if let Some(file) = &arguments.starts {
        let with = (&*observed(arguments)?, !arguments.no_steps);
        return starts::run(&arguments.run, file, arguments.t_end, with);
    }
    let Some(path) = &arguments.resume else {
        return arguments
            .run
            .with_report(|prepared| followed(prepared, arguments, None));
    };
    let system = arguments.run.system()?;
    let options = arguments.run.solver.options(&system)?;
    let memory = End::read(path, &system, &options)?;
    let prepared = PreparedRun {
        system,
        options,
        t: memory.t(),
        x: memory.x().iter().copied().collect(),
    };
    arguments.run.with_report_of(&prepared, |prepared| {
        followed(prepared, arguments, Some(memory))
    })
}

/// The end of a run, as given or as in the file.
pub(super) fn end_time(system: &System, given: Option<f64>) -> Result<f64, Failure> {
    given.or(system.built.t_end).ok_or_else(|| {
        Failure::Usage("the end time is missing; give --t-end, or `end` in [time]".into())
    })
}

/// Names and formulas of what is observed.
fn observed(arguments: &Arguments) -> Result<Vec<(&str, &str)>, Failure> {
    let has_pictures = !arguments.no_figures && arguments.starts.is_none();
    if let Some(text) = arguments.observe.first()
        && arguments.no_steps
        && !has_pictures
    {
        return Err(Failure::Usage(format!(
            "--observe {text} has no effect: neither steps nor pictures are written; leave \
             --no-steps out"
        )));
    }
    let observed = arguments.observe.iter();
    let observed = observed.map(|text| match text.split_once('=') {
        Some((name, formula)) => Ok((name.trim(), formula.trim())),
        None => Err(Failure::Usage(format!(
            "--observe {text}: write a name and a formula, as in --observe \"power = v*f\""
        ))),
    });
    observed.collect()
}

fn followed(
    prepared: &PreparedRun,
    arguments: &Arguments,
    from: Option<RunMemory>,
) -> Result<Report, Failure> {
    let PreparedRun {
        system,
        options,
        t,
        x,
    } = prepared;
    let t_end = end_time(system, arguments.t_end)?;
    // A jump may end the run earlier.
    if system.file.jumps.iter().all(|jump| jump.most.is_none()) {
        options.check_span(*t, t_end)?;
    }
    let by = arguments.derivatives.as_ref();
    let by = by
        .map(|list| derivatives::variables(system, list))
        .transpose()?;
    let wanted = Wanted {
        figures: !arguments.no_figures,
        steps: !arguments.no_steps,
        progress: true,
    };
    let quantities = system.quantities(&observed(arguments)?)?;
    let (from, start) = (from.as_ref(), (*t, &x[..]));
    let varied = by.as_ref().map(|by| by.of(system)).transpose()?;
    let with = (from, varied.as_ref());
    let (mut recording, outcome) =
        Recording::of(system, start, t_end, options, wanted, with, quantities);
    let failure = match &outcome {
        // If the run ends at its start, where the future is not unique, there is nothing to draw.
        Ok(ended) if ended.t == *t => {
            let x = Point::from(&ended.x);
            return Err(Error::NoUniqueFuture { t: *t, x }.into());
        }
        Ok(_) => None,
        // The orbit up to an error is written, unless it has no length.
        Err(error) if recording.orbit.end.t > *t => Some(in_words(error, system)),
        Err(error) => return Err(error.clone().into()),
    };
    let lists = arguments.run.output.json;
    let words = ending(outcome.as_ref().ok()).to_owned();
    let mut report = report(system, &recording, outcome.ok().as_ref(), lists);
    trajectory::put(system, &recording, &mut report)?;
    if let Some((variables, found)) = by.as_ref().zip(recording.derivatives.as_ref()) {
        derivatives::put(system, (variables, found), &recording, &mut report)?;
    }
    let end = (&recording.orbit.end, words);
    let end = End::of(system, options, end, recording.memory.take());
    report.table(end.artifact()?);
    if wanted.steps {
        let names = recording.quantities.0.clone();
        let steps = Table::new()
            .column("t", |(t, ..): &Row<'_>| *t)
            .state(system, "", |(_, x, _)| x.to_vec())
            .many("quantities", names, |(.., quantities)| quantities.to_vec());
        report.table(steps.csv("steps", recording.rows())?);
    }
    let passages = passage_columns(system, false);
    let rows = || recording.orbit.passages.iter().map(|at| (0, at));
    if !system.sections().is_empty() {
        report.table(passages.csv("section", rows())?);
    }
    if lists {
        report.field("section", passages.json(rows()));
    }
    report.field("error", &failure).failure(failure);
    Ok(report)
}

/// The columns of passages of the section, each with the number of its orbit.
pub(super) fn passage_columns<'a>(
    system: &System,
    is_numbered: bool,
) -> Table<'a, (usize, &'a Passage)> {
    numbered(is_numbered, |&(orbit, _): &(usize, &Passage)| orbit)
        .column("t", |(_, at)| at.t)
        .column("direction", |(_, at)| direction_name(at.direction))
        .state(system, "", |(_, at)| at.x.clone())
}

/// Words for the end of a run.
pub(super) fn ending(ended: Option<&Summary>) -> &'static str {
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
    recording
        .orbit
        .events
        .last()
        .map(|last| source_of(system, last))
}

/// Number of transitions of each kind. Contacts, jumps or inputs are counted separately if there
/// are several.
fn counts(system: &System, recording: &Recording) -> Vec<String> {
    let mut counts: Vec<((usize, String), usize)> = Vec::new();
    for at in &recording.orbit.events {
        let kind = KINDS.iter().position(|kind| *kind == kind_of(system, at));
        let kind = kind.unwrap_or(KINDS.len());
        let transition = at.transition();
        let is_of_contact = transition.is_some_and(|at| at.contact < system.contacts());
        let of = match is_of_contact && system.contacts() == 1 {
            true => String::new(),
            false => source_of(system, at),
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

/// The report; its lists are for programs, and take much memory where a run is long.
fn report(system: &System, recording: &Recording, ended: Option<&Summary>, lists: bool) -> Report {
    let (from, to) = (recording.orbit.start.t, recording.orbit.end.t);
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

    let phases = recording.orbit.phases.len();
    report.line("phases", phases).field("phases", phases);

    let counts = counts(system, recording);
    let counts = match &counts[..] {
        [] => "none".to_owned(),
        counts => counts.join(", "),
    };
    report.line("transitions", counts);
    if lists {
        let rows = recording.orbit.events.iter().map(|at| (0, at));
        let list = transitions(system, false).json(rows);
        report.field("transitions", list);
    }

    let mut all = Map::new();
    for (number, contact) in system.file.contacts.iter().enumerate() {
        let sticks = recording.orbit.sticks_of(number);
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
        if lists {
            all.insert(contact.name.clone(), json!(sticks));
        }
    }
    report.field("sticks", all);

    // No point is recorded after a jump that ends the run.
    let last = ended.map_or(&recording.orbit.end.x, |ended| &ended.x);
    let states = system.file.states.iter().zip(last);
    let states = states.map(|(state, &x)| format!("{} = {}", state.name, readable(x)));
    let states: Vec<String> = states.collect();
    report.line("state at end", states.join(", "));
    report.field("x_end", by_state(system, last.as_slice()));

    report.field("doubtful", &recording.doubtful);
    report.lines("doubtful", recording.doubtful.clone());

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
