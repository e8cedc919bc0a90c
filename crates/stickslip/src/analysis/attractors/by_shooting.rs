//! Attractors tested by shooting.

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

impl Attractor {
    /// The attractor that an orbit has reached, tested by shooting, as [`Attractors::number`] tests
    /// it.
    ///
    /// A slow alternating approach to a periodic orbit looks like one of twice the period. Where
    /// the orbit of half the period attracts and the two are not resolved, that orbit is returned.
    ///
    /// An orbit that begins on an unstable periodic orbit, or on its stable manifold, stays there.
    /// The run then continues from a state displaced along the direction that grows fastest, far
    /// enough that the two states are not the same. Where that reaches no attractor, the other side
    /// is tried. The kind is [`AttractorKind::Unstable`] where the displaced run reaches an
    /// unstable orbit, too. Orbits of families are returned as they are, and those at which the
    /// flow map has no derivative.
    ///
    /// ```
    /// use std::f64::consts::TAU;
    /// use stickslip::analysis::{AttractorKind, RecurrenceSettings, attractor};
    /// use stickslip::{Filippov, Options, Scalar, Side};
    ///
    /// /// A spring whose stiffness oscillates at twice its own frequency: unstable at zero.
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
    /// let beside = at_zero.by_shooting(&Spring, &settings, &options);
    /// assert!(matches!(beside.kind, AttractorKind::Periodic { returns: 2, .. }));
    /// # Ok::<(), stickslip::Error>(())
    /// ```
    pub fn by_shooting<Kind>(
        self,
        system: &impl AsDynamics<Kind>,
        settings: &RecurrenceSettings,
        options: &Options,
    ) -> Attractor {
        let attractors = Attractors::new(system, settings, options);
        let (reached, cycle) = attractors.tested(self);
        let Some(cycle) = cycle.filter(|cycle| attractors.is_unstable(cycle)) else {
            return reached;
        };
        let system = &*system.dynamics();
        let (section, options) = section(settings, options);
        let mut other = None;
        for side in [1.0, -1.0] {
            let start = displaced(system, &cycle, &attractors.near, side);
            let Ok(found) = seek(system, section.as_slice(), start, settings, &options) else {
                continue;
            };
            let (mut found, cycle) = attractors.tested(found);
            found.steps += reached.steps;
            if cycle.is_some_and(|cycle| attractors.is_unstable(&cycle)) {
                found.kind = AttractorKind::Unstable;
            }
            if found.kind.is_attractor() {
                return found;
            }
            other.get_or_insert(found);
        }
        other.unwrap_or(Attractor {
            kind: AttractorKind::Unstable,
            ..reached
        })
    }
}

/// The state in the middle of the segment where an orbit is cut, displaced to one side or the
/// other. The direction is that which the flow map stretches most.
fn displaced(system: &dyn Dynamics, cycle: &Cycle, near: &SameWithin, side: f64) -> Moment {
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
    let columns = product(&cycle.directions(system), &power);
    let columns = columns.column_iter();
    let directions = columns.map(|column| column.component_div(&allowed));
    let direction = directions.max_by(|a, b| a.amax().total_cmp(&b.amax()));
    let direction = direction.unwrap_or_else(|| allowed.clone());
    let most = direction[direction.iamax()];
    let x = x + direction.component_mul(&allowed) * (side * SAME_CLOSENESSES / most);
    system.admitted(&Moment { t: *t, x })
}
