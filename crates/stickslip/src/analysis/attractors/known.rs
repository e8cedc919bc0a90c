//! The distinct attractors of a system.

use super::reached::{Kind, Reached, turns};
use super::recurrent::is_same_set;
use super::rest::{holds, off_by};
use crate::analysis::cycle::{Outline, Shooting};
use crate::dynamics::{AsDynamics, DynamicsRef, Modes, Moment, Vector};
use crate::filippov::Options;

/// Points between two of a set of equilibria that must belong to it.
const BETWEEN: usize = 16;

/// Moments of the drive's period at which the equilibrium must hold.
const MOMENTS: usize = 32;

/// The distinct attractors so far, numbered in the order in which orbits first reached them.
///
/// Two orbits have reached the same attractor if their motion is of the same kind and they have
/// come
/// - at an equilibrium, to the same point;
/// - at a set of equilibria, to points with only further equilibria between them (on a straight
///   line, projected onto the boundary); with a drive, at 32 moments of its period;
/// - on a periodic orbit, to the same points of the section in the same order, with the same cycle
///   of phases; or, where a nontrivial multiplier is 1, to two orbits of one family, which has
///   another orbit midway between them;
/// - on a recurrent one, to points of which nearly all lie near (within 5 % of their extent) one of
///   the other's.
///
/// Points are the same within a multiple of [`super::RecurrenceSettings::closeness`] of their size.
/// All escapes count as one attractor. So do all failures, all undecided orbits, and all ends where
/// the future is not unique.
///
/// ```
/// use stickslip::Options;
/// use stickslip::analysis::{Attractors, RecurrenceSettings, attractor};
/// use stickslip::models::BeltOscillator;
///
/// let belt = BeltOscillator { belt_speed: 0.2, ..BeltOscillator::default() };
/// let (settings, options) = (RecurrenceSettings::within(500.0), Options::default());
/// let mut known = Attractors::new(&belt, &settings, &options);
/// for start in [[0.5, 0.1], [-0.5, 0.3], [0.1, 0.0]] {
///     let reached = attractor(&belt, start, &settings, &options)?;
///     println!("{start:?} goes to attractor {}: {}", known.number(reached.clone()), reached.kind);
/// }
/// assert!(!known.found().is_empty());
/// # Ok::<(), stickslip::Error>(())
/// ```
pub struct Attractors<'a> {
    system: DynamicsRef<'a>,
    closeness: f64,
    forcing: Option<f64>,
    options: Options,
    found: Vec<Reached>,
}

/// Closenesses within which points are the same: each of the two was computed to within one of
/// them.
const TIMES: f64 = 10.0;

impl<'a> Attractors<'a> {
    /// No attractors yet, of this system.
    pub fn new<Kind>(
        system: &'a impl AsDynamics<Kind>,
        settings: &super::RecurrenceSettings,
        options: &Options,
    ) -> Self {
        Attractors {
            system: system.dynamics(),
            options: *options,
            closeness: TIMES * settings.closeness,
            forcing: settings.forcing,
            found: Vec::new(),
        }
    }

    /// The number, counted from 0, of the attractor that an orbit has reached; a new one gets the
    /// next number.
    pub fn number(&mut self, mut reached: Reached) -> usize {
        let known = self
            .found
            .iter()
            .position(|one| self.is_same(one, &reached));
        known.unwrap_or_else(|| {
            if matches!(reached.kind, Kind::Periodic { .. }) {
                // Done once: every further orbit is compared with it.
                reached.family = Some(self.family(&reached));
            }
            self.found.push(reached);
            self.found.len() - 1
        })
    }

    /// The attractors in the order of their numbers, each as the first orbit reached it.
    pub fn found(&self) -> &[Reached] {
        &self.found
    }

    /// The attractors, as [`Attractors::found`].
    pub fn into_found(self) -> Vec<Reached> {
        self.found
    }

    /// Whether two orbits have reached the same attractor.
    pub fn is_same(&self, one: &Reached, other: &Reached) -> bool {
        if !(self.is_of_system(one) && self.is_of_system(other)) {
            return false;
        }
        match (&one.kind, &other.kind) {
            (Kind::Equilibrium, Kind::Equilibrium) => {
                one.mode == other.mode
                    && (self.is_near(&one.points, &other.points) || self.are_one(one, other))
            }
            (Kind::EquilibriumSet, Kind::EquilibriumSet) => {
                one.mode == other.mode
                    && (self.is_near(&one.points, &other.points)
                        || self.are_joined(&one.points, &other.points, one.mode))
            }
            (Kind::Periodic { returns: p, .. }, Kind::Periodic { returns: q, .. }) => {
                p == q
                    && one.has_sequence_of(other)
                    && (self.is_near(&one.points, &other.points)
                        || self.are_of_one_family(one, other))
            }
            (Kind::Recurrent, Kind::Recurrent) => is_same_set(&one.points, &other.points),
            (Kind::TwoFold(one), Kind::TwoFold(other)) => one == other,
            (Kind::Escape, Kind::Escape)
            | (Kind::Repelling, Kind::Repelling)
            | (Kind::Failure(_), Kind::Failure(_))
            | (Kind::Undecided, Kind::Undecided) => true,
            _ => false,
        }
    }

