//! Special orbits in words and as JSON objects.

use serde_json::{Value, json};
use stickslip::analysis::{CycleBifurcation, SpecialPoint};
use stickslip::error::readable;
use stickslip_model::file::System;

use super::super::changes;

/// A special orbit in words.
pub(super) fn words(at: &SpecialPoint, system: &System) -> String {
    match &at.what {
        CycleBifurcation::NeimarkSacker { angle } => {
            format!("{}, angle {}", at.what, readable(*angle))
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
        "change": change,
    })
}
