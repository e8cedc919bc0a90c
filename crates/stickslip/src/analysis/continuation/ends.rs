//! Ends of a branch: at an equilibrium or a two-fold to which its orbits shrink, at rest, or where
//! it began.

use super::steps::Continuation;
use super::tangent_line::TangentLine;
use super::{EquilibriumBifurcation, EquilibriumBranch, Stop, parameter_of, with_parameter};
use crate::analysis::attractors::equilibrium::{equilibrium_near, least_guard};
use crate::analysis::critical::zero_between;
use crate::analysis::cycle::{Cycle, MarginKind, Shooting, error_of, resolved};
use crate::analysis::lagrange::weights;
use crate::analysis::passages::passages;
use crate::dynamics::{DynamicsRef, Modes, Moment, RecordedOrbit, Sampling, Vector, run};
use crate::filippov::Options;

/// Extent below which an orbit may be about to shrink to a point, as a fraction of the widest
/// one's. Chosen: there the Hopf point or two-fold is close, and a bifurcation of other orbits is
/// not.
const SHRUNK: f64 = 0.04;

/// Extent below which a driven orbit may be about to come to rest, as a fraction of the widest
/// one's. Chosen: it is what the end [`Stop::HeldByFriction`] says.
const AT_REST: f64 = 1e-3;

/// Distance below which two orbits at one parameter are the same, as a fraction of the extent.
/// Chosen: far above the tolerances, and far below the distance of two orbits, unless they are next
/// to a fold.
pub(super) const SAME_ORBIT: f64 = 1e-6;

/// Difference below which a state of an orbit of a branch and of an attractor is the same, as a
/// fraction of its range; the square is that of its value. Chosen: far above the closeness to which
/// attractors are found, 1e-6.
const SAME_ATTRACTOR: f64 = 1e-3;

/// Largest distance of an orbit from the equilibrium in which it ends, as a fraction of the widest
/// orbit's extent. Chosen.
const LARGEST_DISTANCE: f64 = 1e-2;

/// Largest distance of that equilibrium at the end, in extents of the last orbit. Chosen.
const LARGEST_SHIFT: f64 = 10.0;

/// Least relative decrease of the distance between two orbits that is extrapolated. The
/// extrapolated parameter is then at most a thousand steps away.
const LEAST_DECREASE: f64 = 1e-3;

