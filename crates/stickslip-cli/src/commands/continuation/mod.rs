//! `stickslip continue`: a periodic orbit followed along a parameter.

mod branch;
mod curves;
mod equilibria;
mod figure;
mod saving;

use std::num::NonZeroUsize;

use serde::Serialize;
use serde_json::{Value, json};
use stickslip::analysis::{ContinuationSettings, Special, SpecialPoint, Stop};
use stickslip_kernels::file::System;
use stickslip_kernels::kernel::Change;
use stickslip_kernels::study::{BranchEnd, BranchOrbit, WholeBranch};

use super::arguments::{Ready, RunArguments, SolverArguments, StartArguments, count};
use super::attractors::family_words;
use super::changes;
use super::range::ParameterRange;
use super::search::SearchArguments;
use super::sweeping::{folder, plan};
use crate::failure::{Failure, in_words};
use crate::render::{Answer, Report, Table, explained, place, rounded, within};
use crate::sweep::{Share, Writer};
use crate::terminal::patiently;
use branch::{Begin, Other};

/// Continue a periodic orbit or an equilibrium along a parameter, stable or not, through folds and
/// changes of its phases
///
/// The orbit is located at the parameter's present value, of the file or of --set, and followed
/// both ways by pseudo-arclength. A place is located and named where a multiplier is 1 or -1 or a
/// pair is on the unit circle, and where the phases change. So is an end of the branch in an
/// equilibrium, on the boundary or off it, a two-fold, a homoclinic orbit, or a motion at rest. The
/// period of a drive may depend on the parameter.
///
/// With --also, each of these places but branch points is followed in two parameters. With
/// --branches, the tables have a column `branch`: 0 is the branch through the orbit, and the others
/// are in the order of where they begin. The column `branches` of special.csv has the numbers of
/// those that begin at an orbit, or says that none was found.
///
/// With --equilibrium, the equilibrium that the run comes to is followed, into the sliding field
/// and out of it, too. Folds, branch points, Hopf bifurcations and boundary equilibria are located.
///
/// Writes branch.csv, special.csv and continue.svg; with --also curves.csv and curves.svg; with
/// --equilibrium equilibria.csv, equilibria-special.csv and equilibria.svg. The branch is saved in
/// sweep/ as it is followed, and so is each curve and each other branch when it is complete: after
/// a kill the same command goes on from there, and --also or --branches added to a finished command
/// use what is saved.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The parameter and the range in which the branch is followed
    #[arg(long, value_name = "NAME=LOW:HIGH")]
    parameter: String,

    /// A second parameter and its range: each fold, flip, Neimark-Sacker bifurcation and change of
    /// the phases on the branch is followed in both
    #[arg(long, value_name = "NAME=LOW:HIGH")]
    also: Option<String>,

    /// Follow the branches that begin at flips, of twice the period, and at branch points, too
    #[arg(long)]
    branches: bool,

    /// First and longest step, as a part of the range and of the orbit's size
    #[arg(long, value_name = "PART", default_value_t = 0.02)]
    step: f64,

    /// Orbits on the branch, at most this many each way
    #[arg(long, value_name = "NUMBER", value_parser = count, default_value = "1000")]
    points: NonZeroUsize,

    /// Follow the equilibrium that the run comes to, or with --transient 0 the one near the start
    #[arg(long, conflicts_with_all = ["also", "branches", "periods", "longest"])]
    equilibrium: bool,

    #[command(flatten)]
    search: SearchArguments,
    #[command(flatten)]
    run: RunArguments,
}

pub(super) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    let ready = arguments.run.ready()?;
    if arguments.equilibrium {
        return arguments.run.answered(|ready| equilibria(arguments, ready));
    }
    let found = found(arguments, &ready).map_err(|failure| failure.of(&ready.system));
    let (report, writer) = found?;
    Ok(report.written(&writer.store.staging()?, &arguments.run.output)?)
}

/// Range of the parameter, and settings of the continuation.
fn settings(
    arguments: &Arguments,
    system: &System,
) -> Result<(ParameterRange, ContinuationSettings), Failure> {
    let range = ParameterRange::new("--parameter", &arguments.parameter, system)?;
    let settings = ContinuationSettings {
        step: arguments.step,
        most_points: arguments.points.get(),
        ..ContinuationSettings::over(range.low, range.high)
    };
    settings.check()?;
    Ok((range, settings))
}

