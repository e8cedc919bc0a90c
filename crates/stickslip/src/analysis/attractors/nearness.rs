//! When two states count as the same, and where an orbit has been.

use crate::system::State;

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
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    pub low: Vector,
    pub high: Vector,
}

impl Extent {
    pub fn of(x: &Vector) -> Self {
        Extent { low: *x, high: *x }
    }

    pub fn include(&mut self, x: &Vector) {
        for i in 0..N {
            self.low[i] = self.low[i].min(x[i]);
            self.high[i] = self.high[i].max(x[i]);
        }
    }

    pub fn join(&mut self, other: &dyn Dynamicself) {
        self.include(&other.low);
        self.include(&other.high);
    }

    /// Largest size of a component.
    pub fn size(&self, i: usize) -> f64 {
        self.low[i].abs().max(self.high[i].abs())
    }
}
