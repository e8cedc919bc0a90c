//! Start, parameters and length of a run of the listing.

use std::f64::consts::PI;

use super::defects::Defects;
use crate::paper::models::ForcedOscillator;
use stickslip::{State, math};

/// The listing's step `h` (s), line 3.
pub const PRINTED_STEP: f64 = 1e-4;
/// Length of the listing's run (s), line 3: N·h. By then its motion has settled.
pub const END: f64 = 63.3;

/// One run: oscillator, start, defects, step and length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setup {
    /// The oscillator (lines 2–9), with the listing's own `w`. Its friction has 1 s/m for
    /// `delta`.
    pub model: ForcedOscillator,
    /// The six tangent points of Eq. (24) in metres, largest first (the listing's `T`).
    ///
    /// They follow from `mu0`, `k1` and `k2`, but the listing has them as constants.
    pub tangent_points: [f64; 6],
    /// The start: time (s), displacement (m) and velocity (m/s), the listing's `x`.
    pub start: [f64; 3],
    /// Defects that are present.
    pub defects: Defects,
    /// Step in seconds. Longer steps than a twentieth of the forcing period
    /// cannot distinguish periods.
    pub h: f64,
    /// Start of the plotted window in seconds after the start (line 3: N0·h = 60).
    pub window_start: f64,
    /// Length of the run in seconds (line 3: N·h = 63.3).
    pub end: f64,
}

impl Default for Setup {
    /// The listing as printed. Each tangent point is computed by the operations of lines 4–9.
    fn default() -> Self {
        let model = ForcedOscillator {
            omega: 3.0 * PI / 2.0 / 1.2364,
            ..ForcedOscillator::default()
        };
        let c = 2.0 * 3f64.sqrt() / 3.0;
        let upper = [
            c * math::cos(PI / 9.0),
            c * math::cos(2.0 * PI / 9.0),
            c * math::sin(PI / 18.0),
        ];
        let [t1, t2, t3] = upper;
        Setup {
            tangent_points: [t1, t2, t3, -t3, -t2, -t1],
            start: [0.0, -t3, model.belt_speed],
            model,
            defects: Defects::AS_PRINTED,
            h: PRINTED_STEP,
            window_start: 60.0,
            end: END,
        }
    }
}

impl Setup {
    /// The listing from its own start with these defects.
    pub fn with(defects: Defects) -> Setup {
        Setup {
            defects,
            ..Setup::default()
        }
    }

    /// Displacement (m) and velocity (m/s) at the start.
    pub fn state(&self) -> State<2> {
        let [_, x1, x2] = self.start;
        State::from([x1, x2])
    }

    /// `N`: the last pass of the loop `while i <= N`. The time span does not depend on the step.
    pub(super) fn last_step(&self) -> u64 {
        (self.end / self.h).round() as u64
    }

    /// `N0`: the first pass of the window.
    pub(super) fn first_window_step(&self) -> u64 {
        (self.window_start / self.h).round() as u64
    }
}
