//! The walk along a branch: steps, what is special on the way, and the end.

use std::ops::ControlFlow;

use super::corner::{Behind, DISTANCES};
use super::corrector::{Corrector, Guess, OnBranch, parameter, with_parameter};
use super::line::Line;
use super::{Branch, BranchPoint, ContinuationSettings, Special, SpecialPoint, Stop};
use crate::analysis::anchor::Anchor;
use crate::analysis::attractors::is_same_cycle;
use crate::analysis::sequence::Place;
use crate::analysis::sequence::SequenceBifurcation;
use crate::analysis::sequence::circuit::anchor;
use crate::analysis::sequence::locate::locate;
use crate::dynamics::{Dynamics, Moment, Vector, run};
use crate::error::Error;
use crate::filippov::Options;

/// A change of phases is located to this part of the range.
pub(super) const RESOLUTION: f64 = 1e-11;

/// Steps shorter than this lead nowhere.
const SHORTEST: f64 = 1e-7;

/// The first step behind a change of phases, as a part of the longest one.
const BEHIND: f64 = 0.02;

/// No step is longer than this part of the orbit's own extent.
const OF_EXTENT: f64 = 0.1;

/// A branch under way.
pub(super) struct Walk<'a> {
    pub(super) corrector: Corrector<'a>,
    pub(super) settings: &'a ContinuationSettings,
    /// Width of the range.
    pub(super) width: f64,
    /// Size of the first orbit.
    pub(super) size: f64,
    /// The first orbit.
    pub(super) first: OnBranch,
    /// Extent of the widest orbit yet.
    pub(super) widest: f64,
    /// The last two orbits.
    pub(super) before: OnBranch,
    pub(super) last: OnBranch,
    pub(super) step: f64,
    pub(super) points: Vec<BranchPoint>,
    pub(super) special: Vec<SpecialPoint>,
}

impl<'a> Walk<'a> {
    pub fn begin(
        system: &'a dyn Dynamics,
        x: Vector,
        period: f64,
        settings: &'a ContinuationSettings,
        options: &'a Options,
    ) -> Result<Self, Error> {
        let period = settings.forced.unwrap_or(period);
        let start = Anchor::at_start(system, Moment { t: 0.0, x }, period, options)?;
        let (rate, value) = (parameter(&start.velocity(system)), parameter(&start.x));
        if rate != 0.0 {
            return Err(Error::Parameter {
                name: "the last state's rate",
                value: rate,
                bound: "zero: the last state is the parameter of the continuation",
            });
        }
        let (low, high) = settings.range;
        if !(low..=high).contains(&value) {
            return Err(Error::Parameter {
                name: "the last state",
                value,
                bound: "in the range of the continuation",
            });
        }
        let (at, extent) = anchor(system, &start, period, options)?;
        let corrector = Corrector {
            system,
            forced: settings.forced,
            extent,
            family: 0,
            options,
        };
        let first = corrector.orbit(&Guess::at_parameter(&at, period, value), 0.0);
        let first = first.ok_or(Error::NotFound {
            what: "a periodic orbit near the start of the branch",
            t: at.t,
            span: period,
        })?;
        let family = first.branch.family;
        let mut walk = Walk {
            corrector: Corrector {
                family,
                ..corrector
            },
            settings,
            width: settings.range.1 - settings.range.0,
            size: first.circuit.extent,
            widest: first.circuit.extent,
            before: first.clone(),
            first: first.clone(),
            last: first,
            step: settings.step,
            points: Vec::new(),
            special: Vec::new(),
        };
        walk.note();
        Ok(walk)
    }

    pub fn into_branch(self, stop: Stop) -> Branch {
        Branch {
            points: self.points,
            special: self.special,
            stop,
        }
    }

