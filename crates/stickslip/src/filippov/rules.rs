//! Switching rules: the fate of points of Σ.
//!
//! At a point of Σ each field either leaves into its own side or pushes towards Σ. The sign of the
//! first Lie derivative of the boundary function along the field that does not vanish decides.
//! Almost everywhere it is the normal component. At a tangent point it is the second derivative:
//! the field's orbit stays on its own side (visible) or does not (invisible). At a cusp it is the
//! third. Four cases follow. One of them has no unique continuation, which is reported and never
//! chosen silently. Both fields may be tangent, with an equilibrium on one side to which the other
//! field leads back. The state then rests on that side.

use super::flow::{GUARDS, flow_path, normal_component, seeded};
use super::uncertainty::{RELATIVE_ROUNDING, STATE_ROUNDING, on_one_side};
use crate::dual::{Dual, Dual3};
use crate::ode::Timed;
use crate::scalar::Scalar;
use crate::system::{Filippov, Side, State, components};

/// The fate of a point of Σ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// Slip on this side. Both fields point to it, or its field is tangent and visible, or both are
    /// tangent and its field has an equilibrium there.
    Slip(Side),
    /// Both fields push towards Σ: stick.
    Stick,
    /// Both fields lead away from Σ (escaping, repelling sliding): no unique future.
    Repelling,
}

/// Fate of a point of Σ, with the order at which the motion that follows touches its guards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Departure {
    pub fate: Fate,
    /// Number of derivatives, from the value on, of every guard of the next mode that vanish at the
    /// start. It is 0 away from zero, 1 where the motion leaves Σ across, 2 where it leaves from a
    /// tangent point.
    pub orders: [usize; GUARDS],
}

/// Kind of a tangency of a field's orbit with Σ.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Visibility {
    /// The orbit stays on the field's own side: an orbit of the system leaves Σ here.
    Visible,
    /// The orbit lies on the other side, where the field does not rule.
    Invisible,
    /// The second derivative vanishes as well: a cusp or a higher degeneracy.
    Degenerate,
}

/// Lie derivatives 0 to 3 of a function along one field, each with its rounding.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LieDerivatives {
    pub values: [f64; 4],
    pub floors: [f64; 4],
}

impl LieDerivatives {
    /// Derivatives of the boundary function along `side`'s field at `(t, x)`.
    pub(crate) fn new<S: Filippov<N>, const N: usize>(
        system: &S,
        side: Side,
        t: f64,
        x: &State<N>,
        slack: f64,
    ) -> Self {
        let of = (t, x, system.dimension());
        let [one] = LieDerivatives::along(of, slack, |t, x| {
            let path = flow_path(t, x, |t, x| system.field(side, t, x));
            [system.boundary(path.0, &path.1)]
        });
        one
    }

    /// Derivatives of a function of the first `dimension` components of the state. `path` gives its
    /// values along a field. The rounding is the change of the derivatives if state and time change
    /// by [`STATE_ROUNDING`], and every component by `slack`. A component that should be zero is
    /// zero only to that.
    pub(crate) fn along<const N: usize, const G: usize>(
        (t, x, dimension): (f64, &State<N>, usize),
        slack: f64,
        path: impl Fn(Dual<f64>, &[Dual<f64>; N]) -> [Dual3<Dual<f64>>; G],
    ) -> [Self; G] {
        let mut values = [[0.0; 4]; G];
        let (mut spread, mut shift) = ([[0.0; 4]; G], [[0.0; 4]; G]);
        // Direction N is time.
        for direction in (0..dimension).chain([N]) {
            let (size, slack) = if direction < N {
                (x[direction].abs(), slack)
            } else {
                (t.abs(), 0.0)
            };
            let of = |x: State<N>| {
                let (dual_t, dual_x) = seeded(&Timed { t, x }, direction);
                path(dual_t, &dual_x).map(|h| [h.re, h.v1, h.v2, h.v3])
            };
            let functions = of(*x);
            let is_steep = |one: &Dual<f64>| direction < N && one.eps.is_infinite();
            let beside = functions.iter().flatten().any(is_steep).then(|| {
                [slack, -slack].map(|slack| {
                    let mut there = *x;
                    there[direction] += slack;
                    of(there)
                })
            });
            for (i, h) in functions.iter().enumerate() {
                for (k, derivative) in h.iter().enumerate() {
                    values[i][k] = derivative.re;
                    match beside.filter(|_| is_steep(derivative)) {
                        Some(beside) => {
                            shift[i][k] +=
                                on_one_side(|side| beside[side][i][k].re - derivative.re);
                        }
                        None => {
                            spread[i][k] += derivative.eps.abs() * size;
                            shift[i][k] += derivative.eps.abs() * slack;
                        }
                    }
                }
            }
        }
        std::array::from_fn(|i| LieDerivatives {
            values: values[i],
            floors: std::array::from_fn(|k| {
                // Each derivative is the rate of the previous one. The rate of the last one is
                // unknown.
                let drift = values[i]
                    .get(k + 1)
                    .map_or(0.0, |rate| rate.abs() * t.abs());
                let size = spread[i][k] + values[i][k].abs() + drift;
                STATE_ROUNDING * size + shift[i][k]
            }),
        })
    }

