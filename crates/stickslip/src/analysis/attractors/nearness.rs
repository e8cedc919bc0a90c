//! When two states count as the same, and where an orbit has been.

use crate::dynamics::Vector;

/// Tolerances by which two points may differ that the solver cannot tell apart.
pub(super) const OF_SOLVER: f64 = 100.0;

/// How near counts as the same.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nearness {
    /// Part of a component's size.
    pub closeness: f64,
    /// Of the solver.
    pub rtol: f64,
    pub atol: f64,
}

impl Nearness {
    /// By how much a component of this size may differ.
    pub fn allowed(&self, scale: f64) -> f64 {
        self.closeness * scale + self.rounding(scale)
    }

    /// What the solver leaves of a difference.
    pub fn rounding(&self, scale: f64) -> f64 {
        OF_SOLVER * (self.atol + self.rtol * scale)
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
