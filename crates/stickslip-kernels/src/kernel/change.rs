//! What becomes of an attractor between two values of a parameter, on disk.

use serde::{Deserialize, Serialize};
use stickslip::analysis::{SequenceChange, WhatChanges};
use stickslip::dynamics::Modes;

/// What becomes of an attractor between two neighbouring values of a parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Change {
    /// The phases of a periodic orbit: as [`stickslip::analysis::SequenceChange`], which says more
    /// of each.
    Sequence {
        /// The parameter.
        parameter: f64,
        /// How far from it other phases were seen, or its event function would be zero.
        uncertainty: f64,
        /// What it is called.
        name: String,
        /// The contacts whose event function vanishes, counted from 0; none where the change has no
        /// name.
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
    /// What it is called.
    pub fn name(&self) -> String {
        match self {
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
}

impl From<&SequenceChange> for Change {
    fn from(change: &SequenceChange) -> Self {
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

impl From<&WhatChanges> for Change {
    fn from(change: &WhatChanges) -> Self {
        match change {
            WhatChanges::Sequence(change) => change.into(),
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
                name: what.to_string(),
                x: x.as_slice().to_vec(),
                period: *period,
            },
            WhatChanges::Unlocated => Change::Unlocated,
        }
    }
}
