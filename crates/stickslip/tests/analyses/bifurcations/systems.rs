//! Systems with bifurcations in closed form.

use stickslip::{Contacts, Filippov, Scalar, Side};

use crate::smooth::Field;

/// Motion of a [`Beat`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rhythm {
    /// Attraction by `y = sin t` below; above, the field points down. The boundary is `y = p`.
    Touch,
    /// The field of `Touch` below a distant boundary. Contact is lost where `cos t > p`.
    Lift,
    /// Up at `9/5 + 2 sin t` from below, down at `1 - p cos t` from above.
    Part,
    /// Up at `1/2 + sin t` from below, up at `sin(t - p) - 7/10` above.
    Meet,
    /// `y = sin(t - p)` attracts on both sides and crosses the boundary `y = 0` at p, p + π, and so
    /// on.
    Clock,
    /// Always sticks to `y = sin t`.
    Hold,
}

/// One state `y`. The rate on each side depends only, or almost only, on time, with period 2π.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beat {
    pub rhythm: Rhythm,
    pub p: f64,
}

impl Rhythm {
    fn rate<T: Scalar>(self, side: Side, t: T, y: T, p: T) -> T {
        match (self, side) {
            (Rhythm::Touch, Side::Above) => T::constant(-1.0),
            (Rhythm::Touch | Rhythm::Lift, _) => -y + t.sin() + t.cos(),
            (Rhythm::Part, Side::Below) => t.sin() * 2.0 + 1.8,
            (Rhythm::Part, Side::Above) => t.cos() * p - 1.0,
            (Rhythm::Meet, Side::Below) => t.sin() + 0.5,
            (Rhythm::Meet, Side::Above) => (t - p).sin() - 0.7,
            (Rhythm::Clock, _) => -y + (t - p).sin() + (t - p).cos(),
            (Rhythm::Hold, side) => T::constant(-5.0 * side.sign()),
        }
    }

    fn height<T: Scalar>(self, t: T, y: T, p: T) -> T {
        match self {
            Rhythm::Touch => y - p,
            Rhythm::Lift => y - 5.0,
            Rhythm::Part | Rhythm::Meet | Rhythm::Clock => y,
            Rhythm::Hold => y - t.sin(),
        }
    }

    fn contact<T: Scalar>(self, t: T, p: T) -> Option<T> {
        (self == Rhythm::Lift).then(|| -t.cos() + p)
    }
}

impl Filippov<1> for Beat {
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 1]) -> [T; 1] {
        [self.rhythm.rate(side, t, x[0], T::constant(self.p))]
    }
    fn boundary<T: Scalar>(&self, t: T, x: &[T; 1]) -> T {
        self.rhythm.height(t, x[0], T::constant(self.p))
    }
    fn contact<T: Scalar>(&self, t: T, _x: &[T; 1]) -> Option<T> {
        self.rhythm.contact(t, T::constant(self.p))
    }
}

/// A [`Beat`] with its parameter as the second state.
pub struct BeatFamily(pub Rhythm);

impl Filippov<2> for BeatFamily {
    fn field<T: Scalar>(&self, side: Side, t: T, &[y, p]: &[T; 2]) -> [T; 2] {
        [self.0.rate(side, t, y, p), T::constant(0.0)]
    }
    fn boundary<T: Scalar>(&self, t: T, &[y, p]: &[T; 2]) -> T {
        self.0.height(t, y, p)
    }
    fn contact<T: Scalar>(&self, t: T, &[_, p]: &[T; 2]) -> Option<T> {
        self.0.contact(t, p)
    }
}

/// Two uncoupled beats, each with a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Duet(pub [Beat; 2]);

impl Contacts<2, 2> for Duet {
    fn field<T: Scalar>(&self, sides: &[Side; 2], t: T, x: &[T; 2]) -> [T; 2] {
        std::array::from_fn(|i| self.0[i].field(sides[i], t, &[x[i]])[0])
    }
    fn boundaries<T: Scalar>(&self, t: T, x: &[T; 2]) -> [T; 2] {
        std::array::from_fn(|i| self.0[i].boundary(t, &[x[i]]))
    }
}

