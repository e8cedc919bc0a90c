use stickslip::{Filippov, Scalar, Side};

/// A block in a double well, on a belt. Friction decays with slip speed.
#[derive(Clone, Copy, PartialEq)]
pub struct Belt {
    pub speed: f64,
}

impl Filippov<2> for Belt {
    #[inline(always)]
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
        let slip_speed = (x[1] - self.speed) * side.sign();
        let friction = T::constant(3f64.sqrt() / 9.0 * side.sign()) / (slip_speed + 1.0);
        [x[1], x[0] - x[0] * x[0] * x[0] - friction]
    }
    #[inline(always)]
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[1] - self.speed
    }
}