    /// Follows the branch to its end.
    pub fn go(
        &mut self,
        upwards: bool,
        seen: &mut dyn FnMut(&BranchPoint) -> ControlFlow<()>,
    ) -> Stop {
        let mut stop = self.second(if upwards { 1.0 } else { -1.0 });
        let mut told = 0;
        loop {
            // One step may find several.
            let new = self.points.get(told..).unwrap_or_default();
            told = self.points.len();
            let is_asked = new.iter().try_for_each(&mut *seen).is_break();
            if let Some(stop) = stop {
                return stop;
            }
            if is_asked || self.points.len() >= self.settings.most_points {
                return Stop::Points;
            }
            let step = self.shrinks().or_else(|| self.advance());
            stop = match step.or_else(|| self.closes()) {
                Some(Stop::NoConvergence) if self.is_at_end() => Some(Stop::Range),
                Some(Stop::NoConvergence) => self.homoclinic().or(Some(Stop::NoConvergence)),
                other => other,
            };
        }
    }

    /// The second orbit, at a parameter a little further on.
    fn second(&mut self, direction: f64) -> Option<Stop> {
        let here = self.parameter();
        let (low, high) = self.settings.range;
        let room = if direction > 0.0 {
            high - here
        } else {
            here - low
        };
        if room <= 0.0 {
            return Some(Stop::Range);
        }
        let mut way = room.min(0.1 * self.settings.step * self.width) * direction;
        for _ in 0..12 {
            let circuit = &self.last.circuit;
            let guess = Guess::at_parameter(&circuit.anchor, circuit.period, here + way);
            if let Some(next) = self.corrector.orbit(&guess, 0.0)
                && self.last.goes_on_in(&next)
            {
                self.follow(next);
                return None;
            }
            way *= 0.25;
        }
        let refused = self.refused(&self.last, here + way);
        refused.or(Some(Stop::NoConvergence))
    }

    /// Whether the system is none that can be followed from an orbit's state at a parameter next to
    /// it, and why.
    fn refused(&self, orbit: &OnBranch, parameter: f64) -> Option<Stop> {
        let Moment { t, x } = &orbit.circuit.anchor.at;
        let start = Moment {
            t: *t,
            x: with_parameter(x.clone(), parameter),
        };
        let (system, options) = (self.corrector.system, self.corrector.options);
        let error = run(system, &start, t + orbit.circuit.period, options).err()?;
        let is_of_friction = matches!(
            error,
            Error::StaticBelowKinetic { .. }
                | Error::HoldsElsewhere { .. }
                | Error::NotAdditive { .. }
        );
        is_of_friction.then_some(Stop::Refused(error))
    }

    pub(super) fn parameter(&self) -> f64 {
        self.last.parameter()
    }

    /// Takes a step, or gets behind a change of phases.
    fn advance(&mut self) -> Option<Stop> {
        if let Some(orbits) = self.anchored_anew(&self.before, &self.last) {
            [self.before, self.last] = orbits;
        }
        let line = self.line();
        let step = self
            .step
            .min(OF_EXTENT * self.last.circuit.extent / self.size);
        match self.on(&line, step) {
            Some(next) if self.last.goes_on_in(&next) => {
                if self.turns_without_fold(&next) {
                    self.step = 0.3 * step;
                    return (self.step < SHORTEST).then_some(Stop::NoConvergence);
                }
                if let Some(stop) = self.leaves_range(&next) {
                    return Some(stop);
                }
                let few = next.branch.iterations <= 5;
                let longer = if few { 1.4 * step } else { step };
                self.step = longer.min(self.settings.step);
                self.follow(next);
                None
            }
            other => self.get_behind(&line, step, other),
        }
    }

    /// The way back along the parameter from the last orbit before a change to one that is apart from it.
    fn away_from(&self, good: &[OnBranch]) -> f64 {
        const APART: f64 = 1e-8;
        let last = good.last().map_or(f64::NAN, OnBranch::parameter);
        let ways = good.iter().rev().map(|one| one.parameter() - last);
        let mut apart = ways.filter(|way| way.abs() > APART * self.width);
        apart.next().unwrap_or(0.0)
    }

    /// The sign of the way that the last two orbits have come along the parameter; none where a fold lies between them, or a change of phases, at
    /// which a branch may turn too.
    fn heading(&self) -> Option<f64> {
        let [before, last] = [&self.before, &self.last];
        let is_smooth = before.circuit.sequence() == last.circuit.sequence();
        let [a, b] = [before, last].map(OnBranch::parameter);
        let no_fold = self.to_fold(before) * self.to_fold(last) > 0.0;
        (is_smooth && no_fold && a != b).then_some((b - a).signum())
    }

