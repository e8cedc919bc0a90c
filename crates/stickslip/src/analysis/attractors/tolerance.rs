//! The tolerance within which two states are the same, and the range that an orbit has covered.

use crate::AbsoluteTolerance;
use crate::dynamics::Vector;

/// Tolerances of the solver by which computed points may be off. Chosen: the error of a step is
/// one, and a contracting orbit sums those of some steps.
pub(in crate::analysis) const SOLVER_TOLERANCES: f64 = 100.0;

/// Relative rounding of a sum of terms of the same size: some ten operations, each with some units
/// in the last place.
pub(super) const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// The distance within which two states are the same.
#[derive(Clone, Copy, Debug)]
pub(super) struct SameWithin {
    /// Part of a component's size.
    pub closeness: f64,
    /// Tolerance of the solver.
    pub rtol: f64,
    pub atol: AbsoluteTolerance,
}

impl SameWithin {
    /// Largest allowed difference of a component of this size.
    pub fn allowed(&self, component: usize, scale: f64) -> f64 {
        self.closeness * scale + self.rounding(component, scale)
    }

    /// Largest allowed difference of two phases of the forcing.
    pub fn allowed_of_phase(&self) -> f64 {
        self.closeness + self.rounding_of_time(1.0)
    }

    /// Difference that the solver leaves in a component of this size.
    pub fn rounding(&self, component: usize, scale: f64) -> f64 {
        SOLVER_TOLERANCES * (self.atol.of(component) + self.rtol * scale)
    }

    /// Difference that the solver leaves in a duration.
    pub fn rounding_of_time(&self, duration: f64) -> f64 {
        SOLVER_TOLERANCES * (self.atol.largest() + self.rtol * duration)
    }
}

/// Smallest and largest value of each component at the ends of steps.
#[derive(Clone, Debug)]
pub(super) struct Extent {
    pub low: Vector,
    pub high: Vector,
}

impl Extent {
    pub fn of(x: &[f64]) -> Self {
        let x = Vector::from_column_slice(x);
        Extent {
            low: x.clone(),
            high: x,
        }
    }

    pub fn include(&mut self, x: &[f64]) {
        for (i, x) in x.iter().enumerate() {
            self.low[i] = self.low[i].min(*x);
            self.high[i] = self.high[i].max(*x);
        }
    }

    pub fn join(&mut self, other: &Self) {
        self.include(other.low.as_slice());
        self.include(other.high.as_slice());
    }

    /// Largest size of a component.
    pub fn size(&self, i: usize) -> f64 {
        self.low[i].abs().max(self.high[i].abs())
    }
}
