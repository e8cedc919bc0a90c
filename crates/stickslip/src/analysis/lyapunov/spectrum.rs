//! The result.

use crate::dynamics::Summary;
use crate::math;

/// Standard errors within which an exponent is the true one.
const STANDARD_ERRORS: f64 = 4.0;

/// A direction may have grown by so much without a rate of growth: over a broken number of turns.
/// Across a family of orbits it grows in proportion to the time. That is 11 times as long at the
/// end as after a transient of a tenth of it.
const END_EFFECT: f64 = 30.0;

/// One Lyapunov exponent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exponent {
    /// A rate of growth.
    Finite {
        /// The exponent, per unit of time.
        value: f64,
        /// Standard error from the means of the blocks; infinite when fewer than two were completed. It speaks of the
        /// fluctuation along a chaotic orbit, not of the end effects that a periodic one has over a broken number of periods.
        std_error: f64,
    },
    /// Stick takes the direction to zero in finite time: the exponent is −∞.
    Annihilated,
}

impl Exponent {
    /// The exponent, −∞ for an annihilated direction.
    pub fn value(&self) -> f64 {
        match *self {
            Exponent::Finite { value, .. } => value,
            Exponent::Annihilated => f64::NEG_INFINITY,
        }
    }

    /// By how much the exponent may be off that was measured for so long: four standard errors, and
    /// no less than what a direction shows that has grown by a factor of 30 without a rate of
    /// growth. That is what a motion without damping does, whose exponents are zero.
    pub fn uncertainty(&self, duration: f64) -> f64 {
        let scatter = STANDARD_ERRORS * self.std_error().unwrap_or(0.0);
        scatter.max(math::ln(END_EFFECT) / duration)
    }

    /// Standard error, if the exponent is finite.
    pub fn std_error(&self) -> Option<f64> {
        match *self {
            Exponent::Finite { std_error, .. } => Some(std_error),
            Exponent::Annihilated => None,
        }
    }
}

/// The exponents as they stood at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Running {
    /// Time since measuring began.
    pub elapsed: f64,
    /// Means over that time, in the order of the final exponents; −∞ from the entry into stick that annihilated the
    /// direction.
    pub exponents: Vec<f64>,
}

/// A Lyapunov spectrum.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// The exponents in descending order, annihilated ones last.
    pub exponents: Vec<Exponent>,
    /// The running exponents, equally spaced in time as far as steps allow; the last entry is the result.
    pub convergence: Vec<Running>,
    /// Rate at which the volume spanned by the surviving directions grows, from divergence and saltation instead of the frame's
    /// lengths; see [`Spectrum::defect`].
    pub volume_rate: f64,
    /// Mean divergence of the fields along the orbit, stick included. Without stick,
    /// `volume_rate` is this plus the mean of `ln|det S|` over the crossings.
    pub mean_divergence: f64,
    /// Entries into stick while measuring.
    pub stick_entries: usize,
    /// Collapses while measuring: entries into stick whose saltation matrix is singular and projects tangent space along a
    /// direction. All entries are, save those at which the two fields agree (no normal force, say). Only the
    /// first that meets a direction still alive annihilates it; [`Spectrum::annihilated`] counts those directions.
    pub collapses: usize,
    /// Part of the measured time spent in stick, of any contact.
    pub stick_fraction: f64,
    /// Time measured.
    pub duration: f64,
    /// How the measured run ended, where, and the work it took.
    pub summary: Summary,
}

impl Spectrum {
    /// Sum of the finite exponents.
    pub fn sum(&self) -> f64 {
        let finite = self.exponents.iter().map(Exponent::value);
        finite.filter(|value| value.is_finite()).sum()
    }

    /// How many exponents are −∞.
    pub fn annihilated(&self) -> usize {
        let dead = |exponent: &&Exponent| **exponent == Exponent::Annihilated;
        self.exponents.iter().filter(dead).count()
    }

    /// What the sum of the finite exponents differs from the rate of volume found without them: the error of integration and
    /// rounding, in the unit of an exponent. A large value says that tolerance or fixed step are too coarse.
    pub fn defect(&self) -> f64 {
        self.sum() - self.volume_rate
    }
}