    /// Index and sign of the first that does not vanish, from the first on, or from the second if
    /// the first is known to vanish. Index 4 without a sign if all vanish.
    pub(crate) fn leading(&self, tangent: bool) -> (usize, f64) {
        let first = if tangent { 2 } else { 1 };
        (first..4)
            .find(|&k| is_significant(self.values[k], self.floors[k]))
            .map_or((4, 0.0), |k| (k, self.values[k].signum()))
    }

    /// Whether the sliding field keeps the boundary function at zero: its Lie derivatives vanish up
    /// to the first order at which that of a side's field does not.
    pub(crate) fn holds_beside(&self, fields: [&Self; 2]) -> bool {
        let size = |k: usize| f64::max(fields[0].values[k].abs(), fields[1].values[k].abs());
        let is_moved = |k: &usize| {
            let is_significant = |of: &&Self| is_significant(of.values[*k], of.floors[*k]);
            fields.iter().any(is_significant)
        };
        let vanishes =
            |k: usize| self.values[k].abs() <= self.floors[k].max(RELATIVE_ROUNDING * size(k));
        // Nothing holds where a field is undefined.
        let is_defined = self.values.iter().all(|value| value.is_finite());
        is_defined
            && (1..4)
                .find(is_moved)
                .is_none_or(|first| (1..=first).all(vanishes))
    }

    /// Kind of the tangency of the field of `side`, if it is tangent to Σ here.
    pub(crate) fn visibility(&self, side: Side) -> Visibility {
        if self.values[2].abs() <= self.floors[2] {
            Visibility::Degenerate
        } else if self.values[2] * side.sign() > 0.0 {
            Visibility::Visible
        } else {
            Visibility::Invisible
        }
    }
}

/// Whether a derivative is more than rounding. If its rounding overflows, the value decides.
fn is_significant(value: f64, floor: f64) -> bool {
    value.abs() > if floor.is_nan() { 0.0 } else { floor }
}

/// The first Lie derivative along `side`'s field at `(t, x)`, and the field there.
#[inline(always)]
fn first_derivative<S: Filippov<N>, T: Scalar, const N: usize>(
    system: &S,
    side: Side,
    t: T,
    x: &[T; N],
) -> (T, [T; N]) {
    let f = system.field(side, t, x);
    (normal_component(system, t, x, &f), f)
}

/// The second Lie derivative: the change of the first along the field.
#[inline(always)]
fn second_derivative<S: Filippov<N>, T: Scalar, const N: usize>(
    system: &S,
    side: Side,
    t: T,
    x: &[T; N],
) -> (T, [T; N]) {
    let f = system.field(side, t, x);
    let flowing = std::array::from_fn(|i| Dual::new(x[i], f[i]));
    let rate = first_derivative(system, side, Dual::new(t, T::one()), &flowing).0;
    (rate.eps, f)
}

