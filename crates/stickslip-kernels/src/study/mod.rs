//! Studies of a system from a file that the program and the Python package share.

mod diagram;
mod largest;
mod search;

use stickslip::analysis::RecurrenceSettings;

pub use diagram::{AtValue, ChangeBetween, Diagram, ValueEnd};
pub use largest::Largest;
pub use search::{MOST_PERIODS, PeriodicSearch, SearchError, UNTIL};

use crate::file::System;

/// How attractors are looked for, of a driven system at the flashes of a strobe.
pub fn recurrence(system: &System, until: f64) -> RecurrenceSettings {
    RecurrenceSettings {
        forcing: system.built.period,
        ..RecurrenceSettings::within(until)
    }
}
