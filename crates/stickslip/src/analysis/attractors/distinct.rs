//! The distinct attractors of a system.

use super::attractor::{Attractor, AttractorKind, shifts};
use super::equilibrium::{distance_bounds, holds, resolves};
use super::recurrent::is_same_set;
use super::tolerance::{SOLVER_TOLERANCES, SameWithin};
use crate::analysis::cycle::{Cycle, OrbitGuess, Shooting};
use crate::analysis::multipliers;
use crate::dynamics::{AsDynamics, DynamicsRef, Modes, Moment, Vector};
use crate::filippov::Options;
use crate::math::modulus;

/// Intervals between two equilibria of a set; the points between them must belong to it. Chosen.
const SET_INTERVALS: usize = 16;

/// Moments of the drive's period at which an equilibrium must hold. Chosen.
const DRIVE_MOMENTS: usize = 32;

/// Two points are the same within so many closenesses: one for the error of each, the rest for slow
/// convergence. Chosen.
pub(super) const SAME_CLOSENESSES: f64 = 10.0;

/// The distinct attractors so far, numbered in the order in which orbits first reached them.
///
/// Two orbits have the same attractor if their motion is of the same kind and
/// - at equilibria, their points agree;
/// - in a set of equilibria, all points between theirs are equilibria (on a straight line projected
///   onto the boundary; with a drive, at 32 moments of its period);
/// - on periodic orbits, the points of the section agree in the same order, and so do the cycles of
///   phases. If a nontrivial multiplier is 1, the orbits may also belong to one family, which has
///   another orbit midway between them;
/// - on recurrent orbits, nearly all points lie within 5 % of their extent of one of the other's.
///
/// Points are the same within a multiple of [`super::RecurrenceSettings::closeness`] of the size
/// that each component has on the orbit. On periodic orbits the error that the solver's tolerances
/// leave in each is added.
/// All escapes count as one attractor. So do all failures, all undecided orbits, all ends where the
/// boundary repels, all ends at two-folds, and all starts on unstable periodic orbits.
///
/// ```
#[doc = include_str!("../../../examples/common/belt.rs")]
/// use stickslip::Options;
/// use stickslip::analysis::{Attractors, RecurrenceSettings, attractor};
///
/// let belt = Belt { speed: 0.2 };
/// let (settings, options) = (RecurrenceSettings::within(500.0), Options::default());
/// let mut attractors = Attractors::new(&belt, &settings, &options);
/// for start in [[0.5, 0.1], [-0.5, 0.3], [0.1, 0.0]] {
///     let found = attractor(&belt, start, &settings, &options)?;
///     let number = attractors.number(found.clone());
///     println!("{start:?} goes to attractor {number}: {}", found.kind);
/// }
/// assert!(!attractors.all().is_empty());
/// # Ok::<(), stickslip::Error>(())
/// ```
pub struct Attractors<'a> {
    system: DynamicsRef<'a>,
    /// The distance within which the points of an orbit repeat.
    pub(super) near: SameWithin,
    forcing: Option<f64>,
    options: Options,
    attractors: Vec<Attractor>,
}

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
            near: SameWithin {
                closeness: settings.closeness,
                rtol: options.rtol,
                atol: options.atol,
            },
            forcing: settings.forcing,
            attractors: Vec::new(),
        }
    }

    /// Adds known attractors, numbered by their order.
    #[must_use]
    pub fn knowing(mut self, attractors: Vec<Attractor>) -> Self {
        self.attractors = attractors;
        self
    }

    /// The number, counted from 0, of the attractor that an orbit has reached; a new one gets the
    /// next number.
    pub fn number(&mut self, mut attractor: Attractor) -> usize {
        let mut number = self.number_of(&attractor);
        if number.is_none() && matches!(attractor.kind, AttractorKind::Periodic { .. }) {
            let kind = attractor.kind.clone();
            // Done once: every further orbit is compared with it.
            let (tested, cycle) = self.tested(attractor);
            attractor = tested;
            attractor.family = Some(cycle.as_ref().map_or(0, |cycle| cycle.family));
            if cycle.is_some_and(|cycle| self.is_unstable(&cycle)) {
                attractor.kind = AttractorKind::Unstable;
            }
            if attractor.kind != kind {
                number = self.number_of(&attractor);
            }
        }
        number.unwrap_or_else(|| {
            self.attractors.push(attractor);
            self.attractors.len() - 1
        })
    }

    /// The attractor that an orbit has reached, with the periodic orbit by shooting. That of half
    /// the period is taken where it attracts, and both halves agree to what shooting resolves.
    pub(super) fn tested(&self, mut attractor: Attractor) -> (Attractor, Option<Cycle>) {
        let mut cycle = self.cycle_of(&attractor);
        while let Some(half) = cycle
            .as_ref()
            .filter(|cycle| cycle.is_half_twice() == Some(true))
            .and_then(|_| attractor.half())
            && let Some(single) = self.cycle_of(&half).filter(Cycle::is_stable)
        {
            (attractor, cycle) = (half, Some(single));
        }
        (attractor, cycle)
    }

    /// The number of an attractor that is known.
    fn number_of(&self, attractor: &Attractor) -> Option<usize> {
        let mut earlier = self.attractors.iter();
        earlier.position(|one| self.is_same(one, attractor))
    }

    /// Whether a multiplier lies outside the unit circle by more than the error of two that meet on
    /// it, the square root of that of the solver. In a family that is no criterion.
    pub(super) fn is_unstable(&self, cycle: &Cycle) -> bool {
        let error = SOLVER_TOLERANCES * self.options.coarsest();
        let values = multipliers(&cycle.monodromy);
        cycle.family == 0 && values.iter().any(|one| modulus(*one) > 1.0 + error.sqrt())
    }

    /// The attractors in the order of their numbers, each as the first orbit reached it.
    pub fn all(&self) -> &[Attractor] {
        &self.attractors
    }

    /// The attractors, as [`Attractors::all`].
    pub fn into_vec(self) -> Vec<Attractor> {
        self.attractors
    }

    /// Whether two orbits have reached the same attractor.
    pub fn is_same(&self, one: &Attractor, other: &Attractor) -> bool {
        if !(self.is_of_system(one) && self.is_of_system(other)) {
            return false;
        }
        match (&one.kind, &other.kind) {
            (AttractorKind::Equilibrium, AttractorKind::Equilibrium) => {
                one.mode == other.mode
                    && (self.have_same_points(one, other) || self.agree_within_errors(one, other))
            }
            (AttractorKind::EquilibriumSet, AttractorKind::EquilibriumSet) => {
                one.mode == other.mode
                    && (self.have_same_points(one, other)
                        || self.are_joined(&one.points, &other.points, one.mode))
            }
            (
                AttractorKind::Periodic { returns: p, .. },
                AttractorKind::Periodic { returns: q, .. },
            ) => {
                p == q
                    && one.has_sequence_of(other)
                    && (self.have_same_points(one, other) || self.are_of_one_family(one, other))
            }
            (AttractorKind::Recurrent, AttractorKind::Recurrent) => {
                is_same_set(&one.points, &other.points)
            }
            (AttractorKind::TwoFold(_), AttractorKind::TwoFold(_))
            | (AttractorKind::Escape, AttractorKind::Escape)
            | (AttractorKind::Repelling, AttractorKind::Repelling)
            | (AttractorKind::Failure(_), AttractorKind::Failure(_))
            | (AttractorKind::Undecided, AttractorKind::Undecided)
            | (AttractorKind::Unstable, AttractorKind::Unstable) => true,
            _ => false,
        }
    }

    /// Whether its points have as many components as the system has states; data from a file may
    /// not.
    fn is_of_system(&self, attractor: &Attractor) -> bool {
        let states = self.system.states();
        attractor.points.iter().all(|point| point.x.len() == states)
    }

    /// Dimension of the family to which a periodic orbit belongs; 0 for an isolated orbit and for
    /// other kinds of motion.
    pub fn family(&self, attractor: &Attractor) -> usize {
        let computed = || self.cycle_of(attractor).map_or(0, |cycle| cycle.family);
        attractor.family.unwrap_or_else(computed)
    }

    /// The periodic orbit that is the attractor, by shooting.
    fn cycle_of(&self, attractor: &Attractor) -> Option<Cycle> {
        let is_periodic = matches!(attractor.kind, AttractorKind::Periodic { .. })
            && self.is_of_system(attractor);
        let first = attractor.points.first().filter(|_| is_periodic)?;
        self.cycle_near(first, attractor.period(), f64::INFINITY)
    }

    /// Whether two periodic orbits belong to one family: another of its orbits lies midway between
    /// them, closer to the midpoint than to either.
    fn are_of_one_family(&self, one: &Attractor, other: &Attractor) -> bool {
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
            let between = || self.cycle_near(&middle, period, away(b));
            self.family(one) > 0 && between().is_some_and(|cycle| cycle.family > 0)
        })
    }

    /// The periodic orbit near a point, with a period near the given one, if it lies within half of
    /// the distance.
    fn cycle_near(&self, at: &Moment, period: f64, distance: f64) -> Option<Cycle> {
        let (system, options) = (&*self.system, &self.options);
        let guess = OrbitGuess::of_run(system, at, period, options).ok()?;
        let forced = self.forcing.is_some().then_some(period);
        let orbit = Shooting::of(system, &guess, forced, options).nearest(&guess, None)?;
        let shift = &orbit.outline.begin.x - &guess.begin.x;
        (shift.norm() < 0.5 * distance).then_some(orbit)
    }

    /// Whether the points are the same up to a cyclic shift. A component is compared with the size
    /// that it has on the orbit. At the points of a section it may be zero, as a velocity is where
    /// the orbit turns back.
    fn have_same_points(&self, one: &Attractor, other: &Attractor) -> bool {
        let states = self.system.states();
        let is_orbit = matches!(one.kind, AttractorKind::Periodic { .. });
        let elsewhere = [one, other].into_iter().filter(|_| is_orbit);
        let elsewhere = elsewhere.flat_map(|one| {
            let ends = one.phases.iter().map(|phase| &phase.x_start);
            ends.chain([&one.x]).filter(|x| x.len() == states)
        });
        let points = one.points.iter().map(|point| &point.x);
        let all: Vec<&Vector> = points.chain(elsewhere).collect();
        let size = Vector::from_fn(states, |i, _| {
            all.iter().map(|x| x[i].abs()).fold(0.0, f64::max)
        });
        let allowed = Vector::from_fn(states, |i, _| {
            // A component that tends to zero has no size, but the error of both orbits.
            let errors = if is_orbit {
                2.0 * self.near.rounding(i, size[i])
            } else {
                0.0
            };
            self.closeness() * size[i] + errors
        });
        let same = move |a: &Moment, b: &Moment| {
            (0..states).all(|i| (a.x[i] - b.x[i]).abs() <= allowed[i])
        };
        shifts(&one.points, &other.points, same).next().is_some()
    }

    /// Part of a component's size within which points are the same.
    fn closeness(&self) -> f64 {
        SAME_CLOSENESSES * self.near.closeness
    }

    /// Whether two equilibria agree to within their errors: those of Newton's steps, or distances
    /// that the rounded field does not resolve. At zero they have no size for comparison.
    fn agree_within_errors(&self, one: &Attractor, other: &Attractor) -> bool {
        let ([a], [b]) = (one.points.as_slice(), other.points.as_slice()) else {
            return false;
        };
        let bounds = distance_bounds(&*self.system, one.mode, [a, b]);
        let is_same = |i: usize, bound: f64| {
            let size = a.x[i].abs().max(b.x[i].abs());
            (a.x[i] - b.x[i]).abs() <= (SAME_CLOSENESSES * bound).max(self.closeness() * size)
        };
        let all_same = |bounds: Vector| {
            bounds
                .iter()
                .enumerate()
                .all(|(i, &bound)| is_same(i, bound))
        };
        bounds.is_some_and(all_same) || resolves(&*self.system, one.mode, [a, b]) == Some(false)
    }

    /// Whether all points between the two are equilibria.
    fn are_joined(&self, one: &[Moment], other: &[Moment], mode: Modes) -> bool {
        let (Some(one), Some(other)) = (one.first(), other.first()) else {
            return false;
        };
        let difference = &other.x - &one.x;
        (1..SET_INTERVALS).all(|k| {
            let part = k as f64 / SET_INTERVALS as f64;
            let mut at = Moment {
                t: one.t,
                x: &one.x + &difference * part,
            };
            let flow = self.system.flow(mode, &at);
            at.x = flow.projected(&at);
            let is_at_rest = flow.velocity(&at).amax() <= self.closeness() * at.x.amax();
            is_at_rest && self.holds(mode, &at)
        })
    }

    /// Whether a mode holds at an equilibrium; with a drive, at many moments of its period.
    fn holds(&self, mode: Modes, at: &Moment) -> bool {
        let Some(period) = self.forcing else {
            return holds(&*self.system, mode, at);
        };
        (0..DRIVE_MOMENTS).all(|k| {
            let t = at.t + period * k as f64 / DRIVE_MOMENTS as f64;
            let x = at.x.clone();
            holds(&*self.system, mode, &Moment { t, x })
        })
    }
}
