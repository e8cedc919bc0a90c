//! The figures of an orbit.

use plot::*;
use stickslip::Mode;

use super::recording::{Phase, Recording};
use crate::output::OutputError;
use stickslip_kernels::file::System;

/// Colours of curves, in order.
const COLOURS: [Color; 4] = [BLUE, VERMILLION, GREEN, PURPLE];

/// Colours of stick, by contact.
const STICKS: [Color; 4] = [ORANGE, GREEN, PURPLE, VERMILLION];

/// Height of a state's panel in the time history, px.
const HISTORY: f64 = 130.0;

/// Height of the strip of a contact's stick intervals, px.
const STRIP: f64 = 24.0;

/// Least height of all strips, px.
const LEAST: f64 = 36.0;

/// What the axis of time takes under the last strip, px.
const AXIS: f64 = 44.0;

/// What lies between two panels and around all of them, px.
const BETWEEN: f64 = 16.0;

/// The colour of starts that lead to no attractor, by the word for what they do: none of those of attractors.
pub(super) fn colour_of_none(word: &str) -> Color {
    match word {
        "escape" => LIGHT_GREY,
        "undecided" => MID_GREY,
        "failure" => BLACK,
        // Ends where there is no unique future.
        _ => LIGHT_ORANGE,
    }
}

/// Names of letters.
const GREEK: [(&str, &str); 21] = [
    ("alpha", "α"),
    ("beta", "β"),
    ("gamma", "γ"),
    ("delta", "δ"),
    ("epsilon", "ε"),
    ("zeta", "ζ"),
    ("eta", "η"),
    ("theta", "θ"),
    ("kappa", "κ"),
    ("lambda", "λ"),
    ("mu", "μ"),
    ("nu", "ν"),
    ("xi", "ξ"),
    ("pi", "π"),
    ("rho", "ρ"),
    ("sigma", "σ"),
    ("tau", "τ"),
    ("phi", "φ"),
    ("chi", "χ"),
    ("psi", "ψ"),
    ("omega", "ω"),
];

/// A name in mathematics: italic, digits and what follows `_` below the line, Greek letters for
/// their names.
pub(super) fn symbol(name: &str) -> String {
    let (letters, index) = match name.split_once('_') {
        Some((letters, index)) if !letters.is_empty() => (letters, index),
        _ => name.split_at(name.trim_end_matches(|c: char| c.is_ascii_digit()).len()),
    };
    let plain = |text: &str| {
        let mut escaped = String::new();
        for c in text.chars() {
            if "*_^\\{}".contains(c) {
                escaped.push('\\');
            }
            escaped.push(c);
        }
        escaped
    };
    let greek = GREEK.iter().find(|(name, _)| *name == letters);
    let letters = greek.map_or_else(|| plain(letters), |(_, letter)| (*letter).to_owned());
    if index.is_empty() {
        format!("*{letters}*")
    } else {
        format!("*{letters}*_{{{}}}", plain(index))
    }
}

/// A symbol with its unit.
pub(super) fn with_unit(name: &str, unit: &str) -> String {
    let symbol = symbol(name);
    if unit.is_empty() || unit == "1" {
        return symbol;
    }
    // A unit is a product of powers; the page has no signs to be read as mark-up in it but these.
    let unit = unit.replace('\\', "").replace('*', "·").replace('_', "\\_");
    format!("{symbol}, {unit}")
}

/// The unit of time.
pub(super) fn time_label(system: &System) -> String {
    with_unit("t", system.file.time.unit.as_deref().unwrap_or_default())
}

/// A parameter, with its unit.
pub(super) fn parameter_label(system: &System, name: &str) -> String {
    let mut parameters = system.file.parameters.iter();
    let known = parameters.find(|parameter| parameter.name == name);
    with_unit(name, known.map_or("", |parameter| &parameter.unit))
}

/// Words for what is measured in time, with its unit to a power.
pub(super) fn in_time(system: &System, words: &str, power: &str) -> String {
    match system.file.time.unit.as_deref().unwrap_or_default() {
        "" => words.to_owned(),
        unit => format!("{words}, {unit}{power}"),
    }
}