fn equilibria(arguments: &Arguments, ready: &Ready) -> Result<Report, Failure> {
    let (system, options) = (&ready.system, &ready.options);
    let (range, settings) = settings(arguments, system)?;
    let begin = Begin::at(system, &range)?;
    let x = arguments.search.equilibrium(system, &ready.x, options)?;
    let branches = begin.equilibria(&x, &settings, options)?;
    equilibria::report(system, &range, branches)
}

/// Everything that the branch depends on, except the system.
#[derive(Serialize)]
struct Wanted<'a> {
    parameter: &'a ParameterRange,
    step: f64,
    points: NonZeroUsize,
    search: &'a SearchArguments,
    start: &'a StartArguments,
    solver: &'a SolverArguments,
}

/// Number of directions along the branch. Each is saved in a block.
const WAYS: NonZeroUsize = NonZeroUsize::MIN.saturating_add(1);

fn found(arguments: &Arguments, ready: &Ready) -> Result<(Report, Writer), Failure> {
    let Ready {
        system, options, ..
    } = ready;
    let (range, settings) = settings(arguments, system)?;
    let begin = Begin::at(system, &range)?;
    let also = arguments.also.as_deref();
    let also = also.map(|text| ParameterRange::new("--also", text, system));
    let also = also.transpose()?;
    let also = also.map(|other| begin.also(other)).transpose()?;
    let wanted = Wanted {
        parameter: &range,
        step: arguments.step,
        points: arguments.points,
        search: &arguments.search,
        start: &arguments.run.start,
        solver: &arguments.run.solver,
    };
    let plan = plan("continue", &wanted, (WAYS, NonZeroUsize::MIN), system)?;
    let folder = folder(&arguments.run.output.out);
    Writer::check(&folder, &plan)?;
    let (orbit, periods) = arguments
        .search
        .periodic_orbit(system, (ready.t, &ready.x), options)?;
    let writer = Writer::open(&folder, &plan, Share::WHOLE)?;
    let branch = patiently("following the branch", |status| {
        begin.branch((&orbit, periods), &settings, options, (&writer, status))
    })?;
    let others = arguments.branches.then(|| {
        patiently("following the other branches", |_| {
            begin.others((&orbit, periods), &branch, (&settings, options), &writer)
        })
    });
    let others = others.transpose()?;
    let (name, points) = (&range.name, &branch.points);
    let orbits = points.len();
    let what = format!(
        "{orbits} periodic orbits over {name} from {} to {}",
        range.low, range.high
    );
    let mut report = Report::of(system, what);
    report
        .field("parameter", &range)
        .field("points", orbits)
        .field("family_dimension", orbit.family);
    if let Some(BranchOrbit { orbit, .. }) = points.get(branch.first) {
        let [at, period] = [orbit.parameter, orbit.period].map(rounded);
        let phases = explained(system, &orbit.sequence);
        let phases = phases.map_or(String::new(), |phases| format!(", phases {phases}"));
        let stability = orbit.stability();
        report.note(format!(
            "begun at {name} = {at}: period {period}, {stability}{phases}"
        ));
    }
    if orbit.family > 0 {
        let family = family_words(orbit.family);
        report.note(format!(
            "it is {family}; at each value the one nearest to that before is followed"
        ));
    }
    for at in &branch.special {
        let (at, what) = (place(at.parameter, at.uncertainty), words(at, system));
        report.note(format!("at {name} = {at}: {what}"));
    }
    let special: Vec<Value> = branch.special.iter().map(|at| json(at, system)).collect();
    report.field("special", special);

    let ends = branch
        .stops
        .each_ref()
        .map(|stop| End::of(stop, system, name));
    let last = [points.first(), points.last()];
    let mut objects = Vec::new();
    for ((last, end), way) in last.into_iter().zip(&ends).zip(["downwards", "upwards"]) {
        if let Some(BranchOrbit { orbit, .. }) = last {
            let (stability, at, words) = (orbit.stability(), rounded(orbit.parameter), &end.words);
            report.note(format!(
                "begun {way}, {stability} at its last orbit ({name} = {at}), it ends {words}"
            ));
        }
        let mut object = json!({
            "parameter": last.map(|last| last.orbit.parameter),
            "stop": end.stop,
            "error": null,
            "flip": null,
            "hopf": null,
            "boundary_equilibrium": null,
            "two_fold": null,
            "homoclinic": null,
        });
        if let Some((key, value)) = &end.detail {
            object[key] = value.clone();
        }
        objects.push(object);
    }
    report.field("ends", objects);

    if let Some(others) = &others {
        let objects = others.iter().map(|other| {
            let (note, object) = told(other, &branch, system, name);
            report.note(note);
            object
        });
        let objects: Vec<Value> = objects.collect();
        report.field("branches", objects);
    }

    let is_numbered = others.is_some();
    let others = others.unwrap_or_default();
    let found = others.iter().filter_map(|other| other.branch.as_ref());
    let found = found.map(|(_, branch)| branch);
    let branches: Vec<&WholeBranch> = std::iter::once(&branch).chain(found).collect();
    let numbered = || branches.iter().copied().enumerate();
    let points = numbered().flat_map(|(k, one)| one.points.iter().map(move |at| (k, at)));
    let points: Vec<(usize, &BranchOrbit)> = points.collect();
    report.table(columns(system, name, (is_numbered, &points)).csv("branch", &points)?);
    let rows = numbered().flat_map(|(k, one)| {
        let others = if k == 0 { &others[..] } else { &[] };
        rows((k, one), others, system, name)
    });
    report.table(special_columns(system, name, is_numbered).csv("special", rows)?);
    report.figure("continue", &figure::diagram(system, &range, &branches))?;
    if let Some(also) = also {
        let curves = patiently("following the special orbits in two parameters", |_| {
            let how = (&settings, options);
            begin.curves(&also, (&orbit, periods), &branch, how, &writer)
        })?;
        curves::report(&mut report, system, &range, &also, &curves)?;
    }
    Ok((report, writer))
}