/// The duet with the parameter of one beat as the third state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DuetFamily {
    pub rhythms: [Rhythm; 2],
    /// The parameter of the other one.
    pub p: f64,
    /// Index of the one whose parameter is the third state.
    pub varied: usize,
}

impl DuetFamily {
    fn parameter<T: Scalar>(&self, i: usize, x: &[T; 3]) -> T {
        if i == self.varied {
            x[2]
        } else {
            T::constant(self.p)
        }
    }
}

impl Contacts<3, 2> for DuetFamily {
    fn field<T: Scalar>(&self, sides: &[Side; 2], t: T, x: &[T; 3]) -> [T; 3] {
        let [a, b] = [0, 1].map(|i| self.rhythms[i].rate(sides[i], t, x[i], self.parameter(i, x)));
        [a, b, T::constant(0.0)]
    }
    fn boundaries<T: Scalar>(&self, t: T, x: &[T; 3]) -> [T; 2] {
        std::array::from_fn(|i| self.rhythms[i].height(t, x[i], self.parameter(i, x)))
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

/// The orbit `c = (cos t, sin t)` and a linear flow about it, with the parameter `p` as the third
/// state. In a frame that rotates half as fast, the rates are `p` and -1. In one that rotates by
/// 0.3, both are `p`. A boundary at 0.2 is crossed without effect.
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

/// A system whose last state is a parameter, at one value of it.
pub struct AtParameter<S> {
    pub system: S,
    pub value: f64,
}

impl<S: Filippov<3>> Filippov<2> for AtParameter<S> {
    fn field<T: Scalar>(&self, side: Side, t: T, &[x, y]: &[T; 2]) -> [T; 2] {
        let [rate, other, _] = self.system.field(side, t, &[x, y, T::constant(self.value)]);
        [rate, other]
    }
    fn holding<T: Scalar>(&self, side: Side, t: T, &[x, y]: &[T; 2]) -> [T; 2] {
        let [rate, other, _] = self
            .system
            .holding(side, t, &[x, y, T::constant(self.value)]);
        [rate, other]
    }
    fn boundary<T: Scalar>(&self, t: T, &[x, y]: &[T; 2]) -> T {
        self.system.boundary(t, &[x, y, T::constant(self.value)])
    }
}

/// `r' = r (1/4 - (r² - 1)² - p²)`, `θ' = 1`, with the parameter as the third state. The cycles
/// form a closed branch, with folds at `p = ±1/2`, `r = 1`.
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

/// `r' = r (1 - r²)`, `θ' = 1`, and beside it `a' = p a - a³`. The circle at a = 0 has the
/// multipliers exp(-4π) and exp(2πp). At p = 0 it meets those at a = ±√p. The parameter is the
/// fourth state.
pub struct Pitchfork;

impl Filippov<4> for Pitchfork {
    fn field<T: Scalar>(&self, _side: Side, _t: T, x: &[T; 4]) -> [T; 4] {
        let grows = -x[0] * x[0] - x[1] * x[1] + 1.0;
        [
            x[0] * grows - x[1],
            x[1] * grows + x[0],
            x[2] * (x[3] - x[2] * x[2]),
            T::constant(0.0),
        ]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 4]) -> T {
        x[0] - 0.2
    }
}

/// The pitchfork with `a' = p (1 - p) a - a³`: the circle meets those at a = ±√(p (1 - p)) at p = 0
/// and at p = 1.
pub struct TwoPitchforks;

impl Filippov<4> for TwoPitchforks {
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 4]) -> [T; 4] {
        let p = x[3] * (-x[3] + 1.0);
        let rates = Pitchfork.field(side, t, &[x[0], x[1], x[2], p]);
        [rates[0], rates[1], rates[2], T::constant(0.0)]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 4]) -> T {
        x[0] - 0.2
    }
}

