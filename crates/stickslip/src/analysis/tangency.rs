//! Tangent points: where a field is tangent to Σ, and on which side its orbit lies.

pub use crate::filippov::Visibility;

use crate::filippov::LieDerivatives;
use crate::system::{Filippov, Side, State};

/// The visibility at `(t, x)` if the field of `side` is tangent to Σ there, by the sign of the
/// boundary function's second Lie derivative along it. `None` if the field's normal component does
/// not vanish to rounding.
///
/// ```
#[doc = include_str!("../../examples/common/belt.rs")]
/// use stickslip::analysis::{Visibility, tangency};
/// use stickslip::{State, math};
///
/// let belt = Belt { speed: 1.0 };
/// // The first of six tangent points, where x - x³ + √3/9 = 0: the field below touches Σ.
/// let first = 2.0 / 3f64.sqrt() * math::cos(std::f64::consts::PI / 9.0);
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