    /// The function of an orbit's multipliers that is zero at a fold.
    fn to_fold(&self, orbit: &OnBranch) -> f64 {
        orbit.branch.critical(self.settings.forced.is_some()).one
    }

    /// Whether the next orbit lies back along the parameter though no multiplier has passed 1: the way that has come was found again.
    fn turns_without_fold(&self, next: &OnBranch) -> bool {
        let way = next.parameter() - self.parameter();
        let turns = self.heading().is_some_and(|heading| way * heading < 0.0);
        turns && self.to_fold(&self.last) * self.to_fold(next) > 0.0
    }

    /// Whether a place lies behind the last orbit on the way that has come, and not before it: the orbits there were found again.
    fn is_behind(&self, parameter: f64) -> bool {
        // A graze is noticed some tolerances behind it.
        const NOTICED: f64 = 100.0;
        let way = parameter - self.parameter();
        let least = SHORTEST.max(NOTICED * self.corrector.options.rtol) * self.width;
        self.heading().is_some_and(|heading| way * heading < -least)
    }

    /// The phases change within the step, or it is too long.
    fn get_behind(&mut self, line: &Line, step: f64, trial: Option<OnBranch>) -> Option<Stop> {
        let wanted = self.last.circuit.sequence();
        let (mut before, mut last) = (self.before.clone(), self.last.clone());
        (before.s, last.s) = (-line.length, 0.0);
        let mut good = vec![before, last];
        let certain = trial.filter(|one| self.last.is_as_certain(one));
        let mut behind: Vec<_> = certain.into_iter().collect();
        let bad = locate(&mut good, step, RESOLUTION, |s, good| {
            let found = self.on(line, s).or_else(|| self.on_beyond(line, good, s))?;
            if !self.last.is_as_certain(&found) {
                return None;
            }
            if found.circuit.sequence() != wanted {
                behind.push(found.clone());
            } else if self.turns_without_fold(&found) {
                return None;
            }
            Some(found)
        });
        // On the way there the anchor's phase may be about to vanish.
        let anew = good.iter().skip(2).find_map(|one| {
            let orbits = self.anchored_anew(&self.last, one)?;
            Some((one.clone(), orbits))
        });
        if let Some((one, orbits)) = anew {
            if let Some(stop) = self.leaves_range(&one) {
                return Some(stop);
            }
            self.follow(one);
            [self.before, self.last] = orbits;
            return None;
        }
        behind.sort_by(|a, b| a.s.total_cmp(&b.s));
        let edge = good.last()?.clone();
        let refused = self.refused(&edge, parameter(&line.guess(bad).at.x));
        let end = refused.or_else(|| self.boundary_equilibrium(&good.iter().collect::<Vec<_>>()));
        if let Some(stop) = end {
            if edge.s > 0.0 {
                self.follow(edge);
            }
            return Some(stop);
        }
        let place = Place {
            parameter: edge.parameter(),
            bracket: (bad - edge.s).abs(),
            scale: self.width,
            away: self.away_from(&good),
        };
        let behind = Behind {
            corrector: &self.corrector,
            good: &good,
            found: &behind,
            width: self.width,
        };
        let Some(next) = behind.enter(place) else {
            self.step = 0.1 * step;
            return (self.step < SHORTEST).then_some(Stop::NoConvergence);
        };
        let is_behind = self.is_behind(next.change.parameter);
        if next.change.bifurcation == SequenceBifurcation::Unnamed || is_behind {
            let beyond = self.beyond_branch_point(line, step);
            if let Some(beyond) = beyond.or_else(|| self.round_a_bend(line, step)) {
                return self.leaves_range(&beyond).or_else(|| {
                    self.follow(beyond);
                    None
                });
            }
            // Another orbit was met, or none: nearer to the last one it may be the right one.
            self.step = 0.1 * step;
            if let Some(stop) = self.leaves_range(&edge) {
                return Some(stop);
            }
            if edge.s > 0.01 * step {
                self.follow(edge);
            }
            return (self.step < SHORTEST).then_some(Stop::NoConvergence);
        }
        let (low, high) = self.settings.range;
        if let Some(stop) = self.leaves_range(&edge) {
            return Some(stop);
        }
        if edge.s > 0.0 {
            self.follow(edge);
            if let Some(stop) = self.closes() {
                return Some(stop);
            }
        }
        if !(low..=high).contains(&next.change.parameter) {
            return Some(Stop::Range);
        }
        self.special.push(SpecialPoint {
            parameter: next.change.parameter,
            uncertainty: next.change.uncertainty,
            behind: self.points.len(),
            x: next.x,
            period: next.change.period,
            what: Special::Sequence(Box::new(next.change)),
        });
        let Some([near, far]) = next.orbits else {
            let heading = parameter(&line.direction).signum() * self.width;
            let mut places = DISTANCES
                .iter()
                .map(|part| self.parameter() + part * heading);
            let refused = places.find_map(|place| self.refused(&self.last, place));
            return refused.or(Some(Stop::SequenceEnds));
        };
        let is_outside = |one: &OnBranch| !(low..=high).contains(&one.parameter());
        if is_outside(&near) || is_outside(&far) {
            return Some(Stop::Range);
        }
        // A fold may lie next to it.
        self.step = BEHIND * self.settings.step;
        self.take(near);
        self.follow(far);
        None
    }

