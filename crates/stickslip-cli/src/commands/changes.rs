//! Changes of an attractor at a parameter value, in words and for tables.

use serde_json::{Value, json};
use stickslip_kernels::file::System;
use stickslip_kernels::kernel::Change;

/// Phases before and after the change, if the phases change.
pub(super) fn phases(system: &System, change: &Change) -> Option<[String; 2]> {
    match change {
        Change::Sequence { before, after, .. } => {
            Some([before, after].map(|phases| system.sequence(phases)))
        }
        _ => None,
    }
}

/// As [`Change::name`], with the contacts if the system has several.
pub(super) fn words(system: &System, change: &Change) -> String {
    let mut words = change.name();
    let contacts = contacts(system, change);
    if !contacts.is_empty() && system.contacts() + system.file.jumps.len() > 1 {
        words = format!("{words} of {contacts}");
    }
    match change {
        Change::Sequence { before, after, .. } if before.is_empty() != after.is_empty() => {
            let phases = if after.is_empty() { before } else { after };
            let phases = system.sequence(phases);
            format!("{words}, where an orbit of phases {phases} ends: none was found beyond")
        }
        _ => words,
    }
}

/// Whether the motion at the next value is not the orbit that is followed through these changes.
/// `reached` is the class of that motion.
pub(super) fn lose_attractor(system: &System, changes: &[&Change], reached: &str) -> bool {
    let ends = |change: &&Change| match change {
        Change::Sequence { before, after, .. } => before.is_empty() != after.is_empty(),
        Change::Multiplier { name, .. } => name == "fold",
        Change::Unlocated | Change::Equilibrium { .. } | Change::BoundaryEquilibrium { .. } => {
            false
        }
    };
    let is_other = match changes.last() {
        Some(Change::Sequence { after, .. }) => {
            !reached.ends_with(&format!(", {}", system.sequence(after)))
        }
        _ => false,
    };
    is_other || changes.iter().any(ends)
}

/// Contacts whose event function vanishes at a change; may be empty.
pub(super) fn contacts(system: &System, change: &Change) -> String {
    let Change::Sequence { contacts, .. } = change else {
        return String::new();
    };
    let names = contacts.iter().map(|contact| system.contact_name(*contact));
    names.collect::<Vec<_>>().join(" and ")
}

/// A change as JSON: as on disk, but with contacts and jumps by name.
pub(super) fn json(system: &System, change: &Change) -> Value {
    let mut json = json!(change);
    if let Some(Value::Array(contacts)) = json.pointer_mut("/sequence/contacts") {
        for contact in contacts {
            let number = contact.as_u64().and_then(|number| number.try_into().ok());
            *contact = number.map_or(Value::Null, |number| json!(system.contact_name(number)));
        }
    }
    if let Change::Sequence { before, after, .. } = change {
        for (key, phases) in [("before", before), ("after", after)] {
            let words = phases
                .iter()
                .map(|modes| system.with_jump(modes.to_string(), modes));
            json["sequence"][key] = words.collect();
        }
    }
    json
}
