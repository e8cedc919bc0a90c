//! Tangent points: where a field touches Σ, and from which side its orbit does.

use crate::filippov::LieDerivatives;
use crate::system::{Filippov, Side, State};

/// How the orbit of a field that is tangent to Σ lies there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Visibility {
    /// The orbit stays on the field's own side: an orbit of the system leaves Σ here.
    Visible,
    /// The orbit lies on the other side, where the field does not rule.
    Invisible,
    /// The second derivative vanishes as well: a cusp or a higher degeneracy.
    Degenerate,
}

/// Whether the field of `side` is tangent to Σ at `(t, x)`, and how, by the sign of the second Lie derivative
/// of the boundary function along it; `None` where its normal component does not vanish to rounding.
///
/// ```
/// use stickslip::{analysis::{tangency, Visibility}, models::BeltOscillator, Side, State};
/// let belt = BeltOscillator::default();
/// // Eq. (16): the first of the six tangent points, where the field below touches Σ.
/// let first = 2.0 / 3f64.sqrt() * stickslip::math::cos(std::f64::consts::PI / 9.0);
/// let x = State::from([first, 1.0]);
/// assert_eq!(tangency(&belt, Side::Below, 0.0, &x), Some(Visibility::Visible));
/// assert_eq!(tangency(&belt, Side::Above, 0.0, &x), None);
/// ```
pub fn tangency<S: Filippov<N>, const N: usize>(
    system: &S,
    side: Side,
    t: f64,
    x: &State<N>,
) -> Option<Visibility> {
    let lie = LieDerivatives::new(system, side, t, x, 0.0);
    let is_tangent = lie.values[1].abs() <= lie.floors[1];
    is_tangent.then(|| of_tangent(&lie, side))
}

/// How the field of `side` lies at a point where it is known to be tangent.
pub fn visibility<S: Filippov<N>, const N: usize>(
    system: &S,
    side: Side,
    t: f64,
    x: &State<N>,
) -> Visibility {
    of_tangent(&LieDerivatives::new(system, side, t, x, 0.0), side)
}

fn of_tangent(lie: &LieDerivatives, side: Side) -> Visibility {
    if lie.values[2].abs() <= lie.floors[2] {
        Visibility::Degenerate
    } else if lie.values[2] * side.sign() > 0.0 {
        Visibility::Visible
    } else {
        Visibility::Invisible
    }
}