impl Continuation<'_> {
    /// The end to which the orbits shrink, if they do: an equilibrium, a two-fold, or rest.
    pub(super) fn shrinks(&self) -> Option<Stop> {
        let extent = self.branch.last.extent;
        if extent >= self.branch.before.extent {
            return None;
        }
        if self.settings.forced.is_some() {
            let rests = extent < AT_REST * self.branch.widest && self.rests_further_on();
            return rests.then_some(Stop::HeldByFriction);
        }
        let end = self.boundary_equilibrium();
        if end.is_some() {
            return end;
        }
        if extent >= SHRUNK * self.branch.widest {
            return None;
        }
        let two_fold = self.ends_at().is_none().then(|| self.two_fold());
        if let Some(two_fold) = two_fold.flatten() {
            return Some(two_fold);
        }
        self.hopf()
    }

    /// A boundary-equilibrium bifurcation that the last two orbits approach in the range.
    pub(super) fn boundary_equilibrium(&self) -> Option<Stop> {
        let (parameter, _) = self.ends_at()?;
        let (low, high) = self.settings.range;
        (low..=high)
            .contains(&parameter)
            .then_some(Stop::BoundaryEquilibrium { parameter })
    }

    /// The parameter at which the last two orbits end in an equilibrium of one mode, and that
    /// equilibrium (di Bernardo, Budd, Champneys & Kowalczyk 2008, Ch. 5). Their transitions
    /// approach it while it approaches the edge of its mode's domain. The orbits shrink to it, or
    /// pass it ever more slowly.
    pub(in crate::analysis) fn ends_at(&self) -> Option<(f64, Vector)> {
        let (before, last) = (&self.branch.before, &self.branch.last);
        let modes = before.outline.modes();
        if self.settings.forced.is_some() || modes.len() < 2 {
            return None;
        }
        let mut modes = modes.into_iter();
        modes.find_map(|mode| self.ends_in(mode, [before, last]))
    }

    /// Parameter and state of the equilibrium of a mode in which the branch ends.
    fn ends_in(&self, mode: Modes, [before, last]: [&Cycle; 2]) -> Option<(f64, Vector)> {
        let (system, states) = (self.shooting.system, self.shooting.states);
        let equilibrium = |parameter: f64, x: &Vector| {
            let x = with_parameter(x.clone(), parameter);
            Some(equilibrium_near(system, mode, 0.0, &x, states)?.x)
        };
        // Its distance from the nearest transition, and the state there.
        let near = |one: &Cycle| {
            let distance = |at: &Moment| {
                let equilibrium = equilibrium(parameter_of(one), &at.x)?;
                let away = (equilibrium - &at.x).rows(0, states).amax();
                Some((away, at.x.clone()))
            };
            let nearest = one.begins.iter().filter_map(distance);
            nearest.min_by(|a, b| a.0.total_cmp(&b.0))
        };
        let ((further, _), (distance, mut x)) = (near(before)?, near(last)?);
        let here = parameter_of(last);
        let ahead = (here - parameter_of(before)) * distance / (further - distance);
        if distance * (1.0 + LEAST_DECREASE) >= further
            || distance >= LARGEST_DISTANCE * self.branch.widest
            || ahead == 0.0
        {
            return None;
        }
        let start = x.clone();
        // The smallest guard of the mode: positive where the mode holds.
        let mut guard = |parameter: f64| {
            x = equilibrium(parameter, &x)?;
            let at = Moment {
                t: 0.0,
                x: x.clone(),
            };
            Some(least_guard(system, mode, &at))
        };
        let beyond = here + 2.0 * ahead;
        let [one, other] = [guard(here)?, guard(beyond)?];
        if one * other > 0.0 {
            return None;
        }
        let end = zero_between((here, one), (beyond, other), &mut guard)?;
        guard(end)?;
        let shift = (&x - start).rows(0, states).amax();
        (shift <= LARGEST_SHIFT * last.extent).then_some((end, x))
    }

    /// The parameter at which crossing orbits shrink to a two-fold, as they do if they meet the
    /// boundary ever more slowly from both sides. It is extrapolated to zero extent by a
    /// polynomial.
    fn two_fold(&self) -> Option<Stop> {
        const NODES: usize = 5;
        // Relative difference of the factors by which rates and extents decrease. Chosen: in
        // proportion to the extent it becomes small.
        const PROPORTIONAL: f64 = 0.2;
        let rates = |cycle: &Cycle| {
            let landings = cycle.margins.iter();
            let landings = landings.filter(|margin| margin.kind == MarginKind::Landing);
            landings.map(|margin| margin.scale).collect::<Vec<f64>>()
        };
        let (before, last) = (&self.branch.before, &self.branch.last);
        let ratio = last.extent / before.extent;
        let is_proportional =
            |(before, last): (&f64, &f64)| (last / before / ratio - 1.0).abs() < PROPORTIONAL;
        let is_crossing = !last.outline.modes().iter().any(Modes::any_sticks);
        // Near an equilibrium the period would remain finite.
        let periods = (&before.period, &last.period);
        let (before, last) = (rates(before), rates(last));
        let mut all = before.iter().zip(&last).chain([periods]);
        if !is_crossing
            || last.is_empty()
            || before.len() != last.len()
            || !all.all(is_proportional)
        {
            return None;
        }
        // Each is about twice as large as the one before.
        let mut nodes: Vec<(f64, f64)> = Vec::new();
        for (point, &extent) in self.branch.points.iter().zip(&self.branch.extents).rev() {
            if nodes.last().is_none_or(|(least, _)| extent >= 2.0 * least) {
                nodes.push((extent, point.parameter));
            }
            if nodes.len() == NODES {
                break;
            }
        }
        let extrapolated = |nodes: &[(f64, f64)]| -> f64 {
            let extents: Vec<f64> = nodes.iter().map(|node| node.0).collect();
            let weighted = weights(&extents, 0.0).into_iter().zip(nodes);
            weighted.map(|(weight, node)| weight * node.1).sum()
        };
        // The largest of them must be small.
        if nodes.len() < NODES || nodes[NODES - 1].0 > 0.5 * self.branch.widest {
            return None;
        }
        let parameter = extrapolated(&nodes);
        let uncertainty = (parameter - extrapolated(&nodes[..NODES - 1])).abs();
        // Best uncertainty that is waited for, as a fraction of the range: smaller orbits yield a
        // better one. Chosen.
        const RESOLVED: f64 = 1e-9;
        (uncertainty <= RESOLVED * self.branch.units.width).then_some(Stop::TwoFold {
            parameter,
            uncertainty: self.with_last_digits(parameter, uncertainty),
        })
    }

    /// The nearest Hopf bifurcation of the equilibrium that the last orbit surrounds.
    fn hopf(&self) -> Option<Stop> {
        let (system, options) = (self.shooting.system, self.shooting.options);
        let system = DynamicsRef::Borrowed(system);
        let branch = |upwards| {
            let x = self.branch.last.anchor.x.clone();
            EquilibriumBranch::through(&system, x, upwards, self.settings, options).ok()
        };
        let special = [false, true].into_iter().filter_map(branch);
        let special = special.flat_map(|branch| branch.special);
        let stops = special.filter_map(|at| match at.what {
            EquilibriumBifurcation::Hopf { frequency } => Some((at.parameter, frequency)),
            _ => None,
        });
        let off = |stop: &(f64, f64)| (stop.0 - self.parameter()).abs();
        let (parameter, frequency) = stops.min_by(|a, b| off(a).total_cmp(&off(b)))?;
        Some(Stop::Equilibrium {
            parameter,
            frequency,
        })
    }

    /// Whether an orbit one step farther begins where the last one sticks and sticks throughout.
    fn rests_further_on(&self) -> bool {
        let last = &self.branch.last;
        let mut segments = last.outline.segments.iter().zip(&last.begins);
        let Some((_, stuck)) = segments.find(|(segment, _)| segment.mode.any_sticks()) else {
            return false;
        };
        let change = self.parameter() - parameter_of(&self.branch.before);
        let further = change.signum() * self.settings.step * self.branch.units.width;
        let start = Moment {
            t: stuck.t,
            x: with_parameter(stuck.x.clone(), self.parameter() + further),
        };
        let (system, options) = (self.shooting.system, self.shooting.options);
        let orbit = RecordedOrbit::solve(
            system,
            &start,
            stuck.t + last.period,
            options,
            &[],
            Sampling::Nowhere,
        );
        orbit.is_ok_and(|(orbit, ended)| {
            let is_stuck = orbit.phases.iter().all(|one| one.mode.any_sticks());
            ended.is_ok() && orbit.transitions().next().is_none() && is_stuck
        })
    }

    /// Whether the branch has returned to the first orbit, which is then its last.
    pub(super) fn closes(&mut self) -> Option<Stop> {
        let begin = parameter_of(&self.branch.first);
        let (from, to) = (parameter_of(&self.branch.before), self.parameter());
        let passes = (from - begin) * (to - begin) <= 0.0 && from != to;
        let [one, first] =
            [&self.branch.last, &self.branch.first].map(|cycle| cycle.outline.modes());
        if self.branch.points.len() <= 3 || !passes || one != first {
            return None;
        }
        let row = self.branch.last.outline.unit(self.place());
        let found = self
            .shooting
            .solve(&self.branch.last.outline, Some((&row, begin)))?;
        if !self.is_first(&found) {
            return None;
        }
        let line = self.branch.line.as_ref();
        let line = line.and_then(|line| line.continued(&self.shooting, &self.branch.units, &found));
        if !self.goes_on_as_first(line.as_ref()) {
            return Some(Stop::NoConvergence);
        }
        // Special orbits behind the first orbit were recorded at the beginning.
        let last = self.branch.points.len() - 1;
        self.branch
            .special
            .retain(|at| at.behind < last || (at.parameter - begin) * (from - begin) > 0.0);
        self.branch.points.pop();
        self.branch.extents.pop();
        self.take(found);
        Some(Stop::Closed)
    }

    /// Whether an orbit at the first one's parameter is the first one.
    fn is_first(&self, found: &Cycle) -> bool {
        let (options, first) = (self.shooting.options, &self.branch.first.anchor.x);
        self.offset_from_first(found)
            .is_some_and(|way| is_same(&way, first, &self.branch.units.states, options))
    }

    /// Whether a line through the first orbit has the direction in which the branch began. A branch
    /// that turned round without a fold comes back in the opposite one. Where the first orbit lies
    /// on another branch, the parameter may have no rate there.
    pub(super) fn goes_on_as_first(&self, line: Option<&TangentLine>) -> bool {
        let is_opposite = |line: &TangentLine| line.heading() * self.branch.heading < 0.0;
        self.begins_on_other || !line.is_some_and(is_opposite)
    }

    /// Whether another orbit is where the tangent of the branch at the last one leads, rather than
    /// where the last one is. Driven ones have so many periods of the drive. `None` where it could
    /// not be computed.
    pub(in crate::analysis) fn leads_to(&self, other: &Self, returns: usize) -> Option<bool> {
        let other = &other.branch.last;
        let line = self.branch.line.as_ref()?;
        let s = (parameter_of(other) - self.parameter()) / line.heading();
        let ahead = self.shooting.evaluated(&line.guess(s))?;
        let away = |one: &Cycle| self.offset(&one.anchor, other, returns);
        let [moved, missed] = [&self.branch.last, &ahead].map(away);
        let led = is_led([&missed?, &moved?], &self.allowed(other));
        (self.shooting.family == 0).then_some(led)
    }

    /// The vector to an orbit from a moment. A driven one may begin in any period of the drive.
    fn offset(&self, at: &Moment, orbit: &Cycle, returns: usize) -> Option<Vector> {
        let away = |k: usize| {
            let later = Moment {
                t: at.t + orbit.period * k as f64 / returns as f64,
                x: at.x.clone(),
            };
            let off = offset_from(&self.shooting, &later, orbit)?;
            Some(off.rows(0, self.shooting.states).into_owned())
        };
        let begins = self.shooting.forced.map_or(1, |_| returns);
        let allowed = self.allowed(orbit);
        let size = |off: &Vector| off.component_div(&allowed).amax();
        let all = (0..begins).filter_map(away);
        all.min_by(|a, b| size(a).total_cmp(&size(b)))
    }

    /// Whether a moment lies on the last orbit, to the accuracy of an attractor.
    pub(in crate::analysis) fn is_at(&self, at: &Moment, returns: usize) -> bool {
        let last = &self.branch.last;
        let off = self.offset(at, last, returns);
        off.is_some_and(|off| is_led([&off, &(&off * 0.0)], &self.allowed(last)))
    }

    /// Differences of the states of an orbit and an attractor that are the same.
    fn allowed(&self, orbit: &Cycle) -> Vector {
        let x = orbit.anchor.x.rows(0, self.shooting.states).into_owned();
        same_attractor(&orbit.ranges, &x, self.shooting.options)
    }

    /// The vector to an orbit from the first one's anchor, as [`offset_from`].
    pub(super) fn offset_from_first(&self, found: &Cycle) -> Option<Vector> {
        offset_from(&self.shooting, &self.branch.first.anchor, found)
    }
}