    /// An orbit with the same phases along the branch's tangent behind a fold: where it turns by more than a right angle no orbit is ahead on the line of the
    /// last two.
    fn round_a_bend(&self, line: &Line, step: f64) -> Option<OnBranch> {
        const TIMES: [f64; 3] = [1.0, 0.3, 0.1];
        if self.heading().is_some() {
            return None;
        }
        let tangent = self.tangent(line)?;
        let is_next =
            |next: &OnBranch| self.last.goes_on_in(next) && !self.turns_without_fold(next);
        TIMES
            .into_iter()
            .find_map(|times| self.on(&tangent, times * step).filter(is_next))
    }

    /// An orbit with the same phases a little further on than a step leads: next to where another branch meets this one none is found.
    fn beyond_branch_point(&self, line: &Line, step: f64) -> Option<OnBranch> {
        const TIMES: [f64; 3] = [2.0, 4.0, 8.0];
        let last = self.to_fold(&self.last);
        let is_beyond = |next: &OnBranch| {
            let way = next.parameter() - self.parameter();
            let goes_on = self.heading().is_some_and(|heading| way * heading > 0.0);
            goes_on && last * self.to_fold(next) < 0.0 && self.last.goes_on_in(next)
        };
        TIMES
            .into_iter()
            .find_map(|times| self.on(line, times * step).filter(is_beyond))
    }

    /// Two orbits with the same phases, anchored in another one where that suits the second better: the end of the anchor's own phase is located
    /// badly.
    fn anchored_anew(&self, before: &OnBranch, last: &OnBranch) -> Option<[OnBranch; 2]> {
        let Corrector {
            system, options, ..
        } = self.corrector;
        let old = last.circuit.sequence();
        let part = last.circuit.better_part(system)?;
        if before.circuit.sequence() != old {
            return None;
        }
        let anew = |one: &OnBranch| {
            let at = one.circuit.anchor_in(system, part, options)?;
            let guess = Guess::at_parameter(&at, one.circuit.period, parameter(&at.x));
            self.corrector.orbit(&guess, one.s)
        };
        let orbits = [anew(before)?, anew(last)?];
        let [one, two] = orbits.each_ref().map(|one| one.circuit.sequence());
        (one == two && is_same_cycle(&one, &old)).then_some(orbits)
    }

    /// Goes on from this orbit.
    pub(super) fn take(&mut self, next: OnBranch) {
        self.widest = self.widest.max(next.circuit.extent);
        self.corrector.extent = self.widest;
        self.corrector.family = next.branch.family;
        self.before = std::mem::replace(&mut self.last, next);
        self.note();
    }

    fn note(&mut self) {
        let OnBranch {
            circuit, branch, ..
        } = &self.last;
        let Moment { t, x } = circuit.anchor.at.clone();
        let is_forced = self.settings.forced.is_some();
        self.points.push(BranchPoint {
            parameter: parameter(&x),
            t,
            x,
            period: circuit.period,
            multipliers: branch.critical(is_forced).multipliers,
            sequence: circuit.modes(),
        });
    }
}
