//! Orbits as tables and as JSON.

use serde_json::{Value, json};
use stickslip::{Mode, math};

use super::recording::{
    Crossed, Phase, Recording, Transition, direction_name, kind_name, mode_name,
};
use crate::output::{Artifact, OutputError, csv_table};
use stickslip_kernels::file::System;
use stickslip_kernels::kernel::{Change, Modes};

/// A number that reads back to the last bit.
pub(super) fn exact(value: f64) -> String {
    format!("{value:?}")
}

/// A number for people: twelve digits, of which rounding has not made the last ones.
pub(super) fn rounded(value: f64) -> f64 {
    to_digits(value, 12)
}

/// A number to so many significant digits.
pub(super) fn to_digits(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

/// A number to the digits that it has, in which it is rounded by more than its uncertainty.
pub(super) fn known(value: f64, uncertainty: f64) -> f64 {
    const MOST: f64 = 12.0;
    let digits = 1.0 + math::log10(value.abs() / (2.0 * uncertainty)).floor();
    to_digits(value, digits.clamp(1.0, MOST) as usize)
}

/// Texts of their own.
pub(super) fn strings(texts: &[&str]) -> Vec<String> {
    texts.iter().map(|&text| text.to_owned()).collect()
}

/// A number with what it is uncertain by, and no digits beyond.
pub(super) fn within(value: f64, uncertainty: f64) -> String {
    const MOST: f64 = 16.0;
    if !(uncertainty > 0.0 && uncertainty.is_finite()) {
        return format!("about {}", to_digits(value, 4));
    }
    let decimals = (1.0 - math::log10(uncertainty).floor()).max(0.0);
    if decimals > MOST {
        return format!("{value:.2e} ± {uncertainty:.0e}");
    }
    let text = format!("{value:.0$}", decimals as usize);
    // Rounded to zero it has no sign.
    let is_zero = text
        .bytes()
        .all(|digit| matches!(digit, b'-' | b'0' | b'.'));
    let text = if is_zero {
        text.trim_start_matches('-')
    } else {
        &text
    };
    format!("{text} ± {uncertainty:.0e}")
}

/// A located parameter, with no digits beyond its uncertainty.
pub(super) fn place(value: f64, uncertainty: f64) -> String {
    if uncertainty > 1e-12 * value.abs() {
        within(value, uncertainty)
    } else {
        rounded(value).to_string()
    }
}

/// Names of the states, with something behind each.
fn states(system: &System, suffix: &str) -> Vec<String> {
    let states = system.file.states.iter();
    states
        .map(|state| format!("{}{suffix}", state.name))
        .collect()
}

/// Names of the contacts, with something before each.
fn contacts(system: &System, prefix: &str) -> Vec<String> {
    let contacts = system.file.contacts.iter();
    contacts
        .map(|contact| format!("{prefix}{}", contact.name))
        .collect()
}

fn heading(columns: &[&str], further: &[Vec<String>]) -> Vec<String> {
    let columns = columns.iter().map(|&column| column.to_owned());
    columns.chain(further.iter().flatten().cloned()).collect()
}

fn numbers(values: &[f64]) -> Vec<String> {
    values.iter().map(|&value| exact(value)).collect()
}

fn modes(modes: &Modes) -> Vec<String> {
    modes
        .to_vec()
        .iter()
        .map(|&mode| mode_name(mode).to_owned())
        .collect()
}

/// `phases.csv`
pub(super) fn phases(
    name: &str,
    system: &System,
    phases: &[Phase],
) -> Result<Artifact, OutputError> {
    let heading = heading(
        &["phase", "t_start", "t_end", "duration"],
        &[
            contacts(system, ""),
            states(system, "_start"),
            states(system, "_end"),
        ],
    );
    let rows = phases.iter().enumerate().map(|(k, phase)| {
        let times = [phase.t_start, phase.t_end, phase.duration()];
        let mut row = vec![(k + 1).to_string()];
        row.extend(numbers(&times));
        row.extend(modes(&phase.modes));
        row.extend(numbers(&phase.x_start));
        row.extend(numbers(&phase.x_end));
        row
    });
    csv_table(format!("{name}.csv"), &heading, rows)
}

/// `transitions.csv`
pub(super) fn transitions(
    name: &str,
    system: &System,
    transitions: &[Transition],
) -> Result<Artifact, OutputError> {
    let heading = heading(
        &["t", "kind", "contact"],
        &[
            contacts(system, "from_"),
            contacts(system, "to_"),
            states(system, ""),
            vec!["residual".to_owned()],
        ],
    );
    let rows = transitions.iter().map(|at| {
        let mut row = vec![
            exact(at.t),
            kind_name(at.kind).to_owned(),
            contact_name(system, at.contact),
        ];
        row.extend(modes(&at.from));
        row.extend(modes(&at.to));
        row.extend(numbers(&at.x));
        row.push(exact(at.residual));
        row
    });
    csv_table(format!("{name}.csv"), &heading, rows)
}

/// `section.csv`
pub(super) fn passages(
    name: &str,
    system: &System,
    passages: &[Crossed],
) -> Result<Artifact, OutputError> {
    let heading = heading(&["t", "direction"], &[states(system, "")]);
    let rows = passages.iter().map(|at| {
        let mut row = vec![exact(at.t), direction_name(at.direction).to_owned()];
        row.extend(numbers(&at.x));
        row
    });
    csv_table(format!("{name}.csv"), &heading, rows)
}

/// `steps.csv`: the ends of the steps, where the solution is as accurate as the run.
pub(super) fn steps(
    name: &str,
    system: &System,
    recording: &Recording,
) -> Result<Artifact, OutputError> {
    let heading = heading(&["t"], &[states(system, "")]);
    let ends = recording.points.iter().filter(|point| point.ends_step);
    let rows = ends.map(|point| {
        let mut row = vec![exact(point.t)];
        row.extend(numbers(&point.x));
        row
    });
    csv_table(format!("{name}.csv"), &heading, rows)
}

pub(super) fn contact_name(system: &System, contact: usize) -> String {
    let contacts = &system.file.contacts;
    contacts
        .get(contact)
        .map_or_else(String::new, |contact| contact.name.clone())
}

/// The system's name and values, as JSON.
pub(super) fn system_json(system: &System) -> Value {
    let parameters = system.file.parameters.iter().zip(&system.values);
    let parameters: serde_json::Map<String, Value> = parameters
        .map(|(parameter, &value)| (parameter.name.clone(), json!(value)))
        .collect();
    json!({ "name": system.file.name, "parameters": parameters })
}

/// A state, by names.
pub(super) fn state_json(system: &System, x: &[f64]) -> Value {
    let states = system.file.states.iter().zip(x);
    let map: serde_json::Map<String, Value> = states
        .map(|(state, &value)| (state.name.clone(), json!(value)))
        .collect();
    Value::Object(map)
}

/// The modes of a phase in a few letters, of several contacts separated by `|`: `+` and `-` for slip above and below, `S` for stick.
pub(super) fn letters(modes: &Modes) -> String {
    let letters: Vec<&str> = modes
        .to_vec()
        .iter()
        .map(|mode| match mode {
            Mode::Stick => "S",
            Mode::Slip(side) if side.sign() > 0.0 => "+",
            Mode::Slip(_) => "-",
        })
        .collect();
    letters.join("|")
}

/// The modes gone through, in letters.
pub(super) fn sequence(modes: &[Modes]) -> String {
    let signs: Vec<String> = modes.iter().map(letters).collect();
    signs.join(" ")
}

/// As [`change_name`], with the contacts where there are several.
pub(super) fn change_words(system: &System, change: &Change) -> String {
    let name = match changed_contacts(system, change) {
        contacts if contacts.is_empty() || system.contacts() == 1 => change_name(change),
        contacts => format!("{} of {contacts}", change_name(change)),
    };
    match change {
        Change::Sequence { before, after, .. } if before.is_empty() != after.is_empty() => {
            let phases = if after.is_empty() { before } else { after };
            let phases = sequence(phases);
            format!("{name}, where an orbit of phases {phases} ends: none was found beyond")
        }
        _ => name,
    }
}

/// The contacts whose event function vanishes at a change; empty where there is none.
pub(super) fn changed_contacts(system: &System, change: &Change) -> String {
    let Change::Sequence { contacts, .. } = change else {
        return String::new();
    };
    let names = contacts
        .iter()
        .map(|contact| contact_name(system, *contact));
    names.collect::<Vec<_>>().join(" and ")
}

/// A change for other programs: as it is on disk, but for the contacts, which have their names.
pub(super) fn change_json(system: &System, change: &Change) -> Value {
    let mut json = json!(change);
    if let Some(Value::Array(contacts)) = json.pointer_mut("/sequence/contacts") {
        for contact in contacts {
            let number = contact.as_u64().and_then(|number| number.try_into().ok());
            *contact = number.map_or(Value::Null, |number| json!(contact_name(system, number)));
        }
    }
    json
}

/// What a change of an attractor is called.
pub(super) fn change_name(change: &Change) -> String {
    match change {
        Change::Sequence { name, .. } if name == "unnamed" => {
            "a change of the phases that has no name".to_owned()
        }
        Change::Sequence { name, .. } | Change::Multiplier { name, .. } => name.clone(),
        Change::Equilibrium { frequency, .. } if *frequency > 0.0 => {
            "Hopf bifurcation of the equilibrium".to_owned()
        }
        Change::Equilibrium { .. } => "zero eigenvalue of the equilibrium".to_owned(),
        Change::BoundaryEquilibrium { .. } => "boundary-equilibrium bifurcation".to_owned(),
        Change::Unlocated => "not located".to_owned(),
    }
}
