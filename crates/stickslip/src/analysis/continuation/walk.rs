//! Continuation of a branch: steps, special orbits, and the end.

use std::ops::ControlFlow;

use super::change::{BEYOND, Change};
use super::line::{Line, Units};
use super::{
    Branch, BranchPoint, ContinuationSettings, PartialBranch, Special, SpecialPoint, Stop,
    check_rate, check_start, critical, parameter_of, with_parameter,
};
use crate::analysis::cycle::{Cycle, Extra, Margin, Outline, Shooting};
use crate::dynamics::{Dynamics, Moment, Vector, run};
use crate::error::Error;
use crate::filippov::Options;

/// Precision to which an end of the branch is located, as a fraction of the range.
const RESOLUTION: f64 = 1e-11;

/// Shortest step.
pub(super) const SHORTEST: f64 = 1e-7;

/// The first step behind a change of phases, as a fraction of the longest one.
const BEHIND: f64 = 0.02;

/// Longest step, as a fraction of the orbit's own extent.
const OF_EXTENT: f64 = 0.1;

/// A branch that is being followed.
pub(in crate::analysis) struct Walk<'a> {
    pub(super) shooting: Shooting<'a>,
    pub(super) settings: &'a ContinuationSettings,
    pub(super) branch: PartialBranch,
    /// The kind of special orbit at which to stop, the number of such orbits before it, and the
    /// orbit.
    pub(in crate::analysis) wanted: Option<(IsMeant, usize)>,
    pub(super) junction: Option<Junction>,
}

/// Whether a special orbit is of the kind at which to stop.
type IsMeant = fn(&Special) -> bool;

/// A special orbit from which a curve or another branch is followed.
pub(super) struct Junction {
    pub at: SpecialPoint,
    pub cycle: Cycle,
    pub by: Vanishing,
}

/// The function that vanishes at a special orbit.
pub(super) enum Vanishing {
    Margin(Margin),
    /// A function of the multipliers, on a line that contains the orbit.
    Multiplier(Line),
}

impl<'a> Walk<'a> {
    pub fn begin(
        system: &'a dyn Dynamics,
        (x, period, upwards): (Vector, f64, bool),
        settings: &'a ContinuationSettings,
        (extra, options): (Extra<'a>, &'a Options),
    ) -> Result<Self, Error> {
        let period = settings.forced.unwrap_or(period);
        let start = Moment { t: 0.0, x };
        let fewest = 2 + usize::from(!matches!(extra, Extra::None));
        check_start(&start.x, fewest - 1, settings)?;
        let last = start.x.len() - 1;
        // The other parameter, if there is one, is the one before the last.
        let states = last - usize::from(!matches!(extra, Extra::None));
        let (low, high) = settings.range;
        let value = start.x[last];
        let outline = Outline::of_run(system, &start, period, options)?;
        for segment in &outline.segments {
            let flow = system.flow(segment.mode, &segment.inside);
            let rates = flow.velocity(&segment.inside);
            let parameters = rates.rows(states, last + 1 - states);
            parameters.iter().try_for_each(|rate| check_rate(*rate))?;
        }
        let shooting = Shooting {
            states,
            extra,
            ..Shooting::of(system, &outline, settings.forced, options)
        };
        let row = outline.unit(last);
        let first = shooting.nearest(&outline, Some((&row, value)));
        let first = first.ok_or(Error::NotFound {
            what: "a periodic orbit near the start of the branch",
            t: start.t,
            span: period,
        })?;
        let shooting = Shooting {
            family: first.family,
            extent: first.extent,
            ..shooting
        };
        let units = Units {
            size: first.extent,
            width: high - low,
            other: None,
        };
        let sign = if upwards { 1.0 } else { -1.0 };
        let line = Line::tangent(&shooting, units, &first, &(row * sign));
        Ok(Walk::at(shooting, settings, units, (first, line)))
    }

    /// Resumes a branch.
    pub fn resume(
        system: &'a dyn Dynamics,
        branch: PartialBranch,
        settings: &'a ContinuationSettings,
        options: &'a Options,
    ) -> Self {
        let outline = &branch.last.outline;
        let shooting = Shooting {
            states: outline.begin.x.len() - 1,
            family: branch.first.family,
            extent: branch.widest,
            ..Shooting::of(system, outline, settings.forced, options)
        };
        Walk::with(shooting, settings, branch)
    }

    fn with(
        shooting: Shooting<'a>,
        settings: &'a ContinuationSettings,
        branch: PartialBranch,
    ) -> Self {
        Walk {
            shooting,
            settings,
            branch,
            wanted: None,
            junction: None,
        }
    }