/// An axis for values, with a little room at both ends.
pub(super) fn axis(label: &str, values: impl Iterator<Item = f64>) -> Axis {
    let (low, high) = extremes(values);
    let (low, high) = if low <= high { (low, high) } else { (0.0, 0.0) };
    // What differs by rounding only has one value.
    let least = 1e-9 * low.abs().max(high.abs()).max(1e-6);
    let room = if high - low > least {
        0.05 * (high - low)
    } else {
        0.5 * low.abs().max(1.0)
    };
    Axis::new(label, low - room, high + room)
}

/// The phase portrait in the plane of the first two states, stick in another colour.
pub(super) fn portrait(system: &System, recording: &Recording) -> Result<String, OutputError> {
    let states = &system.file.states;
    let component = |k: usize| recording.points.iter().map(move |point| point.x[k]);
    let label = |k: usize| with_unit(&states[k].name, &states[k].unit);
    let mut panel = Panel::new(axis(&label(0), component(0)), axis(&label(1), component(1)))
        .legend(Legend::Below);
    let curve = |keep: &dyn Fn(f64) -> bool| {
        let points: Vec<(f64, f64)> = recording
            .points
            .iter()
            .map(|point| {
                if keep(point.t) {
                    (point.x[0], point.x[1])
                } else {
                    (f64::NAN, f64::NAN)
                }
            })
            .collect();
        Curve::new(points)
    };
    panel.add(curve(&|_| true).color(BLUE).width(1.2).legend("orbit"));
    let contacts = &system.file.contacts;
    for (k, contact) in contacts.iter().enumerate() {
        let sticks = recording.sticks_of(k);
        if sticks.is_empty() {
            continue;
        }
        let is_stuck = |t: f64| {
            let next = sticks.partition_point(|stick| stick.1 < t);
            sticks.get(next).is_some_and(|stick| stick.0 <= t)
        };
        let name = match contacts.len() {
            1 => "stick".to_owned(),
            _ => format!("stick of {}", symbol(&contact.name)),
        };
        // Where several stick, the first ones show beside the last.
        let width = 3.0 + 1.5 * (contacts.len() - 1 - k) as f64;
        let stick = curve(&is_stuck).color(STICKS[k % STICKS.len()]);
        panel.add(stick.width(width).legend(&name));
        // Where a stick goes nowhere there is no line to be seen.
        let points = standing(recording, k);
        let markers = Markers::new(points).size(width + 1.5);
        panel.add(markers.color(STICKS[k % STICKS.len()]));
    }
    if let Some(first) = recording.points.first() {
        panel.add(
            Markers::new([(first.x[0], first.x[1])])
                .color(BLACK)
                .open()
                .legend("start"),
        );
    }
    if !recording.passages.is_empty() {
        let points = recording.passages.iter().map(|at| (at.x[0], at.x[1]));
        panel.add(
            Markers::new(points)
                .size(4.0)
                .color(VERMILLION)
                .legend("section"),
        );
    }
    let description = format!(
        "Phase portrait of {}: {} against {}, from t = {} on. It sticks {} times.",
        system.file.name,
        states[1].name,
        states[0].name,
        recording.points.first().map_or(0.0, |point| point.t),
        recording
            .phases
            .iter()
            .filter(|phase| phase.modes.to_vec().contains(&Mode::Stick))
            .count()
    );
    let title = format!("{}: phase portrait", system.file.name);
    let figure = Figure::new("portrait", (560.0, 480.0), &title, &description).row(1.0, panel);
    Ok(figure.render()?)
}

