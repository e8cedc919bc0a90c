//! Memory of a run, from which another run goes on from its end.

use super::Vector;
use super::jump_search::JumpMemory;
use crate::filippov::StepMemory;

/// The end of a run, from which another run goes on with the bits of a single one.
///
/// It holds the run before the first step that its end has shortened. The next step depends on
/// mode, step length, functions left at zero, and transitions that may accumulate. The other run
/// repeats that step at its own length, and reports what comes after the end of the first.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RunMemory {
    pub(super) t: f64,
    pub(super) x: Vector,
    /// Number of items that were reported since, up to the last transition.
    pub(super) items: usize,
    pub(super) step: StepMemory,
    pub(super) jumps: Option<JumpMemory>,
}

impl RunMemory {
    /// Time at which the run ended.
    pub fn t(&self) -> f64 {
        self.t
    }

    /// State at which the run ended.
    pub fn x(&self) -> &Vector {
        &self.x
    }
}

/// Items that a resumed run does not report again.
pub(super) struct Repeated {
    /// The end of the run before.
    pub(super) t: f64,
    pub(super) x: Vector,
    /// Number of items that run has reported.
    pub(super) items: usize,
}