/// Name of the fact that no branch was found where one begins.
const NOT_FOUND: &str = "not found";

/// A branch that begins at another branch, in words and as a JSON object.
fn told(
    Other { from, branch }: &Other,
    main: &WholeBranch,
    system: &System,
    name: &str,
) -> (String, Value) {
    let at = main.special.get(*from);
    let begin = at.map_or_else(String::new, |at| {
        let place = place(at.parameter, at.uncertainty);
        format!(" from the {} at {name} = {place}", what(at))
    });
    let Some((number, branch)) = branch else {
        let note = format!("no branch{begin} was found; a shorter --step may lead to one");
        let object = json!({
            "branch": null,
            "from": from,
            "points": 0,
            "parameter": null,
            "special": [],
            "stop": NOT_FOUND,
        });
        return (note, object);
    };
    let [_, stop] = &branch.stops;
    let end = End::of(stop, system, name);
    let last = branch.points.last();
    let of_last = last.map_or_else(String::new, |BranchOrbit { orbit, .. }| {
        let [at, period] = [orbit.parameter, orbit.period].map(rounded);
        let stability = orbit.stability();
        format!(", {stability} at its last orbit ({name} = {at}, period {period})")
    });
    let orbits = branch.points.len();
    let words = &end.words;
    let special: Vec<Value> = branch.special.iter().map(|at| json(at, system)).collect();
    let mut object = json!({
        "branch": number,
        "from": from,
        "points": orbits,
        "parameter": last.map(|last| last.orbit.parameter),
        "special": special,
        "stop": end.stop,
    });
    if let Some((key, value)) = end.detail {
        object[key] = value;
    }
    let note = format!("branch {number}{begin}: {orbits} orbits{of_last}; it ends {words}");
    (note, object)
}

/// Rows of the special orbits of branch `number`, at which other branches may begin. Ends that are
/// bifurcations come before and after them.
fn rows(
    (number, branch): (usize, &WholeBranch),
    others: &[Other],
    system: &System,
    name: &str,
) -> Vec<Row> {
    let [first, last] = branch
        .stops
        .each_ref()
        .map(|stop| End::of(stop, system, name));
    let special = branch.special.iter().enumerate().map(|(k, at)| Row {
        branches: begins(others.iter().filter(|other| other.from == k)),
        ..Row::of(at, system)
    });
    let rows = first.row(0).into_iter().chain(special);
    let rows = rows.chain(last.row(branch.points.len()));
    rows.map(|row| Row {
        branch: number,
        ..row
    })
    .collect()
}

/// The numbers of branches that begin at one place, or that none was found.
fn begins<'a>(others: impl Iterator<Item = &'a Other>) -> String {
    let numbers = others.map(|other| match &other.branch {
        Some((number, _)) => number.to_string(),
        None => NOT_FOUND.to_owned(),
    });
    numbers.collect::<Vec<String>>().join(" ")
}

/// The change of the phases at a special orbit, if it is one.
fn change(at: &SpecialPoint) -> Option<Change> {
    match &at.what {
        Special::Sequence(change) => Some(Change::from(&**change)),
        _ => None,
    }
}

