//! Model 3 of the paper: a block on a belt, coupled to a rotating bracket that unloads its contact.

mod reading;
mod rig;

pub use reading::{Amplitude, Caption, CaptionOrder, Interpretation, Unloading};
pub use rig::Rig;

use super::parameters::{finite, not_negative, positive};
use stickslip::{Error, Filippov, Scalar, Side};

/// Eq. (27)–(28), nondimensional.
///
/// # From Newton's law
/// A block of mass `m` at `x` rides a belt, tied to a wall by the spring `k1`. A bracket has the
/// moment of inertia `J` and the arm `r`; its end is displaced by `y = rφ`. The spring `k2` and the
/// damper `c1`, both stretched by `x + y`, join it to the block. The spring `k3` and the damper
/// `c2` join it to the frame. Their force also lifts the block off the belt. So the normal force is
/// `N = mg − k3 y − c2 ẏ`, but not negative, because a contact cannot pull:
///
/// ```text
///     m ẍ      = −k1 x − k2 (x + y) − c1 (ẋ + ẏ) − μ(v) N sgn v,  μ(v) = μ0/(1 + δ|v|), v = ẋ − vp
///     J φ̈ / r  = −k2 (x + y) − c1 (ẋ + ẏ) − k3 y − c2 ẏ
/// ```
///
/// Time is measured in `1/ω`, `ω² = (k1 + k2)/m`, and length in `L = mg/k2`. With `x₁ = x/L`, `x₃ =
/// y/L`, their derivatives `x₂`, `x₄`, and
///
/// ```text
///     ξ1 = k2/(ω²m)    ξ2 = c1 ω/k2    ξ3 = k2 r²/(ω²J)    ξ4 = (k2 + k3)/k2    ξ5 = ω(c1 + c2)/k2
///     N/mg = 1 − ν x₃ − η x₄,   ν = k3/k2 = ξ6/μ0,   η = ω c2/k2 = ξ7/μ0
/// ```
///
/// division of the first equation by `mω²L`, and of the second by `ω²LJ/r²`, gives
///
/// ```text
///     x₁' = x₂
///     x₂' = −x₁ − ξ1 [ ξ2 (x₂ + x₄) + x₃ + T ],    T = sgn(v) μ0 (N/mg) / (1 + δ|v|),  v = x₂ − vp
///     x₃' = x₄
///     x₄' = ξ3 ( −x₁ − ξ2 x₂ − ξ4 x₃ − ξ5 x₄ )
/// ```
///
/// with `δ` and `vp` in units of `1/(ωL)` and `ωL`. The paper prints `−x₃ − T` in the second row.
/// The signs of both terms are parameters here, so that the printed equations can be run as well.
/// An [`Interpretation`] turns the nine numbers of a caption into parameters. [`Rig`] is the system
/// in its physical units.
///
/// State: `(x₁, x₂, x₃, x₄)`; Σ is `x₂ = vp`. There the block sticks while the required force is at
/// most `μ0 N/mg`. Where `N` is clipped to zero, both fields agree and the block does not stick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockAndBracket {
    /// ξ1: the part `k2/(k1 + k2)` of the block's stiffness that the coupling spring has.
    pub coupling: f64,
    /// ξ2: damping of the coupling.
    pub coupling_damping: f64,
    /// ξ3: how readily the coupling moves the bracket.
    pub mobility: f64,
    /// ξ4: stiffness that the bracket feels, in units of k2.
    pub bracket_stiffness: f64,
    /// ξ5: damping that the bracket feels.
    pub bracket_damping: f64,
    /// μ0: static friction at rest of the bracket, in units of `mg`.
    pub mu0: f64,
    /// ν: effect of the bracket's displacement on the normal force.
    pub unloading: f64,
    /// η: effect of the bracket's velocity on the normal force.
    pub unloading_rate: f64,
    /// δ: decay of kinetic friction with speed.
    pub delta: f64,
    /// vp: belt speed.
    pub belt_speed: f64,
    /// Factor of `x₃` in the second row: 1 by Newton's law, −1 as printed.
    pub displacement_sign: f64,
    /// Factor of `T` in the second row: 1 where friction opposes slip, −1 as printed.
    pub friction_sign: f64,
    /// Whether the normal force is clipped at zero. Otherwise the contact of a lifted block can
    /// pull.
    pub clipped: bool,
}

impl BlockAndBracket {
    /// The normal force in units of its value `mg` at rest, unclipped: where it is negative the
    /// block would lift off.
    #[inline(always)]
    pub fn unclipped_normal_force<T: Scalar>(&self, x: &[T; 4]) -> T {
        -(x[2] * self.unloading + x[3] * self.unloading_rate) + 1.0
    }

    /// The normal force in the friction law, in units of `mg`: clipped at zero if `clipped` is set.
    #[inline(always)]
    pub fn normal_force<T: Scalar>(&self, x: &[T; 4]) -> T {
        let contact = self.unclipped_normal_force(x);
        if self.clipped {
            contact.max(T::constant(0.0))
        } else {
            contact
        }
    }
}

impl Filippov<4> for BlockAndBracket {
    #[inline(always)]
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 4]) -> [T; 4] {
        let slip_speed = (x[1] - self.belt_speed) * side.sign();
        let limit = self.normal_force(x) * (self.mu0 * side.sign() * self.friction_sign);
        let friction = limit / (slip_speed * self.delta + 1.0);
        let damper = (x[1] + x[3]) * self.coupling_damping;
        let force = damper + x[2] * self.displacement_sign + friction;
        let pull = x[0] + x[1] * self.coupling_damping + x[2] * self.bracket_stiffness;
        [
            x[1],
            -x[0] - force * self.coupling,
            x[3],
            -(pull + x[3] * self.bracket_damping) * self.mobility,
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
        positive("coupling", self.coupling)?;
        not_negative("coupling_damping", self.coupling_damping)?;
        positive("mobility", self.mobility)?;
        positive("bracket_stiffness", self.bracket_stiffness)?;
        not_negative("bracket_damping", self.bracket_damping)?;
        not_negative("mu0", self.mu0)?;
        finite("unloading", self.unloading)?;
        finite("unloading_rate", self.unloading_rate)?;
        not_negative("delta", self.delta)?;
        not_negative("belt_speed", self.belt_speed)?;
        let signs = [
            ("displacement_sign", self.displacement_sign),
            ("friction_sign", self.friction_sign),
        ];
        for (name, value) in signs {
            if value.abs() != 1.0 {
                let bound = "1 or -1";
                return Err(Error::Parameter { name, value, bound });
            }
        }
        Ok(())
    }
}
