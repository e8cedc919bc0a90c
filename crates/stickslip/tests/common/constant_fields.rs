//! Constant fields on a line.

use stickslip::{Filippov, Scalar, Side};

/// `x' = below` for `x < 0`, `x' = above` for `x > 0`. The signs decide whether the boundary
/// attracts, is crossed or repels.
pub struct ConstantFields {
    pub below: f64,
    pub above: f64,
}

impl Filippov<1> for ConstantFields {
    fn field<T: Scalar>(&self, side: Side, _t: T, _x: &[T; 1]) -> [T; 1] {
        [T::constant(match side {
            Side::Below => self.below,
            Side::Above => self.above,
        })]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 1]) -> T {
        x[0]
    }
}
