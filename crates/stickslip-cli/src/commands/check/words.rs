//! What was understood of a file, in words.

use std::fmt::Write;

use stickslip::error::readable;

use super::whereabouts;
use crate::tangents::{Line, OnLine};
use stickslip_kernels::file::Rate;
use stickslip_kernels::file::System;

/// A line with a title in front.
fn entry(text: &mut String, title: &str, content: &str) {
    // Writing into a text cannot fail.
    let _ = writeln!(text, "{title:12}{content}");
}

/// Lines under one title.
fn lines(text: &mut String, title: &str, contents: impl IntoIterator<Item = String>) {
    for (k, content) in contents.into_iter().enumerate() {
        entry(text, if k == 0 { title } else { "" }, &content);
    }
}

/// A unit or meaning behind a value.
fn behind(parts: &[&str]) -> String {
    let parts = parts.iter().filter(|part| !part.is_empty());
    parts.map(|part| format!("  {part}")).collect()
}

/// What was understood, line by line.
pub(super) fn understood(
    system: &System,
    on_boundary: Option<&(Line, Vec<(Line, OnLine)>)>,
    doubts: &[String],
) -> String {
    let file = &system.file;
    let mut text = format!("{}\n", file.name);
    for row in file.description.iter().flat_map(|text| text.lines()) {
        let _ = writeln!(text, "  {row}");
    }
    text.push('\n');
    let start = system.built.start.as_deref();
    lines(
        &mut text,
        "states",
        file.states.iter().enumerate().map(|(k, state)| {
            let from = start.map_or_else(String::new, |start| {
                format!(", starts at {}", readable(start[k]))
            });
            let unit = if state.unit.is_empty() {
                String::new()
            } else {
                format!(" ({})", state.unit)
            };
            let meaning = state.meaning.as_deref().unwrap_or_default();
            format!("{}{unit}{from}{}", state.name, behind(&[meaning]))
        }),
    );
    lines(
        &mut text,
        "parameters",
        file.parameters
            .iter()
            .zip(&system.values)
            .map(|(parameter, &value)| {
                let meaning = parameter.meaning.as_deref().unwrap_or_default();
                let set = if value == parameter.value {
                    ""
                } else {
                    "(set)"
                };
                format!(
                    "{} = {}{}",
                    parameter.name,
                    readable(value),
                    behind(&[&parameter.unit, set, meaning])
                )
            }),
    );
    for contact in &file.contacts {
        entry(
            &mut text,
            "contact",
            &format!("{}: Σ is where {} = 0", contact.name, contact.boundary.text),
        );
        if let Some(friction) = &contact.friction {
            entry(
                &mut text,
                "",
                &format!("friction in slip  {}", friction.text),
            );
        }
        if let Some(holding) = &contact.holding {
            entry(
                &mut text,
                "",
                &format!("static friction   {}", holding.text),
            );
        }
        if let Some(force) = &contact.normal_force {
            entry(
                &mut text,
                "",
                &format!(
                    "normal force      {}; without it no contact and no friction",
                    force.text
                ),
            );
        }
    }
    lines(
        &mut text,
        "definitions",
        file.definitions
            .iter()
            .map(|definition| format!("{} = {}", definition.name, definition.formula.text)),
    );
    lines(
        &mut text,
        "field",
        file.states
            .iter()
            .zip(&file.field)
            .map(|(state, rate)| match rate {
                Rate::Same(formula) => format!("d{}/dt = {}", state.name, formula.text),
                Rate::BySide { below, above } => {
                    format!(
                        "d{}/dt = {} below, {} above",
                        state.name, below.text, above.text
                    )
                }
            }),
    );
    let period = system.built.period.map_or_else(String::new, |period| {
        format!(", period {}", readable(period))
    });
    let time = if system.built.depends_on_time {
        "the system depends on time"
    } else {
        "the system does not depend on time"
    };
    entry(&mut text, "time", &format!("{time}{period}"));
    if let Some(section) = &file.section {
        let direction = super::super::recording::direction_name(section.direction);
        entry(
            &mut text,
            "section",
            &format!("where {} = 0, passed {direction}", section.function.text),
        );
    }
    if let Some(start) = start {
        let t = system.built.t_start;
        lines(
            &mut text,
            "start",
            file.contacts.iter().enumerate().map(|(k, contact)| {
                let height = system.boundary(k, t, start);
                format!(
                    "{} the boundary of {} ({} = {})",
                    whereabouts(height),
                    contact.name,
                    contact.boundary.text,
                    readable(height)
                )
            }),
        );
    }
    if let Some((line, found)) = on_boundary {
        let listed = super::super::tangents::listing(system, line, found);
        let (low, high) = (readable(line.range.0), readable(line.range.1));
        let along = &file.states[line.along].name;
        entry(
            &mut text,
            "boundary",
            &format!(
                "along {along} from {low} to {high}, at t = {}:",
                readable(line.t)
            ),
        );
        lines(&mut text, "", listed);
    }
    lines(&mut text, "doubtful", doubts.iter().cloned());
    text
}
