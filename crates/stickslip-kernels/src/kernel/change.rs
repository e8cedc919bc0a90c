//! Changes of an attractor between two parameter values, in the form stored on disk.

use serde::{Deserialize, Serialize};
use stickslip::analysis::{SequenceChange, WhatChanges};
use stickslip::dynamics::Modes;

/// A change of an attractor between two neighbouring parameter values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Change {
    /// The phases of a periodic orbit change; see [`stickslip::analysis::SequenceChange`] for
    /// details.
    Sequence {
        /// Parameter value.
        parameter: f64,
        /// Distance to the nearest value with other phases, or to the zero of the event function.
        uncertainty: f64,
        /// Name of the change.
        name: String,
        /// The contacts whose event function vanishes, counted from 0. Empty if the change has no
        /// name.
        contacts: Vec<usize>,
        /// State on the orbit.
        x: Vec<f64>,
        /// Period of the orbit.
        period: f64,
        /// Modes before the change.
        before: Vec<Modes>,
        /// Modes after the change; empty if no orbit was found there.
        after: Vec<Modes>,
    },
    /// An equilibrium loses or gains stability.
    Equilibrium {
        /// Parameter value.
        parameter: f64,
        /// Equilibrium at that value.
        x: Vec<f64>,
        /// Magnitude of the imaginary part of the crossing eigenvalues.
        frequency: f64,
    },
    /// An equilibrium reaches the limit of its mode.
    BoundaryEquilibrium {
        /// Parameter value.
        parameter: f64,
        /// Equilibrium at that value.
        x: Vec<f64>,
    },
    /// A multiplier of a periodic orbit reaches the unit circle, and the phases do not change.
    Multiplier {
        /// Parameter value.
        parameter: f64,
        /// Uncertainty of the parameter value.
        uncertainty: f64,
        /// Name of the bifurcation.
        name: String,
        /// A state on the orbit.
        x: Vec<f64>,
        /// Period of the orbit.
        period: f64,
    },
    /// The change could not be located.
    Unlocated,
}

impl Change {
    /// Name of the change.
    pub fn name(&self) -> String {
        match self {
            Change::Sequence { name, .. } | Change::Multiplier { name, .. } => name.clone(),
            Change::Equilibrium { frequency, .. } if *frequency > 0.0 => {
                "Hopf bifurcation of the equilibrium".to_owned()
            }
            Change::Equilibrium { .. } => "zero eigenvalue of the equilibrium".to_owned(),
            Change::BoundaryEquilibrium { .. } => "boundary-equilibrium bifurcation".to_owned(),
            Change::Unlocated => "not located".to_owned(),
        }
    }

    /// Parameter value, if it is located.
    pub fn parameter(&self) -> Option<f64> {
        match *self {
            Change::Sequence { parameter, .. }
            | Change::Equilibrium { parameter, .. }
            | Change::BoundaryEquilibrium { parameter, .. }
            | Change::Multiplier { parameter, .. } => Some(parameter),
            Change::Unlocated => None,
        }
    }

    /// Uncertainty of the parameter value, where it is known.
    pub fn uncertainty(&self) -> Option<f64> {
        match *self {
            Change::Sequence { uncertainty, .. } | Change::Multiplier { uncertainty, .. } => {
                Some(uncertainty)
            }
            _ => None,
        }
    }

    /// Period of the orbit, if it is one.
    pub fn period(&self) -> Option<f64> {
        match *self {
            Change::Sequence { period, .. } | Change::Multiplier { period, .. } => Some(period),
            _ => None,
        }
    }

    /// State at the change.
    pub fn state(&self) -> Option<Vec<f64>> {
        match self {
            Change::Sequence { x, .. }
            | Change::Equilibrium { x, .. }
            | Change::BoundaryEquilibrium { x, .. }
            | Change::Multiplier { x, .. } => Some(x.clone()),
            Change::Unlocated => None,
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
