//! A bound of the work that an analysis may do.

use std::cell::Cell;

/// A number of integration steps that an analysis may take, counted down. Steps and not seconds:
/// the result is the same on every machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StepBudget {
    left: Cell<u64>,
}

impl StepBudget {
    /// A budget of so many steps.
    pub fn of(steps: u64) -> Self {
        StepBudget {
            left: Cell::new(steps),
        }
    }

    /// Count for a step that carries tangent vectors of so many states and of a parameter.
    pub(crate) fn with_tangents(states: usize) -> u64 {
        states as u64 + 2
    }

    /// Number of steps left.
    pub fn left(&self) -> u64 {
        self.left.get()
    }

    /// Whether no step is left.
    pub fn is_spent(&self) -> bool {
        self.left() == 0
    }

    /// Takes so many steps, or all that are left. Returns whether there were enough.
    pub fn spend(&self, steps: u64) -> bool {
        let left = self.left();
        self.left.set(left.saturating_sub(steps));
        steps <= left
    }
}
