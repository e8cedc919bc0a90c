//! Blocks on belts: with a spring and friction, and with a bracket that unloads the contact.

use stickslip::{Error, Filippov, Scalar, Side, math};

/// `m x'' = k1 z - k2 z³ - T(x' - belt_speed)`, `z = x - amplitude sin ωt`: the support moves.
/// Friction decays with slip speed: `T(v) = sgn(v) mu0/(1 + delta |v|)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    pub mass: f64,
    pub k1: f64,
    pub k2: f64,
    pub mu0: f64,
    pub delta: f64,
    pub belt_speed: f64,
    pub amplitude: f64,
    pub omega: f64,
}

impl Block {
    /// A block in a double well. Its references are `data/references/belt_*.csv`.
    pub fn on_belt(belt_speed: f64) -> Self {
        Block {
            mass: 1.0,
            k1: 1.0,
            k2: 1.0,
            mu0: 3f64.sqrt() / 9.0,
            delta: 1.0,
            belt_speed,
            amplitude: 0.0,
            omega: 0.0,
        }
    }

    /// A block on a softening spring, whose support is shaken. Far out the spring pushes away.
    pub fn shaken() -> Self {
        Block {
            mass: 0.1,
            k1: -1.0,
            k2: -1.0,
            amplitude: 4.0 * 3f64.sqrt() / 3.0 * math::sin(std::f64::consts::PI / 18.0),
            omega: 3.0 * std::f64::consts::PI / 2.4728,
            ..Block::on_belt(0.4)
        }
    }

    /// Period of the support.
    pub fn period(&self) -> f64 {
        2.0 * std::f64::consts::PI / self.omega
    }
}

impl Filippov<2> for Block {
    #[inline(always)]
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 2]) -> [T; 2] {
        let slip_speed = (x[1] - self.belt_speed) * side.sign();
        let friction = T::constant(self.mu0 * side.sign()) / (slip_speed * self.delta + 1.0);
        let z = if self.amplitude == 0.0 {
            x[0]
        } else {
            x[0] - (t * self.omega).sin() * self.amplitude
        };
        let spring = z * (z * z * -self.k2 + self.k1);
        [x[1], (spring - friction) / self.mass]
    }
    #[inline(always)]
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[1] - self.belt_speed
    }
    fn check_parameters(&self) -> Result<(), Error> {
        if self.mass > 0.0 {
            return Ok(());
        }
        let (name, value, bound) = ("mass", self.mass, "positive");
        Err(Error::Parameter { name, value, bound })
    }
}

/// A block on a belt, coupled to a bracket whose displacement unloads the contact until it is lost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bracket {
    pub unloading: f64,
}

impl Bracket {
    /// Negative where the contact is lost.
    pub fn normal_force<T: Scalar>(&self, x: &[T; 4]) -> T {
        -(x[2] * self.unloading) + 1.0
    }
}

impl Filippov<4> for Bracket {
    #[inline(always)]
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 4]) -> [T; 4] {
        let slip_speed = (x[1] - 0.707) * side.sign();
        let limit = self.normal_force(x).max(T::zero()) * (0.707 * side.sign());
        let friction = limit / (slip_speed * 0.101 + 1.0);
        [
            x[1],
            -x[0] - (x[2] + friction) * 0.413,
            x[3],
            -(x[0] + x[2] * 1.98) * 1.069,
        ]
    }
    #[inline(always)]
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 4]) -> T {
        x[1] - 0.707
    }
    #[inline(always)]
    fn contact<T: Scalar>(&self, _t: T, x: &[T; 4]) -> Option<T> {
        Some(self.normal_force(x))
    }
}
