//! What becomes of an attractor between two values of a parameter, without the number of states and contacts in its type, and on disk.

use serde::{Deserialize, Serialize};
use stickslip::analysis::{AttractorChange, SequenceChange, Special, WhatChanges};
use stickslip::dynamics::Modes;

use super::system::{ManyContacts, OneContact};

/// The equations of a system of any kind.
#[derive(Clone, Debug)]
pub enum Equations {
    /// Of one contact.
    OneContact(Box<OneContact>),
    /// Of several.
    ManyContacts(ManyContacts),
}

/// The equations at each value of a parameter; `None` where there are none.
pub type Family<'a> = dyn Fn(f64) -> Option<Equations> + 'a;

/// What becomes of an attractor between two neighbouring values of a parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Change {
    /// The phases of a periodic orbit: as [`stickslip::analysis::SequenceChange`], which says more of each.
    Sequence {
        /// The parameter.
        parameter: f64,
        /// How far from it other phases were seen, or its event function would be zero.
        uncertainty: f64,
        /// What it is called.
        name: String,
        /// The contacts whose event function vanishes, counted from 0; none where the change has no name.
        contacts: Vec<usize>,
        /// Where on the orbit.
        x: Vec<f64>,
        /// Period of the orbit.
        period: f64,
        /// The modes before it.
        before: Vec<Modes>,
        /// The modes after it; none where no orbit was found there.
        after: Vec<Modes>,
    },
    /// An equilibrium loses its stability, or gains it.
    Equilibrium {
        /// The parameter.
        parameter: f64,
        /// The equilibrium there.
        x: Vec<f64>,
        /// Size of the imaginary part of the eigenvalues that cross.
        frequency: f64,
    },
    /// An equilibrium comes to the edge of where its mode holds.
    BoundaryEquilibrium {
        /// The parameter.
        parameter: f64,
        /// The equilibrium there.
        x: Vec<f64>,
    },
    /// A periodic orbit that keeps its phases has a multiplier on the unit circle.
    Multiplier {
        /// The parameter.
        parameter: f64,
        /// By how much that may be off.
        uncertainty: f64,
        /// What it is called.
        name: String,
        /// A state on the orbit.
        x: Vec<f64>,
        /// Period of the orbit.
        period: f64,
    },
    /// It could not be located.
    Unlocated,
}

impl Change {
    pub(super) fn of(change: &AttractorChange) -> Self {
        match &change.what {
            WhatChanges::Sequence(change) => Change::of_sequence(change),
            WhatChanges::Equilibrium {
                parameter,
                x,
                frequency,
            } => Change::Equilibrium {
                parameter: *parameter,
                x: x.as_slice().to_vec(),
                frequency: *frequency,
            },
            WhatChanges::BoundaryEquilibrium { parameter, x } => Change::BoundaryEquilibrium {
                parameter: *parameter,
                x: x.as_slice().to_vec(),
            },
            WhatChanges::Multiplier {
                parameter,
                uncertainty,
                what,
                x,
                period,
            } => Change::Multiplier {
                parameter: *parameter,
                uncertainty: *uncertainty,
                name: special_name(what),
                x: x.as_slice().to_vec(),
                period: *period,
            },
            WhatChanges::Unlocated => Change::Unlocated,
        }
    }

    pub(super) fn of_sequence(change: &SequenceChange) -> Self {
        Change::Sequence {
            parameter: change.parameter,
            uncertainty: change.uncertainty,
            name: change.bifurcation.to_string(),
            contacts: change.contacts.clone(),
            x: change.x.as_slice().to_vec(),
            period: change.period,
            before: change.before.clone(),
            after: change.after.clone(),
        }
    }
}

/// What a special orbit is called.
fn special_name(what: &Special) -> String {
    match what {
        Special::Fold => "fold".to_owned(),
        Special::BranchPoint => "branch point".to_owned(),
        Special::Flip => "flip".to_owned(),
        Special::NeimarkSacker { .. } => "Neimark-Sacker".to_owned(),
        Special::Sequence(change) => change.bifurcation.to_string(),
    }
}
