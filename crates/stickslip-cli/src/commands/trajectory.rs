//! The tables and figures of an orbit.

use plot::*;
use stickslip::Mode;
use stickslip::dynamics::Phase;

use super::figures::{axis, extremes, symbol, time_label, with_unit};
use super::recording::{Occurrence, Recording};
use crate::render::{OutputError, Report, Table};
use stickslip_kernels::file::System;

/// Colours of curves, in order.
const COLOURS: [Color; 4] = [BLUE, VERMILLION, GREEN, PURPLE];

/// Colours of stick, by contact.
const STICKS: [Color; 4] = [ORANGE, GREEN, PURPLE, VERMILLION];

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
    let phases = Table::new()
        .column("phase", |&(k, _): &(usize, &Phase)| k)
        .column("t_start", |(_, phase)| phase.t_start)
        .column("t_end", |(_, phase)| phase.t_end)
        .column("duration", |(_, phase)| phase.duration())
        .modes(system, ("modes", ""), |(_, phase)| phase.mode);
    let phases = match system.file.jumps.is_empty() {
        true => phases,
        false => phases.column("jump", |(_, phase)| {
            let number = phase.mode.jump().map(|jump| system.contacts() + jump);
            number.map(|number| system.contact_name(number))
        }),
    };
    let phases = phases
        .state(system, "_start", |(_, phase)| phase.x_start.clone())
        .state(system, "_end", |(_, phase)| phase.x_end.clone());
    let transitions = transitions(system).column("residual", |at| match at {
        Occurrence::Transition(at) => Some(at.residual),
        Occurrence::Kink(_) => None,
    });
    report
        .table(phases.csv("phases", (1..).zip(&recording.phases))?)
        .table(transitions.csv("transitions", &recording.transitions)?)
        .figure("history", &history(system, recording))?;
    if system.states() > 1 {
        report.figure("portrait", &portrait(system, recording))?;
    }
    Ok(())
}

/// The columns of transitions.
pub(super) fn transitions<'a>(system: &'a System) -> Table<'a, &'a Occurrence> {
    Table::new()
        .column("t", |at: &&Occurrence| at.t())
        .column("kind", |at| at.kind(system))
        .column("contact", |at| at.of(system))
        .modes(system, ("from", "from_"), |at| at.modes()[0])
        .modes(system, ("to", "to_"), |at| at.modes()[1])
        .state(system, "", |at| at.x().clone())
}

