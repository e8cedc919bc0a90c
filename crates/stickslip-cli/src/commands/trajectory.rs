//! The tables and figures of an orbit.

use plot::*;
use stickslip::TransitionKind;
use stickslip::dynamics::{OrbitEvent, Phase};

use super::figures::{axis, symbol, time_label, with_unit};
use super::recording::{Pictures, Recording, kind_of, source_of};
use crate::render::{OutputError, Report, Table};
use stickslip_model::file::System;

/// Colours of curves, in order.
const COLOURS: [Color; 4] = [BLUE, VERMILLION, GREEN, PURPLE];

/// Colours of stick, by contact.
const STICKS: [Color; 4] = [ORANGE, GREEN, PURPLE, VERMILLION];

/// Width of the curves, px.
pub(super) const CURVE_WIDTH: f64 = 1.2;

/// Most points of the curves of a figure before those on straight lines are dropped, and most
/// bands: about half a megabyte each.
pub(super) const MOST_POINTS: usize = 160_000;
const MOST_BANDS: usize = 4000;

/// Size of the portrait, and bounds of the size of a state's panel in the time history, px.
pub(super) const PORTRAIT_SIZE: (f64, f64) = (560.0, 480.0);
pub(super) const HISTORY_SIZE: (f64, f64) = (720.0, STATE_PANEL_HEIGHT);

/// Height of a state's panel in the time history, px.
const STATE_PANEL_HEIGHT: f64 = 130.0;

/// Height of the strip of a contact's stick intervals, px.
const STRIP_HEIGHT: f64 = 24.0;

/// Least height of all strips, px.
const LEAST_STRIPS_HEIGHT: f64 = 36.0;

/// Height of the time axis below the last strip, px.
const AXIS_HEIGHT: f64 = 44.0;

/// Space between two panels and around all of them, px.
const PANEL_SPACING: f64 = 16.0;

/// Adds phases and transitions to a report, as tables and, for at least two states, as figures.
pub(super) fn put(
    system: &System,
    recording: &Recording,
    report: &mut Report,
) -> Result<(), OutputError> {
    let phases = (1..).zip(&recording.orbit.phases);
    let phases = phases.map(|(k, phase)| (0, k, phase));
    let transitions = recording.orbit.events.iter().map(|at| (0, at));
    report
        .table(phase_columns(system, false).csv("phases", phases)?)
        .table(transitions_with_residuals(system, false).csv("transitions", transitions)?);
    if let Some(pictures) = &recording.pictures {
        report.figure("history", &history(system, recording, pictures));
        if system.states() > 1 {
            report.figure("portrait", &portrait(system, recording, pictures));
        }
    }
    Ok(())
}

/// A table with a column for the number of the orbit, if `is_numbered`.
pub(super) fn numbered<'a, R>(
    is_numbered: bool,
    number: impl Fn(&R) -> usize + 'a,
) -> Table<'a, R> {
    match is_numbered {
        true => Table::new().column("orbit", number),
        false => Table::new(),
    }
}

/// A phase with the number of its orbit and its number there.
pub(super) type PhaseRow<'a> = (usize, usize, &'a Phase);

/// The columns of phases.
pub(super) fn phase_columns<'a>(system: &'a System, is_numbered: bool) -> Table<'a, PhaseRow<'a>> {
    let phases = numbered(is_numbered, |&(orbit, ..): &PhaseRow<'_>| orbit)
        .column("phase", |&(_, k, _)| k)
        .column("t_start", |(.., phase)| phase.t_start)
        .column("t_end", |(.., phase)| phase.t_end)
        .column("duration", |(.., phase)| phase.duration())
        .modes(system, ("modes", ""), |(.., phase)| phase.mode);
    let phases = match system.file.jumps.is_empty() {
        true => phases,
        false => phases.column("jump", |(.., phase)| {
            let number = phase.mode.jump().map(|jump| system.contacts() + jump);
            number.map(|number| system.contact_name(number))
        }),
    };
    phases
        .state(system, "_start", |(.., phase)| phase.x_start.clone())
        .state(system, "_end", |(.., phase)| phase.x_end.clone())
}

/// A transition with the number of its orbit.
pub(super) type TransitionRow<'a> = (usize, &'a OrbitEvent);