/// `x'' = -x - 2ζ x' + F` on a belt of speed 1 that is faster than the block. The kinetic friction
/// is F = 1, and the third state is the static friction in units of it.
pub struct FasterBelt;

impl FasterBelt {
    pub const DAMPING: f64 = 0.05;

    fn rates<T: Scalar>([x, v, _]: [T; 3], friction: T) -> [T; 3] {
        let damping = v * (2.0 * Self::DAMPING);
        [v, -x - damping - friction, T::zero()]
    }
}

impl Filippov<3> for FasterBelt {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 3]) -> [T; 3] {
        FasterBelt::rates(*x, T::constant(side.sign()))
    }
    fn holding<T: Scalar>(&self, side: Side, _t: T, x: &[T; 3]) -> [T; 3] {
        FasterBelt::rates(*x, x[2] * side.sign())
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 3]) -> T {
        x[1] - 1.0
    }
}

/// End of an orbit of [`Ends`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    TwoFold,
    Pole,
}

/// `(x', v') = (p, -x)` below and `(2p, x)` above `v = 0`. It sticks where x < 0, with velocity
/// 3p/2; both fields are tangent at 0. Or `x' = -p/x`, which reaches 0 in finite time if p > 0, and
/// never if p < 0.
pub struct Ends {
    pub end: End,
    pub p: f64,
}

impl Filippov<2> for Ends {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
        match self.end {
            End::TwoFold => {
                let rate = match side {
                    Side::Below => self.p,
                    Side::Above => 2.0 * self.p,
                };
                [T::constant(rate), x[0] * side.sign()]
            }
            End::Pole => [x[0].recip() * -self.p, T::constant(0.0)],
        }
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[1]
    }
}

/// [`Ends`] with its parameter as the third state.
pub struct EndsFamily(pub End);

impl Filippov<3> for EndsFamily {
    fn field<T: Scalar>(&self, side: Side, _t: T, &[x, _, p]: &[T; 3]) -> [T; 3] {
        match (self.0, side) {
            (End::TwoFold, Side::Below) => [p, x * side.sign(), T::zero()],
            (End::TwoFold, Side::Above) => [p * 2.0, x * side.sign(), T::zero()],
            (End::Pole, _) => [-p / x, T::zero(), T::zero()],
        }
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 3]) -> T {
        x[1]
    }
}

/// [`crate::den_hartog::DenHartog`] with the friction as the third state.
pub struct DenHartogFamily {
    pub frequency: f64,
}

impl Filippov<3> for DenHartogFamily {
    fn field<T: Scalar>(&self, side: Side, t: T, &[x, v, friction]: &[T; 3]) -> [T; 3] {
        let push = (t * self.frequency).cos() - friction * side.sign();
        [v, push - x, T::zero()]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 3]) -> T {
        x[1]
    }
}

/// The block on a belt of model 1, with the belt's speed as the third state. The fourth state is
/// the logarithm of the factor by which slips change an area: the integral of the field's
/// divergence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area;

impl Area {
    pub const FRICTION: f64 = 0.192_450_089_729_875_25;
}

impl Filippov<4> for Area {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 4]) -> [T; 4] {
        let falls = (x[1] - x[2]) * side.sign() + 1.0;
        let friction = T::constant(Area::FRICTION * side.sign()) / falls;
        let spring = x[0] - x[0] * x[0] * x[0];
        let divergence = T::constant(Area::FRICTION) / (falls * falls);
        [x[1], spring - friction, T::zero(), divergence]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 4]) -> T {
        x[1] - x[2]
    }
}

/// The block of [`Area`] without the area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Belt;

impl Filippov<3> for Belt {
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 3]) -> [T; 3] {
        let [position, velocity, speed, _] = Area.field(side, t, &[x[0], x[1], x[2], T::zero()]);
        [position, velocity, speed]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 3]) -> T {
        x[1] - x[2]
    }
}

