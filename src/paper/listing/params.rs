//! Parameters and extent of a run.

use std::f64::consts::PI;

use super::defects::Defects;
use super::error::ListingError;
use stickslip::math;

/// Length of the listing's run (s), line 3: N·h. Its motion has settled then.
pub const END: f64 = 63.3;
/// Steps a run may take at most: some minutes of computing.
const MAX_STEPS: f64 = 1e9;
/// Steps a forcing period needs at least.
const STEPS_PER_PERIOD: f64 = 20.0;
/// How far the spring force at a tangent point may be from ±μ0, relative to μ0 or k1.
const TANGENT_TOLERANCE: f64 = 1e-9;

/// The oscillator's parameters and start; the default is that of Fig. 8 (Sect. 4.1, lines 2–9).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Params {
    /// Mass `m` in kilograms.
    pub mass: f64,
    /// Belt speed `vp` in metres per second, above 0 (the listing's `a`).
    pub belt_speed: f64,
    /// Static friction `μ0` in newtons (the listing's `b`).
    pub mu0: f64,
    /// Linear stiffness `k1` in newtons per metre.
    pub k1: f64,
    /// Cubic stiffness `k2` in newtons per cubic metre.
    pub k2: f64,
    /// Amplitude `A` of the forcing in metres.
    pub amplitude: f64,
    /// Angular frequency `ω` of the forcing in radians per second.
    pub omega: f64,
    /// The six tangent points of Eq. (24) in metres, largest first (the listing's `T`).
    ///
    /// They follow from `mu0`, `k1` and `k2`; the listing has them as constants, and so they are
    /// given.
    pub tangent_points: [f64; 6],
    /// Time of the start in seconds.
    pub t0: f64,
    /// Displacement at the start in metres.
    pub x1: f64,
    /// Velocity at the start in metres per second.
    pub x2: f64,
}

impl Default for Params {
    /// Fig. 8, each constant by the operations of lines 3–9.
    fn default() -> Self {
        let c = 2.0 * 3f64.sqrt() / 3.0;
        let tangent_points = [
            c * math::cos(PI / 9.0),
            c * math::cos(2.0 * PI / 9.0),
            c * math::sin(PI / 18.0),
            -c * math::sin(PI / 18.0),
            -c * math::cos(2.0 * PI / 9.0),
            -c * math::cos(PI / 9.0),
        ];
        Params {
            mass: 0.1,
            belt_speed: 0.4,
            mu0: 3f64.sqrt() / 9.0,
            k1: 1.0,
            k2: 1.0,
            amplitude: 4.0 * 3f64.sqrt() / 3.0 * math::sin(PI / 18.0),
            omega: 3.0 * PI / 2.0 / 1.2364,
            tangent_points,
            t0: 0.0,
            x1: tangent_points[3],
            x2: 0.4,
        }
    }
}

impl Params {
    /// Forcing period `2π/ω` in seconds.
    pub fn period(&self) -> f64 {
        2.0 * PI / self.omega
    }

    /// Displacement `A sin(ωt)` of the forcing in metres at time `t` in seconds (line 86).
    pub fn harmonic(&self, t: f64) -> f64 {
        self.amplitude * math::sin(self.omega * t)
    }

    /// Spring force `s = k2 z³ − k1 z` in newtons at the stretch `z` in metres (lines 53, 69).
    ///
    /// The cube goes through a power as in the listing: a product rounds differently.
    pub fn spring(&self, z: f64) -> f64 {
        -self.k1 * z + self.k2 * math::pow(z, 3.0)
    }

    fn validate(&self) -> Result<(), ListingError> {
        for (name, value, bound) in [
            ("mass", self.mass, POSITIVE),
            ("belt_speed", self.belt_speed, POSITIVE),
            ("mu0", self.mu0, NOT_NEGATIVE),
            ("k1", self.k1, POSITIVE),
            ("k2", self.k2, POSITIVE),
            ("amplitude", self.amplitude, NOT_NEGATIVE),
            ("omega", self.omega, POSITIVE),
            ("t0", self.t0, FINITE),
            ("x1", self.x1, FINITE),
            ("x2", self.x2, FINITE),
        ] {
            hold(name, value, bound)?;
        }
        for value in self.tangent_points {
            hold("tangent_points", value, FINITE)?;
        }
        self.validate_tangent_points()
    }