/// The phase portrait in the plane of the first two states, with stick in another colour.
fn portrait(system: &System, recording: &Recording) -> Figure {
    let states = &system.file.states;
    let component = |k: usize| recording.points.iter().map(move |point| point.x[k]);
    let label = |k: usize| with_unit(&states[k].name, &states[k].unit);
    let mut panel = Panel::new(axis(&label(0), component(0)), axis(&label(1), component(1)))
        .legend(Legend::Below);
    let times: Vec<f64> = recording.points.iter().map(|point| point.t).collect();
    let curve = |keep: &dyn Fn(usize) -> bool| {
        let points = recording.points.iter().enumerate();
        Curve::new(points.map(|(k, point)| match keep(k) {
            true => (point.x[0], point.x[1]),
            false => (f64::NAN, f64::NAN),
        }))
    };
    panel.add(curve(&|_| true).color(BLUE).width(1.2).legend("orbit"));
    let contacts = &system.file.contacts;
    for (k, contact) in contacts.iter().enumerate() {
        let sticks = recording.sticks_of(k);
        if sticks.is_empty() {
            continue;
        }
        let is_stuck = |k: usize| {
            // Of two points of one time the second is behind a jump, which may end the stick.
            let is_behind_jump = k > 0 && times[k - 1] == times[k];
            let is_over = |end: f64| end < times[k] || is_behind_jump && end == times[k];
            let next = sticks.partition_point(|stick| is_over(stick.1));
            sticks.get(next).is_some_and(|stick| stick.0 <= times[k])
        };
        let name = match contacts.len() {
            1 => "stick".to_owned(),
            _ => format!("stick of {}", symbol(&contact.name)),
        };
        // Where several contacts stick, the wider lines of the first ones remain visible.
        let width = 3.0 + 1.5 * (contacts.len() - 1 - k).min(3) as f64;
        let stick = curve(&is_stuck).color(STICKS[k % STICKS.len()]);
        panel.add(stick.width(width).legend(&name));
        // A stick without motion has no visible line, so it is drawn as a point.
        let points = standing(recording, k);
        let markers = Markers::new(points).size(width + 1.5);
        panel.add(markers.color(STICKS[k % STICKS.len()]));
    }
    for (k, jump) in system.file.jumps.iter().enumerate() {
        let places = recording.transitions.iter().filter_map(|at| match at {
            Occurrence::Transition(at) if at.contact == contacts.len() + k => {
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
    if let Some(first) = recording.points.first() {
        let start = Markers::new([(first.x[0], first.x[1])]).color(BLACK);
        panel.add(start.open().legend("start"));
    }
    if !recording.passages.is_empty() {
        let points = recording.passages.iter().map(|at| (at.x[0], at.x[1]));
        let section = Markers::new(points).size(4.0).color(VERMILLION);
        panel.add(section.legend("section"));
    }
    let phases = recording.phases.iter();
    let description = format!(
        "Phase portrait of {}: {} against {}, from t = {} on. It sticks {} times.",
        system.file.name,
        states[1].name,
        states[0].name,
        recording.points.first().map_or(0.0, |point| point.t),
        phases.filter(|phase| phase.mode.any_sticks()).count()
    );
    let title = format!("{}: phase portrait", system.file.name);
    Figure::new("portrait", (560.0, 480.0), &title, &description).row(1.0, panel)
}

/// Points of the plane of the first two states at which a contact sticks without visible motion.
fn standing(recording: &Recording, contact: usize) -> Vec<(f64, f64)> {
    const INVISIBLE_FRACTION: f64 = 0.01;
    let points = &recording.points;
    let width = [0, 1].map(|k| {
        let (low, high) = extremes(points.iter().map(|point| point.x[k]));
        high - low
    });
    let is_stick = |phase: &&Phase| phase.mode.get(contact) == Mode::Stick;
    let stands = recording.phases.iter().filter(is_stick).filter(|phase| {
        let from = points.partition_point(|point| point.t < phase.t_start);
        let end = points.partition_point(|point| point.t <= phase.t_end);
        (0..2).all(|k| {
            let (low, high) = extremes(points[from..end].iter().map(|point| point.x[k]));
            high - low <= INVISIBLE_FRACTION * width[k]
        })
    });
    stands
        .map(|phase| (phase.x_end[0], phase.x_end[1]))
        .collect()
}

/// All states against time, and the intervals in which each contact sticks.
fn history(system: &System, recording: &Recording) -> Figure {
    let points = &recording.points;
    let from = points.first().map_or(0.0, |point| point.t);
    let to = points.last().map_or(1.0, |point| point.t);
    let time = |label: &str| Axis::new(label, from, to);
    let states = &system.file.states;
    // The minimum is the room for the label beside the strips.
    let strips_height = (STRIP_HEIGHT * system.contacts() as f64).max(LEAST_STRIPS_HEIGHT);
    let panels = states.len() as f64;
    let strips = match system.contacts() {
        0 => 0.0,
        _ => strips_height + PANEL_SPACING,
    };
    let height = (STATE_PANEL_HEIGHT + PANEL_SPACING) * panels + strips + AXIS_HEIGHT;
    let title = format!("{}: time history", system.file.name);
    let names: Vec<&str> = states.iter().map(|state| state.name.as_str()).collect();
    let description = format!(
        "Time history of {} from t = {from} to {to}: {}{}.",
        system.file.name,
        names.join(", "),
        match system.contacts() {
            0 => "",
            _ => "; under them when each contact sticks",
        }
    );
    let mut figure = Figure::new("history", (720.0, height), &title, &description);
    let all_sticks: Vec<Vec<(f64, f64)>> = (0..system.contacts())
        .map(|contact| recording.sticks_of(contact))
        .collect();
    for (k, state) in states.iter().enumerate() {
        let values = points.iter().map(|point| point.x[k]);
        let label = with_unit(&state.name, &state.unit);
        // Without contacts the time axis is below the panel of the last state.
        let is_lowest = all_sticks.is_empty() && k + 1 == states.len();
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
        let curve = Curve::new(points.iter().map(|point| (point.t, point.x[k])));
        panel.add(curve.color(COLOURS[k % COLOURS.len()]).width(1.2));
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
