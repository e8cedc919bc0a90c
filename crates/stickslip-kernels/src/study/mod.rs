//! Studies of a system from a file, shared by the program and the Python package.

mod branch;
mod diagram;
mod equilibria;
mod extremes;
mod largest;
mod phases;
mod search;
pub mod tangents;
mod warnings;

use stickslip::analysis::RecurrenceSettings;

pub use branch::{
    Along, BranchEnd, BranchOrbit, DirectedBranch, EndBifurcation, WholeBranch, only_once,
};
pub use diagram::{AtValue, ChangeBetween, Diagram, ValueEnd};
pub use equilibria::{EquilibriaOfBranch, equilibrium};
pub use extremes::Extremes;
pub use largest::Largest;
pub use phases::PhasesOfPeriod;
pub use search::{BOUND_OF_TIMES, MOST_PERIODS, MOTION_SEARCH_TIME, PeriodicSearch, SearchError};
pub use warnings::warnings;

use crate::file::System;

/// Settings of the attractor search. A driven system is observed at strobe times.
pub fn recurrence(system: &System, until: f64) -> RecurrenceSettings {
    RecurrenceSettings {
        forcing: system.built.period,
        ..RecurrenceSettings::within(until)
    }
}
