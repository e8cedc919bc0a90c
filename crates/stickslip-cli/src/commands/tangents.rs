//! `stickslip tangents`: tangent points and stick zones on a boundary.

use plot::*;
use serde_json::{Value, json};
use stickslip::Side;
use stickslip::Visibility;
use stickslip::error::readable;

use super::arguments::{StartArguments, SystemArguments, position};
use super::figures;
use crate::failure::Failure;
use crate::render::{CommandOutput, OutputArguments, Report, Table};
use stickslip_model::file::System;
use stickslip_model::study::tangents::{BoundaryLine, LineResults, TangentPoint, Zone, ZoneKind};

/// Branches of a boundary, with their tangent points and zones.
pub(super) type Branches = [(BoundaryLine, LineResults)];

/// Tangent points and stick zones on the boundary of a contact
///
/// The search goes along one state on the boundary, at one time (--t-start). Further states keep
/// their values of the start, and further contacts slip on the side where the start is. Where the
/// boundary has several values of the other state, each branch is followed to where it turns back.
///
/// Not found: double tangent points; two tangent points closer than 1/2000 of the range; two
/// branches closer than 1/64 of the other state's range in [ranges]; branches outside of it.
///
/// Writes tangents.csv, zones.csv and tangents.svg.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    system: SystemArguments,
    #[command(flatten)]
    start: StartArguments,
    /// Contact; default the first
    #[arg(long, value_name = "NAME")]
    contact: Option<String>,
    /// State along which to search; default the first that the boundary's equation leaves free
    #[arg(long, value_name = "STATE")]
    along: Option<String>,
    /// Lowest value of that state; default as in [ranges]
    #[arg(long, value_name = "VALUE")]
    from: Option<f64>,
    /// Highest value of that state; default as in [ranges]
    #[arg(long, value_name = "VALUE")]
    to: Option<f64>,
    #[command(flatten)]
    output: OutputArguments,
}

pub(super) fn run(arguments: &Arguments) -> Result<CommandOutput, Failure> {
    arguments.output.check()?;
    let system = arguments.system.system()?;
    let start = arguments.start.of(&system)?;
    let line = arguments.line(&system, (start.0, &start.1))?;
    let found = line.scan(&system);
    let [low, high, t] = [line.range.0, line.range.1, line.t].map(readable);
    let states = &system.file.states;
    let contact = &system.file.contacts[line.contact].name;
    let along = &states[line.along].name;
    let what = format!("boundary of {contact} along {along} from {low} to {high}, t = {t}");
    let mut report = Report::of(&system, what);
    for (k, state) in states.iter().enumerate() {
        if k != line.along && k != line.solved {
            report.note(format!("at {} = {}", state.name, readable(line.x[k])));
        }
    }
    for row in listing(&system, &line, &found) {
        report.note(row);
    }
    report
        .fields(json(&system, &line, &found))
        .table(points(&system, &line).csv("tangents", numbered(&found, |on_it| &on_it.points))?)
        .table(zones(&system, &line).csv("zones", numbered(&found, |on_it| &on_it.zones))?)
        .figure("tangents", &figure(&system, &line, &found));
    let output = &arguments.output;
    Ok(report.written(output.out.as_ref(), output)?)
}