/// Whether a solution that has moved by a vector from another one is where that leads. In each
/// state it misses at most a part of the way, and what is allowed.
pub(in crate::analysis) fn is_led([missed, moved]: [&Vector; 2], allowed: &Vector) -> bool {
    // Chosen: a branch that bends more, or jumps, is followed.
    const LARGEST_PART: f64 = 0.5;
    let mut states = missed.iter().zip(moved).zip(allowed);
    states.all(|((missed, moved), allowed)| missed.abs() <= LARGEST_PART * moved.abs() + allowed)
}

/// Differences of the states of two attractors that are the same, by the range of each state and by
/// its value: an attractor is known to so many digits, and no length is known below what orbits
/// resolve.
pub(in crate::analysis) fn same_attractor(
    ranges: &Vector,
    x: &Vector,
    options: &Options,
) -> Vector {
    let sizes = ranges + x.abs() * SAME_ATTRACTOR;
    sizes * SAME_ATTRACTOR + Vector::repeat(x.len(), resolved(options.coarsest()))
}

/// Whether the vector between two orbits, near a state, is short for them to be one: by the size of
/// each state, or by the error within which it closes.
pub(super) fn is_same(way: &Vector, at: &Vector, sizes: &Vector, options: &Options) -> bool {
    let mut states = way.iter().zip(at).zip(sizes).enumerate();
    states.all(|(i, ((way, at), size))| {
        way.abs() <= (SAME_ORBIT * size).max(error_of(options.allowed(i, at.abs())))
    })
}

/// The vector to an orbit from a moment of another one, where it is shortest; of a driven orbit, at
/// its time.
pub(super) fn offset_from(
    shooting: &Shooting<'_>,
    place: &Moment,
    found: &Cycle,
) -> Option<Vector> {
    let (system, options) = (shooting.system, shooting.options);
    let start = &found.anchor;
    let off = |x: &Vector| x - &place.x;
    if shooting.forced.is_some() {
        let later = (place.t - start.t).rem_euclid(found.period);
        if later == 0.0 {
            return Some(off(&start.x));
        }
        return Some(off(&run(system, start, start.t + later, options).ok()?.x));
    }
    let passages = passages(system, (start, found.period), place, options, |_| false).ok()?;
    let all = std::iter::once(start).chain(&passages).map(|at| off(&at.x));
    all.min_by(|a, b| a.norm().total_cmp(&b.norm()))
}
