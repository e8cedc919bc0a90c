//! Tangent points: where a field is tangent to Σ, and on which side its orbit lies.

pub use crate::filippov::Visibility;

use crate::filippov::LieDerivatives;
use crate::system::{Filippov, Side, State};

/// The visibility at `(t, x)` if the field of `side` is tangent to Σ there, by the sign of the
/// boundary function's second Lie derivative along it. `None` if the field's normal component does
/// not vanish to rounding.
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

/// The visibility at a point where the field of `side` is tangent, without a check that it is.
pub fn visibility<S: Filippov<N>, const N: usize>(
    system: &S,
    side: Side,
    t: f64,
    x: &State<N>,
) -> Visibility {
    LieDerivatives::new(system, side, t, x, 0.0).visibility(side)
}
