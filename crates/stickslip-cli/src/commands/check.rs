//! `stickslip check`: how a file was read.

use serde_json::{Map, Value, json};
use stickslip::Direction;
use stickslip::error::readable;

use super::arguments::{StartArguments, SystemArguments};
use super::recording::direction_name;
use super::sweeping::check_period;
use super::tangents;
use crate::failure::{CommandLine, Failure};
use crate::render::{CommandOutput, Report};
use stickslip_model::file::{Formula, InputShape, Rate, System};
use stickslip_model::study::tangents::{BoundaryLine, LineResults};
use stickslip_model::study::{jumps_at_start, warnings};

/// Show how a file is read, and what looks wrong in it
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    system: SystemArguments,

    #[command(flatten)]
    start: StartArguments,

    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<CommandOutput, Failure> {
    let system = arguments.system.system()?;
    // A file without a start is checked without one.
    let start = match system.start().is_none() && arguments.start.is_default() {
        true => None,
        false => Some(arguments.start.of(&system)?),
    };
    let start = start.as_ref().map(|(t, x)| (*t, x.as_slice()));
    Ok(understood(&system, start).output(arguments.json))
}

/// Time and state at the start, if they are known.
type Start<'a> = Option<(f64, &'a [f64])>;

/// Lists what was read, line by line.
fn understood(system: &System, start: Start<'_>) -> Report {
    let (file, built) = (&system.file, &system.built);
    let mut text = format!("{}\n", file.name);
    for row in file.description.iter().flat_map(|text| text.lines()) {
        text.extend(["  ", row, "\n"]);
    }
    text.push('\n');
    let mut report = Report::plain(text, (0, 12));
    report
        .system(system)
        .field("description", &file.description);
    states(&mut report, system, start);
    parameters(&mut report, system);
    contacts(&mut report, system, start);
    jumps_and_inputs(&mut report, system);

    let definitions = file.definitions.iter().map(|one| {
        let (name, text) = (&one.name, &one.formula.text);
        (
            format!("{name} = {text}"),
            json!({ "name": name, "formula": text }),
        )
    });
    report.list("definitions", definitions);
    let moving = file.states.iter().zip(&file.field);
    let moving = moving.filter(|(state, _)| !state.is_discrete);
    let rates = moving.map(|(state, rate)| {
        let name = &state.name;
        match rate {
            Rate::Same(Formula { text, .. }) => (
                format!("d{name}/dt = {text}"),
                json!({ "state": name, "rate": text }),
            ),
            Rate::BySide { below, above } => (
                format!("d{name}/dt = {} below, {} above", below.text, above.text),
                json!({ "state": name, "below": below.text, "above": above.text }),
            ),
        }
    });
    report.list("field", rates);

    let period = built.period.map_or(String::new(), |period| {
        format!(", period {}", readable(period))
    });
    let depends = match built.depends_on_time {
        true => "depends",
        false => "does not depend",
    };
    report
        .line("time", format!("the system {depends} on time{period}"))
        .field(
            "time",
            json!({
                "depends_on_time": built.depends_on_time,
                "period": built.period,
                "start": start.map_or(built.t_start, |(t, _)| t),
                "end": built.t_end,
                "unit": file.time.unit,
            }),
        );
    report.field("section", Value::Null);
    if let Some(section) = file.sections.first() {
        let (function, direction) = (&section.function.text, direction_name(section.direction));
        let line = format!("where {function} = 0, passed {direction}");
        let object = json!({ "function": function, "direction": direction });
        report.line("section", line).field("section", object);
    }
    if let Some(start) = start {
        let lines = file.contacts.iter().enumerate().map(|(k, contact)| {
            let (side, height) = whereabouts(system, k, start);
            let (name, boundary, height) =
                (&contact.name, &contact.boundary.text, readable(height));
            format!("{side} the boundary of {name} ({boundary} = {height})")
        });
        let names = jumps_at_start(system, start).unwrap_or_default();
        let names: Vec<&str> = names
            .into_iter()
            .map(|jump| &*file.jumps[jump].name)
            .collect();
        let jumps = names.iter().map(|name| format!("{name} happens at once"));
        report
            .lines("start", lines.chain(jumps))
            .field("jumps_at_start", &names);
    }
    report.field("boundary", Value::Null);
    if let Some((line, found)) = on_boundary(system, start) {
        let (low, high) = (readable(line.range.0), readable(line.range.1));
        let (along, t) = (&file.states[line.along].name, readable(line.t));
        report
            .line(
                "boundary",
                format!("along {along} from {low} to {high}, at t = {t}:"),
            )
            .lines("", tangents::listing(system, &line, &found))
            .field("boundary", tangents::json(system, &line, &found));
    }
    let warnings = all_warnings(system, start);
    report
        .field("doubtful", &warnings)
        .lines("doubtful", warnings);
    report
}