/// A softening spring, x'' = -x + x³, with damping that is negative near the centre: small `pull`
/// times (p - x²) x'. Its cycle grows with p until it connects the saddles ±1.
pub struct Softening;

impl Softening {
    pub const PULL: f64 = 0.1;
}

impl Field<3> for Softening {
    fn at<T: Scalar>(&self, x: &[T; 3]) -> [T; 3] {
        let square = x[0] * x[0];
        let pull = (x[2] - square) * x[1] * Softening::PULL;
        [x[1], x[0] * (square - 1.0) + pull, T::zero()]
    }
}

/// Variant of a [`Sheet`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SheetVariant {
    /// `r' = r (p + 2 r² - r⁴)` on `z = x² + p`, with a contact force of 5: two cycles for -1 < p <
    /// 0.
    Folded,
    /// `r' = r (1 - r²)` on `z = x²`, with a contact force of `p` and a pull of `x + 1/10`. The
    /// circle of radius 1 never leaves it for `p > 11/10`.
    Pulled,
    /// `r' = r (p + r² - r⁴)` on `z = 0`, with a contact force of 11/10 and a pull of `x`, at twice
    /// the rate. The outer cycle never leaves it for `p < 0.2541`, where r = 11/10.
    Growing,
}

/// A circle `θ' = 1` in x and y that sticks to a boundary in x and z. The boundary is curved except
/// for the last variant. The fourth state is the parameter `p`.
pub struct Sheet {
    pub variant: SheetVariant,
}

impl Filippov<4> for Sheet {
    fn field<T: Scalar>(&self, side: Side, _t: T, &[x, y, _, p]: &[T; 4]) -> [T; 4] {
        let square = x * x + y * y;
        let (grows, lifted) = match self.variant {
            SheetVariant::Folded => (
                p + square * 2.0 - square * square,
                T::constant(-5.0 * side.sign()),
            ),
            SheetVariant::Pulled => (-square + 1.0, x + 0.1 - p * side.sign()),
            SheetVariant::Growing => (p + square - square * square, x - 1.1 * side.sign()),
        };
        let (pace, bent) = match self.variant {
            SheetVariant::Folded | SheetVariant::Pulled => (1.0, 2.0),
            SheetVariant::Growing => (2.0, 0.0),
        };
        let forward = x * grows - y * pace;
        let across = y * grows + x * pace;
        [
            forward,
            across,
            x * forward * bent + lifted,
            T::constant(0.0),
        ]
    }
    fn boundary<T: Scalar>(&self, _t: T, &[x, _, z, p]: &[T; 4]) -> T {
        match self.variant {
            SheetVariant::Folded => z - x * x - p,
            SheetVariant::Pulled => z - x * x,
            SheetVariant::Growing => z,
        }
    }
}

impl<S: Filippov<4>> Filippov<3> for AtParameter<S> {
    fn field<T: Scalar>(&self, side: Side, t: T, &[x, y, z]: &[T; 3]) -> [T; 3] {
        let p = T::constant(self.value);
        let [x, y, z, _] = self.system.field(side, t, &[x, y, z, p]);
        [x, y, z]
    }
    fn boundary<T: Scalar>(&self, t: T, &[x, y, z]: &[T; 3]) -> T {
        let p = T::constant(self.value);
        self.system.boundary(t, &[x, y, z, p])
    }
}

/// A block with friction `p` on a belt of speed `a sin t + b sin 2t`. The second state is `p`.
pub struct Shaken {
    pub a: f64,
    pub b: f64,
}

impl Filippov<2> for Shaken {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
        [x[1] * -side.sign(), T::constant(0.0)]
    }
    fn boundary<T: Scalar>(&self, t: T, x: &[T; 2]) -> T {
        x[0] - t.sin() * self.a - (t * 2.0).sin() * self.b
    }
}