/// Name of a special orbit.
fn what(at: &SpecialPoint) -> String {
    change(at).map_or_else(|| at.what.to_string(), |change| change.name())
}

/// A special orbit in words.
fn words(at: &SpecialPoint, system: &System) -> String {
    if let Some(angle) = angle(at) {
        return format!("{}, angle {}", what(at), rounded(angle));
    }
    let Some(change) = change(at) else {
        return what(at);
    };
    let name = changes::words(system, &change);
    match changes::phases(system, &change) {
        Some([before, after]) if !before.is_empty() && !after.is_empty() => {
            format!("{name}, between phases {before} and {after}")
        }
        _ => name,
    }
}

fn angle(at: &SpecialPoint) -> Option<f64> {
    match at.what {
        Special::NeimarkSacker { angle } => Some(angle),
        _ => None,
    }
}

fn json(at: &SpecialPoint, system: &System) -> Value {
    let change = change(at).map(|change| changes::json(system, &change));
    json!({
        "parameter": at.parameter,
        "uncertainty": at.uncertainty,
        "what": what(at),
        "behind": at.behind,
        "period": at.period,
        "x": at.x.as_slice(),
        "angle": angle(at),
        "change": change,
    })
}

/// The end of a branch.
struct End {
    /// Name for programs.
    stop: &'static str,
    /// Words that follow "it ends".
    words: String,
    /// A value for programs, with its name.
    detail: Option<(&'static str, Value)>,
    /// The row of `special.csv`, if the end is a bifurcation. It has no phases, and a homoclinic
    /// orbit has no period.
    row: Option<Row>,
}

impl End {
    fn of(stop: &Stop, system: &System, name: &str) -> Self {
        let BranchEnd { word, bifurcation } = stop.into();
        let (words, detail) = match *stop {
            Stop::Range => ("at an end of the range".to_owned(), None),
            Stop::Points => (
                "after as many orbits as were asked for (--points)".to_owned(),
                None,
            ),
            Stop::Closed => ("where it began: the branch is closed".to_owned(), None),
            Stop::Flip {
                parameter,
                uncertainty,
            } => (
                format!(
                    "in a flip of the orbit of half the period: at {name} = {}",
                    within(parameter, uncertainty)
                ),
                Some((
                    "flip",
                    json!({ "parameter": parameter, "uncertainty": uncertainty }),
                )),
            ),
            Stop::Equilibrium {
                parameter,
                frequency,
            } => (
                format!(
                    "in an equilibrium: Hopf bifurcation at {name} = {}, frequency {}",
                    rounded(parameter),
                    rounded(frequency)
                ),
                Some((
                    "hopf",
                    json!({ "parameter": parameter, "frequency": frequency }),
                )),
            ),
            Stop::BoundaryEquilibrium { parameter } => (
                format!(
                    "in an equilibrium on the boundary or at a jump: boundary-equilibrium \
                     bifurcation at {name} = {}",
                    rounded(parameter)
                ),
                Some(("boundary_equilibrium", json!(parameter))),
            ),
            Stop::TwoFold {
                parameter,
                uncertainty,
            } => (
                format!(
                    "in a two-fold, to which it shrinks: at {name} = {}",
                    within(parameter, uncertainty)
                ),
                Some((
                    "two_fold",
                    json!({ "parameter": parameter, "uncertainty": uncertainty }),
                )),
            ),
            Stop::Homoclinic {
                parameter,
                uncertainty,
                saddles,
                leaves,
                comes,
            } => {
                let orbit = match saddles.get() {
                    1 => "a homoclinic orbit of a saddle".to_owned(),
                    number => format!("a heteroclinic cycle of {number} saddles"),
                };
                (
                    format!(
                        "in {orbit}: at {name} = {}, rates {} and {}",
                        within(parameter, uncertainty),
                        rounded(comes),
                        rounded(leaves)
                    ),
                    Some((
                        "homoclinic",
                        json!({
                            "parameter": parameter,
                            "uncertainty": uncertainty,
                            "saddles": saddles,
                            "leaves": leaves,
                            "comes": comes,
                        }),
                    )),
                )
            }
            Stop::Rest => (
                "where it comes to rest: it moves a thousandth of what it did".to_owned(),
                None,
            ),
            Stop::Refused(ref error) => {
                let words = in_words(error, system);
                (format!("where {words}"), Some(("error", json!(words))))
            }
            Stop::SequenceEnds => (
                "where its phases change: no orbit with other phases was found next to it"
                    .to_owned(),
                None,
            ),
            Stop::NoConvergence => (
                "where no further orbit was found; a shorter --step or a smaller --tol may lead on"
                    .to_owned(),
                None,
            ),
        };
        End {
            stop: word,
            words,
            detail,
            row: bifurcation.map(|end| Row {
                parameter: end.parameter,
                what: end.name.to_owned(),
                uncertainty: end.uncertainty,
                period: end.period,
                ..Row::default()
            }),
        }
    }

