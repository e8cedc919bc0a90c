//! Systems whose bifurcations are known in closed form.

use stickslip::{Filippov, Scalar, Side};

/// What a [`Beat`] does.
#[derive(Clone, Copy, PartialEq)]
pub enum Rhythm {
    /// Below, `y = sin t` attracts; above, all falls. The boundary is `y = p`.
    Touch,
    /// The same below a boundary that is far away; contact is lost where `cos t > p`.
    Lift,
    /// Up at `9/5 + 2 sin t` from below, down at `1 - p cos t` from above.
    Part,
    /// Up at `1/2 + sin t` from below, up at `sin(t - p) - 7/10` above.
    Meet,
}

/// One state `y` of which each side's rate is a function of time alone, or nearly: period 2π.
#[derive(Clone, Copy, PartialEq)]
pub struct Beat {
    pub rhythm: Rhythm,
    pub p: f64,
}

impl Filippov<1> for Beat {
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 1]) -> [T; 1] {
        [match (self.rhythm, side) {
            (Rhythm::Touch, Side::Above) => T::constant(-1.0),
            (Rhythm::Touch | Rhythm::Lift, _) => -x[0] + t.sin() + t.cos(),
            (Rhythm::Part, Side::Below) => t.sin() * 2.0 + 1.8,
            (Rhythm::Part, Side::Above) => t.cos() * self.p - 1.0,
            (Rhythm::Meet, Side::Below) => t.sin() + 0.5,
            (Rhythm::Meet, Side::Above) => (t - self.p).sin() - 0.7,
        }]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 1]) -> T {
        match self.rhythm {
            Rhythm::Touch => x[0] - self.p,
            Rhythm::Lift => x[0] - 5.0,
            Rhythm::Part | Rhythm::Meet => x[0],
        }
    }
    fn contact<T: Scalar>(&self, t: T, _x: &[T; 1]) -> Option<T> {
        (self.rhythm == Rhythm::Lift).then(|| -t.cos() + self.p)
    }
}

/// [`crate::attractors::systems::Driven`] with the belt's speed as the third state.
pub struct DrivenFamily;

impl Filippov<3> for DrivenFamily {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 3]) -> [T; 3] {
        let slip = (x[1] - x[2]) * side.sign();
        let friction = ((slip * -2.0).exp() * 0.5 + 0.5) * side.sign();
        [x[1], -x[0] - x[1] * 0.1 - friction, T::constant(0.0)]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 3]) -> T {
        x[1] - x[2]
    }
}

/// The orbit `c = (cos t, sin t)` and a linear flow about it, with the parameter `p` as the third state: in a frame that turns half as fast
/// the rates are `p` and -1, or in one that turns by 0.3 both are `p`. A boundary at 0.2 is crossed, and means nothing.
pub struct Twisted {
    pub half_turn: bool,
}

impl Filippov<3> for Twisted {
    fn field<T: Scalar>(&self, _side: Side, t: T, x: &[T; 3]) -> [T; 3] {
        let (sin, cos) = t.sin_cos();
        let (a, b, p) = (x[0] - cos, x[1] - sin, x[2]);
        let (turn, mean, half) = if self.half_turn {
            (0.5, (p - 1.0) * 0.5, (p + 1.0) * 0.5)
        } else {
            (0.3, p, T::constant(0.0))
        };
        [
            -sin + a * mean - b * turn + half * (cos * a + sin * b),
            cos + b * mean + a * turn + half * (sin * a - cos * b),
            T::constant(0.0),
        ]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 3]) -> T {
        x[0] - 0.2
    }
}

/// `r' = r (1/4 - (r² - 1)² - p²)`, `θ' = 1`, the parameter being the third state: the cycles are a closed branch, with folds at `p = ±1/2`, `r = 1`.
pub struct Island;

impl Filippov<3> for Island {
    fn field<T: Scalar>(&self, _side: Side, _t: T, x: &[T; 3]) -> [T; 3] {
        let off = x[0] * x[0] + x[1] * x[1] - 1.0;
        let grows = -off * off - x[2] * x[2] + 0.25;
        [x[0] * grows - x[1], x[1] * grows + x[0], T::constant(0.0)]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 3]) -> T {
        x[0] - 50.0
    }
}
