//! The friction law of Eq. (2): dry friction that weakens with sliding speed.

use super::parameters::not_negative;
use stickslip::Error;

/// `T(v) = sgn(v) μ₀ / (1 + δ|v|)`, Eq. (2), for a unit normal force; at `v = 0` any force in
/// `[-μ₀, μ₀]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction {
    mu0: f64,
    delta: f64,
}

/// The friction force at one relative velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Force {
    /// Sliding: one value.
    Kinetic(f64),
    /// At rest relative to each other: any force up to this magnitude.
    Static {
        /// Largest magnitude.
        limit: f64,
    },
}

impl Friction {
    /// Coefficient of static friction `mu0 ≥ 0` and decay `delta ≥ 0` of kinetic friction, in
    /// seconds per metre (both 1-degree-of-freedom models of the paper have `delta = 1`).
    ///
    /// # Errors
    /// [`Error::Parameter`] if one of them is negative or not finite.
    pub fn new(mu0: f64, delta: f64) -> Result<Self, Error> {
        Ok(Self {
            mu0: not_negative("mu0", mu0)?,
            delta: not_negative("delta", delta)?,
        })
    }

    /// Coefficient of static friction.
    pub fn mu0(&self) -> f64 {
        self.mu0
    }

    /// Decay of kinetic friction, s/m.
    pub fn delta(&self) -> f64 {
        self.delta
    }

    /// Coefficient of kinetic friction `μₖ(v) = μ₀/(1 + δ|v|)` at the relative velocity `v`, m/s.
    pub fn coefficient(&self, v: f64) -> f64 {
        self.mu0 / (1.0 + self.delta * v.abs())
    }

    /// The friction force on the belt's side at the relative velocity `v`, m/s; on the body it acts
    /// as `-T`.
    pub fn force(&self, v: f64) -> Force {
        if v > 0.0 {
            Force::Kinetic(self.coefficient(v))
        } else if v < 0.0 {
            Force::Kinetic(-self.coefficient(v))
        } else {
            Force::Static { limit: self.mu0 }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn static_and_kinetic_friction_agree_at_rest() {
        let law = Friction::new(0.3, 1.0).unwrap();
        assert_eq!(law.force(0.0), Force::Static { limit: 0.3 });
        assert_eq!(law.force(-0.0), Force::Static { limit: 0.3 });
        assert_eq!(law.force(f64::MIN_POSITIVE), Force::Kinetic(0.3));
        assert_eq!(law.force(-f64::MIN_POSITIVE), Force::Kinetic(-0.3));
    }

    #[test]
    fn half_the_friction_is_left_at_the_speed_one_over_delta() {
        let law = Friction::new(0.3, 4.0).unwrap();
        assert_eq!(law.force(0.25), Force::Kinetic(0.15));
    }

    #[test]
    fn bad_parameters_are_named() {
        let error = Friction::new(-0.1, 1.0).unwrap_err();
        assert!(error.to_string().contains("mu0 = -0.1"));
        let error = Friction::new(0.1, f64::NAN).unwrap_err();
        assert!(error.to_string().contains("delta = NaN"));
    }

    proptest! {
        #[test]
        fn odd_and_bounded(mu0 in 0.0..10.0, delta in 0.0..10.0, v in 1e-6..100.0) {
            let law = Friction::new(mu0, delta).unwrap();
            let (Force::Kinetic(forward), Force::Kinetic(backward)) =
                (law.force(v), law.force(-v))
            else {
                return Err(TestCaseError::fail("sliding has one force"));
            };
            prop_assert_eq!(forward, -backward);
            prop_assert!((0.0..=mu0).contains(&forward));
            prop_assert!(law.coefficient(2.0 * v) <= law.coefficient(v));
        }
    }
}
