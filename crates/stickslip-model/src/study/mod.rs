//! Studies of a system from a file, shared by the program and the Python package.

mod at_start;
mod branch;
mod branch_rows;
mod derivatives;
mod diagram;
pub mod ensemble;
mod equilibria;
mod extremes;
pub mod fit;
mod friction;
pub mod largest;
pub mod least_squares;
mod orbit_derivatives;
pub mod past;
mod phases;
mod reached;
mod search;
pub mod shares;
mod step_monitor;
pub mod tangents;
mod warnings;

use stickslip::analysis::RecurrenceSettings;

pub use at_start::{jumps_at_start, left_out_at_start};
pub use branch::{BranchOrbit, Followed, ParameterLine, SideBranch, TwoSidedBranch};
pub use branch_rows::{BranchEnd, SpecialRow, criticality_of, word_of_curve_stop};
pub use derivatives::{
    DerivativeError, NoVariable, START_TIME, Variables, VariedSystem, VariedTangents,
};
pub use diagram::{AtValue, Diagram, Locates};
pub use equilibria::{EquilibriaOfBranch, boundary_of, equilibrium, frequency_of};
pub use extremes::extremes;
pub use friction::FrictionWatch;
pub(crate) use friction::negative_at;
pub use orbit_derivatives::{NoMultiplierDerivatives, OrbitSlopes, OrbitVariables};
pub use phases::phases_of_period;
pub use reached::reported;
pub use search::{BOUND_OF_TIMES, MOST_PERIODS, MOTION_SEARCH_TIME, PeriodicSearch, SearchError};
pub use step_monitor::StepMonitor;
pub use warnings::warnings;

use crate::file::System;

/// Settings of the attractor search. A driven system is observed at strobe times.
pub fn recurrence(system: &System, until: f64) -> RecurrenceSettings {
    RecurrenceSettings {
        forcing: system.built.period,
        ..RecurrenceSettings::within(until)
    }
}