/// The field along Σ: without its component across. For a field that is a root of the distance from
/// Σ, the slope across is infinite.
#[inline(always)]
fn field_along<S: Filippov<N>, T: Scalar, const N: usize>(
    system: &S,
    side: Side,
    t: T,
    x: &[T; N],
) -> [T; N] {
    let f = system.field(side, t, x);
    let rate = normal_component(system, t, x, &f);
    let normal: [T; N] = std::array::from_fn(|i| {
        let along = std::array::from_fn(|k| match k == i {
            true => Dual::new(x[k], T::one()),
            false => Dual::new(x[k], T::zero()),
        });
        system.boundary(Dual::new(t, T::zero()), &along).eps
    });
    let square = normal.iter().fold(T::zero(), |sum, &n| sum + n * n);
    std::array::from_fn(|i| f[i] - normal[i] * (rate / square))
}

/// The second Lie derivative where the first vanishes, of the motion along Σ.
#[inline(never)]
fn second_derivative_along<S: Filippov<N>, T: Scalar, const N: usize>(
    system: &S,
    side: Side,
    t: T,
    x: &[T; N],
) -> (T, [T; N]) {
    let along = field_along(system, side, t, x);
    let flowing = std::array::from_fn(|i| Dual::new(x[i], along[i]));
    let rate = first_derivative(system, side, Dual::new(t, T::one()), &flowing).0;
    (rate.eps, system.field(side, t, x))
}

/// Lie derivatives where the first vanishes, of the motion along Σ: the normal component is the
/// first of them.
#[cold]
#[inline(never)]
fn derivatives_along<S: Filippov<N>, const N: usize>(
    system: &S,
    side: Side,
    (t, x): (f64, &State<N>),
    slack: f64,
) -> LieDerivatives {
    let [one] = LieDerivatives::along((t, x, system.dimension()), slack, |t, x| {
        let (t, x) = flow_path(t, x, |t, x| field_along(system, side, t, x));
        let rate = first_derivative(system, side, t, &x).0;
        let height = system.boundary(t, &x);
        [Dual3::new(height.re, rate.re, rate.v1, rate.v2)]
    });
    one
}

/// A Lie derivative and its rounding, as in [`LieDerivatives`] but at a small part of the cost.
/// `along` gives the derivative and the field.
#[inline(always)]
fn one_derivative<const N: usize>(
    (t, x, dimension): (f64, &State<N>, usize),
    slack: f64,
    along: impl Fn(Dual<f64>, &[Dual<f64>; N]) -> (Dual<f64>, [Dual<f64>; N]),
) -> (f64, f64) {
    let in_direction = |direction: usize| {
        let (t, x) = seeded(&Timed { t, x: *x }, direction);
        along(t, &x)
    };
    let (derivative, f) = in_direction(N);
    let (mut spread, mut shift) = (derivative.eps.abs() * t.abs(), 0.0);
    // Its change along the field is the next derivative.
    let mut next = derivative.eps;
    for direction in 0..dimension {
        let change = in_direction(direction).0.eps;
        // The slope of a root of the distance is infinite on Σ, and its change over the slack is
        // not.
        if change.is_infinite() {
            shift += on_one_side(|side| {
                let mut there = *x;
                there[direction] += [slack, -slack][side];
                let (t, x) = seeded(&Timed { t, x: there }, N);
                along(t, &x).0.re - derivative.re
            });
            continue;
        }
        spread += change.abs() * x[direction].abs();
        shift += change.abs() * slack;
        next += change * f[direction].re;
    }
    let size = spread + derivative.re.abs() + next.abs() * t.abs();
    let floor = STATE_ROUNDING * size + shift;
    (derivative.re, floor)
}

/// Whether the point `(t, x)` lies on Σ to rounding.
pub(crate) fn on_boundary<S: Filippov<N>, const N: usize>(
    system: &S,
    side: Side,
    t: f64,
    x: &State<N>,
    slack: f64,
) -> bool {
    let along = |t, x: &_| (system.boundary(t, x), system.field(side, t, x));
    let (height, floor) = one_derivative((t, x, system.dimension()), slack, along);
    height.abs() <= floor
}

