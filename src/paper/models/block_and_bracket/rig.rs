//! The block and the bracket in physical units.

use super::super::parameters::{not_negative, positive};
use super::BlockAndBracket;
use stickslip::{Error, Filippov, Scalar, Side};

/// Fig. 9 in SI units, as Newton's law gives it (see [`BlockAndBracket`]).
///
/// State: block position (m) and velocity (m/s), displacement `y = rφ` of the bracket's end (m) and
/// its velocity (m/s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rig {
    /// Mass m of the block (kg).
    pub mass: f64,
    /// Moment of inertia J of the bracket (kg m²).
    pub inertia: f64,
    /// Arm r of the bracket (m).
    pub arm: f64,
    /// Spring k1 from wall to block (N/m).
    pub k1: f64,
    /// Spring k2 from block to bracket (N/m).
    pub k2: f64,
    /// Spring k3 under the bracket (N/m).
    pub k3: f64,
    /// Damper c1 from block to bracket (N s/m).
    pub c1: f64,
    /// Damper c2 under the bracket (N s/m).
    pub c2: f64,
    /// Gravity g (m/s²).
    pub gravity: f64,
    /// Coefficient μ0 of static friction.
    pub mu0: f64,
    /// Decay δ of kinetic friction with speed (s/m).
    pub delta: f64,
    /// Belt speed vp (m/s).
    pub belt_speed: f64,
}

impl Rig {
    /// Unit of time `1/ω` (s) of the nondimensional form.
    pub fn time_unit(&self) -> f64 {
        (self.mass / (self.k1 + self.k2)).sqrt()
    }

    /// Unit of length `L = mg/k2` (m) of the nondimensional form.
    pub fn length_unit(&self) -> f64 {
        self.mass * self.gravity / self.k2
    }

    /// The nondimensional form.
    pub fn nondimensional(&self) -> BlockAndBracket {
        let per_time = 1.0 / self.time_unit();
        let speed_unit = self.length_unit() * per_time;
        let square = per_time * per_time;
        BlockAndBracket {
            coupling: self.k2 / (square * self.mass),
            coupling_damping: self.c1 * per_time / self.k2,
            mobility: self.k2 * self.arm * self.arm / (square * self.inertia),
            bracket_stiffness: (self.k2 + self.k3) / self.k2,
            bracket_damping: per_time * (self.c1 + self.c2) / self.k2,
            mu0: self.mu0,
            unloading: self.k3 / self.k2,
            unloading_rate: per_time * self.c2 / self.k2,
            delta: self.delta * speed_unit,
            belt_speed: self.belt_speed / speed_unit,
            displacement_sign: 1.0,
            friction_sign: 1.0,
            clipped: true,
        }
    }

    /// The normal force at a state (N), unclipped: negative where the block would lift off.
    #[inline(always)]
    pub fn unclipped_normal_force<T: Scalar>(&self, x: &[T; 4]) -> T {
        let lift = x[2] * self.k3 + x[3] * self.c2;
        -lift + self.mass * self.gravity
    }

    /// The normal force at a state (N), zero where the block would lift off.
    #[inline(always)]
    pub fn normal_force<T: Scalar>(&self, x: &[T; 4]) -> T {
        self.unclipped_normal_force(x).max(T::constant(0.0))
    }
}

impl Filippov<4> for Rig {
    #[inline(always)]
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 4]) -> [T; 4] {
        let slip_speed = (x[1] - self.belt_speed) * side.sign();
        let coefficient = T::constant(self.mu0 * side.sign()) / (slip_speed * self.delta + 1.0);
        let coupling = (x[0] + x[2]) * self.k2 + (x[1] + x[3]) * self.c1;
        let support = x[2] * self.k3 + x[3] * self.c2;
        let on_block = -(x[0] * self.k1) - coupling - coefficient * self.normal_force(x);
        // J φ̈ = r F and y = rφ.
        let per_force = self.arm * self.arm / self.inertia;
        [
            x[1],
            on_block / self.mass,
            x[3],
            -(coupling + support) * per_force,
        ]
    }

    #[inline(always)]
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 4]) -> T {
        x[1] - self.belt_speed
    }

    #[inline(always)]
    fn contact<T: Scalar>(&self, _t: T, x: &[T; 4]) -> Option<T> {
        Some(self.unclipped_normal_force(x))
    }

    fn check_parameters(&self) -> Result<(), Error> {
        positive("mass", self.mass)?;
        positive("inertia", self.inertia)?;
        positive("arm", self.arm)?;
        not_negative("k1", self.k1)?;
        positive("k2", self.k2)?;
        not_negative("k3", self.k3)?;
        not_negative("c1", self.c1)?;
        not_negative("c2", self.c2)?;
        positive("gravity", self.gravity)?;
        not_negative("mu0", self.mu0)?;
        not_negative("delta", self.delta)?;
        not_negative("belt_speed", self.belt_speed)?;
        Ok(())
    }
}
