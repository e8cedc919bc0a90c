//! What was understood of a file, for other programs.

use serde_json::{Value, json};

use super::super::{recording, tables, tangents};
use super::whereabouts;
use crate::tangents::{Line, OnLine};
use stickslip_kernels::file::System;
use stickslip_kernels::file::{Contact, Formula, Rate};

/// The text of an expression that may be missing.
fn text(formula: Option<&Formula>) -> Option<&str> {
    formula.map(|formula| formula.text.as_str())
}

pub(super) fn understood(
    system: &System,
    on_boundary: Option<&(Line, Vec<(Line, OnLine)>)>,
    doubts: &[String],
) -> Value {
    let file = &system.file;
    let start = system.built.start.as_deref();
    let states = file.states.iter().enumerate().map(|(k, state)| {
        json!({
            "name": state.name,
            "unit": state.unit,
            "meaning": state.meaning,
            "start": start.map(|start| start[k]),
            "range": state.range,
        })
    });
    let parameters = file.parameters.iter().zip(&system.values);
    let parameters = parameters.map(|(parameter, &value)| {
        json!({
            "name": parameter.name,
            "value": value,
            "in_file": parameter.value,
            "unit": parameter.unit,
            "meaning": parameter.meaning,
            // JSON has no infinity: an end that is none is null.
            "range": parameter.range,
        })
    });
    let contacts = file.contacts.iter().enumerate();
    let contacts = contacts.map(|(k, one)| contact(system, k, one));
    let definitions = file.definitions.iter();
    let definitions =
        definitions.map(|one| json!({ "name": one.name, "formula": one.formula.text }));
    let field = file.states.iter().zip(&file.field);
    let field = field.map(|(state, rate)| match rate {
        Rate::Same(formula) => json!({ "state": state.name, "rate": formula.text }),
        Rate::BySide { below, above } => {
            json!({ "state": state.name, "below": below.text, "above": above.text })
        }
    });
    let section = file.section.as_ref().map(|section| {
        json!({
            "function": section.function.text,
            "direction": recording::direction_name(section.direction),
        })
    });
    json!({
        "system": tables::system_json(system),
        "description": file.description,
        "states": states.collect::<Vec<_>>(),
        "parameters": parameters.collect::<Vec<_>>(),
        "contacts": contacts.collect::<Vec<_>>(),
        "definitions": definitions.collect::<Vec<_>>(),
        "field": field.collect::<Vec<_>>(),
        "time": {
            "depends_on_time": system.built.depends_on_time,
            "period": system.built.period,
            "start": system.built.t_start,
            "end": system.built.t_end,
            "unit": file.time.unit,
        },
        "section": section,
        "boundary": on_boundary.map(|(line, found)| tangents::json(system, line, found)),
        "doubtful": doubts,
    })
}

fn contact(system: &System, number: usize, contact: &Contact) -> Value {
    let start = system.built.start.as_deref().map(|start| {
        let height = system.boundary(number, system.built.t_start, start);
        json!({ "side": whereabouts(height), "height": height })
    });
    json!({
        "name": contact.name,
        "boundary": contact.boundary.text,
        "friction": text(contact.friction.as_ref()),
        "static": text(contact.holding.as_ref()),
        "normal_force": text(contact.normal_force.as_ref()),
        "start": start,
    })
}
