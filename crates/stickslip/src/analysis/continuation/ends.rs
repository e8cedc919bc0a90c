//! Where a branch ends.

use super::Stop;
use super::corrector::{Guess, OnBranch, parameter, with_parameter};
use super::rest::hopf;
use super::walk::{RESOLUTION, Walk};
use crate::analysis::anchor::Anchor;
use crate::analysis::attractors::is_same_cycle;
use crate::analysis::boundary_equilibrium::{Held, ends_in};
use crate::dynamics::{Moment, Orbit, Vector, run};

/// An orbit of less than this part of the widest one's extent is about to be an equilibrium.
const SMALL: f64 = 0.04;

/// A driven orbit that moves by less than this part of the widest one's extent may be about to rest.
const AT_REST: f64 = 1e-3;

/// An orbit that comes so near to a state of another, in parts of its extent, may be that one: it is followed in steps of some of this.
const NEAR: f64 = 0.1;

/// So near to an end of the range, in parts of it, the orbit is at that end.
const AT_END: f64 = 10.0 * RESOLUTION;

/// Two orbits at one parameter that differ by less than this part are one.
const SAME: f64 = 1e-6;

impl Walk<'_> {
    /// Whether the next orbit lies outside the range; the last one is then that at its end.
    pub(super) fn leaves_range(&mut self, next: &OnBranch) -> Option<Stop> {
        let (low, high) = self.settings.range;
        let (here, there) = (self.parameter(), next.parameter());
        if (low..=high).contains(&there) {
            return None;
        }
        let end = there.clamp(low, high);
        let part = ((end - here) / (there - here)).clamp(0.0, 1.0);
        let (a, b) = (&self.last.circuit, &next.circuit);
        let at = self.between(&a.anchor, &b.anchor, part);
        let is_same = |found: &OnBranch| found.circuit.sequence() == a.sequence();
        let corrector = &self.corrector;
        let found = corrector
            .orbit(&Guess::at_parameter(&at, b.period, end), 0.0)
            .filter(is_same)
            .or_else(|| corrector.next_at(&self.last, end).filter(is_same))
            .or_else(|| corrector.next_at(next, end).filter(is_same));
        match found {
            _ if part == 0.0 => Some(Stop::Range),
            Some(found) => {
                self.follow(found);
                Some(Stop::Range)
            }
            None => Some(Stop::NoConvergence),
        }
    }

    /// Whether the branch has come to an end of the range, to what a parameter is located to: beyond it the system may not exist.
    pub(super) fn is_at_end(&self) -> bool {
        let (low, high) = self.settings.range;
        let [before, here] = [&self.before, &self.last].map(OnBranch::parameter);
        let end = if here > before { high } else { low };
        here != before && (end - here).abs() <= AT_END * self.width
    }

    /// A part of the way from one orbit to the next, at the time of the second.
    fn between(&self, from: &Anchor, to: &Anchor, part: f64) -> Anchor {
        to.moved(&to.x - self.corrector.way(from, to) * (1.0 - part))
    }

    /// Whether the orbit is about to be an equilibrium, or at rest.
    pub(super) fn shrinks(&self) -> Option<Stop> {
        let circuit = &self.last.circuit;
        let extent = circuit.extent;
        if extent >= self.before.circuit.extent {
            return None;
        }
        if self.settings.forced.is_some() {
            let rests = extent < AT_REST * self.widest && self.rests_further_on();
            return rests.then_some(Stop::Rest);
        }
        let end = self.boundary_equilibrium(&[&self.before, &self.last]);
        if end.is_some() {
            return end;
        }
        if extent >= SMALL * self.widest {
            return None;
        }
        let (parameter, frequency) = hopf(self.corrector.system, &self.last, self.width)?;
        Some(Stop::Equilibrium {
            parameter,
            frequency,
        })
    }

    /// The parameter at which orbits end in an equilibrium that comes to the edge of where its mode
    /// holds.
    pub(super) fn boundary_equilibrium(&self, orbits: &[&OnBranch]) -> Option<Stop> {
        if self.settings.forced.is_some() {
            return None;
        }
        let system = self.corrector.system;
        let states = system.states() - 1;
        let held = |parameter: f64, mode, x: &Vector| {
            Held::near(system, mode, &with_parameter(x.clone(), parameter), states)
        };
        let (parameter, _) = ends_in(orbits, self.widest, states, OnBranch::parameter, held)?;
        let (low, high) = self.settings.range;
        (low..=high)
            .contains(&parameter)
            .then_some(Stop::BoundaryEquilibrium { parameter })
    }

    /// Whether an orbit a step further on begins where the last one sticks, and does so all the time.
    fn rests_further_on(&self) -> bool {
        let circuit = &self.last.circuit;
        let stick = circuit.parts.iter().find(|part| part.mode.any_sticks());
        let Some(stuck) = stick.and_then(|part| part.first.as_ref()) else {
            return false;
        };
        let way = self.parameter() - self.before.parameter();
        let further = way.signum() * self.settings.step * self.width;
        let start = Moment {
            t: stuck.t,
            x: with_parameter(stuck.x.clone(), parameter(&stuck.x) + further),
        };
        let (system, options) = (self.corrector.system, self.corrector.options);
        let Ok(orbit) = Orbit::solve(system, &start, stuck.t + circuit.period, options) else {
            return false;
        };
        orbit.transitions.is_empty() && orbit.phases.iter().all(|phase| phase.mode.any_sticks())
    }

    /// Whether the branch has come back to the first orbit, which is then its last.
    pub(super) fn closes(&mut self) -> Option<Stop> {
        let first = &self.first;
        let (a, b) = (&self.before.circuit, &self.last.circuit);
        let begin = first.parameter();
        let (from, to) = (self.before.parameter(), self.last.parameter());
        let passes = (from - begin) * (to - begin) <= 0.0 && from != to;
        // Either may be anchored in another phase.
        let is_alike = || is_same_cycle(&b.sequence(), &first.circuit.sequence());
        if self.points.len() <= 3 || !passes || !is_alike() {
            return None;
        }
        let part = (begin - from) / (to - from);
        let at = self.between(&a.anchor, &b.anchor, part);
        let guess = Guess::at_parameter(&at, b.period, begin);
        let found = self.corrector.orbit(&guess, 0.0)?;
        if !self.is_first(&found) {
            return None;
        }
        // What lies behind the first orbit was found at the beginning.
        let last = self.points.len() - 1;
        self.special
            .retain(|at| at.behind < last || (at.parameter - begin) * (from - begin) > 0.0);
        self.points.pop();
        self.take(found);
        Some(Stop::Closed)
    }

    /// Whether an orbit at the first one's parameter is the first one.
    fn is_first(&self, found: &OnBranch) -> bool {
        let is_forced = self.settings.forced.is_some();
        let first = &self.first;
        let agree = |a: f64, b: f64| (a - b).abs() <= SAME * (1.0 + b.abs());
        if is_forced {
            let off = |x: Vector| (x - &first.circuit.anchor.x).amax();
            return self
                .at_time(found, first.circuit.anchor.t)
                .is_some_and(|x| off(x) <= SAME * first.circuit.extent);
        }
        // Any state of it may be the anchor.
        let [a, b] = [found, first].map(|one| one.branch.critical(is_forced));
        let [one, two] = [found, first].map(|one| one.circuit.period);
        let alike = agree(one / two, 1.0) && agree(a.one, b.one) && agree(a.minus_one, b.minus_one);
        alike && self.comes_by(found, &first.circuit.anchor.x) <= NEAR * first.circuit.extent
    }

    /// The state of a driven orbit at a time or whole periods of its own from it.
    fn at_time(&self, orbit: &OnBranch, t: f64) -> Option<Vector> {
        // So little of a period that the state is the same.
        const SAME_TIME: f64 = 1e-9;
        let (at, period) = (&orbit.circuit.anchor, orbit.circuit.period);
        let away = (t - at.t).rem_euclid(period);
        if away.min(period - away) <= SAME_TIME * period {
            return Some(at.x.clone());
        }
        let (system, options) = (self.corrector.system, self.corrector.options);
        Some(run(system, at, at.t + away, options).ok()?.x)
    }

    /// How near an orbit comes to a state: the mirror image of the first orbit is like it, but elsewhere.
    fn comes_by(&self, found: &OnBranch, place: &Vector) -> f64 {
        const PARTS: u32 = 128;
        let start = &found.circuit.anchor;
        let (mut nearest, mut here) = ((&start.x - place).norm(), start.at.clone());
        let (system, options) = (self.corrector.system, self.corrector.options);
        for k in 1..=PARTS {
            let t = start.t + found.circuit.period * f64::from(k) / f64::from(PARTS);
            let Ok(part) = run(system, &here, t, options) else {
                return f64::INFINITY;
            };
            here = Moment { t, x: part.x };
            nearest = nearest.min((&here.x - place).norm());
        }
        nearest
    }
}