/// The columns of transitions.
pub(super) fn transitions<'a>(
    system: &'a System,
    is_numbered: bool,
) -> Table<'a, TransitionRow<'a>> {
    let table = numbered(is_numbered, |&(orbit, _): &TransitionRow<'_>| orbit)
        .column("t", |(_, at)| at.t())
        .column("kind", |(_, at)| kind_of(system, at))
        .column("contact", |(_, at)| source_of(system, at))
        .modes(system, ("from", "from_"), |(_, at)| at.modes()[0])
        .modes(system, ("to", "to_"), |(_, at)| at.modes()[1])
        .state(system, "", |(_, at)| at.before().clone());
    let stops = system.file.stops.iter().enumerate();
    stops.fold(table, |table, (stop, entry)| {
        table.column(
            &format!("{}.impulse", entry.name),
            move |(_, at)| match at {
                OrbitEvent::Transition { at, .. } if at.kind == TransitionKind::Jump => {
                    let impulses = system.impulses(at.contact, at.t, at.x.as_slice());
                    impulses.get(stop).map(|impulse| impulse + 0.0)
                }
                _ => None,
            },
        )
    })
}

/// The columns of transitions, and how far the boundary is from zero.
pub(super) fn transitions_with_residuals<'a>(
    system: &'a System,
    is_numbered: bool,
) -> Table<'a, TransitionRow<'a>> {
    transitions(system, is_numbered).column("residual", |(_, at)| match at {
        OrbitEvent::Transition { at, .. } => Some(at.residual),
        OrbitEvent::Kink(_) => None,
    })
}

/// Width of the line of a contact's stick in the portrait, px. Where several contacts stick, the
/// wider lines of the first ones remain visible.
pub(super) fn stick_width(contacts: usize, contact: usize) -> f64 {
    3.0 + 1.5 * (contacts - 1 - contact).min(3) as f64
}

/// The phase portrait in the plane of the first two states, with stick in another colour.
fn portrait(system: &System, recording: &Recording, pictures: &Pictures) -> Figure {
    let states = &system.file.states;
    let label = |k: usize| with_unit(&states[k].name, &states[k].unit);
    let [x, y] = [0, 1].map(|k| axis(&label(k), ends(pictures.extents[k])));
    let mut panel = Panel::new(x, y).legend(Legend::Below);
    let orbit = Curve::new(pictures.portrait.points()).color(BLUE);
    // A thinned line ends in the middle of others: a round end is a corner there.
    panel.add(orbit.width(CURVE_WIDTH).round().legend("orbit"));
    let contacts = &system.file.contacts;
    for (k, (contact, stick)) in contacts.iter().zip(&pictures.sticks).enumerate() {
        let points = stick.points();
        if points.iter().all(|point| point.0.is_nan()) {
            continue;
        }
        let name = match contacts.len() {
            1 => "stick".to_owned(),
            _ => format!("stick of {}", symbol(&contact.name)),
        };
        let stick = Curve::new(points).color(STICKS[k % STICKS.len()]).round();
        panel.add(stick.width(stick_width(contacts.len(), k)).legend(&name));
    }
    for (k, jump) in system.file.jumps.iter().enumerate() {
        let places = recording.orbit.events.iter().filter_map(|at| match at {
            OrbitEvent::Transition { at, .. } if at.contact == contacts.len() + k => {
                Some((at.x[0], at.x[1]))
            }
            _ => None,
        });
        let places: Vec<(f64, f64)> = places.collect();
        if !places.is_empty() {
            let markers = Markers::new(places).color(STICKS[k % STICKS.len()]).open();
            panel.add(markers.size(5.0).legend(&symbol(&jump.name)));
        }
    }
    let begin = &recording.orbit.start;
    let start = Markers::new([(begin.x[0], begin.x[1])]).color(BLACK);
    panel.add(start.open().legend("start"));
    if !recording.orbit.passages.is_empty() {
        let points = recording.orbit.passages.iter().map(|at| (at.x[0], at.x[1]));
        let section = Markers::new(points).size(4.0).color(VERMILLION);
        panel.add(section.legend("section"));
    }
    let phases = recording.orbit.phases.iter();
    let description = format!(
        "Phase portrait of {}: {} against {}, from t = {} on. It sticks {} times.",
        system.file.name,
        states[1].name,
        states[0].name,
        begin.t,
        phases.filter(|phase| phase.mode.any_sticks()).count()
    );
    let title = format!("{}: phase portrait", system.file.name);
    Figure::new("portrait", PORTRAIT_SIZE, &title, &description).row(1.0, panel)
}

/// Both ends of a range.
fn ends((low, high): (f64, f64)) -> impl Iterator<Item = f64> {
    [low, high].into_iter()
}

