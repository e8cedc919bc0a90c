//! The tolerance within which two states are the same, and the range that an orbit has covered.

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
    pub atol: f64,
}

impl SameWithin {
    /// Largest allowed difference of a component of this size.
    pub fn allowed(&self, scale: f64) -> f64 {
        self.closeness * scale + self.rounding(scale)
    }

    /// Difference that the solver leaves.
    pub fn rounding(&self, scale: f64) -> f64 {
        SOLVER_TOLERANCES * (self.atol + self.rtol * scale)
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
