//! Where a branch ends.

use super::Stop;
use super::walk::Walk;
use super::{parameter_of, with_parameter};
use crate::analysis::boundary_equilibrium::{Approach, Held, ends_in};
use crate::analysis::cycle::{Cycle, MarginKind};
use crate::analysis::lagrange::weights;
use crate::dynamics::{Happening, Modes, Moment, Orbit, Section, Vector, run};
use crate::filippov::Direction;

/// An orbit below this fraction of the widest one's extent is about to shrink to an equilibrium.
const SMALL: f64 = 0.04;

/// A driven orbit whose motion is below this fraction of the widest one's extent may be about to
/// come to rest.
const AT_REST: f64 = 1e-3;

/// Two orbits at one parameter are the same if they come this near, as a fraction of the extent.
const SAME: f64 = 1e-6;

impl Walk<'_> {
    /// Whether the orbit is about to shrink to an equilibrium or to come to rest.
    pub(super) fn shrinks(&self) -> Option<Stop> {
        let extent = self.branch.last.extent;
        if extent >= self.branch.before.extent {
            return None;
        }
        if self.settings.forced.is_some() {
            let rests = extent < AT_REST * self.branch.widest && self.rests_further_on();
            return rests.then_some(Stop::Rest);
        }
        let end = self.boundary_equilibrium();
        if end.is_some() {
            return end;
        }
        if extent >= SMALL * self.branch.widest {
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

    /// The parameter at which the last two orbits end in an equilibrium that reaches the edge of
    /// its mode's domain, and that equilibrium.
    pub(in crate::analysis) fn ends_at(&self) -> Option<(f64, Vector)> {
        if self.settings.forced.is_some() {
            return None;
        }
        let system = self.shooting.system;
        let states = self.shooting.states;
        let held = |parameter: f64, mode, x: &Vector| {
            Held::near(system, mode, &with_parameter(x.clone(), parameter), states)
        };
        let orbits = [&self.branch.before, &self.branch.last]
            .map(|cycle| Approach::of(parameter_of(cycle), cycle));
        ends_in(&orbits, self.branch.widest, states, held)
    }

    /// The parameter at which crossing orbits shrink to a two-fold, as they do if they meet the
    /// boundary ever more slowly from both sides. It is extrapolated to zero extent by a
    /// polynomial.
    fn two_fold(&self) -> Option<Stop> {
        const NODES: usize = 5;
        // Tolerance for rates that decrease in proportion to the extents.
        const LIKE: f64 = 0.2;
        let rates = |cycle: &Cycle| {
            let landings = cycle.margins.iter();
            let landings = landings.filter(|margin| margin.kind == MarginKind::Landing);
            landings.map(|margin| margin.scale).collect::<Vec<f64>>()
        };
        let (before, last) = (&self.branch.before, &self.branch.last);
        let falls = last.extent / before.extent;
        let is_like = |(before, last): (&f64, &f64)| (last / before / falls - 1.0).abs() < LIKE;
        let is_crossing = !last.outline.modes().iter().any(Modes::any_sticks);
        // Near an equilibrium the period would remain finite.
        let periods = (&before.period, &last.period);
        let (before, last) = (rates(before), rates(last));
        let mut all = before.iter().zip(&last).chain([periods]);
        if !is_crossing || last.is_empty() || before.len() != last.len() || !all.all(is_like) {
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
        let at_nothing = |nodes: &[(f64, f64)]| -> f64 {
            let extents: Vec<f64> = nodes.iter().map(|node| node.0).collect();
            let weighted = weights(&extents, 0.0).into_iter().zip(nodes);
            weighted.map(|(weight, node)| weight * node.1).sum()
        };
        // Not yet: the largest of them is not small.
        if nodes.len() < NODES || nodes[NODES - 1].0 > 0.5 * self.branch.widest {
            return None;
        }
        let parameter = at_nothing(&nodes);
        let uncertainty = (parameter - at_nothing(&nodes[..NODES - 1])).abs();
        // Smaller ones determine it better.
        const RESOLVED: f64 = 1e-9;
        (uncertainty <= RESOLVED * self.branch.units.width).then_some(Stop::TwoFold {
            parameter,
            uncertainty: self.at_least(parameter, uncertainty),
        })
    }

    /// Whether an orbit one step farther begins where the last one sticks and sticks throughout.
    fn rests_further_on(&self) -> bool {
        let last = &self.branch.last;
        let mut segments = last.outline.segments.iter().zip(&last.begins);
        let Some((_, stuck)) = segments.find(|(segment, _)| segment.mode.any_sticks()) else {
            return false;
        };
        let way = self.parameter() - parameter_of(&self.branch.before);
        let further = way.signum() * self.settings.step * self.branch.units.width;
        let start = Moment {
            t: stuck.t,
            x: with_parameter(stuck.x.clone(), self.parameter() + further),
        };
        let (system, options) = (self.shooting.system, self.shooting.options);
        Orbit::solve(system, &start, stuck.t + last.period, options).is_ok_and(|orbit| {
            orbit.transitions.is_empty() && orbit.phases.iter().all(|one| one.mode.any_sticks())
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
        // What lies behind the first orbit was computed at the beginning.
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
        let near = SAME * self.branch.first.extent;
        self.away(found).is_some_and(|way| way.norm() <= near)
    }

    /// The way to an orbit from the first one's anchor, where it is shortest; of a driven one, at
    /// its time.
    pub(super) fn away(&self, found: &Cycle) -> Option<Vector> {
        let (system, options) = (self.shooting.system, self.shooting.options);
        let (start, place) = (&found.anchor, &self.branch.first.anchor);
        let off = |x: &Vector| x - &place.x;
        if self.shooting.forced.is_some() {
            let away = (place.t - start.t).rem_euclid(found.period);
            if away == 0.0 {
                return Some(off(&start.x));
            }
            return Some(off(&run(system, start, start.t + away, options).ok()?.x));
        }
        let t_end = start.t + found.period;
        let begun = system.begin(place, place.t + found.period, options, &Section::None);
        let section = Section::Plane {
            point: place.x.clone(),
            normal: system.flow(begun.ok()?.mode(), place).velocity(place),
            direction: Direction::Rising,
        };
        let mut orbit = system.begin(start, t_end, options, &section).ok()?;
        let mut nearest = off(&start.x);
        loop {
            match orbit.step().ok()? {
                Happening::Passage(at) if off(&at.x).norm() < nearest.norm() => {
                    nearest = off(&at.x);
                }
                Happening::End(_) => return Some(nearest),
                _ => {}
            }
        }
    }
}