impl Arguments {
    fn line(&self, system: &System, start: (f64, &[f64])) -> Result<BoundaryLine, Failure> {
        if system.contacts() == 0 {
            let message = "the system has no contact, and so no boundary with tangent points";
            return Err(Failure::Usage(message.to_owned()));
        }
        let contacts = system.file.contacts.iter().map(|contact| &*contact.name);
        let contact = match &self.contact {
            Some(name) => position("contact", name, contacts)?,
            None => 0,
        };
        let states = system.file.states.iter().map(|state| &*state.name);
        let along = match &self.along {
            Some(name) => Some(position("state", name, states)?),
            None => None,
        };
        let whole = (f64::NEG_INFINITY, f64::INFINITY);
        let line =
            BoundaryLine::through(system, contact, along, whole, start).ok_or_else(|| {
                Failure::Usage(
                "there is no line to search along: the boundary must change with one state and \
                    leave another one free"
                    .to_owned(),
            )
            })?;
        let state = &system.file.states[line.along];
        let end = |option: &str, given: Option<f64>, shown: Option<f64>| {
            given.or(shown).ok_or_else(|| {
                Failure::Usage(format!(
                    "the range of `{}` is missing; give {option}, or add {} = [lowest, highest] to \
                        [ranges] of the file",
                    state.name, state.name
                ))
            })
        };
        let from = end("--from", self.from, state.range.map(|range| range.0))?;
        let to = end("--to", self.to, state.range.map(|range| range.1))?;
        if !(from < to && from.is_finite() && to.is_finite()) {
            return Err(Failure::Usage(format!(
                "the range of `{}` from {from} to {to} is empty; give a --from below --to",
                state.name
            )));
        }
        let range = (from, to);
        Ok(BoundaryLine { range, ..line })
    }
}

fn side_name(side: Side) -> &'static str {
    match side {
        Side::Below => "below",
        Side::Above => "above",
    }
}

fn visibility_name(visibility: Visibility) -> &'static str {
    match visibility {
        Visibility::Visible => "visible",
        Visibility::Invisible => "invisible",
        Visibility::Degenerate => "degenerate",
    }
}

fn kind_name(kind: ZoneKind) -> &'static str {
    match kind {
        ZoneKind::Stick => "stick",
        ZoneKind::Repelling => "repelling",
    }
}

/// Lists the results, line by line, with the names of the states.
pub(super) fn listing(system: &System, line: &BoundaryLine, found: &Branches) -> Vec<String> {
    let states = &system.file.states;
    let (along, solved) = (&states[line.along].name, &states[line.solved].name);
    let mut rows = Vec::new();
    for (k, (branch, on_it)) in found.iter().enumerate() {
        // A single branch over the whole range needs no heading.
        if found.len() > 1 || branch.range != line.range {
            let [from, to] = [0, branch.path.len() - 1].map(|end| branch.path[end].map(readable));
            rows.push(format!(
                "branch {}  {along} from {} to {}, {solved} from {} to {}",
                k + 1,
                from[0],
                to[0],
                from[1],
                to[1]
            ));
        }
        rows.extend(on_it.points.iter().map(|point| {
            format!(
                "{} tangent point of the field {}  {along} = {}, {solved} = {}",
                visibility_name(point.visibility),
                side_name(point.side),
                readable(point.x[line.along]),
                readable(point.x[line.solved]),
            )
        }));
        rows.extend(on_it.zones.iter().map(|zone| {
            let (from, to) = (readable(zone.from), readable(zone.to));
            format!("{} zone  {along} from {from} to {to}", kind_name(zone.kind))
        }));
    }
    if found.is_empty() {
        rows.push("the boundary has no point there".to_owned());
    } else if rows.is_empty() {
        rows.push("no tangent point, and no stick zone".to_owned());
    }
    rows
}

/// The columns of tangent points, with the numbers of their branches.
fn points<'a>(system: &System, line: &'a BoundaryLine) -> Table<'a, (usize, &'a TangentPoint)> {
    Table::new()
        .column("side", |(_, point): &(usize, &TangentPoint)| {
            side_name(point.side)
        })
        .column("visibility", |(_, point)| visibility_name(point.visibility))
        .column("t", |_| line.t)
        .state(system, "", |(_, point)| point.x.clone())
        .column("branch", |&(branch, _)| branch)
}

/// The columns of zones.
fn zones<'a>(system: &System, line: &BoundaryLine) -> Table<'a, (usize, &'a Zone)> {
    let along = &system.file.states[line.along].name;
    let end = |end: &str| vec![format!("{along}_{end}")];
    Table::new()
        .column("kind", |(_, zone): &(usize, &Zone)| kind_name(zone.kind))
        .many("from", end("from"), |(_, zone)| zone.from)
        .many("to", end("to"), |(_, zone)| zone.to)
        .column("branch", |&(branch, _)| branch)
}

