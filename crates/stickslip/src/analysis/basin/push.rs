//! The least push out of a basin of attraction.

use rayon::prelude::*;

use super::is_on_boundary;
use crate::analysis::attractors::{
    Attractor, AttractorKind, Attractors, RecurrenceSettings, SOLVER_TOLERANCES,
};
use crate::dynamics::{AsDynamics, Components, Vector};
use crate::error::{Error, Point, require};
use crate::filippov::Options;

/// Width, as a part of the push, to which a boundary is bisected.
const PRECISION: f64 = 1e-9;

/// Settings of a search along rays for the boundary of a basin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PushSettings {
    /// Largest push that is tried, in lengths of the direction.
    pub largest: f64,
    /// Number of equal parts of the ray at whose ends the attractor is sought. Default 64.
    pub parts: usize,
}

impl PushSettings {
    /// The defaults with this largest push.
    pub fn up_to(largest: f64) -> Self {
        PushSettings { largest, parts: 64 }
    }

    /// Checks every setting.
    ///
    /// # Errors
    /// [`Error::Option`] with name, value and bound of the first that is not allowed.
    pub fn check(&self) -> Result<(), Error> {
        let is_allowed = self.largest > 0.0 && self.largest.is_finite();
        require(is_allowed, "largest", self.largest, "positive and finite")?;
        let parts = self.parts as f64;
        require(self.parts >= 1, "parts", parts, "at least 1")
    }
}

/// A push out of a basin.
#[derive(Clone, Debug, PartialEq)]
pub struct Push {
    /// The least push, in lengths of the direction.
    pub size: f64,
    /// Half of the width to which the boundary was bisected.
    pub uncertainty: f64,
    /// Attractor that larger pushes lead to.
    pub beyond: Attractor,
    /// Whether the ray ends there at a stop. No start lies behind it, so that `size` is the largest
    /// push that can be tried, and none leads out of the basin.
    pub ends_at_stop: bool,
}

impl Push {
    /// The least push from a state along each direction that changes the attractor; `None` where
    /// none up to the largest does.
    ///
    /// The attractor from `from + s·direction` is sought at equally spaced `s`, from 0 on. The
    /// first that differs from the attractor of `from` brackets the boundary, which is then
    /// bisected. If the ray crosses boundaries several times, the push is the least one: at all
    /// sampled pushes below it the orbit returns. A part of another basin narrower than
    /// [`PushSettings::largest`] divided by [`PushSettings::parts`] may hide between two samples.
    /// Orbits that escape, fail or are undecided have left the basin. A ray that comes to a stop
    /// ends there, as [`Push::ends_at_stop`] says.
    ///
    /// Its size over all directions is the stability threshold of Klinshov, Nekorkin & Kurths, *New
    /// Journal of Physics* 18 (2016) 013004, and the "minimal critical shock" of Attractors.jl.
    /// Rays are computed on all threads.
    ///
    /// ```
    /// use stickslip::analysis::{Push, PushSettings, RecurrenceSettings};
    /// use stickslip::{Filippov, Options, Scalar, Side};
    ///
    /// /// x' = x - x³ with equilibria at -1 and 1; 0 is the boundary between their basins.
    /// struct Wells;
    /// impl Filippov<1> for Wells {
    ///     fn field<T: Scalar>(&self, _side: Side, _t: T, &[x]: &[T; 1]) -> [T; 1] {
    ///         [x - x * x * x]
    ///     }
    ///     fn boundary<T: Scalar>(&self, _t: T, _x: &[T; 1]) -> T {
    ///         T::constant(-1.0)
    ///     }
    /// }
    /// let (within, options) = (RecurrenceSettings::within(200.0), Options::default());
    /// let (how, directions) = (PushSettings::up_to(5.0), [[-1.0], [1.0]]);
    /// let found = Push::least(&Wells, [1.0], directions, &how, &within, &options)?;
    /// assert!((found[0].as_ref().unwrap().size - 1.0).abs() < 1e-8);
    /// assert_eq!(found[1], None);
    /// # Ok::<(), stickslip::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Option`] for a setting that is not allowed, or a direction of no length. Those of
    /// [`crate::analysis::Attractor::of_any`].
    pub fn least<Kind>(
        system: &(impl AsDynamics<Kind> + Sync),
        from: impl Components,
        directions: impl IntoIterator<Item = impl Components>,
        how: &PushSettings,
        settings: &RecurrenceSettings,
        options: &Options,
    ) -> Result<Vec<Option<Push>>, Error> {
        how.check()?;
        let from = from.vector();
        let directions: Vec<Vector> = directions.into_iter().map(Components::vector).collect();
        for direction in &directions {
            let size = direction.norm();
            let is_allowed = size > 0.0 && size.is_finite() && direction.len() == from.len();
            let bound = "of a length that is positive and finite, with a part for each state";
            require(is_allowed, "direction", size, bound)?;
        }
        let dynamics = system.dynamics();
        let home = Attractor::of_any(system, &from, settings, options)?;
        let of_ray = |direction: &Vector| -> Result<Option<Push>, Error> {
            let mut distinct = Attractors::new(system, settings, options);
            let home = distinct.number(home.clone());
            let start_at = |size: f64| dynamics.opened(&from + direction * size);
            let mut leaves = |size: f64| -> Result<Option<Attractor>, Error> {
                let start = start_at(size);
                let reached = Attractor::of_any(system, start, settings, options)?;
                let is_other = distinct.number(reached.clone()) != home;
                Ok(is_other.then_some(reached))
            };
            let mut inside = 0.0;
            let mut found: Option<(f64, Attractor)> = None;
            for part in 1..=how.parts {
                let size = how.largest * part as f64 / how.parts as f64;
                match (leaves(size)?, &mut found) {
                    // A start on the boundary does not say what lies beyond; the next one does.
                    (Some(other), Some(first)) => first.1 = other,
                    (Some(other), none) => *none = Some((size, other)),
                    (None, Some(_)) => break,
                    (None, None) => inside = size,
                }
                if found
                    .as_ref()
                    .is_some_and(|one| !is_on_boundary(&one.1.kind))
                {
                    break;
                }
            }
            let Some((mut outside, mut beyond)) = found else {
                return Ok(None);
            };
            loop {
                let x = &from + direction * outside;
                let error = SOLVER_TOLERANCES * options.largest_allowed(&x) / direction.amax();
                let middle = 0.5 * (inside + outside);
                let is_between = inside < middle && middle < outside;
                if !is_between || outside - inside <= error.max(PRECISION * outside) {
                    let start = Point::from(&start_at(outside));
                    return Ok(Some(Push {
                        size: middle,
                        uncertainty: 0.5 * (outside - inside),
                        ends_at_stop: matches!(
                            &beyond.kind,
                            AttractorKind::Failure(Error::BehindStop { x, .. }) if *x == start
                        ),
                        beyond,
                    }));
                }
                match leaves(middle)? {
                    Some(other) if is_on_boundary(&other.kind) => outside = middle,
                    Some(other) => (outside, beyond) = (middle, other),
                    None => inside = middle,
                }
            }
        };
        directions.par_iter().map(of_ray).collect()
    }
}
