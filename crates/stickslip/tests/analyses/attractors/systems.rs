//! Systems with known attractors.

use stickslip::{Filippov, Scalar, Side};

use crate::smooth::Field;

/// `x'' = -x - 0.1 x' - F`, a block on a belt of speed `vd`, the friction decaying with slip speed:
/// the example of bSTAB (Stender & Hoffmann, *Nonlinear Dyn.* 107 (2022) 1451).
#[derive(Clone, Copy, PartialEq)]
pub struct Driven {
    pub vd: f64,
}

impl Filippov<2> for Driven {
    #[inline(always)]
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
        let slip = (x[1] - self.vd) * side.sign();
        let friction = ((slip * -2.0).exp() * 0.5 + 0.5) * side.sign();
        [x[1], -x[0] - x[1] * 0.1 - friction]
    }
    #[inline(always)]
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[1] - self.vd
    }
}

/// `x'' = -x - sgn(w)/(1 + 3|w|)`, `w = x' - 0.2` (Leine, van Campen, de Kraker & van den Steen,
/// *Nonlinear Dyn.* 16 (1998) 41).
pub struct Leine;

impl Filippov<2> for Leine {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
        let slip = (x[1] - 0.2) * side.sign();
        let friction = (slip * 3.0 + 1.0).recip() * side.sign();
        [x[1], -x[0] - friction]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[1] - 0.2
    }
}

/// `x'' = x - x³ - F sgn x'`: friction holds on three disjoint intervals of the axis.
pub struct Wells {
    pub friction: f64,
}

impl Filippov<2> for Wells {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
        [
            x[1],
            x[0] - x[0] * x[0] * x[0] - self.friction * side.sign(),
        ]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[1]
    }
}

/// `r' = r (p + 2 r² - r⁴)`, `θ' = 1` in the plane, with the parameter `p` as the third state.
/// Cycles at `r² = 1 ± √(1 + p)` meet in a fold at `p = -1`, `r = 1`. The boundary `x = place` is
/// crossed or far away; the fields are the same on both sides.
pub struct Rings {
    pub place: f64,
}

impl Filippov<3> for Rings {
    fn field<T: Scalar>(&self, _side: Side, _t: T, x: &[T; 3]) -> [T; 3] {
        let square = x[0] * x[0] + x[1] * x[1];
        let grows = x[2] + square * 2.0 - square * square;
        [x[0] * grows - x[1], x[1] * grows + x[0], T::constant(0.0)]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 3]) -> T {
        x[0] - self.place
    }
}

/// Van der Pol's oscillator with time reversed, `x'' = -x - (1 - x²) x'/10`: its cycle of amplitude
/// about 2 repels.
pub struct Backwards;

impl Field<2> for Backwards {
    fn at<T: Scalar>(&self, x: &[T; 2]) -> [T; 2] {
        [x[1], -x[0] - (-x[0] * x[0] + 1.0) * x[1] * 0.1]
    }
}

/// `x' = -x + 100 y`, `y' = -y`. From `(0, 1)`, `x = 100 t exp(-t)`: an orbit that comes to rest is
/// 36.8 away before.
pub struct Detour;

impl Field<2> for Detour {
    fn at<T: Scalar>(&self, x: &[T; 2]) -> [T; 2] {
        [-x[0] + x[1] * 100.0, -x[1]]
    }
}

/// `x' = -x`, `y' = -y + x²`: `y = x(0)² (exp(-t) - exp(-2t))` from `y = 0`.
pub struct Shear;

impl Field<2> for Shear {
    fn at<T: Scalar>(&self, x: &[T; 2]) -> [T; 2] {
        [-x[0], x[0] * x[0] - x[1]]
    }
}

/// `x'' = -x - x'/2 + p`, pushed by `p = sin(t/20)/5` or by a decaying push.
pub struct Pushed {
    pub decay: f64,
}

impl Filippov<2> for Pushed {
    fn field<T: Scalar>(&self, _side: Side, t: T, x: &[T; 2]) -> [T; 2] {
        let push = if self.decay > 0.0 {
            (t * -self.decay).exp()
        } else {
            (t * 0.05).sin() * 0.2
        };
        [x[1], -x[0] - x[1] * 0.5 + push]
    }
    fn boundary<T: Scalar>(&self, _t: T, _x: &[T; 2]) -> T {
        T::constant(-1.0)
    }
}

/// `x' = x (1 - (1000 x)²)`: equilibria at -1/1000 and 1/1000 attract from anywhere. The boundary
/// is never met.
pub struct NearWells;

impl Filippov<1> for NearWells {
    fn field<T: Scalar>(&self, _side: Side, _t: T, &[x]: &[T; 1]) -> [T; 1] {
        let apart = x * 1000.0;
        [x * (-apart * apart + 1.0)]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 1]) -> T {
        x[0] - 1e4
    }
}

/// Mechanism of a [`ToZero`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mechanism {
    /// `x'' = -x - 0.4 x'`, with a boundary that is never met.
    Spring,
    /// `x'' = -4 sgn(x + x')`: from stick at `x + x' = 0`, where `x' = -x`.
    Relay,
    /// The relay at `sin x + x' = 0`.
    CurvedRelay,
}

/// A system with an equilibrium that is zero to the last bit.
pub struct ToZero(pub Mechanism);

impl Filippov<2> for ToZero {
    fn field<T: Scalar>(&self, side: Side, _t: T, &[x, v]: &[T; 2]) -> [T; 2] {
        let pull = match self.0 {
            Mechanism::Spring => -x - v * 0.4,
            Mechanism::Relay | Mechanism::CurvedRelay => T::constant(-4.0 * side.sign()),
        };
        [v, pull]
    }
    fn boundary<T: Scalar>(&self, _t: T, &[x, v]: &[T; 2]) -> T {
        match self.0 {
            Mechanism::Spring => x - 5.0,
            Mechanism::Relay => x + v,
            Mechanism::CurvedRelay => x.sin() + v,
        }
    }
}
