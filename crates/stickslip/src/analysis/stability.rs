//! The stability of a periodic orbit by its multipliers.

use std::fmt;

use nalgebra::Complex;

use crate::math::modulus;

/// Largest distance of a neutral multiplier from modulus 1: the square root of the error of an
/// orbit computed to 1e-12. If two multipliers meet at 1, as without damping, an error of the
/// monodromy matrix moves them by its square root.
pub(super) const NEUTRAL_DISTANCE: f64 = 1e-6;

/// The fate of a small deviation from a periodic orbit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stability {
    /// Dies out: all multipliers are inside the unit circle.
    Stable,
    /// Stays, to first order: a multiplier is on the unit circle, to 1e-6, and none outside.
    /// Multipliers of an orbit computed with a tolerance above 1e-12 may be less exact.
    Neutral,
    /// Grows: a multiplier is outside the unit circle.
    Unstable,
}

impl Stability {
    /// Stability by the multipliers without the trivial one of an autonomous system. NaN
    /// multipliers give an unstable orbit.
    ///
    /// ```
    /// use stickslip::analysis::Stability;
    /// use stickslip::nalgebra::Complex;
    ///
    /// assert_eq!(Stability::of(&[Complex::new(0.3, 0.4)]), Stability::Stable);
    /// assert_eq!(Stability::of(&[Complex::new(0.6, 0.8)]), Stability::Neutral);
    /// ```
    pub fn of(multipliers: &[Complex<f64>]) -> Self {
        let is = |within: f64| multipliers.iter().all(|&value| modulus(value) < within);
        if is(1.0 - NEUTRAL_DISTANCE) {
            Stability::Stable
        } else if is(1.0 + NEUTRAL_DISTANCE) {
            Stability::Neutral
        } else {
            Stability::Unstable
        }
    }

    /// Stability by the eigenvalues of an equilibrium. A pair may be imaginary to 1e-6 of the
    /// largest.
    pub(super) fn of_eigenvalues(eigenvalues: &[Complex<f64>]) -> Self {
        let sizes = eigenvalues.iter().map(|&value| modulus(value));
        let noise = NEUTRAL_DISTANCE * sizes.fold(0.0, f64::max);
        if eigenvalues.iter().all(|value| value.re < -noise) {
            Stability::Stable
        } else if eigenvalues.iter().all(|value| value.re <= noise) {
            Stability::Neutral
        } else {
            Stability::Unstable
        }
    }
}

impl fmt::Display for Stability {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Stability::Stable => "stable",
            Stability::Neutral => "neutral",
            Stability::Unstable => "unstable",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn multipliers_near_the_circle_are_neutral_and_no_numbers_unstable() {
        let of = |sizes: [f64; 2]| Stability::of(&sizes.map(|size| Complex::new(0.0, size)));
        assert_eq!(of([0.5, 1.0 - 2e-6]), Stability::Stable);
        assert_eq!(of([0.5, 1.0 - 1e-7]), Stability::Neutral);
        assert_eq!(of([-1.0 - 1e-7, 0.5]), Stability::Neutral);
        assert_eq!(of([-1.0 - 2e-6, 1.0]), Stability::Unstable);
        assert_eq!(of([0.0, f64::NAN]), Stability::Unstable);
        assert_eq!(Stability::of(&[]), Stability::Stable);
    }
}