/// Intervals within a range of time. Those in one of `columns` columns become one of their total
/// length, which looks the same where a column is narrower than a pixel.
fn by_columns(sticks: &[(f64, f64)], (from, to): (f64, f64), columns: usize) -> Vec<(f64, f64)> {
    if sticks.len() <= columns {
        return sticks.to_vec();
    }
    let width = (to - from) / columns as f64;
    let mut joined: Vec<(f64, f64)> = Vec::new();
    let mut column_end = f64::NEG_INFINITY;
    for &(begin, end) in sticks {
        match joined.last_mut() {
            Some(last) if end <= column_end => last.1 += end - begin,
            _ => {
                joined.push((begin, end));
                column_end = from + (((end - from) / width).floor() + 1.0) * width;
            }
        }
    }
    joined
}

/// All states and further quantities against time, and the intervals in which each contact sticks.
fn history(system: &System, recording: &Recording, pictures: &Pictures) -> Figure {
    let (from, to) = (recording.orbit.start.t, recording.orbit.end.t);
    let time = |label: &str| Axis::new(label, from, to);
    let states = &system.file.states;
    // The minimum is the room for the label beside the strips.
    let strips_height = (STRIP_HEIGHT * system.contacts() as f64).max(LEAST_STRIPS_HEIGHT);
    let states = states
        .iter()
        .map(|state| (&state.name, state.unit.as_str()));
    let quantities = recording.quantities.0.iter().map(|name| (name, ""));
    let curves: Vec<(&String, &str)> = states.chain(quantities).collect();
    let panels = curves.len() as f64;
    let strips = match system.contacts() {
        0 => 0.0,
        _ => strips_height + PANEL_SPACING,
    };
    let height = (STATE_PANEL_HEIGHT + PANEL_SPACING) * panels + strips + AXIS_HEIGHT;
    let title = format!("{}: time history", system.file.name);
    let names: Vec<&str> = curves.iter().map(|curve| curve.0.as_str()).collect();
    let description = format!(
        "Time history of {} from t = {from} to {to}: {}{}.",
        system.file.name,
        names.join(", "),
        match system.contacts() {
            0 => "",
            _ => "; under them when each contact sticks",
        }
    );
    let mut figure = Figure::new("history", (HISTORY_SIZE.0, height), &title, &description);
    // The sticks of a single contact are also behind each state.
    let strips_of_sticks = match system.contacts() {
        1 => 1 + curves.len(),
        contacts => contacts,
    };
    let all_sticks = (0..system.contacts()).map(|contact| {
        let columns = MOST_BANDS / strips_of_sticks;
        by_columns(&recording.orbit.sticks_of(contact), (from, to), columns)
    });
    let all_sticks: Vec<Vec<(f64, f64)>> = all_sticks.collect();
    for (k, (name, unit)) in curves.iter().enumerate() {
        let extent = pictures.extents[k];
        // What never had a value has an empty panel.
        let values = ends(if extent.0 <= extent.1 {
            extent
        } else {
            (0.0, 0.0)
        });
        let label = with_unit(name, unit);
        // Without contacts the time axis is below the last panel.
        let is_lowest = all_sticks.is_empty() && k + 1 == curves.len();
        let (below, height) = match is_lowest {
            true => (time(&time_label(system)), STATE_PANEL_HEIGHT + AXIS_HEIGHT),
            false => (time("").bare(), STATE_PANEL_HEIGHT),
        };
        let mut panel = Panel::new(below, axis(&label, values));
        if let [sticks] = &all_sticks[..] {
            for &(begin, end) in sticks {
                panel.add(Band::x(begin, end).fill(LIGHT_ORANGE));
            }
        }
        let curve = Curve::new(pictures.history[k].points()).round();
        panel.add(curve.color(COLOURS[k % COLOURS.len()]).width(CURVE_WIDTH));
        figure = figure.row(height, panel);
    }
    let rows = system.contacts();
    if rows == 0 {
        return figure;
    }
    // The first contact has the top strip.
    let floor = |contact: usize| (rows - 1 - contact) as f64;
    let contacts = system.file.contacts.iter();
    let names: Vec<String> = contacts.map(|contact| symbol(&contact.name)).collect();
    let ticks = names.iter().enumerate();
    let ticks = ticks.map(|(k, name)| (floor(k) + 0.5, &**name));
    let y = Axis::new("stick", 0.0, rows as f64).ticks(ticks);
    let mut strips = Panel::new(time(&time_label(system)), y);
    for (k, sticks) in all_sticks.iter().enumerate() {
        let y = (floor(k) + 0.2, floor(k) + 0.8);
        for &(begin, end) in sticks {
            let colour = STICKS[k % STICKS.len()];
            strips.add(Band::rect((begin, end), y).fill(colour));
        }
    }
    figure.row(strips_height + AXIS_HEIGHT, strips)
}