    /// Begins at an orbit, along a line.
    pub(super) fn at(
        shooting: Shooting<'a>,
        settings: &'a ContinuationSettings,
        units: Units,
        (first, line): (Cycle, Option<Line>),
    ) -> Self {
        let branch = PartialBranch {
            units,
            widest: first.extent,
            before: first.clone(),
            first: first.clone(),
            last: first,
            line,
            step: 0.1 * settings.step,
            points: Vec::new(),
            extents: Vec::new(),
            special: Vec::new(),
        };
        let mut walk = Walk::with(shooting, settings, branch);
        walk.note();
        walk
    }

    pub fn into_branch(self, stop: Stop) -> Branch {
        Branch {
            points: self.branch.points,
            special: self.branch.special,
            stop,
        }
    }

    /// Follows the branch to its end.
    pub fn go_on(&mut self, observe: &mut dyn FnMut(&PartialBranch) -> ControlFlow<()>) -> Stop {
        if self.branch.points.len() == 1 && self.leaves_range() {
            return Stop::Range;
        }
        loop {
            let is_enough = observe(&self.branch).is_break();
            if is_enough || self.branch.points.len() >= self.settings.most_points {
                return Stop::Points;
            }
            let step = self.shrinks().or_else(|| self.advance());
            match step.or_else(|| self.closes()) {
                None => {}
                Some(Stop::NoConvergence) => {
                    return self.slow_end().unwrap_or(Stop::NoConvergence);
                }
                Some(stop) => return stop,
            }
        }
    }

    /// Whether the line leads out of the range.
    fn leaves_range(&self) -> bool {
        let heading = self.branch.line.as_ref().map_or(0.0, Line::heading);
        let (low, high) = self.settings.range;
        let here = self.parameter();
        heading > 0.0 && here >= high || heading < 0.0 && here <= low
    }

    /// The component of the parameter.
    pub(super) fn place(&self) -> usize {
        self.branch.last.outline.begin.x.len() - 1
    }

    pub(super) fn parameter(&self) -> f64 {
        parameter_of(&self.branch.last)
    }

    /// Takes a step, or passes a change of phases.
    fn advance(&mut self) -> Option<Stop> {
        if self.branch.last.is_badly_cut() {
            self.cut_anew();
        }
        let Some(line) = self.branch.line.clone() else {
            return Some(Stop::NoConvergence);
        };
        let by_extent = OF_EXTENT * self.branch.last.extent / self.branch.units.size;
        let mut step = self.branch.step.min(by_extent);
        if let Some(&(_, place)) = line.vanishing(step).first() {
            let change = self.vanishes(&line, place);
            if let Some(change) = change.filter(|change| self.is_in_range(&change.at.solution)) {
                return self.pass(change);
            }
            step = 0.5 * place;
            if step < SHORTEST {
                return match self.vanished(&line, place) {
                    Some(change) => self.pass(change),
                    None => Some(Stop::NoConvergence),
                };
            }
        }
        let (low, high) = self.settings.range;
        let Some(mut next) = line.on(&self.shooting, step) else {
            return self.shorten(step, 0.3);
        };
        let is_outside = !self.is_in_range(&next);
        if is_outside {
            let there = parameter_of(&next);
            let end = there.clamp(low, high);
            let part = (end - self.parameter()) / (there - self.parameter());
            let guess = line.guess(part * step);
            let row = guess.unit(self.place());
            let Some(at_end) = self.shooting.solve(&guess, Some((&row, end))) else {
                return self.shorten(step, 0.3);
            };
            next = at_end;
        }
        let onward = line.goes_on(&self.shooting, self.branch.units, &next);
        let bends = |onward: &Line| !line.bends_little(onward);
        if onward.as_ref().is_some_and(bends) {
            return self.shorten(step, 0.5);
        }
        match self.passed(&line, &next) {
            Err(()) => return self.shorten(step, 0.5),
            Ok(Some(change)) => return self.pass(change),
            Ok(None) => {}
        }
        if let Some(why) = self.refused(&next.anchor) {
            return Some(self.go_to_edge(&line, line.place(&next), why));
        }
        if self.is_homoclinic(&next) {
            return Some(Stop::NoConvergence);
        }
        let longer = if next.iterations <= 5 { 1.4 } else { 1.0 };
        self.branch.step = (longer * step).min(self.settings.step);
        let end = self.follow(&line, next, onward);
        if self.junction.is_some() {
            return Some(Stop::Points);
        }
        end.or(is_outside.then_some(Stop::Range))
    }

    /// Whether the period grows while the parameter changes by no more than the tolerance.
    fn is_homoclinic(&self, next: &Cycle) -> bool {
        let least = self.shooting.options.rtol.max(16.0 * f64::EPSILON);
        let grows = self.shooting.forced.is_none() && next.period > self.branch.last.period;
        let size = self.parameter().abs().max(self.branch.units.width);
        grows && (parameter_of(next) - self.parameter()).abs() <= least * size
    }