/// `y' = -3y/10 + cos 2t`, and beside it `z' = cos 2t + y/5 - p sgn z` on `z = 0`. The third state
/// is `p`. Once y has settled, the pull has the amplitude [`Pulse::amplitude`]. It always
/// sticks if `p` is larger.
pub struct Pulse;

impl Pulse {
    /// Amplitude of `cos 2t`, times `1 + (1/5)/(3/10 + 2i)`.
    pub fn amplitude() -> f64 {
        (4.25_f64 / 4.09).sqrt()
    }
}

impl Filippov<3> for Pulse {
    fn field<T: Scalar>(&self, side: Side, t: T, &[y, _, p]: &[T; 3]) -> [T; 3] {
        let drive = (t * 2.0).cos();
        [
            y * -0.3 + drive,
            drive + y * 0.2 - p * side.sign(),
            T::constant(0.0),
        ]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 3]) -> T {
        x[1]
    }
}

/// A block on a rough floor, driven by `cos 0.8t`. A block of 1/5 of its mass lies on top, which it
/// moves by at most the friction `p` between them.
pub struct Stack;

impl Stack {
    pub const PACE: f64 = 0.8;
    pub const FLOOR: f64 = 0.3;
    pub const TOP: f64 = 0.2;
}

impl Contacts<4, 2> for Stack {
    fn field<T: Scalar>(&self, sides: &[Side; 2], t: T, &[x, v, _, p]: &[T; 4]) -> [T; 4] {
        let between = p * sides[1].sign();
        let force = (t * Stack::PACE).cos() - x - Stack::FLOOR * sides[0].sign();
        [v, force + between, between / -Stack::TOP, T::zero()]
    }
    fn boundaries<T: Scalar>(&self, _t: T, &[_, v, upper, _]: &[T; 4]) -> [T; 2] {
        [v, upper - v]
    }
}

/// [`Rhythm::Clock`], whose upward crossing releases a second contact that it holds from π on.
/// Beside them is a [`Rhythm::Touch`] with the fourth state as its parameter.
pub struct Released;

impl Contacts<4, 3> for Released {
    fn field<T: Scalar>(&self, sides: &[Side; 3], t: T, &[clock, _, touch, p]: &[T; 4]) -> [T; 4] {
        let pull = 0.75 * (1.0 + sides[0].sign());
        [
            Rhythm::Clock.rate(sides[0], t, clock, T::zero()),
            T::constant(pull - sides[1].sign()),
            Rhythm::Touch.rate(sides[2], t, touch, p),
            T::zero(),
        ]
    }
    fn boundaries<T: Scalar>(&self, t: T, &[clock, held, touch, p]: &[T; 4]) -> [T; 3] {
        [clock, held, Rhythm::Touch.height(t, touch, p)]
    }
}

/// `y' = 1/4 - y² - p²`, with `p` as the third state, beside a driven block: driven orbits without
/// events on a closed branch.
pub struct DrivenIsland;

impl Filippov<3> for DrivenIsland {
    fn field<T: Scalar>(&self, _side: Side, t: T, &[y, x, p]: &[T; 3]) -> [T; 3] {
        [-y * y - p * p + 0.25, t.sin() - x, T::zero()]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 3]) -> T {
        x[1] - 10.0
    }
}

/// `x'' = cos wt - x - (2/5) sgn x'`, in the drive's own time `wt`. The third state is `w`.
pub struct Rough;

impl Filippov<3> for Rough {
    fn field<T: Scalar>(&self, side: Side, t: T, &[x, v, w]: &[T; 3]) -> [T; 3] {
        let force = t.cos() - x - 0.4 * side.sign();
        [v / w, force / w, T::zero()]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 3]) -> T {
        x[1]
    }
}

/// A block on a spring and a belt, with friction 1 in slip and 3/2 at rest. The third state is the
/// damping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grip;

impl Grip {
    pub const SPEED: f64 = 0.3;
    pub const STATIC: f64 = 1.5;

    fn rates<T: Scalar>([x, v, damping]: [T; 3], friction: f64) -> [T; 3] {
        [v, -x - damping * v - friction, T::zero()]
    }
}

