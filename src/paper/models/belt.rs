//! Model 1 of the paper: a block on a belt, tied by a double-well spring.

use super::parameters::{finite, not_negative, positive};
use stickslip::{Error, Filippov, Scalar, Side};

/// Eq. (3)–(5): `m ẍ = k1 x − k2 x³ − T(ẋ − vp)` with dry friction `T(v) = sgn(v) μ0/(1 + δ|v|)`.
///
/// State: position `x₁` and velocity `x₂`. Σ is `x₂ = vp`: there the block rides the belt. The
/// `Default` is the paper's Fig. 4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BeltOscillator {
    /// Mass m (kg), positive.
    pub mass: f64,
    /// Linear stiffness k1 (N/m): it pushes away from 0.
    pub k1: f64,
    /// Cubic stiffness k2 (N/m³): it pulls back.
    pub k2: f64,
    /// Friction amplitude μ0 (static friction force), not negative.
    pub mu0: f64,
    /// Decay δ of kinetic friction with speed (s/m), not negative.
    pub delta: f64,
    /// Belt speed vp (m/s), not negative.
    pub belt_speed: f64,
}

impl Default for BeltOscillator {
    fn default() -> Self {
        BeltOscillator {
            mass: 1.0,
            k1: 1.0,
            k2: 1.0,
            mu0: 3f64.sqrt() / 9.0,
            delta: 1.0,
            belt_speed: 1.0,
        }
    }
}

impl Filippov<2> for BeltOscillator {
    #[inline(always)]
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
        let slip_speed = (x[1] - self.belt_speed) * side.sign();
        let friction = T::constant(self.mu0 * side.sign()) / (slip_speed * self.delta + 1.0);
        let spring = x[0] * (x[0] * x[0] * -self.k2 + self.k1);
        [x[1], (spring - friction) / self.mass]
    }

    #[inline(always)]
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[1] - self.belt_speed
    }

    fn check_parameters(&self) -> Result<(), Error> {
        positive("mass", self.mass)?;
        finite("k1", self.k1)?;
        finite("k2", self.k2)?;
        not_negative("mu0", self.mu0)?;
        not_negative("delta", self.delta)?;
        not_negative("belt_speed", self.belt_speed)?;
        Ok(())
    }
}