    /// Cuts the last orbit in another segment.
    fn cut_anew(&mut self) {
        let mut outline = self.branch.last.outline.clone();
        outline.cut = None;
        let row = outline.unit(self.place());
        if let (Some(line), Some(anew)) = (
            &self.branch.line,
            self.shooting
                .solve(&outline, Some((&row, self.parameter()))),
        ) {
            self.branch.line = line.goes_on(&self.shooting, self.branch.units, &anew);
            self.branch.last = anew;
        }
    }

    /// Whether an orbit lies in the parameter's range.
    fn is_in_range(&self, cycle: &Cycle) -> bool {
        let (low, high) = self.settings.range;
        (low..=high).contains(&parameter_of(cycle))
    }

    /// Shortens the next step, if it is long enough for that.
    fn shorten(&mut self, step: f64, part: f64) -> Option<Stop> {
        self.branch.step = part * step;
        if self.branch.step >= SHORTEST {
            return None;
        }
        let end = self.boundary_equilibrium();
        end.or(Some(Stop::NoConvergence))
    }

    /// Whether the system cannot be integrated for a period from a moment of the last orbit, and
    /// why.
    fn refused(&self, start: &Moment) -> Option<Stop> {
        let (system, options) = (self.shooting.system, self.shooting.options);
        let error = run(system, start, start.t + self.branch.last.period, options).err()?;
        let is_of_friction = matches!(
            error,
            Error::StaticBelowKinetic { .. }
                | Error::HoldsElsewhere { .. }
                | Error::NotAdditive { .. }
        );
        is_of_friction.then_some(Stop::Refused(error))
    }

    /// Moves to the last orbit on a line, before a place, along which the system can be integrated.
    fn go_to_edge(&mut self, line: &Line, step: f64, mut why: Stop) -> Stop {
        let (mut good, mut bad) = ((0.0, None), step);
        while bad - good.0 > RESOLUTION {
            let middle = 0.5 * (good.0 + bad);
            match line.on(&self.shooting, middle) {
                Some(one) => match self.refused(&one.anchor) {
                    Some(stop) => (bad, why) = (middle, stop),
                    None => good = (middle, Some(one)),
                },
                None => bad = middle,
            }
        }
        if let (_, Some(last)) = good {
            let onward = line.goes_on(&self.shooting, self.branch.units, &last);
            return self.follow(line, last, onward).unwrap_or(why);
        }
        why
    }

    /// Passes a change of phases.
    fn pass(&mut self, change: Change) -> Option<Stop> {
        let described = self.described(&change);
        let point = SpecialPoint {
            parameter: described.parameter,
            uncertainty: described.uncertainty,
            behind: self.branch.points.len(),
            x: change.at.solution.anchor.x.clone(),
            period: change.at.solution.period,
            what: Special::Sequence(Box::new(described)),
        };
        let cycle = change.at.solution.clone();
        self.note_special(point, cycle, Vanishing::Margin(change.margin.clone()));
        if self.junction.is_some() {
            return Some(Stop::Points);
        }
        let Some((next, line)) = change.behind else {
            let way = (change.at.parameter - self.parameter()).signum() * self.branch.units.width;
            let beyond = |at: &Moment| Moment {
                t: at.t,
                x: with_parameter(at.x.clone(), change.at.parameter + BEYOND * way),
            };
            let mut starts = self.branch.last.begins.iter().map(beyond);
            let refused = starts.find_map(|start| self.refused(&start));
            return refused.or(Some(Stop::SequenceEnds));
        };
        if !self.is_in_range(&next) {
            return Some(Stop::Range);
        }
        // A fold may lie next to it.
        self.branch.step = BEHIND * self.settings.step;
        self.take(next);
        self.branch.line = Some(line);
        None
    }

    /// Continues from this orbit.
    pub(super) fn take(&mut self, next: Cycle) {
        self.branch.widest = self.branch.widest.max(next.extent);
        self.shooting.extent = self.branch.widest;
        self.branch.before = std::mem::replace(&mut self.branch.last, next);
        self.note();
    }

    /// Records a special orbit, and keeps it if it is the one at which to stop.
    pub(super) fn note_special(&mut self, at: SpecialPoint, cycle: Cycle, by: Vanishing) {
        self.branch.special.push(at.clone());
        match &mut self.wanted {
            Some((is_meant, number)) if is_meant(&at.what) => match number.checked_sub(1) {
                Some(less) => *number = less,
                None => {
                    self.wanted = None;
                    self.junction = Some(Junction { at, cycle, by });
                }
            },
            _ => {}
        }
    }

    fn note(&mut self) {
        let Moment { t, x } = self.branch.last.anchor.clone();
        self.branch.extents.push(self.branch.last.extent);
        self.branch.points.push(BranchPoint {
            parameter: parameter_of(&self.branch.last),
            t,
            x,
            period: self.branch.last.period,
            multipliers: critical(&self.branch.last, &self.shooting).multipliers,
            sequence: self.branch.last.outline.modes(),
        });
    }
}