/// A unit or meaning after a value.
fn suffix(parts: &[&str]) -> String {
    let parts = parts.iter().filter(|part| !part.is_empty());
    parts.map(|part| format!("  {part}")).collect()
}

fn states(report: &mut Report, system: &System, start: Start<'_>) {
    let starts = match start {
        Some((_, x)) => x.iter().copied().map(Some).collect(),
        None => system.built.starts.clone(),
    };
    let states = system.file.states.iter().zip(starts);
    let states = states.map(|(state, start)| {
        let from = start.map(|start| format!(", starts at {}", readable(start)));
        let unit = match state.unit.as_str() {
            "" if state.is_discrete => " (discrete)".to_owned(),
            "" => String::new(),
            unit => format!(" ({unit})"),
        };
        let meaning = suffix(&[state.meaning.as_deref().unwrap_or_default()]);
        let line = format!("{}{unit}{}{meaning}", state.name, from.unwrap_or_default());
        let object = json!({
            "name": state.name,
            "unit": state.unit,
            "meaning": state.meaning,
            "start": start,
            "range": state.range,
            "discrete": state.is_discrete,
        });
        (line, object)
    });
    report.list("states", states);
}

fn parameters(report: &mut Report, system: &System) {
    let parameters = system.file.parameters.iter().zip(&system.values);
    let parameters = parameters.map(|(parameter, &value)| {
        let meaning = parameter.meaning.as_deref().unwrap_or_default();
        let set = if value == parameter.value {
            ""
        } else {
            "(set)"
        };
        let suffix = suffix(&[&parameter.unit, set, meaning]);
        let line = format!("{} = {}{suffix}", parameter.name, readable(value));
        let object = json!({
            "name": parameter.name,
            "value": value,
            "in_file": parameter.value,
            "unit": parameter.unit,
            "meaning": parameter.meaning,
            // JSON has no infinity, so an infinite end is null.
            "range": parameter.range,
        });
        (line, object)
    });
    report.list("parameters", parameters);
}

fn contacts(report: &mut Report, system: &System, start: Start<'_>) {
    let text = |formula: &Option<Formula>| formula.as_ref().map(|formula| formula.text.clone());
    let mut objects = Vec::new();
    for (k, contact) in system.file.contacts.iter().enumerate() {
        let (name, boundary) = (&contact.name, &contact.boundary.text);
        let friction = text(&contact.friction);
        let holding = text(&contact.holding);
        let force = text(&contact.normal_force);
        report.line("contact", format!("{name}: Σ is where {boundary} = 0"));
        let note = "; without it no contact and no friction";
        let slip = friction
            .as_ref()
            .map(|text| format!("friction in slip  {text}"));
        let stick = holding
            .as_ref()
            .map(|text| format!("static friction   {text}"));
        let normal = force
            .as_ref()
            .map(|text| format!("normal force      {text}{note}"));
        report.lines("", [slip, stick, normal].into_iter().flatten());
        let start = start.map(|start| {
            let (side, height) = whereabouts(system, k, start);
            json!({ "side": side, "height": height })
        });
        objects.push(json!({
            "name": name,
            "boundary": boundary,
            "friction": friction,
            "static": holding,
            "normal_force": force,
            "start": start,
        }));
    }
    report.field("contacts", objects);
}