    /// Row of the end, after the number of orbits in `behind`.
    fn row(&self, behind: usize) -> Option<Row> {
        let row = self.row.clone()?;
        Some(Row { behind, ..row })
    }
}

/// A row of `special.csv`.
#[derive(Clone, Default)]
struct Row {
    branch: usize,
    /// The branches that begin here.
    branches: String,
    behind: usize,
    parameter: f64,
    what: String,
    contacts: String,
    angle: Option<f64>,
    uncertainty: Option<f64>,
    phases: Option<[String; 2]>,
    period: Option<f64>,
    x: Vec<f64>,
}

impl Row {
    fn of(at: &SpecialPoint, system: &System) -> Self {
        let change = change(at);
        let contacts = change
            .as_ref()
            .map(|change| changes::contacts(system, change));
        Row {
            behind: at.behind,
            parameter: at.parameter,
            what: what(at),
            contacts: contacts.unwrap_or_default(),
            angle: angle(at),
            uncertainty: Some(at.uncertainty),
            phases: change
                .as_ref()
                .and_then(|change| changes::phases(system, change)),
            period: Some(at.period),
            x: at.x.as_slice().to_vec(),
            ..Row::default()
        }
    }
}

/// The columns of `special.csv`: special orbits and ends that are bifurcations. Each has the number
/// of rows of its branch that come before it in `branch.csv`.
fn special_columns<'a>(system: &System, parameter: &str, is_numbered: bool) -> Table<'a, Row> {
    let phases = |k: usize| move |row: &Row| row.phases.as_ref().map(|phases| phases[k].clone());
    let table = numbered(is_numbered, |row: &Row| row.branch);
    let table = match is_numbered {
        true => table.column("branches", |row| row.branches.clone()),
        false => table,
    };
    table
        .column("behind", |row| row.behind)
        .column(parameter, |row| row.parameter)
        .column("what", |row| row.what.clone())
        .column("contacts", |row| row.contacts.clone())
        .column("angle", |row| row.angle)
        .column("uncertainty", |row| row.uncertainty)
        .column("before", phases(0))
        .column("after", phases(1))
        .column("period", |row| row.period)
        .state(system, "", |row| row.x.clone())
}

/// A table with a column for the number of the branch, if `is_numbered`.
fn numbered<'a, R>(is_numbered: bool, number: impl Fn(&R) -> usize + 'a) -> Table<'a, R> {
    match is_numbered {
        true => Table::new().column("branch", number),
        false => Table::new(),
    }
}

/// The columns of `branch.csv`: one row per orbit, from the lower to the upper end of the branch.
fn columns<'a>(
    system: &'a System,
    parameter: &str,
    (is_numbered, points): (bool, &[(usize, &BranchOrbit)]),
) -> Table<'a, &'a (usize, &'a BranchOrbit)> {
    let states = system.file.states.iter().map(|state| &state.name);
    let ends = states.flat_map(|name| ["low", "high"].map(|end| format!("{name}_{end}")));
    let of_points = points.iter().map(|(_, at)| at.orbit.multipliers.len());
    let multipliers = of_points.max();
    let numbers = 1..=multipliers.unwrap_or(0);
    let parts = numbers.flat_map(|k| ["re", "im"].map(|part| format!("multiplier{k}_{part}")));
    numbered(is_numbered, |(number, _): &&(usize, &BranchOrbit)| *number)
        .column(parameter, |(_, at)| at.orbit.parameter)
        .column("period", |(_, at)| at.orbit.period)
        .column("stability", |(_, at)| at.orbit.stability().to_string())
        .column("phases", |(_, at)| system.sequence(&at.orbit.sequence))
        .column("t", |(_, at)| at.orbit.t)
        .state(system, "", |(_, at)| at.orbit.x.clone())
        .many("extremes", ends.collect(), |(_, at)| -> Vec<f64> {
            at.extremes
                .iter()
                .flat_map(|&(low, high)| [low, high])
                .collect()
        })
        .many("multipliers", parts.collect(), |(_, at)| -> Vec<f64> {
            at.orbit
                .multipliers
                .iter()
                .flat_map(|one| [one.re, one.im])
                .collect()
        })
}