/// Index and sign of the first Lie derivative (from the first on) along one field that does not
/// vanish; index 4 if all vanish.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LeadingDerivative {
    order: usize,
    sign: f64,
    /// Number of calls of the field.
    pub calls: u64,
}

impl LeadingDerivative {
    /// Leading derivative of `side`'s field at `(t, x)`; `slack` as for [`LieDerivatives::new`].
    /// `tangent`: the first derivative vanishes by construction, so that its rounding does not
    /// count.
    pub(crate) fn new<S: Filippov<N>, const N: usize>(
        system: &S,
        side: Side,
        t: f64,
        x: &State<N>,
        slack: f64,
        tangent: bool,
    ) -> Self {
        // Usually the first one decides.
        let (n, at) = (system.dimension() as u64, (t, x, system.dimension()));
        let mut is_root = false;
        let (first, (value, floor), calls) = if tangent {
            let along = |t, x: &_| second_derivative(system, side, t, x);
            let mut second = one_derivative(at, slack, along);
            is_root = !second.0.is_finite();
            if is_root {
                let along = |t, x: &_| second_derivative_along(system, side, t, x);
                second = one_derivative(at, slack, along);
            }
            (2, second, 2 * (n + 1))
        } else {
            let along = |t, x: &_| first_derivative(system, side, t, x);
            (1, one_derivative(at, slack, along), n + 1)
        };
        if is_significant(value, floor) {
            return LeadingDerivative {
                order: first,
                sign: value.signum(),
                calls,
            };
        }
        let all = match is_root {
            true => derivatives_along(system, side, (t, x), slack),
            false => LieDerivatives::new(system, side, t, x, slack),
        };
        let (order, sign) = all.leading(tangent);
        LeadingDerivative {
            order,
            sign,
            calls: calls + 3 * (n + 1),
        }
    }
}

/// The side on which a point of Σ is an equilibrium to rounding. Both fields are tangent to Σ, so
/// that no sliding field is determined, and the other field leads back to it.
fn equilibrium_side<S: Filippov<N>, const N: usize>(
    system: &S,
    t: f64,
    x: &State<N>,
    [below, above]: [&LeadingDerivative; 2],
) -> Option<Side> {
    let side = match (below.sign, above.sign) {
        (0.0, sign) if sign < 0.0 => Side::Below,
        (sign, 0.0) if sign > 0.0 => Side::Above,
        _ => return None,
    };
    let speed = |side| {
        let rates = system.field(side, t, components(x));
        rates
            .iter()
            .fold(0.0_f64, |most, rate| most.max(rate.abs()))
    };
    let both_tangent = below.order > 1 && above.order > 1;
    (both_tangent && speed(side) <= RELATIVE_ROUNDING * speed(side.opposite())).then_some(side)
}

/// Applies the rules at a point of Σ to the leading derivatives along the two fields. `rests` is
/// the side with an equilibrium there, if exactly one has it.
pub(crate) fn departure(
    below: LeadingDerivative,
    above: LeadingDerivative,
    rests: Option<Side>,
) -> Departure {
    let fate = match (below.sign < 0.0, above.sign > 0.0) {
        (true, true) => Fate::Repelling,
        (true, false) => Fate::Slip(Side::Below),
        (false, true) => Fate::Slip(Side::Above),
        (false, false) => rests.map_or(Fate::Stick, Fate::Slip),
    };
    let orders = match fate {
        Fate::Slip(Side::Below) => [below.order, 0, 0],
        Fate::Slip(Side::Above) => [above.order, 0, 0],
        // A guard of the stick phase is the first derivative, so its order is one less.
        Fate::Stick | Fate::Repelling => [below.order - 1, above.order - 1, 0],
    };
    Departure { fate, orders }
}

/// A system whose fields are those of static friction.
pub(crate) struct WithStaticFriction<'a, S>(pub &'a S);

