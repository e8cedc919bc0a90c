//! The systems of the tests, each with the property that gives its orbit in closed form.

use std::f64::consts::PI;
use std::sync::atomic::{AtomicU64, Ordering};

use stickslip::{Filippov, Scalar, Side};

use crate::blocks::Block;

/// `x'' = -x - 0.4 sgn x'`: a block on a floor at rest. Each swing is half a turn of a circle about
/// ±0.4.
pub struct Floor;

impl Filippov<2> for Floor {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
        [x[1], -x[0] - 0.4 * side.sign()]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[1]
    }
}

/// `x'' = -x`, with friction on a belt of speed 0.2 that is larger at rest than in slip.
pub struct StaticFriction {
    pub at_rest: f64,
    pub in_slip: f64,
}

impl StaticFriction {
    fn with<T: Scalar>(friction: f64, side: Side, x: &[T; 2]) -> [T; 2] {
        [x[1], -x[0] - friction * side.sign()]
    }
}

impl Filippov<2> for StaticFriction {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
        StaticFriction::with(self.in_slip, side, x)
    }
    fn holding<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
        StaticFriction::with(self.at_rest, side, x)
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[1] - 0.2
    }
}

/// A linear spring and friction that decays with slip speed: `x'' = -x ± 1/(1 + |x' - 0.2|)`.
pub fn decaying_friction() -> Block {
    Block {
        k1: -1.0,
        k2: 0.0,
        mu0: 1.0,
        ..Block::on_belt(0.2)
    }
}

/// A linear spring and constant friction: circles about ±μ0 in the plane of position and velocity.
pub fn coulomb_friction(mu0: f64, belt_speed: f64) -> Block {
    Block {
        k1: -1.0,
        k2: 0.0,
        mu0,
        delta: 0.0,
        ..Block::on_belt(belt_speed)
    }
}

/// An unstable focus that rotates one way inside the unit circle and the other way outside.
pub struct Spiral;

impl Filippov<2> for Spiral {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
        let w = 2.0 * PI * side.sign();
        [x[0] + x[1] * w, x[1] - x[0] * w]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[0] * x[0] + x[1] * x[1] - 1.0
    }
}

/// `x' = a` below and `-a` above a boundary that moves as `sin t`. It slides while `|cos t| < a`.
/// With `a < 0` it repels where it would slide.
pub struct MovingLine {
    pub a: f64,
}

impl Filippov<1> for MovingLine {
    fn field<T: Scalar>(&self, side: Side, _t: T, _x: &[T; 1]) -> [T; 1] {
        [T::constant(-self.a * side.sign())]
    }
    fn boundary<T: Scalar>(&self, t: T, x: &[T; 1]) -> T {
        x[0] - t.sin()
    }
}

/// `x' = 1, y' = 2x` on both sides: the parabola `y = x² + y0` against the line `y = level`.
pub struct Parabola {
    pub level: f64,
}

impl Filippov<2> for Parabola {
    fn field<T: Scalar>(&self, _side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
        [T::constant(1.0), x[0] * 2.0]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[1] - self.level
    }
}

/// `x'' = -x` on both sides of `x = 1 - gap`: circles, of which the unit circle exceeds the
/// boundary by `gap`.
pub struct Ceiling {
    pub gap: f64,
}

impl Filippov<2> for Ceiling {
    fn field<T: Scalar>(&self, _side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
        [x[1], -x[0]]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[0] - (1.0 - self.gap)
    }
}

/// Stick that is released briefly. Relative to Σ, which moves as `amplitude · sin t`, the field
/// below is `q² - width²` and the one above `-1`. Here `q = x₁ - centre`, and `x₁` is the time.
///
/// Released at `q = -width`, the body returns to Σ at `q = 2 width`. In between its distance is `(q
/// + width)² (q - 2 width)/3`.
pub struct Dip {
    pub centre: f64,
    pub width: f64,
    pub amplitude: f64,
}

impl Filippov<2> for Dip {
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 2]) -> [T; 2] {
        let q = x[0] - self.centre;
        let push = match side {
            Side::Below => q * q - self.width * self.width,
            Side::Above => T::constant(-1.0),
        };
        [T::constant(1.0), push + t.cos() * self.amplitude]
    }
    fn boundary<T: Scalar>(&self, t: T, x: &[T; 2]) -> T {
        x[1] - t.sin() * self.amplitude
    }
}

/// A body pulled towards Σ from both sides by a force of size 1, and braked by one that depends
/// only on `x₂/|x₁|^½`. The equations are invariant when time, `x₂` and `x₁` are scaled by `k`, `k`
/// and `k²`. So each excursion is the previous one scaled by the same ratio, and infinitely many
/// end in finite time.
pub struct Zeno {
    pub brake: f64,
}

impl Filippov<2> for Zeno {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
        let size = Scalar::sqrt(Scalar::sqrt(x[1] * x[1] * x[1] * x[1] + x[0] * x[0]));
        [x[1], x[1] / size * -self.brake - side.sign()]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[0]
    }
}

