//! Special orbits in words and as JSON objects.

use serde_json::{Value, json};
use stickslip::analysis::{CycleBifurcation, SpecialPoint};
use stickslip::error::readable;
use stickslip_model::file::System;
use stickslip_model::study::criticality_of;

use super::super::changes;

/// A special orbit in words.
pub(super) fn words(at: &SpecialPoint, system: &System) -> String {
    let side = || match criticality_of(at) {
        Some(side) => side.to_string(),
        None => "super- or subcritical: not determined".to_owned(),
    };
    match &at.what {
        CycleBifurcation::Flip => format!("{}, {}", at.what, side()),
        CycleBifurcation::NeimarkSacker { angle } => {
            format!("{}, angle {}, {}", at.what, readable(*angle), side())
        }
        CycleBifurcation::Sequence(change) => {
            let name = changes::words(system, change);
            match changes::phases(system, change) {
                [before, after] if !before.is_empty() && !after.is_empty() => {
                    format!("{name}, between phases {before} and {after}")
                }
                _ => name,
            }
        }
        CycleBifurcation::Unresolved { before, after } => format!(
            "{}: {after} multipliers are outside the unit circle instead of {before}, and no \
             bifurcation that explains it was resolved",
            at.what
        ),
        other => other.to_string(),
    }
}

pub(super) fn json(at: &SpecialPoint, system: &System) -> Value {
    let (angle, change) = match &at.what {
        CycleBifurcation::NeimarkSacker { angle } => (Some(angle), None),
        CycleBifurcation::Sequence(change) => (None, Some(changes::sequence_json(system, change))),
        _ => (None, None),
    };
    json!({
        "parameter": at.parameter,
        "uncertainty": at.uncertainty,
        "what": at.what.to_string(),
        "behind": at.behind,
        "period": at.period,
        "x": at.x.as_slice(),
        "angle": angle,
        "criticality": criticality_of(at).map(|side| side.to_string()),
        "normal_form": at.normal_form.map(|form| json!({
            "coefficient": form.coefficient,
            "uncertainty": form.uncertainty,
        })),
        "change": change,
    })
}
