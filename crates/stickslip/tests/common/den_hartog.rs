//! Den Hartog's forced oscillator.

use stickslip::{Filippov, Scalar, Side};

/// `x'' = -x - S sgn x' + cos Ωt`. Den Hartog (1930) gives the amplitude of its orbits without
/// stick.
pub struct DenHartog {
    pub frequency: f64,
    pub friction: f64,
}

impl Filippov<2> for DenHartog {
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 2]) -> [T; 2] {
        let push = (t * self.frequency).cos() - self.friction * side.sign();
        [x[1], push - x[0]]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[1]
    }
}