/// `x' = x cos t`, with the solution `exp(sin t)`, under a ceiling.
pub struct Breathing {
    pub ceiling: f64,
}

impl Filippov<1> for Breathing {
    fn field<T: Scalar>(&self, _side: Side, t: T, x: &[T; 1]) -> [T; 1] {
        [x[0] * t.cos()]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 1]) -> T {
        x[0] - self.ceiling
    }
}

/// `x₁' = 1` on both sides and `x₂' = below · x₁`, `x₂' = above · x₁`: both fields are tangent to Σ
/// at the origin.
pub struct TwoFold {
    pub below: f64,
    pub above: f64,
}

impl Filippov<2> for TwoFold {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
        let slope = match side {
            Side::Below => self.below,
            Side::Above => self.above,
        };
        [T::constant(1.0), x[0] * slope]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[1]
    }
}

/// `x' = ±cos t` relative to Σ, which moves as `speed · t²/2`: attracts until π/2, then repels.
pub struct TurningLine {
    pub speed: f64,
}

impl Filippov<1> for TurningLine {
    fn field<T: Scalar>(&self, side: Side, t: T, _x: &[T; 1]) -> [T; 1] {
        [t.cos() * -side.sign() + t * self.speed]
    }
    fn boundary<T: Scalar>(&self, t: T, x: &[T; 1]) -> T {
        x[0] - t * t * (0.5 * self.speed)
    }
}

/// `x' = 1`, under a boundary that is NaN between `from` and `to`.
pub struct Window {
    pub from: f64,
    pub to: f64,
}

impl Filippov<1> for Window {
    fn field<T: Scalar>(&self, _side: Side, _t: T, _x: &[T; 1]) -> [T; 1] {
        [T::constant(1.0)]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 1]) -> T {
        ((x[0] - self.from) * (x[0] - self.to)).sqrt() * 1e-3 - 100.0
    }
}

/// `x' = 1 + √(1 - x)`: reaches 1 with speed 1 and has no field beyond.
pub struct Wall;

impl Filippov<1> for Wall {
    fn field<T: Scalar>(&self, _side: Side, _t: T, x: &[T; 1]) -> [T; 1] {
        [Scalar::sqrt(-x[0] + 1.0) + 1.0]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 1]) -> T {
        x[0] + 100.0
    }
}

/// `x' = x²`: infinite at time `1/x0`.
pub struct BlowUp;

impl Filippov<1> for BlowUp {
    fn field<T: Scalar>(&self, _side: Side, _t: T, x: &[T; 1]) -> [T; 1] {
        [x[0] * x[0]]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 1]) -> T {
        x[0] + 100.0
    }
}

/// `x' = √(1 - x)`, which comes to rest at 1. Its boundary is far away, and its evaluations are
/// counted.
#[derive(Clone, Copy)]
pub struct ComesToRest {
    pub looks: &'static AtomicU64,
}

impl Filippov<1> for ComesToRest {
    fn field<T: Scalar>(&self, _side: Side, _t: T, x: &[T; 1]) -> [T; 1] {
        [Scalar::sqrt(-x[0] + 1.0)]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 1]) -> T {
        let looks = self.looks.fetch_add(1, Ordering::Relaxed);
        assert!(looks < 1_000_000, "a step is searched for ever");
        x[0] + 100.0
    }
}

/// A boundary function that is undefined for x < 0, where the orbit goes.
pub struct Ledge;

impl Filippov<2> for Ledge {
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 2]) -> [T; 2] {
        [x[1], -x[0] + t.sin() * 0.8 - 0.3 * side.sign()]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[1] - x[0].sqrt() * 0.3
    }
}

/// A system with time reversed.
pub struct Reversed<S>(pub S);

impl<const N: usize, S: Filippov<N>> Filippov<N> for Reversed<S> {
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; N]) -> [T; N] {
        self.0.field(side, -t, x).map(|v| -v)
    }
    fn boundary<T: Scalar>(&self, t: T, x: &[T; N]) -> T {
        self.0.boundary(-t, x)
    }
}

/// The unit circle, which attracts, and a third component that follows `3 cos 2θ`: it returns twice
/// per turn.
pub struct TwiceRound;

impl Filippov<3> for TwiceRound {
    fn field<T: Scalar>(&self, _side: Side, _t: T, x: &[T; 3]) -> [T; 3] {
        let (a, b) = (x[0] * x[0], x[1] * x[1]);
        let inwards = -a - b + 1.0;
        [
            x[0] * inwards - x[1],
            x[1] * inwards + x[0],
            (a - b) * 15.0 - x[2] * 5.0,
        ]
    }
    fn boundary<T: Scalar>(&self, _t: T, _x: &[T; 3]) -> T {
        T::constant(-1.0)
    }
}

/// Two blocks with only friction between them. Friction shares a change of one velocity by
/// momentum. A projection across the boundary at a right angle would not.
pub struct Pair;

impl Filippov<4> for Pair {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 4]) -> [T; 4] {
        let friction = T::constant(side.sign());
        [x[1], -friction, x[3], friction / 3.0]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 4]) -> T {
        x[1] - x[3]
    }
}
