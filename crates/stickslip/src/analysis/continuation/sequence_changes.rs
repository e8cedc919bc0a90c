//! Changes of the phases along a branch: where they are, which margin vanishes, and the orbits
//! behind them.

use super::stepping::StepOutcome;
use super::steps::{Continuation, RESOLUTION};
use super::tangent_line::TangentLine;
use super::{CycleBifurcation, Stop, parameter_of, with_parameter};
use crate::analysis::cycle::{
    Cycle, LocatedZero, Margin, MarginKind, OrbitGuess, SAFETY, Shooting, SolutionsOnLine, describe,
};
use crate::analysis::passages::passages;
use crate::dynamics::{Moment, Vector};

/// A change of the phases.
pub(super) struct Change {
    /// The orbit at the change.
    pub at: LocatedZero,
    /// The line on which it was located.
    line: TangentLine,
    /// The margin that vanishes there.
    margin: Margin,
    /// The first orbit behind it, and the line on which the branch goes on from there.
    behind: Option<(Cycle, TangentLine)>,
}

/// Distance beyond a change at which the orbit behind it is sought, as a fraction of a step.
/// Chosen: nearer, rounding decides the phases; farther, the next change may lie before it.
pub(super) const STEP_BEYOND: f64 = 1e-3;

/// First step behind a change of the phases, as a fraction of the longest one. Chosen: a fold is
/// often next to the change, and later steps grow by 1.4 each.
const FIRST_BEHIND_CHANGE: f64 = 0.02;

/// Segments may vanish at once if, by their tangents, they vanish within this multiple of the
/// distance to the first. Chosen: tangents predict the distance to a factor of two or so, since
/// durations may vanish like a square root.
const AT_ONCE: f64 = 4.0;

/// Longest segment that may have begun at the change, as a fraction of the longest one. Chosen: at
/// [`STEP_BEYOND`] it is far shorter.
const NEW_SEGMENT: f64 = 0.2;

/// Distance at which an orbit has returned, as a fraction of its extent; and how far behind the
/// change the next orbit may be, as a fraction of the range. Chosen: unrelated orbits are farther.
const NEAR: f64 = 0.1;

/// Number of periods within which it returns: one, or two behind a flip, and some more.
const MOST_PERIODS: f64 = 3.0;

