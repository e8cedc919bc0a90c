//! Model 2 of the paper: a block on a belt, tied by a softening spring to a shaken support.

use super::parameters::{finite, not_negative, positive};
use stickslip::{Error, Filippov, Scalar, Side, math};

/// Eq. (17)–(18): `m ẍ = k2 z³ − k1 z − T(ẋ − vp)`, `z = x − A sin(ωt)`, with dry friction
/// `T(v) = sgn(v) μ0/(1 + δ|v|)`.
///
/// The spring has the opposite sign of model 1's. It pulls towards the support for small `|z|` and
/// pushes away beyond `√(k1/k2)`, where orbits escape. (Eq. (17) prints `+T`; friction opposes the
/// slip, as in Eq. (18) and the Appendix.) State: position `x₁`, velocity `x₂`; Σ is `x₂ = vp`. The
/// `Default` is the paper's Fig. 8.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForcedOscillator {
    /// Mass m (kg), positive.
    pub mass: f64,
    /// Linear stiffness k1 (N/m): it pulls back.
    pub k1: f64,
    /// Cubic stiffness k2 (N/m³): it pushes away.
    pub k2: f64,
    /// Friction amplitude μ0 (static friction force, N), not negative.
    pub mu0: f64,
    /// Decay δ of kinetic friction with speed (s/m), not negative.
    pub delta: f64,
    /// Belt speed vp (m/s), not negative.
    pub belt_speed: f64,
    /// Amplitude A of the support (m).
    pub amplitude: f64,
    /// Angular frequency ω of the support (rad/s), not negative.
    pub omega: f64,
}

impl Default for ForcedOscillator {
    fn default() -> Self {
        use std::f64::consts::PI;
        ForcedOscillator {
            mass: 0.1,
            k1: 1.0,
            k2: 1.0,
            mu0: 3f64.sqrt() / 9.0,
            delta: 1.0,
            belt_speed: 0.4,
            amplitude: 4.0 * 3f64.sqrt() / 3.0 * math::sin(PI / 18.0),
            omega: 3.0 * PI / 2.4728,
        }
    }
}

impl ForcedOscillator {
    /// Position of the support at time `t`: `A sin(ωt)` (m). The stick zones move with it.
    pub fn support(&self, t: f64) -> f64 {
        self.amplitude * math::sin(self.omega * t)
    }

    /// Forcing period 2π/ω (s).
    pub fn period(&self) -> f64 {
        2.0 * std::f64::consts::PI / self.omega
    }
}

impl Filippov<2> for ForcedOscillator {
    #[inline(always)]
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 2]) -> [T; 2] {
        let slip_speed = (x[1] - self.belt_speed) * side.sign();
        let friction = T::constant(self.mu0 * side.sign()) / (slip_speed * self.delta + 1.0);
        let z = x[0] - (t * self.omega).sin() * self.amplitude;
        let spring = z * (z * z * self.k2 - self.k1);
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
        finite("amplitude", self.amplitude)?;
        not_negative("omega", self.omega)?;
        Ok(())
    }
}
