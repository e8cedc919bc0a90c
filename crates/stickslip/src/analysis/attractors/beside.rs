//! Attractors of orbits next to an unstable periodic orbit.

use super::attractor::{Attractor, AttractorKind};
use super::distinct::{Attractors, SAME_CLOSENESSES};
use super::tolerance::SameWithin;
use super::{RecurrenceSettings, section, seek};
use crate::analysis::cycle::Cycle;
use crate::dynamics::{AsDynamics, Dynamics, Moment, Vector};
use crate::filippov::Options;
use crate::math::product;

/// Squarings of the derivative of the flow map. Chosen: in its 64th power, a multiplier of 1.2
/// exceeds those inside the unit circle by five digits, and any deviation grows.
const SQUARINGS: usize = 6;

/// The attractor of the neighbours of an orbit. An orbit that begins on an unstable periodic orbit,
/// or on its stable manifold, stays there. Unstable orbits are told as in [`Attractors::number`].
///
/// The run continues from a state displaced along the direction that grows fastest, far enough that
/// the two states are not the same. Other motions are returned as they are, and so are orbits of
/// families and orbits at which the flow map has no derivative. The kind is
/// [`AttractorKind::Unstable`] where the displaced run reaches an unstable orbit, too.
///
/// ```
/// use std::f64::consts::TAU;
/// use stickslip::analysis::{AttractorKind, RecurrenceSettings, attractor, attractor_beside};
/// use stickslip::{Filippov, Options, Scalar, Side};
///
/// /// A spring whose stiffness oscillates at twice its own frequency. Rest at zero is unstable.
/// struct Spring;
/// impl Filippov<2> for Spring {
///     fn field<T: Scalar>(&self, _: Side, t: T, x: &[T; 2]) -> [T; 2] {
///         let stiffness = t.cos() * 0.4 + 0.25;
///         [x[1], -x[0] * (stiffness + x[0] * x[0]) - x[1] * 0.2]
///     }
///     fn boundary<T: Scalar>(&self, _t: T, _x: &[T; 2]) -> T {
///         T::constant(1.0)
///     }
/// }
///
/// let settings = RecurrenceSettings::within(2000.0).forced(TAU);
/// let options = Options::tol(1e-10);
/// let at_zero = attractor(&Spring, [0.0, 0.0], &settings, &options)?;
/// assert!(matches!(at_zero.kind, AttractorKind::Periodic { returns: 1, .. }));
/// let beside = attractor_beside(&Spring, at_zero, &settings, &options);
/// assert!(matches!(beside.kind, AttractorKind::Periodic { returns: 2, .. }));
/// # Ok::<(), stickslip::Error>(())
/// ```
pub fn attractor_beside<Kind>(
    system: &impl AsDynamics<Kind>,
    reached: Attractor,
    settings: &RecurrenceSettings,
    options: &Options,
) -> Attractor {
    let attractors = Attractors::new(system, settings, options);
    let Some(cycle) = attractors.unstable_cycle(&reached) else {
        return reached;
    };
    let system = &*system.dynamics();
    let start = displaced(system, &cycle, &attractors.near);
    let (section, options) = section(settings, options);
    let Ok(mut found) = seek(system, section.as_slice(), start, settings, &options) else {
        let kind = AttractorKind::Unstable;
        return Attractor { kind, ..reached };
    };
    found.steps += reached.steps;
    if attractors.unstable_cycle(&found).is_some() {
        found.kind = AttractorKind::Unstable;
    }
    found
}

/// The state in the middle of the segment where an orbit is cut, displaced along the direction that
/// the flow map stretches most.
fn displaced(system: &dyn Dynamics, cycle: &Cycle, near: &SameWithin) -> Moment {
    let mut power = cycle.monodromy.clone();
    for _ in 0..SQUARINGS {
        power /= power.amax();
        power = product(&power, &power);
    }
    let Moment { t, x } = &cycle.anchor;
    let allowed = Vector::from_fn(x.len(), |i, _| {
        let sizes = cycle.begins.iter().map(|begin| begin.x[i].abs());
        near.allowed(i, sizes.fold(x[i].abs(), f64::max))
    });
    // Directions in units of what counts as the same.
    let columns = power.column_iter();
    let directions = columns.map(|column| column.component_div(&allowed));
    let direction = directions.max_by(|a, b| a.amax().total_cmp(&b.amax()));
    let direction = direction.unwrap_or_else(|| allowed.clone());
    let most = direction[direction.iamax()];
    let x = x + direction.component_mul(&allowed) * (SAME_CLOSENESSES / most);
    system.admitted(&Moment { t: *t, x })
}