impl<S: Filippov<N>, const N: usize> Filippov<N> for WithStaticFriction<'_, S> {
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; N]) -> [T; N] {
        self.0.holding(side, t, x)
    }
    fn boundary<T: Scalar>(&self, t: T, x: &[T; N]) -> T {
        self.0.boundary(t, x)
    }
    fn dimension(&self) -> usize {
        self.0.dimension()
    }
}

/// The fate of the point `(t, x)` of Σ by its two fields (Filippov 1988, Sect. 4 and 19; Kuznetsov,
/// Rinaldi & Gragnani 2003 for tangent points).
///
/// ```
#[doc = include_str!("../../examples/common/belt.rs")]
/// use stickslip::{Fate, State, fate};
///
/// let belt = Belt { speed: 1.0 };
/// assert_eq!(fate(&belt, 0.0, &State::from([0.0, 1.0])), Fate::Stick);
/// assert_eq!(fate(&belt, 0.0, &State::from([1.5, 1.0])), Fate::Slip(Side::Below));
/// ```
pub fn fate<S: Filippov<N>, const N: usize>(system: &S, t: f64, x: &State<N>) -> Fate {
    let at = (&Timed { t, x: *x }, 0.0);
    let held = departure_by(&WithStaticFriction(system), at, None, &mut 0);
    if held.fate == Fate::Stick {
        return held.fate;
    }
    departure_by(system, at, None, &mut 0).fate
}

/// The fate of a point of Σ by the fields of one kind of friction. `tangent` names the side whose
/// normal component is known to vanish. The calls of the field are added to `calls`.
pub(crate) fn departure_by<S: Filippov<N>, const N: usize>(
    system: &S,
    (Timed { t, x }, slack): (&Timed<N>, f64),
    tangent: Option<Side>,
    calls: &mut u64,
) -> Departure {
    let of = |side| LeadingDerivative::new(system, side, *t, x, slack, tangent == Some(side));
    let [below, above] = [Side::Below, Side::Above].map(of);
    *calls += below.calls + above.calls;
    let rests = equilibrium_side(system, *t, x, [&below, &above]);
    departure(below, above, rests)
}

#[cfg(test)]
mod tests {
    use super::*;
    use numerics::SplitMix;

    /// A boundary that moves, and a field that is tangent to it at times.
    struct Moving;

