//! Tangent points: where a field touches Σ, and from which side its orbit does.

pub use crate::filippov::Visibility;

use crate::filippov::LieDerivatives;
use crate::system::{Filippov, Side, State};

/// Whether the field of `side` is tangent to Σ at `(t, x)`, and how, by the sign of the second Lie
/// derivative of the boundary function along it; `None` where its normal component does not vanish
/// to rounding.
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
    is_tangent.then(|| lie.visibility(side))
}

/// How the field of `side` lies at a point where it is known to be tangent.
pub fn visibility<S: Filippov<N>, const N: usize>(
    system: &S,
    side: Side,
    t: f64,
    x: &State<N>,
) -> Visibility {
    LieDerivatives::new(system, side, t, x, 0.0).visibility(side)
}