    fn validate_tangent_points(&self) -> Result<(), ListingError> {
        let mut previous = f64::INFINITY;
        for (index, &value) in self.tangent_points.iter().enumerate() {
            if value > previous {
                return Err(ListingError::TangentOrder {
                    index,
                    value,
                    previous,
                });
            }
            previous = value;
            let force = self.spring(value);
            if (force.abs() - self.mu0).abs() > TANGENT_TOLERANCE * self.mu0.max(self.k1) {
                return Err(ListingError::NotTangent {
                    index,
                    value,
                    force,
                    mu0: self.mu0,
                });
            }
        }
        Ok(())
    }
}

/// One run: what, with which defects, at which step, for how long.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setup {
    /// The oscillator and its start.
    pub params: Params,
    /// Which defects are present.
    pub defects: Defects,
    /// Step `h` in seconds (line 3: 1e-4).
    pub h: f64,
    /// Start of the plotted window in seconds after the start (line 3: N0·h = 60).
    pub window_start: f64,
    /// Length of the run in seconds (line 3: N·h = 63.3).
    pub end: f64,
}

impl Default for Setup {
    /// The listing as printed.
    fn default() -> Self {
        Setup {
            params: Params::default(),
            defects: Defects::AS_PRINTED,
            h: 1e-4,
            window_start: 60.0,
            end: END,
        }
    }
}

impl Setup {
    /// The listing as printed from another start: time (s), position (m) and velocity (m/s).
    pub fn starting(t0: f64, x1: f64, x2: f64) -> Setup {
        let params = Params {
            t0,
            x1,
            x2,
            ..Params::default()
        };
        Setup {
            params,
            ..Setup::default()
        }
    }

    /// The listing from its own start with some of its defects.
    pub fn with(defects: Defects) -> Setup {
        Setup {
            defects,
            ..Setup::default()
        }
    }

    /// Whether the run can be made; [`run`](super::run) asks this first.
    ///
    /// # Errors
    ///
    /// The first [`ListingError`] found.
    pub fn validate(&self) -> Result<(), ListingError> {
        self.params.validate()?;
        for (name, value) in [("h", self.h), ("end", self.end)] {
            hold(name, value, POSITIVE)?;
        }
        let bound = self.params.period() / STEPS_PER_PERIOD;
        if self.h > bound {
            return Err(ListingError::StepTooLong { h: self.h, bound });
        }
        let steps = self.end / self.h;
        if steps > MAX_STEPS {
            return Err(ListingError::TooManySteps {
                steps,
                bound: MAX_STEPS,
            });
        }
        if !(0.0..=self.end).contains(&self.window_start) {
            return Err(ListingError::WindowOutside {
                window_start: self.window_start,
                end: self.end,
            });
        }
        Ok(())
    }

    /// `N`: the last pass of the loop `while i <= N`, the same time span whatever the step.
    pub(super) fn last_step(&self) -> u64 {
        (self.end / self.h).round() as u64
    }

    /// `N0`: the first pass of the window.
    pub(super) fn first_window_step(&self) -> u64 {
        (self.window_start / self.h).round() as u64
    }
}

/// What a number must be, and whether it is.
type Bound = (&'static str, fn(f64) -> bool);
const FINITE: Bound = ("a finite number", |_| true);
const NOT_NEGATIVE: Bound = ("a finite number, 0 or more", |value| value >= 0.0);
const POSITIVE: Bound = ("a finite number above 0", |value| value > 0.0);

fn hold(name: &'static str, value: f64, (bound, within): Bound) -> Result<(), ListingError> {
    match within(value) && value.is_finite() {
        true => Ok(()),
        false => Err(ListingError::OutOfRange { name, value, bound }),
    }
}
