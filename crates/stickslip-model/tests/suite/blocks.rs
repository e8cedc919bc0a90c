//! The systems of shipped files, compiled.

use stickslip::{Filippov, Scalar, Side};

/// Friction oscillators of mass one, by their law and their drive.
pub struct Block {
    belt_speed: f64,
    damping: f64,
    drive: Option<f64>,
    law: Law,
}

enum Law {
    Hyperbolic(f64),
    Exponential { slow: f64, fast: f64, decay: f64 },
    Coulomb(f64),
}

impl Block {
    pub const LEINE: Block = Block {
        belt_speed: 0.2,
        damping: 0.0,
        drive: None,
        law: Law::Hyperbolic(3.0),
    };
    pub const BASINS: Block = Block {
        belt_speed: 1.5,
        damping: 0.1,
        drive: None,
        law: Law::Exponential {
            slow: 1.0,
            fast: 0.5,
            decay: 2.0,
        },
    };
    pub const DEN_HARTOG: Block = Block {
        belt_speed: 0.0,
        damping: 0.0,
        drive: Some(0.7),
        law: Law::Coulomb(0.2),
    };
}

impl Filippov<2> for Block {
    #[inline(always)]
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 2]) -> [T; 2] {
        let slip_speed = (x[1] - self.belt_speed) * side.sign();
        let size = match self.law {
            Law::Hyperbolic(decay) => T::constant(1.0) / (slip_speed * decay + 1.0),
            Law::Exponential { slow, fast, decay } => {
                (slip_speed * -decay).exp() * (slow - fast) + fast
            }
            Law::Coulomb(size) => T::constant(size),
        };
        let force = -x[0] - x[1] * self.damping - size * side.sign();
        match self.drive {
            Some(frequency) => [x[1], force + (t * frequency).cos()],
            None => [x[1], force],
        }
    }
    #[inline(always)]
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[1] - self.belt_speed
    }
}