    impl Filippov<1> for Moving {
        fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 1]) -> [T; 1] {
            [(t * 0.5).cos() * x[0] - side.sign()]
        }
        fn boundary<T: Scalar>(&self, t: T, x: &[T; 1]) -> T {
            x[0] - t.sin()
        }
    }

    /// A block on a belt, on a soft spring to a support that is shaken.
    struct Shaken;

    impl Filippov<2> for Shaken {
        fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 2]) -> [T; 2] {
            let slip_speed = (x[1] - 0.4) * side.sign();
            let friction = T::constant(0.2 * side.sign()) / (slip_speed + 1.0);
            let z = x[0] - (t * 3.8).sin() * 0.4;
            [x[1], (z * (z * z - 1.0) - friction) * 10.0]
        }
        fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
            x[1] - 0.4
        }
    }

    fn compare<S: Filippov<N>, const N: usize>(system: &S) {
        let mut draw = SplitMix::new(1988);
        for _ in 0..200 {
            let t = draw.between(0.0, 50.0);
            let x = State::from([(); N].map(|()| draw.between(-2.0, 2.0)));
            let slack = draw.between(0.0, 1e-12);
            for side in [Side::Below, Side::Above] {
                let all = LieDerivatives::new(system, side, t, &x, slack);
                let first = one_derivative((t, &x, N), slack, |t, x| {
                    first_derivative(system, side, t, x)
                });
                let second = one_derivative((t, &x, N), slack, |t, x| {
                    second_derivative(system, side, t, x)
                });
                for (k, (value, floor)) in [(1, first), (2, second)] {
                    let size = all.floors[k] / STATE_ROUNDING;
                    assert!((value - all.values[k]).abs() < 1e-14 * size, "{k}: {value}");
                    assert!((floor / all.floors[k] - 1.0).abs() < 1e-9, "{k}: {floor}");
                }
            }
        }
    }

    #[test]
    fn one_derivative_alone_is_that_of_all_with_its_floor() {
        compare(&Shaken);
        compare(&Moving);
    }

    #[test]
    fn where_the_first_that_may_decide_vanishes_the_next_ones_do() {
        /// Three integrators in a row: all derivatives are those of the state.
        struct Integrators;
        impl Filippov<3> for Integrators {
            fn field<T: Scalar>(&self, _side: Side, _t: T, x: &[T; 3]) -> [T; 3] {
                [x[1], x[2], T::constant(-2.0)]
            }
            fn boundary<T: Scalar>(&self, _t: T, x: &[T; 3]) -> T {
                x[0]
            }
        }
        for (x, tangent, order, sign, calls) in [
            ([0.0, 1.0, -1.0], false, 1, 1.0, 4),
            ([0.0, 0.0, -1.0], false, 2, -1.0, 4 + 12),
            ([0.0, 1.0, -1.0], true, 2, -1.0, 8),
            ([0.0, 1.0, 0.0], true, 3, -1.0, 8 + 12),
        ] {
            let found = LeadingDerivative::new(
                &Integrators,
                Side::Above,
                1.0,
                &State::from(x),
                0.0,
                tangent,
            );
            assert_eq!((found.order, found.sign, found.calls), (order, sign, calls));
        }
        assert_eq!(derivatives([1.0, 0.0, 0.0, 0.0]).leading(false), (4, 0.0));
    }

    #[test]
    fn leading_derivatives_decide_the_fate_and_the_orders_of_guards() {
        let rests = Some(Side::Below);
        for (below, above, rests, fate, orders) in [
            ((1, 1.0), (1, -1.0), None, Fate::Stick, [0, 0, 0]),
            ((2, 1.0), (1, -1.0), None, Fate::Stick, [1, 0, 0]),
            ((4, 0.0), (4, 0.0), None, Fate::Stick, [3, 3, 0]),
            (
                (3, -1.0),
                (2, -1.0),
                None,
                Fate::Slip(Side::Below),
                [3, 0, 0],
            ),
            ((1, 1.0), (2, 1.0), None, Fate::Slip(Side::Above), [2, 0, 0]),
            ((1, -1.0), (3, 1.0), None, Fate::Repelling, [0, 2, 0]),
            (
                (4, 0.0),
                (2, -1.0),
                rests,
                Fate::Slip(Side::Below),
                [4, 0, 0],
            ),
        ] {
            let [of_below, of_above] = [below, above].map(|(order, sign)| LeadingDerivative {
                order,
                sign,
                calls: 0,
            });
            let found = departure(of_below, of_above, rests);
            assert_eq!(found, Departure { fate, orders }, "{below:?} {above:?}");
        }
    }

    #[test]
    fn a_normal_component_that_is_known_to_vanish_decides_nothing() {
        let system = AlongBoundary {
            along: [1.0, 1.0],
            bend: [-1.0, 1.0],
            holding: 0.0,
        };
        // Far more than rounding before the tangent point, from which the field above leaves.
        let at = Timed {
            t: 0.0,
            x: State::from([-1e-9, 0.0]),
        };
        let fate = |tangent| departure_by(&system, (&at, 0.0), tangent, &mut 0).fate;
        assert_eq!(fate(None), Fate::Stick);
        assert_eq!(fate(Some(Side::Above)), Fate::Slip(Side::Above));
    }

    /// Lie derivatives with floors of rounding.
    fn derivatives(values: [f64; 4]) -> LieDerivatives {
        let floors = [1e-15; 4];
        LieDerivatives { values, floors }
    }

    #[test]
    fn a_combination_holds_as_far_as_its_fields_move() {
        let holds = |own: [f64; 4], fields: [[f64; 4]; 2]| {
            let [one, other] = fields.map(derivatives);
            derivatives(own).holds_beside([&one, &other])
        };
        let (still, first, second) = ([0.0; 4], [0.0, 1e3, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]);
        // Beside the larger of the fields.
        for fields in [[first, still], [still, first]] {
            assert!(holds([0.0, 9e-10, 5.0, 5.0], fields));
            assert!(!holds([0.0, 1.1e-9, 0.0, 0.0], fields));
            assert!(!holds([0.0, -1.1e-9, 0.0, 0.0], fields));
        }
        // Up to the first derivative that moves, and with it.
        assert!(holds([0.0, 0.0, 0.0, 5.0], [second, still]));
        assert!(!holds([0.0, 0.0, 1e-3, 0.0], [second, still]));
        assert!(!holds([0.0, 1e-3, 0.0, 0.0], [second, still]));
        let third = [0.0, 0.0, 0.0, 1.0];
        assert!(!holds([0.0, 0.0, 0.0, 1e-3], [third, still]));
        assert!(holds([0.0, 1.0, 1.0, 1.0], [still, still]));
        assert!(!holds([f64::NAN, 0.0, 0.0, 0.0], [first, still]));
        assert!(!holds([0.0, 0.0, 0.0, f64::INFINITY], [first, still]));
        // Within the rounding of the combination.
        let rounded = LieDerivatives {
            values: [0.0, 1e-6, 0.0, 0.0],
            floors: [2e-6; 4],
        };
        let [one, other] = [first, still].map(derivatives);
        assert!(rounded.holds_beside([&one, &other]));
    }

    #[test]
    fn a_tangency_is_visible_on_the_side_to_which_it_bends() {
        for (second, below, above) in [
            (2e-15, Visibility::Invisible, Visibility::Visible),
            (-2e-15, Visibility::Visible, Visibility::Invisible),
            (1e-15, Visibility::Degenerate, Visibility::Degenerate),
            (-1e-15, Visibility::Degenerate, Visibility::Degenerate),
        ] {
            let found = derivatives([0.0, 0.0, second, 1.0]);
            assert_eq!(found.visibility(Side::Below), below, "{second}");
            assert_eq!(found.visibility(Side::Above), above, "{second}");
        }
    }

    #[test]
    fn a_value_counts_beyond_its_rounding_or_where_that_overflows() {
        for (value, floor, counts) in [
            (2.0, 1.0, true),
            (-2.0, 1.0, true),
            (1.0, 1.0, false),
            (1.0, f64::NAN, true),
            (0.0, f64::NAN, false),
        ] {
            assert_eq!(is_significant(value, floor), counts, "{value} {floor}");
        }
    }

    #[test]
    fn the_slope_of_a_root_counts_by_its_change_over_the_slack() {
        let (x, slack) = (State::from([0.0]), 1e-8);
        let root = |_t, x: &[Dual<f64>; 1]| (x[0].sqrt() + 3.0, *x);
        let (value, floor) = one_derivative((0.0, &x, 1), slack, root);
        assert_eq!(value, 3.0);
        // The root of the slack, and the rounding of 3.
        assert!(
            (floor - (1e-4 + 3.0 * STATE_ROUNDING)).abs() < 1e-15,
            "{floor:e}"
        );

        /// The field across Σ is a root of the distance from it, on a plane scaled by 2.
        struct Root {
            rate: f64,
        }
        impl Filippov<2> for Root {
            fn field<T: Scalar>(&self, _side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
                [x[0].sqrt() + x[1], T::constant(self.rate)]
            }
            fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
                x[0] * 2.0
            }
        }
        let origin = [Dual::new(0.0, 0.0); 2];
        let system = Root { rate: 1.5 };
        let along = |x| second_derivative_along(&system, Side::Above, Dual::new(0.0, 1.0), x).0;
        // Twice the rate of x₁.
        assert_eq!(along(&origin).re, 3.0);
        let slope = [Dual::new(0.0, 0.0), Dual::new(0.25, 0.0)];
        assert_eq!(along(&slope).re, 3.0);
        // What rounding leaves of the first derivative has an infinite slope.
        for (rate, left) in [(1.5, 0.0), (1.5, -1e-17), (-1.5, 1e-17)] {
            let x = State::from([0.0, left]);
            let found = LeadingDerivative::new(&Root { rate }, Side::Above, 0.0, &x, slack, true);
            assert_eq!((found.order, found.sign), (2, rate.signum()), "{left:e}");
        }
    }

    /// Fields along the boundary x₁ = 0, by side: their rate along it, and that of their bend.
    struct AlongBoundary {
        along: [f64; 2],
        bend: [f64; 2],
        /// Strength by which static friction pushes back what holds.
        holding: f64,
    }

    impl Filippov<2> for AlongBoundary {
        fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
            let of = usize::from(side == Side::Above);
            [T::constant(self.along[of]), x[0] * self.bend[of]]
        }
        fn holding<T: Scalar>(&self, side: Side, t: T, x: &[T; 2]) -> [T; 2] {
            let [along, across] = self.field(side, t, x);
            [along, across - self.holding * side.sign()]
        }
        fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
            x[1]
        }
    }

    #[test]
    fn a_state_rests_on_the_side_of_an_equilibrium_to_which_the_other_leads_back() {
        let from = |x: [f64; 2], along: [f64; 2], bend: [f64; 2]| {
            let holding = 0.0;
            let system = AlongBoundary {
                along,
                bend,
                holding,
            };
            fate(&system, 0.0, &State::from(x))
        };
        let at = |along, bend| from([0.0, 0.0], along, bend);
        // The other field bends back to Σ at once.
        assert_eq!(at([0.0, 1.0], [0.0, -1.0]), Fate::Slip(Side::Below));
        assert_eq!(at([1.0, 0.0], [1.0, 0.0]), Fate::Slip(Side::Above));
        // An equilibrium to rounding, beside the other field's speed.
        assert_eq!(at([1e-13, 1.0], [0.0, -1.0]), Fate::Slip(Side::Below));
        assert_eq!(at([1e-3, 1.0], [0.0, -1.0]), Fate::Stick);
        // A field that leads away is followed.
        assert_eq!(at([0.0, 1.0], [0.0, 1.0]), Fate::Slip(Side::Above));
        // Nothing leads away: both fields stay on Σ, or one crosses it towards the equilibrium.
        assert_eq!(at([1.0, 1.0], [0.0, 0.0]), Fate::Stick);
        assert_eq!(from([1.0, 0.0], [0.0, 1.0], [0.0, -1.0]), Fate::Stick);
    }

    #[test]
    fn static_friction_decides_before_that_in_slip() {
        let at = |holding: f64| {
            let (along, bend) = ([1.0, 1.0], [1.0, 1.0]);
            let system = AlongBoundary {
                along,
                bend,
                holding,
            };
            // Both fields leave upwards, at a rate of 0.5.
            fate(&system, 0.0, &State::from([0.5, 0.0]))
        };
        assert_eq!(at(0.4), Fate::Slip(Side::Above));
        assert_eq!(at(0.6), Fate::Stick);

        /// One component is room.
        struct Padded;
        impl Filippov<2> for Padded {
            fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
                [-x[0] - side.sign(), T::zero()]
            }
            fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
                x[0]
            }
            fn dimension(&self) -> usize {
                1
            }
        }
        assert_eq!(WithStaticFriction(&Padded).dimension(), 1);
    }

    #[test]
    fn a_point_is_on_the_boundary_to_slack_and_rounding() {
        /// A small distance between large numbers.
        struct Between;
        impl Filippov<2> for Between {
            fn field<T: Scalar>(&self, _side: Side, _t: T, _x: &[T; 2]) -> [T; 2] {
                [T::zero(), T::zero()]
            }
            fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
                x[0] - x[1]
            }
        }
        for (size, gap, slack, is_on) in [
            // The slack of both components.
            (0.0, 1.9e-9, 1e-9, true),
            (0.0, 2.1e-9, 1e-9, false),
            (0.0, -2.1e-9, 1e-9, false),
            // 64 units in the last place of both.
            (1e6, 2.5e-8, 0.0, true),
            (1e6, 3.2e-8, 0.0, false),
        ] {
            let x = State::from([size + gap, size]);
            assert_eq!(
                on_boundary(&Between, Side::Above, 0.0, &x, slack),
                is_on,
                "{gap:e}"
            );
        }
    }
}