/// Items on the branches, with the numbers of the branches from 1.
fn numbered<'a, T: 'a>(
    found: &'a Branches,
    of: impl Fn(&'a LineResults) -> &'a [T],
) -> impl Iterator<Item = (usize, &'a T)> {
    let branches = (1..).zip(found);
    branches.flat_map(move |(k, (_, on_it))| of(on_it).iter().map(move |one| (k, one)))
}

/// Results on a line as JSON, without the system.
pub(super) fn json(system: &System, line: &BoundaryLine, found: &Branches) -> Value {
    let branches: Vec<(f64, f64)> = found.iter().map(|(branch, _)| branch.range).collect();
    json!({
        "contact": system.file.contacts[line.contact].name,
        "along": system.file.states[line.along].name,
        "range": line.range,
        "t": line.t,
        "branches": branches,
        "tangent_points": points(system, line).json(numbered(found, |on_it| &on_it.points)),
        "zones": zones(system, line).json(numbered(found, |on_it| &on_it.zones)),
    })
}

fn figure(system: &System, line: &BoundaryLine, found: &Branches) -> Figure {
    let state = &system.file.states[line.along];
    let (low, high) = line.range;
    let all = found.iter().flat_map(|(_, on_it)| &on_it.rates);
    let all = all.flat_map(|(_, rates)| *rates);
    let boundary = &system.file.contacts[line.contact];
    let mut panel = Panel::new(
        Axis::new(&figures::with_unit(&state.name, &state.unit), low, high),
        figures::axis("rate upwards through Σ", all.chain([0.0])),
    )
    .legend(Legend::Below);
    let mut in_legend: Vec<ZoneKind> = Vec::new();
    for (_, zone) in numbered(found, |on_it| &on_it.zones) {
        let fill = match zone.kind {
            ZoneKind::Stick => LIGHT_ORANGE,
            ZoneKind::Repelling => LIGHT_GREY,
        };
        let band = Band::x(zone.from, zone.to).fill(fill);
        let is_new = !in_legend.contains(&zone.kind);
        panel.add(match zone.kind {
            ZoneKind::Stick if is_new => band.legend("both fields push to Σ: stick"),
            ZoneKind::Repelling if is_new => band.legend("both fields lead away from Σ"),
            _ => band,
        });
        in_legend.push(zone.kind);
    }
    panel.add(Guide::horizontal(0.0));
    for (side, colour, name) in [(0, BLUE, "field below Σ"), (1, VERMILLION, "field above Σ")] {
        for (k, (_, on_it)) in found.iter().enumerate() {
            let curve = on_it.rates.iter().map(|(s, rates)| (*s, rates[side]));
            let curve = Curve::new(curve).color(colour);
            panel.add(if k == 0 { curve.legend(name) } else { curve });
        }
    }
    use Visibility::{Degenerate, Invisible, Visible};
    for visibility in [Visible, Invisible, Degenerate] {
        let points = found.iter().flat_map(|(_, on_it)| &on_it.points);
        let points: Vec<(f64, f64)> = points
            .filter(|point| point.visibility == visibility)
            .map(|point| (point.x[line.along], 0.0))
            .collect();
        if points.is_empty() {
            continue;
        }
        let name = format!("{} tangent point", visibility_name(visibility));
        let markers = Markers::new(points).color(BLACK).legend(&name);
        panel.add(match visibility {
            Visible => markers,
            Invisible => markers.open(),
            Degenerate => markers.shape(Shape::Cross),
        });
    }
    let title = format!("{}: boundary of {}", system.file.name, boundary.name);
    let description = format!(
        "How fast the fields below and above go upwards through the boundary of {}, along {} from \
            {low} to {high}: {} tangent points, {} zones.",
        boundary.name,
        state.name,
        numbered(found, |on_it| &on_it.points).count(),
        numbered(found, |on_it| &on_it.zones).count()
    );
    Figure::new("tangents", (640.0, 420.0), &title, &description).row(1.0, panel)
}
