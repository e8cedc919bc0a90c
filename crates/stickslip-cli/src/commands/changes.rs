//! Changes of an attractor at a parameter value, in words and for tables.

use serde_json::{Value, json};
use stickslip::analysis::{CycleBifurcation, NotFollowed, SequenceChange, WhatChanges};
use stickslip_model::file::System;

/// Phases before and after a change of the phases.
pub(super) fn phases(system: &System, change: &SequenceChange) -> [String; 2] {
    [&change.before, &change.after].map(|phases| system.sequence(phases))
}

/// The change of the phases, if it is one.
pub(super) fn sequence(change: &WhatChanges) -> Option<&SequenceChange> {
    match change {
        WhatChanges::Sequence(change) => Some(change),
        _ => None,
    }
}

/// The period of an orbit that doubles there.
pub(super) fn period_of_flip(change: &WhatChanges) -> Option<f64> {
    match change {
        WhatChanges::Multiplier { what, period, .. } if *what == CycleBifurcation::Flip => {
            Some(*period)
        }
        _ => None,
    }
}

/// A change of the phases in words: its name, with the contacts if the system has several.
pub(super) fn words(system: &System, change: &SequenceChange) -> String {
    let mut words = change.bifurcation.to_string();
    let contacts = system.contact_names(&change.contacts);
    if !contacts.is_empty() && system.contacts() + system.file.jumps.len() > 1 {
        words = format!("{words} of {contacts}");
    }
    let [before, after] = [&change.before, &change.after];
    if before.is_empty() != after.is_empty() {
        let phases = if after.is_empty() { before } else { after };
        let phases = system.sequence(phases);
        words = format!("{words}, where an orbit of phases {phases} ends: none was found beyond");
    }
    words
}

/// Whether the motion at the next value is not the orbit that is followed through these changes.
/// `reached` is the class of that motion.
pub(super) fn lose_attractor(system: &System, changes: &[&WhatChanges], reached: &str) -> bool {
    let ends = |change: &&WhatChanges| match change {
        WhatChanges::Sequence(change) => change.before.is_empty() != change.after.is_empty(),
        WhatChanges::Multiplier { what, .. } => *what == CycleBifurcation::Fold,
        _ => false,
    };
    let last = changes.last().and_then(|change| sequence(change));
    let is_other = last
        .is_some_and(|change| !reached.ends_with(&format!(", {}", system.sequence(&change.after))));
    is_other || changes.iter().any(ends)
}

/// A change as JSON, with contacts and jumps by name.
pub(super) fn json(system: &System, change: &WhatChanges) -> Value {
    match change {
        WhatChanges::Sequence(change) => sequence_json(system, change),
        WhatChanges::Equilibrium {
            parameter,
            x,
            frequency,
        } => json!({ "equilibrium": {
            "parameter": parameter,
            "x": x.as_slice(),
            "frequency": frequency,
        } }),
        WhatChanges::BoundaryEquilibrium { parameter, x } => {
            json!({ "boundary-equilibrium": { "parameter": parameter, "x": x.as_slice() } })
        }
        WhatChanges::Multiplier {
            parameter,
            uncertainty,
            what,
            x,
            period,
            criticality,
        } => json!({ "multiplier": {
            "parameter": parameter,
            "uncertainty": uncertainty,
            "name": what.to_string(),
            "x": x.as_slice(),
            "period": period,
            "criticality": criticality.map(|side| side.to_string()),
        } }),
        WhatChanges::NotFollowed(why) => json!({ "not-followed": match why {
            NotFollowed::Loops(loops) => json!({ "loops": loops }),
            NotFollowed::Budget => json!("budget"),
        } }),
        WhatChanges::Unlocated => json!("unlocated"),
    }
}

/// A change of the phases as JSON.
pub(super) fn sequence_json(system: &System, change: &SequenceChange) -> Value {
    let contacts = change.contacts.iter();
    let [before, after] = [&change.before, &change.after].map(|phases| -> Value {
        let words = phases.iter();
        words
            .map(|modes| system.with_jump(modes.to_string(), modes))
            .collect()
    });
    json!({ "sequence": {
        "parameter": change.parameter,
        "uncertainty": change.uncertainty,
        "name": change.bifurcation.to_string(),
        "contacts": contacts.map(|&contact| system.contact_name(contact)).collect::<Value>(),
        "x": change.x.as_slice(),
        "period": change.period,
        "before": before,
        "after": after,
    } })
}