impl Filippov<3> for Grip {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 3]) -> [T; 3] {
        Grip::rates(*x, side.sign())
    }
    fn holding<T: Scalar>(&self, side: Side, _t: T, x: &[T; 3]) -> [T; 3] {
        Grip::rates(*x, Grip::STATIC * side.sign())
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 3]) -> T {
        x[1] - Grip::SPEED
    }
}

/// Three equal lags in a row, under a relay that counteracts the last one above the threshold. The
/// fourth state is the threshold, in its own unit. Either side alone comes to rest at ±1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lags {
    pub unit: f64,
}

impl Filippov<4> for Lags {
    fn field<T: Scalar>(&self, side: Side, _t: T, &[x, y, z, _]: &[T; 4]) -> [T; 4] {
        [-x - side.sign(), x - y, y - z, T::zero()]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 4]) -> T {
        x[2] - x[3] * self.unit
    }
}

/// A focus at `x = -1` below `x = 0` that rotates at the rate 1 and grows at the rate of the third
/// state; above it the field (-1, -1/5). Orbits slide on the boundary to where the focus' field is
/// tangent, unless they start beyond the equilibrium of the sliding field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Focus;

impl Focus {
    pub const ABOVE: f64 = -0.2;
}

impl Filippov<3> for Focus {
    fn field<T: Scalar>(&self, side: Side, _t: T, &[x, y, grows]: &[T; 3]) -> [T; 3] {
        let off = x + 1.0;
        match side {
            Side::Below => [grows * off - y, off + grows * y, T::zero()],
            Side::Above => [T::constant(-1.0), T::constant(Focus::ABOVE), T::zero()],
        }
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 3]) -> T {
        x[0]
    }
}

/// An attracting focus at `x = p` below `x = 0`; above it the field (-1, 1). The third state is
/// `p`. Beyond zero the sliding field has an attracting equilibrium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Persists;

impl Filippov<3> for Persists {
    fn field<T: Scalar>(&self, side: Side, _t: T, &[x, y, p]: &[T; 3]) -> [T; 3] {
        let off = x - p;
        match side {
            Side::Below => [-off * 0.3 - y, off - y * 0.3, T::zero()],
            Side::Above => [T::constant(-1.0), T::constant(1.0), T::zero()],
        }
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 3]) -> T {
        x[0]
    }
}

/// A resonance at about 10 and a lag under a relay, with relative degree 1. The fourth state,
/// `rho`, is the location of the zeros. Symmetric orbits lose their symmetry and regain it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resonant;

impl Filippov<4> for Resonant {
    fn field<T: Scalar>(&self, side: Side, _t: T, &[y, a, b, rho]: &[T; 4]) -> [T; 4] {
        let relay = side.sign();
        [
            a - y * 2.0 - relay,
            b - y * 101.0 + rho * (2.0 * relay),
            -y * 100.0 - rho * rho * relay,
            T::zero(),
        ]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 4]) -> T {
        x[0]
    }
}

/// A driven block on a spring and a belt of speed 3/10, with damping 1/20, friction 1 in slip and
/// 13/10 at rest. The third state is the amplitude of the drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dragged;

impl Dragged {
    pub const PACE: f64 = 0.7;

    fn rates<T: Scalar>(t: T, [x, v, amplitude]: [T; 3], friction: f64) -> [T; 3] {
        let drive = amplitude * (t * Dragged::PACE).cos();
        [v, -x - v * 0.05 - friction + drive, T::zero()]
    }
}

impl Filippov<3> for Dragged {
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 3]) -> [T; 3] {
        Dragged::rates(t, *x, side.sign())
    }
    fn holding<T: Scalar>(&self, side: Side, t: T, x: &[T; 3]) -> [T; 3] {
        Dragged::rates(t, *x, 1.3 * side.sign())
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 3]) -> T {
        x[1] - 0.3
    }
}