/// Where a contact's sticks stand in the plane of the first two states, but for a part of it that is not seen.
fn standing(recording: &Recording, contact: usize) -> Vec<(f64, f64)> {
    const UNSEEN: f64 = 0.01;
    let points = &recording.points;
    let width = [0, 1].map(|k| {
        let (low, high) = extremes(points.iter().map(|point| point.x[k]));
        high - low
    });
    let is_stick = |phase: &&Phase| phase.modes.to_vec().get(contact) == Some(&Mode::Stick);
    let stands = recording.phases.iter().filter(is_stick).filter(|phase| {
        let from = points.partition_point(|point| point.t < phase.t_start);
        let end = points.partition_point(|point| point.t <= phase.t_end);
        (0..2).all(|k| {
            let (low, high) = extremes(points[from..end].iter().map(|point| point.x[k]));
            high - low <= UNSEEN * width[k]
        })
    });
    stands
        .map(|phase| (phase.x_end[0], phase.x_end[1]))
        .collect()
}

/// The least and the greatest of the values that are finite; infinite, and the greater one first, where there are none.
pub(super) fn extremes(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let finite = values.filter(|value| value.is_finite());
    finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    })
}

/// All states against time, and when each contact sticks.
pub(super) fn history(system: &System, recording: &Recording) -> Result<String, OutputError> {
    let times = || recording.points.iter().map(|point| point.t);
    let (from, to) = (
        times().next().unwrap_or(0.0),
        times().next_back().unwrap_or(1.0),
    );
    let time = |label: &str| Axis::new(label, from, to);
    let states = &system.file.states;
    // The word beside them wants as much.
    let strips_height = (STRIP * system.contacts() as f64).max(LEAST);
    let panels = states.len() as f64;
    let height = HISTORY * panels + strips_height + AXIS + BETWEEN * (panels + 1.0);
    let title = format!("{}: time history", system.file.name);
    let description = format!(
        "Time history of {} from t = {from} to {to}: {}; under them when each contact sticks.",
        system.file.name,
        states
            .iter()
            .map(|state| state.name.as_str())
            .collect::<Vec<_>>()
            .join(", ")
    );
    let mut figure = Figure::new("history", (720.0, height), &title, &description);
    let all_sticks: Vec<Vec<(f64, f64)>> = (0..system.contacts())
        .map(|contact| recording.sticks_of(contact))
        .collect();
    for (k, state) in states.iter().enumerate() {
        let values = recording.points.iter().map(|point| point.x[k]);
        let label = with_unit(&state.name, &state.unit);
        let mut panel = Panel::new(time("").bare(), axis(&label, values));
        if let [sticks] = &all_sticks[..] {
            for &(begin, end) in sticks {
                panel.add(Band::x(begin, end).fill(LIGHT_ORANGE));
            }
        }
        let curve = recording.points.iter().map(|point| (point.t, point.x[k]));
        panel.add(
            Curve::new(curve)
                .color(COLOURS[k % COLOURS.len()])
                .width(1.2),
        );
        figure = figure.row(HISTORY, panel);
    }
    let rows = system.contacts();
    // The first contact stands at the top.
    let floor = |contact: usize| (rows - 1 - contact) as f64;
    let names: Vec<(f64, String)> = system
        .file
        .contacts
        .iter()
        .enumerate()
        .map(|(k, contact)| (floor(k) + 0.5, symbol(&contact.name)))
        .collect();
    let ticks: Vec<(f64, &str)> = names
        .iter()
        .map(|(at, name)| (*at, name.as_str()))
        .collect();
    let y = Axis::new("stick", 0.0, rows as f64).ticks(&ticks);
    let mut strips = Panel::new(time(&time_label(system)), y);
    for (k, sticks) in all_sticks.iter().enumerate() {
        let y = (floor(k) + 0.2, floor(k) + 0.8);
        for &(begin, end) in sticks {
            let colour = STICKS[k % STICKS.len()];
            strips.add(Band::rect((begin, end), y).fill(colour));
        }
    }
    figure = figure.row(strips_height + AXIS, strips);
    Ok(figure.render()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_letters_are_letters_and_other_names_stay() {
        assert_eq!(symbol("mu0"), "*μ*_{0}");
        assert_eq!(symbol("mu_v"), "*μ*_{v}");
        assert_eq!(symbol("omega"), "*ω*");
        assert_eq!(symbol("mus"), "*mus*");
        assert_eq!(symbol("x1"), "*x*_{1}");
    }
}