fn jumps_and_inputs(report: &mut Report, system: &System) {
    let file = &system.file;
    let stops = file.stops.iter().map(|stop| {
        let acts = file.states.iter().zip(&stop.acts);
        let acts = acts.filter_map(|(state, acts)| Some((&state.name, &acts.as_ref()?.text)));
        let words: Vec<String> = acts
            .clone()
            .map(|(state, acts)| format!("{acts} to d{state}/dt"))
            .collect();
        let (name, gap, part) = (&stop.name, &stop.gap.text, &stop.restitution.text);
        let line = format!(
            "{name}: {gap} ≥ 0, restitution {part}; a unit of {name}.force adds {}",
            words.join(", ")
        );
        let acts: Map<String, Value> = acts.map(|(of, acts)| (of.clone(), json!(acts))).collect();
        let object = json!({ "name": name, "gap": gap, "acts": acts, "restitution": part });
        (line, object)
    });
    report.list("stops", stops);
    let jumps = file.jumps.iter().filter(|jump| jump.of_stop.is_none());
    let jumps = jumps.map(|jump| {
        let states = file.states.iter().zip(&jump.set);
        let set = states.filter_map(|(state, to)| Some((&state.name, &to.as_ref()?.text)));
        let words: Vec<String> = set
            .clone()
            .map(|(state, to)| format!("{state} becomes {to}"))
            .chain(jump.most.map(|most| match most {
                1 => "the run ends".to_owned(),
                most => format!("the run ends with number {most}"),
            }))
            .collect();
        let (when, direction) = (&jump.when.text, direction_name(jump.direction));
        let way = match jump.direction {
            Direction::Both => String::new(),
            _ => format!(", {direction}"),
        };
        let condition = jump.condition.as_ref().map(|condition| &condition.text);
        let only = condition.map_or_else(String::new, |text| format!(", if {text}"));
        let (name, words) = (&jump.name, words.join(", "));
        let line = format!("{name}: where {when} = 0{way}{only}: {words}");
        let set: Map<String, Value> = set.map(|(state, to)| (state.clone(), json!(to))).collect();
        let object = json!({
            "name": jump.name,
            "when": when,
            "direction": direction,
            "if": condition,
            "set": set,
            "count": jump.most,
        });
        (line, object)
    });
    report.list("jumps", jumps);
    let inputs = file.inputs.iter().map(|input| {
        let name = &input.name;
        match &input.shape {
            InputShape::Periodic {
                shape,
                period,
                phase,
                width,
                ..
            } => {
                let [phase, width] = [phase, width].map(|one| one.as_ref().map(|one| &one.text));
                let suffix = |what: &str, of: Option<&String>| {
                    of.map_or_else(String::new, |of| format!(", {what} {of}"))
                };
                let (of_phase, of_width) = (suffix("phase", phase), suffix("width", width));
                (
                    format!(
                        "{name}: {shape} of period {}{of_width}{of_phase}",
                        period.text
                    ),
                    json!({
                        "name": name,
                        "shape": shape,
                        "period": period.text,
                        "phase": phase,
                        "width": width,
                    }),
                )
            }
            InputShape::Table { pieces, .. } => {
                let points = pieces.len() - 1;
                let line = format!("{name}: a table of {points} points in time");
                (line, json!({ "name": name, "points": points }))
            }
            InputShape::Switch(function) => (
                format!("{name}: the sign of {}", function.text),
                json!({ "name": name, "function": function.text }),
            ),
        }
    });
    report.list("inputs", inputs);
    let curves = file.curves.iter().map(|curve| {
        let (name, points) = (&curve.name, curve.points);
        let (from, to) = curve.range;
        (
            format!(
                "{name}: {points} points from {} to {}",
                readable(from),
                readable(to)
            ),
            json!({ "name": name, "points": points, "range": curve.range }),
        )
    });
    report.list("curves", curves);
}

/// Side of a boundary on which the start lies, and the value of the boundary function there.
fn whereabouts(system: &System, contact: usize, (t, x): (f64, &[f64])) -> (&'static str, f64) {
    let height = system.boundary(contact, t, x);
    let side = match height {
        height if height < 0.0 => "below",
        height if height > 0.0 => "above",
        _ => "on",
    };
    (side, height)
}

/// Tangent points and stick zones, for a system of one contact and two states whose range is in the
/// file.
fn on_boundary(
    system: &System,
    start: Start<'_>,
) -> Option<(BoundaryLine, Vec<(BoundaryLine, LineResults)>)> {
    if system.contacts() != 1 || system.states() != 2 {
        return None;
    }
    let everywhere = (f64::NEG_INFINITY, f64::INFINITY);
    let line = BoundaryLine::through(system, 0, None, everywhere, start?)?;
    let range = system.file.states[line.along].range?;
    let line = BoundaryLine { range, ..line };
    let found = line.scan(system);
    Some((line, found))
}

/// Warnings about a system, of which the first is of a wrong period.
fn all_warnings(system: &System, start: Start<'_>) -> Vec<String> {
    let period = match (system.is_periodic(), check_period(system)) {
        (Some(false), Err(failure)) => Some(failure.to_string()),
        _ => None,
    };
    let others = warnings(system, start, &CommandLine);
    period.into_iter().chain(others).collect()
}
