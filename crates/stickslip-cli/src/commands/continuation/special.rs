//! Special orbits in words and as JSON objects.

use serde_json::{Value, json};
use stickslip::analysis::{CycleBifurcation, SpecialPoint};
use stickslip::error::readable;
use stickslip_kernels::file::System;
use stickslip_kernels::kernel::Change;

use super::super::changes;

/// The change of the phases at a special orbit, if it is one.
pub(super) fn change(at: &SpecialPoint) -> Option<Change> {
    match &at.what {
        CycleBifurcation::Sequence(change) => Some(Change::from(&**change)),
        _ => None,
    }
}

/// Name of a special orbit.
pub(super) fn name_of(at: &SpecialPoint) -> String {
    change(at).map_or_else(|| at.what.to_string(), |change| change.name())
}

/// A special orbit in words.
pub(super) fn words(at: &SpecialPoint, system: &System) -> String {
    if let Some(angle) = angle(at) {
        return format!("{}, angle {}", name_of(at), readable(angle));
    }
    let Some(change) = change(at) else {
        return name_of(at);
    };
    let name = changes::words(system, &change);
    match changes::phases(system, &change) {
        Some([before, after]) if !before.is_empty() && !after.is_empty() => {
            format!("{name}, between phases {before} and {after}")
        }
        _ => name,
    }
}

pub(super) fn angle(at: &SpecialPoint) -> Option<f64> {
    match at.what {
        CycleBifurcation::NeimarkSacker { angle } => Some(angle),
        _ => None,
    }
}

pub(super) fn json(at: &SpecialPoint, system: &System) -> Value {
    let change = change(at).map(|change| changes::json(system, &change));
    json!({
        "parameter": at.parameter,
        "uncertainty": at.uncertainty,
        "what": name_of(at),
        "behind": at.behind,
        "period": at.period,
        "x": at.x.as_slice(),
        "angle": angle(at),
        "change": change,
    })
}

/// A row of `special.csv`.
#[derive(Clone, Default)]
pub(super) struct SpecialRow {
    pub(super) branch: usize,
    /// The branches that begin here.
    pub(super) branches: String,
    pub(super) behind: usize,
    pub(super) parameter: f64,
    pub(super) what: String,
    pub(super) contacts: String,
    pub(super) angle: Option<f64>,
    pub(super) uncertainty: Option<f64>,
    pub(super) phases: Option<[String; 2]>,
    pub(super) period: Option<f64>,
    pub(super) x: Vec<f64>,
}

impl SpecialRow {
    pub(super) fn of(at: &SpecialPoint, system: &System) -> Self {
        let change = change(at);
        let contacts = change
            .as_ref()
            .map(|change| changes::contacts(system, change));
        SpecialRow {
            behind: at.behind,
            parameter: at.parameter,
            what: name_of(at),
            contacts: contacts.unwrap_or_default(),
            angle: angle(at),
            uncertainty: Some(at.uncertainty),
            phases: change
                .as_ref()
                .and_then(|change| changes::phases(system, change)),
            period: Some(at.period),
            x: at.x.as_slice().to_vec(),
            ..SpecialRow::default()
        }
    }
}