    /// Whether its points have as many components as the system has states; data from a file may
    /// not.
    fn is_of_system(&self, reached: &Reached) -> bool {
        let states = self.system.states();
        reached.points.iter().all(|point| point.x.len() == states)
    }

    /// Dimension of the family of periodic orbits to which the one reached belongs; 0 for an
    /// isolated orbit and for other kinds of motion.
    pub fn family(&self, reached: &Reached) -> usize {
        let is_periodic =
            matches!(reached.kind, Kind::Periodic { .. }) && self.is_of_system(reached);
        let first = reached.points.first().filter(|_| is_periodic);
        let near = |at| self.family_near(at, reached.period(), f64::INFINITY);
        reached.family.unwrap_or_else(|| first.map_or(0, near))
    }

    /// Whether two periodic orbits belong to one family: another of its orbits lies midway between
    /// them, closer to the midpoint than to either.
    fn are_of_one_family(&self, one: &Reached, other: &Reached) -> bool {
        let Some(a) = one.points.first() else {
            return false;
        };
        let away = |b: &Moment| (&b.x - &a.x).norm();
        let nearest = other
            .points
            .iter()
            .min_by(|b, c| away(b).total_cmp(&away(c)));
        nearest.is_some_and(|b| {
            let x = (&a.x + &b.x) * 0.5;
            let middle = Moment { t: a.t, x };
            let period = 0.5 * (one.period() + other.period());
            self.family(one) > 0 && self.family_near(&middle, period, away(b)) > 0
        })
    }

    /// Dimension of the family of the periodic orbit near a point, with a period near the given
    /// one, if the orbit lies within half of a distance.
    fn family_near(&self, at: &Moment, period: f64, distance: f64) -> usize {
        let found = || {
            let (system, options) = (&*self.system, &self.options);
            let guess = Outline::of_run(system, at, period, options).ok()?;
            let forced = self.forcing.is_some().then_some(period);
            let shooting = Shooting::of(system, &guess, forced, options);
            let orbit = shooting.nearest(&guess, None)?;
            let way = &orbit.outline.begin.x - &guess.begin.x;
            (way.norm() < 0.5 * distance).then_some(orbit.family)
        };
        found().unwrap_or(0)
    }

    /// Whether the points are the same up to a cyclic shift.
    fn is_near(&self, one: &[Moment], other: &[Moment]) -> bool {
        let states = self.system.states();
        let size = Vector::from_fn(states, |i, _| {
            let sizes = one.iter().map(|point| point.x[i].abs());
            sizes.fold(0.0, f64::max)
        });
        // A component that is always zero has no size of its own.
        let least = 1e-3 * size.amax();
        let same = move |a: &Moment, b: &Moment| {
            (0..states).all(|i| (a.x[i] - b.x[i]).abs() <= self.closeness * size[i].max(least))
        };
        turns(one, other, same).next().is_some()
    }

    /// Whether two equilibria agree to within their errors. At zero they have no size for
    /// comparison.
    fn are_one(&self, one: &Reached, other: &Reached) -> bool {
        let ([a], [b]) = (one.points.as_slice(), other.points.as_slice()) else {
            return false;
        };
        let off = off_by(&*self.system, one.mode, [a, b]);
        off.is_some_and(|off| (&a.x - &b.x).amax() <= TIMES * off.amax())
    }

    /// Whether all points between the two are equilibria.
    fn are_joined(&self, one: &[Moment], other: &[Moment], mode: Modes) -> bool {
        let (Some(one), Some(other)) = (one.first(), other.first()) else {
            return false;
        };
        let way = &other.x - &one.x;
        (1..BETWEEN).all(|k| {
            let part = k as f64 / BETWEEN as f64;
            let mut at = Moment {
                t: one.t,
                x: &one.x + &way * part,
            };
            let flow = self.system.flow(mode, &at);
            at.x = flow.settled(&at);
            let rests = flow.velocity(&at).amax() <= self.closeness * at.x.amax();
            rests && self.holds(mode, &at)
        })
    }

    /// Whether a mode holds at an equilibrium; with a drive, at many moments of its whole period.
    fn holds(&self, mode: Modes, at: &Moment) -> bool {
        let Some(period) = self.forcing else {
            return holds(&*self.system, mode, at);
        };
        (0..MOMENTS).all(|k| {
            let t = at.t + period * k as f64 / MOMENTS as f64;
            let x = at.x.clone();
            holds(&*self.system, mode, &Moment { t, x })
        })
    }
}
