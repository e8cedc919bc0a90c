//! Tangent points of the two one-degree-of-freedom models in closed form, classified numerically.

use super::cubic::{Balance, Cubic, TangentPoint};
use super::{BeltOscillator, ForcedOscillator};
use stickslip::scalar::Dual;
use stickslip::{Error, Filippov, Scalar, Side, State, Visibility};

/// A tangent point of Σ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BeltTangency {
    /// Position x₁ (m) at the given time.
    pub position: f64,
    /// Side whose field is tangent.
    pub side: Side,
    /// Visibility. In an oscillating zone this changes with time.
    pub visibility: Visibility,
}

impl BeltOscillator {
    /// The tangent points (Eq. 16 for the defaults), the largest position first. There are six
    /// below the critical μ0 of Eq. (13), two above it. A point at which both fields are tangent
    /// (μ0 = 0) is listed once for either side.
    ///
    /// # Errors
    /// [`Error::Parameter`] where a parameter is not allowed, or k1 or k2 is not positive.
    pub fn tangent_points(&self) -> Result<Vec<BeltTangency>, Error> {
        // The acceleration below is (k1 z − k2 z³ + μ0)/m: it vanishes where k2 z³ − k1 z = +μ0.
        let (spring, belt) = ((self.k1, self.k2, self.mu0), (self.belt_speed, Side::Below));
        tangencies(self, spring, belt, (0.0, 0.0))
    }

    /// The stick zones as intervals (lower end, upper end) of x₁, the largest first.
    ///
    /// # Errors
    /// As [`BeltOscillator::tangent_points`].
    pub fn stick_zones(&self) -> Result<Vec<(f64, f64)>, Error> {
        self.checked()?;
        Cubic::new(self.k1, self.k2)?.stick_zones(self.mu0)
    }
}

impl ForcedOscillator {
    /// The tangent points at time `t` (Eq. 24 moved by the support, `z_k + A sin(ωt)`), the largest
    /// position first.
    ///
    /// # Errors
    /// [`Error::Parameter`] where a parameter is not allowed, or k1 or k2 is not positive.
    pub fn tangent_points(&self, t: f64) -> Result<Vec<BeltTangency>, Error> {
        // The acceleration below is (k2 z³ − k1 z + μ0)/m: it vanishes where k2 z³ − k1 z = −μ0.
        let (spring, belt) = ((self.k1, self.k2, self.mu0), (self.belt_speed, Side::Above));
        tangencies(self, spring, belt, (t, self.support(t)))
    }

    /// The stick zones as intervals (lower end, upper end) of `z = x₁ − A sin(ωt)`, the largest
    /// first. Those of the opposite spring (k1 and k2 negative) are the same.
    ///
    /// # Errors
    /// [`Error::Parameter`] where a parameter is not allowed, or k1 and k2 have different signs.
    pub fn stick_zones(&self) -> Result<Vec<(f64, f64)>, Error> {
        self.checked()?;
        let sign = self.k1.signum();
        Cubic::new(sign * self.k1, sign * self.k2)?.stick_zones(self.mu0)
    }
}

/// The points at time `t`, displaced by `offset`. `plus` is the side that is tangent where the
/// cubic equals +μ0.
fn tangencies<S: Filippov<2>>(
    model: &S,
    (k1, k2, mu0): (f64, f64, f64),
    (belt_speed, plus): (f64, Side),
    (t, offset): (f64, f64),
) -> Result<Vec<BeltTangency>, Error> {
    model.check_parameters()?;
    let of_point = |point: TangentPoint| {
        let sides = match point.balance {
            Balance::Plus => vec![plus],
            Balance::Minus => vec![plus.opposite()],
            Balance::Both => vec![Side::Below, Side::Above],
        };
        let position = point.z + offset;
        let x = State::from([position, belt_speed]);
        sides.into_iter().map(move |side| BeltTangency {
            position,
            side,
            visibility: visibility(model, side, t, &x),
        })
    };
    let points = Cubic::new(k1, k2)?.tangent_points(mu0)?;
    Ok(points.into_iter().flat_map(of_point).collect())
}

/// Rounding of a rate, in units of its largest term: some operations with half a unit in the last
/// place each.
const ROUNDING_ULPS: f64 = 64.0;

/// First and second derivative of the boundary function along the field of `side`, and the rounding
/// of either.
fn lie_derivatives<S: Filippov<2>>(model: &S, side: Side, t: f64, x: &State<2>) -> ([f64; 2], f64) {
    let x: [f64; 2] = (*x).into();
    let along = |x: f64, rate: f64| Dual::new(x, rate);
    let velocity = model.field(side, t, &x);
    let time = along(t, 1.0);
    let once = [0, 1].map(|i| along(x[i], velocity[i]));
    let rates = model.field(side, time, &once);
    let twice = [0, 1].map(|i| Dual::new(once[i], rates[i]));
    let boundary = model.boundary(Dual::new(time, Dual::one()), &twice);
    let terms = rates.iter().flat_map(|rate| [rate.re, rate.eps]);
    let size = terms.fold(1.0, |most: f64, term| most.max(term.abs()));
    let rounding = ROUNDING_ULPS * f64::EPSILON * size;
    ([boundary.eps.re, boundary.eps.eps], rounding)
}

/// The visibility at a point where the field of `side` is tangent to Σ.
pub(crate) fn visibility<S: Filippov<2>>(
    model: &S,
    side: Side,
    t: f64,
    x: &State<2>,
) -> Visibility {
    let ([_, bending], rounding) = lie_derivatives(model, side, t, x);
    if bending.abs() <= rounding {
        Visibility::Degenerate
    } else if bending * side.sign() > 0.0 {
        Visibility::Visible
    } else {
        Visibility::Invisible
    }
}

/// The visibility if the field of `side` is tangent to Σ at `(t, x)`, to rounding.
pub(crate) fn tangency<S: Filippov<2>>(
    model: &S,
    side: Side,
    t: f64,
    x: &State<2>,
) -> Option<Visibility> {
    let ([rate, _], rounding) = lie_derivatives(model, side, t, x);
    (rate.abs() <= rounding).then(|| visibility(model, side, t, x))
}
