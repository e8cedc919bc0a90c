//! Evidence for the paper's statements: what was measured, which parts of a statement that bears out, and a line on it.
//!
//! One file for each statement or group of statements. Each has a `compute` that runs the solver or the listing and keeps plain
//! numbers; [`Evidence`] says what they come to.

mod arcs;
mod beside_curves;
mod by_procedure;
mod exact_lengths;
mod exits;
mod found_by_appendix;
mod grid;
mod inner_points;
mod no_friction;
mod oscillating_boundary;
mod said_of_fig08;
mod shapes;
mod sigma;
mod stick_ends;
mod stick_phases;
mod tangent_set;
mod until_tangent;
mod zone_attracts;
mod zone_location;
mod zone_oscillates;

pub use crate::figures::rows::Part;
pub use arcs::{Arcs, Sides};
pub use beside_curves::{Beside, BesideCurves};
pub use by_procedure::ByProcedure;
pub use exact_lengths::ExactLengths;
pub use exits::{Exits, OfListing, OfModel};
pub use found_by_appendix::FoundByAppendix;
pub use inner_points::{InnerPoints, Ride};
pub use no_friction::NoFriction;
pub use oscillating_boundary::OscillatingBoundary;
pub use said_of_fig08::{FromPoint, Start, Way};
pub use shapes::{Kind, Shape, Shapes};
pub use sigma::{Model, Sigma};
pub use stick_phases::Followed;
pub use tangent_set::TangentSet;
pub use until_tangent::{Meetings, UntilTangent};
pub use zone_attracts::{Sweep, SweepPoint, ZoneAttracts};
pub use zone_location::{Moved, ZoneLocation};
pub use zone_oscillates::ZoneOscillates;

use crate::paper::listing::ListingError;
use crate::paper::published::PublishedError;
use stickslip::error::Error;
use stickslip::filippov::Failure;

/// How much of a statement holds.
#[cfg(test)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Support {
    /// Every part.
    Whole,
    /// Some parts, and others fail.
    InPart,
    /// No part.
    Nothing,
}

#[cfg(test)]
impl Support {
    /// What a statement with these parts comes to.
    pub fn of(parts: &[Part]) -> Support {
        let held = parts.iter().filter(|part| part.holds).count();
        match held {
            0 => Support::Nothing,
            _ if held == parts.len() => Support::Whole,
            _ => Support::InPart,
        }
    }
}

/// What a computation says of a statement.
pub trait Evidence {
    /// The statement's parts, each judged by the measured numbers.
    fn parts(&self) -> Vec<Part>;
    /// What the listing as printed makes of the statement, where it was looked at too; decides nothing of the model.
    fn as_printed(&self) -> Vec<Part> {
        Vec::new()
    }
    /// The numbers in one sentence.
    fn line(&self) -> String;
    /// How much of the statement holds.
    #[cfg(test)]
    fn support(&self) -> Support {
        Support::of(&self.parts())
    }
}

/// Why evidence could not be computed.
#[derive(Debug, thiserror::Error)]
pub enum EvidenceError {
    /// The solver failed.
    #[error(transparent)]
    Solver(#[from] Error),
    /// The listing cannot run.
    #[error(transparent)]
    Listing(#[from] ListingError),
    /// The table of claims lacks a number.
    #[error(transparent)]
    Published(#[from] PublishedError),
}

impl<R> From<Failure<R>> for EvidenceError {
    fn from(failure: Failure<R>) -> EvidenceError {
        EvidenceError::Solver(failure.error)
    }
}

/// A small number for a line: its size, or that it is none.
fn small(value: f64) -> String {
    if value == 0.0 {
        "0".to_owned()
    } else {
        format!("{value:.0e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_statement_holds_in_part_when_some_parts_fail() {
        let part = |holds| Part {
            what: "a part",
            holds,
        };
        assert_eq!(Support::of(&[part(true), part(true)]), Support::Whole);
        assert_eq!(Support::of(&[part(true), part(false)]), Support::InPart);
        assert_eq!(Support::of(&[part(false)]), Support::Nothing);
        assert_eq!(Support::of(&[]), Support::Nothing);
    }
}
