//! Changes of the phases along a branch: where they are, by which margin, and the orbits behind
//! them.

use super::line::Line;
use super::parameter_of;
use super::walk::{BEHIND, Walk};
use crate::analysis::cycle::{
    Cycle, Margin, MarginKind, Outline, Path, SequenceChange, Shooting, Zero, describe,
};
use crate::dynamics::{Happening, Moment, Section, Vector};
use crate::filippov::Direction;

/// A located change.
pub(super) struct Change {
    /// The orbit at the change.
    pub at: Zero,
    /// The margin that vanishes there.
    pub margin: Margin,
    /// The orbits behind it: the first of them, and the line on which they continue.
    pub behind: Option<(Cycle, Line)>,
}

/// Distance beyond a change at which orbits are sought, as a fraction of a step.
pub(super) const BEYOND: f64 = 1e-3;

/// Segments may vanish together if their durations would vanish within this multiple of the
/// distance to the first that does.
const AT_ONCE: f64 = 4.0;

/// A segment that begins at a change is shorter than this fraction of the longest.
const SHORT: f64 = 0.2;

/// An orbit has returned if it is within this fraction of its extent.
const NEAR: f64 = 0.1;

/// Number of periods within which it returns.
const MOST_PERIODS: f64 = 3.0;

impl Walk<'_> {
    /// The first margin that is below zero at an orbit on the line, and where; `Err` where the step
    /// is too long to decide.
    pub(super) fn passed(&self, line: &Line, next: &Cycle) -> Result<Option<Change>, ()> {
        // On a shorter step orbits differ by one change: a margin that the last one lacks has no
        // cause before the first zero.
        const NEAREST: f64 = 1e-5;
        let (last, length) = (&self.branch.last, line.place(next));
        let mut first: Option<(Zero, Margin)> = None;
        let mut is_unclear = false;
        let violated = next.margins.iter();
        for margin in violated.filter(|margin| self.shooting.is_violated(margin)) {
            let Some(before) = last.margin_like(margin) else {
                is_unclear = true;
                continue;
            };
            let zero = if before.value <= 0.0 {
                // The last orbit is at the change, to within its error.
                let slope = (margin.value - before.value) / length;
                Zero {
                    s: 0.0,
                    parameter: parameter_of(last),
                    solution: last.clone(),
                    uncertainty: (line.heading() * before.value / slope).abs(),
                }
            } else {
                let value = |one: &Cycle| Some(one.margin_like(margin)?.value);
                let ends = [(0.0, before.value), (length, margin.value)];
                self.zero(line, ends, &value).ok_or(())?
            };
            let margin = zero.solution.margin_like(margin).ok_or(())?.clone();
            if first.as_ref().is_none_or(|(first, _)| zero.s < first.s) {
                first = Some((zero, margin));
            }
        }
        // Another one may come first, if the step is not short enough to decide.
        if is_unclear && (first.is_none() || length > NEAREST) {
            return Err(());
        }
        Ok(first.map(|(at, margin)| {
            // Near the graze of a jump, orbits with that jump have unbounded derivatives.
            let ends = margin.is_of_jump;
            let behind = (!ends).then(|| self.behind(line, &at, length)).flatten();
            Change { at, margin, behind }
        }))
    }

    /// The orbits behind a change, in the sequence that the system itself takes from the orbit
    /// slightly beyond it.
    fn behind(&self, line: &Line, at: &Zero, step: f64) -> Option<(Cycle, Line)> {
        let beyond = line.on(&self.shooting, at.s + BEYOND * step)?;
        let outline = self.run_through(&beyond)?;
        let is_other = outline.modes() != self.branch.last.outline.modes();
        is_other
            .then(|| self.enter(&outline, parameter_of(&at.solution)))
            .flatten()
    }

    /// An orbit with a new sequence near an outline, and the line on which it leaves the change.
    /// Along the line the shortest segment grows, or else the parameter advances.
    fn enter(&self, outline: &Outline, change: f64) -> Option<(Cycle, Line)> {
        let n = outline.begin.x.len();
        let durations = || outline.segments.iter().map(|one| one.duration);
        let longest = durations().fold(0.0, f64::max);
        // Of the new segments, if there are any.
        let known = &self.branch.last.outline.segments;
        let is_new = |k: usize| !known.iter().any(|one| one.mode == outline.segments[k].mode);
        let any_new = (0..outline.segments.len()).any(is_new);
        let may_grow = durations()
            .enumerate()
            .filter(|(k, _)| !any_new || is_new(*k));
        let shortest = may_grow.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let by_duration = (shortest.1 < SHORT * longest).then(|| outline.unit(n + shortest.0));
        let by_parameter = outline.unit(n - 1);
        let rows = by_duration.into_iter().chain([by_parameter.clone()]);
        rows.into_iter().find_map(|row| {
            let value = row.dot(&outline.unknowns());
            let found = self.shooting.solve(outline, Some((&row, value)))?;
            let way = parameter_of(&found) - change;
            let is_near = way.abs() <= NEAR * self.branch.units.width;
            let row = if row == by_parameter { row * way } else { row };
            let line = Line::tangent(&self.shooting, self.branch.units, &found, &row)?;
            (is_near && self.shooting.is_valid(&found)).then_some((found, line))
        })
    }

    /// The system's own orbit for one period, from a start that is not on a periodic orbit.
    fn run_through(&self, orbit: &Cycle) -> Option<Outline> {
        let (system, options) = (self.shooting.system, self.shooting.options);
        let start = &orbit.anchor;
        let period = match self.shooting.forced {
            Some(period) => period,
            None => self.comes_back(start, orbit).unwrap_or(orbit.period),
        };
        Outline::of_run(system, start, period, options).ok()
    }

    /// The time at which an orbit first returns near one of its states.
    fn comes_back(&self, from: &Moment, orbit: &Cycle) -> Option<f64> {
        let (system, options) = (self.shooting.system, self.shooting.options);
        let mode = system.begin(from, from.t + orbit.period, options, &Section::None);
        let section = Section::Plane {
            point: from.x.clone(),
            normal: system.flow(mode.ok()?.mode(), from).velocity(from),
            direction: Direction::Rising,
        };
        let t_end = from.t + MOST_PERIODS * orbit.period;
        let mut run = system.begin(from, t_end, options, &section).ok()?;
        loop {
            match run.step().ok()? {
                Happening::Passage(at) if (&at.x - &from.x).norm() <= NEAR * orbit.extent => {
                    return Some(at.t - from.t);
                }
                Happening::End(_) => return None,
                _ => {}
            }
        }
    }

    /// The change at which the durations of segments vanish, of the first at a place on the line.
    pub(super) fn vanishes(&self, line: &Line, place: f64) -> Option<Change> {
        let numbers = line.vanishing(AT_ONCE * place);
        let numbers: Vec<usize> = numbers.into_iter().map(|(k, _)| k).collect();
        let first = &numbers[..1];
        let several = (numbers.len() > 1).then(|| self.vanishes_without(&numbers, place));
        several
            .flatten()
            .or_else(|| self.vanishes_without(first, place))
            .or_else(|| self.coincides(line, &numbers, place))
    }

    /// The change at which some segments vanish, near a place.
    fn vanishes_without(&self, numbers: &[usize], place: f64) -> Option<Change> {
        let outline = &self.branch.last.outline;
        let simple = outline.without(numbers, &self.branch.last.begins)?;
        let n = outline.begin.x.len();
        let row = simple.unit(n - 1);
        let value = row.dot(&simple.unknowns());
        let first = self.shooting.solve(&simple, Some((&row, value)))?;
        // In a family, the margin is zero at any parameter.
        if first.family > self.shooting.family {
            return None;
        }
        let line = Line::tangent(&self.shooting, self.branch.units, &first, &row)?;
        let margin = first.margin_about(&self.branch.last, numbers)?;
        let (at, slope) = self.zero_near(&line, margin, place)?;
        let margin = at.solution.margin_like(margin)?.clone();
        let (sign, units) = (slope.signum(), self.branch.units);
        let row = line.across() * sign;
        let tangent = Line::tangent(&self.shooting, units, &at.solution, &row)?;
        // Where a multiplier is 1 at the change, the equations leave the tangent undetermined.
        let straight = Line::along(&self.shooting, units, &at.solution, &line.direction * sign);
        let lines = [Some(&tangent), straight.as_ref()];
        let behind = lines.into_iter().flatten().find(|one| self.leads_on(one));
        let behind = behind.unwrap_or(&tangent).clone();
        let cycle = at.solution.clone();
        Some(Change {
            at,
            margin,
            behind: Some((cycle, behind)),
        })
    }

    /// Whether the branch has nearly the direction of a line one short step farther.
    fn leads_on(&self, line: &Line) -> bool {
        let next = line.on(&self.shooting, BEHIND * self.settings.step);
        let onward = next.and_then(|next| line.goes_on(&self.shooting, self.branch.units, &next));
        onward.is_some_and(|onward| line.bends_little(&onward))
    }

    /// The change at the last orbit, of which a segment has all but vanished, if no orbit without
    /// it could be computed.
    pub(super) fn vanished(&self, line: &Line, place: f64) -> Option<Change> {
        let (number, _) = *line.vanishing(place).first()?;
        let last = &self.branch.last;
        let margin = duration(last, number)?;
        let row = last.outline.unit(last.outline.begin.x.len() + number);
        let by_tolerance = self.by_tolerance(last, &last.outline, (&row, margin.value));
        let ahead = line.heading() * place;
        let at = Zero {
            s: 0.0,
            parameter: self.parameter() + ahead,
            solution: last.clone(),
            uncertainty: ahead.abs() + by_tolerance,
        };
        let behind = None;
        Some(Change { at, margin, behind })
    }

    /// Error of an orbit's parameter due to the tolerances, with the product of the unknowns with a
    /// row held fixed: twice the change caused by a tenth of them.
    fn by_tolerance(&self, orbit: &Cycle, guess: &Outline, row: (&Vector, f64)) -> f64 {
        const SAFE: f64 = 2.0;
        let finer = Shooting {
            options: &self.shooting.options.finer(),
            ..self.shooting
        };
        let finer = finer.solve(guess, Some(row));
        finer.map_or(f64::NAN, |finer| {
            SAFE * (parameter_of(&finer) - parameter_of(orbit)).abs()
        })
    }

    /// The zero of a margin near the beginning of a line, and the sign of its slope there.
    fn zero_near(&self, line: &Line, margin: &Margin, step: f64) -> Option<(Zero, f64)> {
        let value = |one: &Cycle| Some(one.margin_like(margin)?.value);
        let path = line.orbits(&self.shooting);
        let [a, b] = path.bracket((0.0, margin.value), step, &value)?;
        let slope = (b.1 - a.1) / (b.0 - a.0);
        Some((self.zero(line, [a, b], &value)?, slope))
    }

    /// The change at which two contacts switch in the same instant.
    fn coincides(&self, line: &Line, numbers: &[usize], place: f64) -> Option<Change> {
        let &number = numbers.first()?;
        let mut guess = line.guess(place);
        guess.segments[number].duration = 0.0;
        let n = guess.begin.x.len();
        let row = guess.unit(n + number);
        let cycle = self.shooting.solve(&guess, Some((&row, 0.0)))?;
        let margin = duration(&cycle, number)?;
        let lasts = 0.1 * self.branch.last.outline.segments[number].duration;
        let mut numbers = numbers.iter();
        let swapped = numbers.try_fold(cycle.outline.clone(), |outline, &number| {
            outline.swapped(number, lasts)
        })?;
        let parameter = parameter_of(&cycle);
        let uncertainty = self.by_tolerance(&cycle, &guess, (&row, 0.0));
        let behind = self.enter(&swapped, parameter);
        let at = Zero {
            s: line.place(&cycle),
            parameter,
            solution: cycle,
            uncertainty,
        };
        Some(Change { at, margin, behind })
    }

    /// Describes a change.
    pub(super) fn described(&self, change: &Change) -> SequenceChange {
        let Change { at, margin, behind } = change;
        let parameter = at.parameter;
        let after = behind.as_ref();
        let after = after.map_or(Vec::new(), |(cycle, _)| cycle.outline.modes());
        describe(
            self.shooting.system,
            (&at.solution, margin),
            (parameter, self.at_least(parameter, at.uncertainty)),
            [self.branch.last.outline.modes(), after],
        )
    }
}

/// The margin of a segment's duration.
fn duration(cycle: &Cycle, number: usize) -> Option<Margin> {
    let is_meant = |margin: &&Margin| margin.kind == MarginKind::Duration && margin.part == number;
    cycle.margins.iter().find(is_meant).cloned()
}