impl Continuation<'_> {
    /// The first change of the phases before an orbit on the line; `Err` where the step is too long
    /// to decide.
    pub(super) fn change_before(
        &self,
        line: &TangentLine,
        next: &Cycle,
    ) -> Result<Option<Change>, ()> {
        // In a shorter step there is one change: the margins that the last orbit lacks appear
        // behind the first zero. Chosen: far above the shortest step.
        const DECISIVE_STEP: f64 = 1e-5;
        let (last, length) = (&self.branch.last, line.place(next));
        let options = self.shooting.options;
        let mut first: Option<(LocatedZero, Margin)> = None;
        let mut is_undecided = false;
        let violated = next.margins.iter();
        for margin in violated.filter(|margin| margin.is_violated(options)) {
            // Such an orbit is another solution. It does not continue the orbits before the change.
            if next.repeats_event(options) {
                return Err(());
            }
            let Some(before) = last.margin_like(margin) else {
                is_undecided = true;
                continue;
            };
            let zero = if before.value <= 0.0 {
                // The last orbit is at the change, to within its error.
                let slope = (margin.value - before.value) / length;
                LocatedZero {
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
        // A change without a margin at the last orbit may come first.
        if is_undecided && (first.is_none() || length > DECISIVE_STEP) {
            return Err(());
        }
        Ok(first.map(|(at, margin)| {
            // Next to the graze of a jump, orbits with that jump have unbounded derivatives.
            let behind = (!margin.is_of_jump).then(|| self.behind(line, &at, length));
            let behind = behind.flatten();
            Change {
                at,
                line: line.clone(),
                margin,
                behind,
            }
        }))
    }

    /// The orbit behind a change, with the phases that the system itself takes from an orbit
    /// slightly beyond it.
    fn behind(
        &self,
        line: &TangentLine,
        at: &LocatedZero,
        step: f64,
    ) -> Option<(Cycle, TangentLine)> {
        // Where a multiplier is 1 at the change, orbits this near are not determined well enough.
        let mut steps = [1.0, 10.0, 100.0]
            .map(|times| times * STEP_BEYOND * step)
            .into_iter();
        steps.find_map(|step| {
            let beyond = line.on(&self.shooting, at.s + step)?;
            let outline = self.run_from(&beyond)?;
            let phases = |one: &OrbitGuess| (one.modes(), one.kinks());
            (phases(&outline) != phases(&self.branch.last.outline))
                .then(|| self.enter(&outline, at.parameter))
                .flatten()
        })
    }

    /// The orbit near an outline with other phases, and the line on which the branch goes on from
    /// it. Along the line the shortest segment grows, or else the parameter moves away from the
    /// change.
    fn enter(&self, outline: &OrbitGuess, change: f64) -> Option<(Cycle, TangentLine)> {
        let n = outline.begin.x.len();
        let durations = || outline.segments.iter().map(|one| one.duration);
        let longest = durations().fold(0.0, f64::max);
        // The shortest of the new segments, if there are any: where fewer are left, one has ended.
        let old = &self.branch.last.outline.segments;
        let is_new = |k: usize| !old.iter().any(|one| one.mode == outline.segments[k].mode);
        let any_new = (0..outline.segments.len()).any(is_new);
        let is_fewer = outline.segments.len() < old.len();
        let may_grow = durations()
            .enumerate()
            .filter(|(k, lasts)| match any_new {
                true => is_new(*k),
                false => !is_fewer,
            } && *lasts < NEW_SEGMENT * longest);
        let shortest = may_grow.min_by(|a, b| a.1.total_cmp(&b.1));
        let by_duration = shortest.map(|(k, _)| outline.unit(n + k));
        let by_parameter = outline.unit(n - 1);
        let rows = by_duration.into_iter().chain([by_parameter.clone()]);
        rows.into_iter().find_map(|row| {
            let value = row.dot(&outline.unknowns());
            let cycle = self.shooting.solve(outline, Some((&row, value)))?;
            let distance = parameter_of(&cycle) - change;
            let is_near = distance.abs() <= NEAR * self.branch.units.width;
            let row = if row == by_parameter {
                row * distance
            } else {
                row
            };
            let line = TangentLine::tangent(&self.shooting, &self.branch.units, &cycle, &row)?;
            let is_valid = cycle.is_differentiable() && self.shooting.is_valid(&cycle);
            (is_near && is_valid).then_some((cycle, line))
        })
    }

    /// The system's own orbit over one period, from a state that need not be on a periodic orbit.
    fn run_from(&self, orbit: &Cycle) -> Option<OrbitGuess> {
        let (system, options) = (self.shooting.system, self.shooting.options);
        let start = &orbit.anchor;
        let period = match self.shooting.prescribed(&start.x) {
            Some((period, _)) => period,
            None => self.return_time(start, orbit).unwrap_or(orbit.period),
        };
        OrbitGuess::of_run(system, start, period, options).ok()
    }

    /// The time after which an orbit first returns to near one of its states.
    fn return_time(&self, from: &Moment, orbit: &Cycle) -> Option<f64> {
        let (system, options) = (self.shooting.system, self.shooting.options);
        let span = MOST_PERIODS * orbit.period;
        let is_near = |at: &Moment| (&at.x - &from.x).norm() <= NEAR * orbit.extent;
        let passages = passages(system, (from, span), from, options, is_near).ok()?;
        let nearby = passages.last().filter(|at| is_near(at))?;
        Some(nearby.t - from.t)
    }

    /// The change at which segments vanish, the first of them at a place on the line.
    pub(super) fn vanishing_segments(&self, line: &TangentLine, place: f64) -> Option<Change> {
        let numbers = line.vanishing(AT_ONCE * place);
        let numbers: Vec<usize> = numbers.into_iter().map(|(k, _)| k).collect();
        let first = &numbers[..1];
        let several = (numbers.len() > 1).then(|| self.change_without(&numbers, place));
        several
            .flatten()
            .or_else(|| self.change_without(first, place))
            .or_else(|| self.coincidence(line, &numbers, place))
    }

    /// The change at which some segments vanish: the zero of a margin of orbits without them, near
    /// a place.
    fn change_without(&self, numbers: &[usize], place: f64) -> Option<Change> {
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
        let line = TangentLine::tangent(&self.shooting, &self.branch.units, &first, &row)?;
        let margin = first.margin_near(&self.branch.last, numbers)?;
        let (at, slope) = self.zero_near(&line, margin, place)?;
        if !at.solution.is_differentiable() {
            return None;
        }
        let margin = at.solution.margin_like(margin)?.clone();
        let (sign, units) = (slope.signum(), &self.branch.units);
        let row = line.across() * sign;
        let tangent = TangentLine::tangent(&self.shooting, units, &at.solution, &row)?;
        // Where a multiplier is 1 at the change, the equations leave the tangent undetermined.
        let direction = &line.direction * sign;
        let straight = TangentLine::along(&self.shooting, units, &at.solution, direction);
        let lines = [Some(&tangent), straight.as_ref()];
        let behind = lines.into_iter().flatten().find(|one| self.leads_on(one));
        let behind = behind.unwrap_or(&tangent).clone();
        let cycle = at.solution.clone();
        Some(Change {
            at,
            line,
            margin,
            behind: Some((cycle, behind)),
        })
    }

    /// Whether the branch has nearly the direction of a line one short step farther.
    fn leads_on(&self, line: &TangentLine) -> bool {
        let next = line.on(&self.shooting, FIRST_BEHIND_CHANGE * self.settings.step);
        let onward =
            next.and_then(|next| line.continued(&self.shooting, &self.branch.units, &next));
        onward.is_some_and(|onward| line.bends_little(&onward))
    }

    /// The change at the last orbit where a segment of it has all but vanished, for when no orbit
    /// without it could be computed.
    pub(super) fn vanished_segment(&self, line: &TangentLine, place: f64) -> Option<Change> {
        // Part of the period. Chosen: a duration that vanishes like a root is far shorter within
        // the shortest step. A long one has an infinite rate where another change is.
        const SHORT: f64 = 1e-2;
        let (number, _) = *line.vanishing(place).first()?;
        let last = &self.branch.last;
        let margin = duration(last, number).filter(|margin| margin.relative() <= SHORT)?;
        let row = last.outline.unit(last.outline.begin.x.len() + number);
        let of_steps = self.error_of_steps(last, &last.outline, (&row, margin.value));
        let ahead = line.heading() * place;
        let at = LocatedZero {
            s: 0.0,
            parameter: self.parameter() + ahead,
            solution: last.clone(),
            uncertainty: ahead.abs() + of_steps,
        };
        Some(Change {
            at,
            line: line.clone(),
            margin,
            behind: None,
        })
    }

    /// The change within a step that leads to no orbit, by a jump. Along the last two orbits the
    /// speed of its arrival vanishes there, or the lead in one of its comparisons. Behind it the
    /// jump may have no map, as at a stop that nothing approaches, or another one.
    pub(super) fn vanishing_at_jump(&self, step: f64) -> Option<Change> {
        let (line, [before, last]) = (
            self.branch.line.as_ref()?,
            [&self.branch.before, &self.branch.last],
        );
        if before.outline.modes() != last.outline.modes() {
            return None;
        }
        let gone = -line.place(before);
        let of_jumps = last.margins.iter();
        let ends = |kind| matches!(kind, MarginKind::Arrival | MarginKind::Choice(_));
        let of_jumps = of_jumps.filter(|margin| margin.is_of_jump && ends(margin.kind));
        let places = of_jumps.filter_map(|margin| {
            let before = before.margin_like(margin)?.value;
            Some((line.heading() * gone / (before - margin.value), margin))
        });
        let is_within = |rate: f64, margin: &Margin| {
            (0.0..=step).contains(&(margin.value * rate / line.heading()))
        };
        let places = places.filter(|(rate, margin)| is_within(*rate, margin));
        let ahead = |(rate, margin): &(f64, &Margin)| (margin.value * rate).abs();
        let (rate, margin) = places.min_by(|a, b| ahead(a).total_cmp(&ahead(b)))?;
        let row = last.outline.unit(self.place());
        let finer = (self.shooting.finer()).solve(&last.outline, Some((&row, self.parameter())));
        let finer = finer.and_then(|finer| Some(finer.margin_like(margin)?.value));
        let of_steps = finer.map_or(f64::NAN, |finer| SAFETY * (finer - margin.value).abs());
        let at = LocatedZero {
            s: 0.0,
            parameter: self.parameter() + margin.value * rate,
            solution: last.clone(),
            uncertainty: (margin.value.abs() + of_steps) * rate.abs(),
        };
        Some(Change {
            at,
            line: line.clone(),
            margin: margin.clone(),
            behind: None,
        })
    }

    /// The change within a step that leads to no orbit, if impacts that accumulate before a phase
    /// at rest do so ever later, until that phase would end before.
    ///
    /// The duration of the phase vanishes like a power of the distance, with ever more impacts:
    /// each takes the same part of the time that is left. So the place is the last one with such
    /// an orbit.
    pub(super) fn late_landing(&self, step: f64) -> Option<Change> {
        let (line, last) = (self.branch.line.as_ref()?, &self.branch.last);
        let part = self.shooting.never_landing(&line.guess(step))?;
        let is_its = |margin: &&Margin| margin.kind == MarginKind::Rest && margin.part == part;
        let margin = last.margins.iter().find(is_its)?;
        let edge = |shooting: &Shooting<'_>| {
            let (mut good, mut bad) = (-step, 2.0 * step);
            while bad - good > RESOLUTION {
                let middle = 0.5 * (good + bad);
                match line.on(shooting, middle) {
                    Some(_) => good = middle,
                    None => bad = middle,
                }
            }
            (good, bad)
        };
        let (good, bad) = edge(&self.shooting);
        let (good_finer, _) = edge(&self.shooting.finer());
        let of_steps = SAFETY * (good_finer - good).abs();
        let solution = line.on(&self.shooting, good)?;
        let at = LocatedZero {
            s: good,
            parameter: parameter_of(&solution),
            uncertainty: (bad - good + of_steps) * line.heading().abs(),
            solution,
        };
        Some(Change {
            margin: at.solution.margin_like(margin)?.clone(),
            at,
            line: line.clone(),
            behind: None,
        })
    }

    /// Error of integration of an orbit's parameter, where the product of the unknowns with a row
    /// has a given value.
    fn error_of_steps(&self, orbit: &Cycle, guess: &OrbitGuess, row: (&Vector, f64)) -> f64 {
        let finer = self.shooting.finer().solve(guess, Some(row));
        finer.map_or(f64::NAN, |finer| {
            SAFETY * (parameter_of(&finer) - parameter_of(orbit)).abs()
        })
    }

    /// The zero of a margin near the beginning of a line, and the sign of its slope there.
    fn zero_near(
        &self,
        line: &TangentLine,
        margin: &Margin,
        step: f64,
    ) -> Option<(LocatedZero, f64)> {
        let value = |one: &Cycle| Some(one.margin_like(margin)?.value);
        let path = line.orbits(&self.shooting);
        let [a, b] = path.bracket((0.0, margin.value), step, &value)?;
        let slope = (b.1 - a.1) / (b.0 - a.0);
        Some((self.zero(line, [a, b], &value)?, slope))
    }

    /// The change at which two contacts switch in the same instant.
    fn coincidence(&self, line: &TangentLine, numbers: &[usize], place: f64) -> Option<Change> {
        let &number = numbers.first()?;
        let mut guess = line.guess(place);
        guess.segments[number].duration = 0.0;
        let n = guess.begin.x.len();
        let row = guess.unit(n + number);
        let cycle = self.shooting.solve(&guess, Some((&row, 0.0)))?;
        let margin = duration(&cycle, number)?;
        let duration_behind = 0.1 * self.branch.last.outline.segments[number].duration;
        let mut numbers = numbers.iter();
        let swapped = numbers.try_fold(cycle.outline.clone(), |outline, &number| {
            outline.swapped(number, duration_behind)
        })?;
        let parameter = parameter_of(&cycle);
        let uncertainty = self.error_of_steps(&cycle, &guess, (&row, 0.0));
        let behind = self.enter(&swapped, parameter);
        let at = LocatedZero {
            s: line.place(&cycle),
            parameter,
            solution: cycle,
            uncertainty,
        };
        Some(Change {
            at,
            line: line.clone(),
            margin,
            behind,
        })
    }

    /// Records a change of the phases and continues behind it.
    pub(super) fn pass_change(&mut self, change: Change) -> StepOutcome<Stop> {
        let Change {
            at,
            line,
            margin,
            behind,
        } = change;
        let parameter = at.parameter;
        let after = behind.as_ref();
        let after = after.map_or(Vec::new(), |(cycle, _)| cycle.outline.modes());
        let described = describe(
            self.shooting.system,
            (&at.solution, &margin),
            (parameter, self.with_last_digits(parameter, at.uncertainty)),
            [self.branch.last.outline.modes(), after],
        );
        let what = CycleBifurcation::Sequence(Box::new(described));
        self.record_special(what, at, line, Some(margin));
        if self.junction.is_some() {
            return StepOutcome::End(Stop::Points);
        }
        let Some((next, line)) = behind else {
            let offset = (parameter - self.parameter()).signum() * self.branch.units.width;
            let beyond = |at: &Moment| {
                let x = with_parameter(at.x.clone(), parameter + STEP_BEYOND * offset);
                self.shooting.system.admitted(&Moment { t: at.t, x })
            };
            let mut starts = self.branch.last.begins.iter().map(beyond);
            let refused = starts.find_map(|start| self.refused(&start));
            return StepOutcome::End(refused.unwrap_or(Stop::SequenceEnds));
        };
        if !self.is_in_range(&next) {
            return StepOutcome::End(Stop::Range);
        }
        // A fold may lie next to it.
        self.branch.step = FIRST_BEHIND_CHANGE * self.settings.step;
        self.take(next);
        self.branch.line = Some(line);
        StepOutcome::Elsewhere
    }
}

/// The margin that is the duration of a segment.
fn duration(cycle: &Cycle, number: usize) -> Option<Margin> {
    let is_its = |margin: &&Margin| margin.kind == MarginKind::Duration && margin.part == number;
    cycle.margins.iter().find(is_its).cloned()
}
