//! Curves of special orbits in two parameters.

use super::steps::{Continuation, Junction, SHORTEST_STEP};
use super::tangent_line::{TangentLine, Units};
use super::{
    ContinuationSettings, CycleBifurcation, SpecialPoint, check_start, critical, parameter_of,
};
use crate::analysis::critical::Critical;
use crate::analysis::cycle::{Cycle, Margin, MarginKind, Outline, Path, Shooting, unit};
use crate::dynamics::{AsDynamics, Components, Vector};
use crate::error::Error;
use crate::filippov::Options;

/// An orbit on a curve of special ones.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CurvePoint {
    /// The two parameters, which are the last two states; the branch parameter comes last.
    pub parameters: [f64; 2],
    /// A time and a state on the orbit.
    pub t: f64,
    /// See `t`.
    pub x: Vector,
    /// Period.
    pub period: f64,
}

/// Reason for the end of the continuation of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum CurveStop {
    /// A parameter has reached an end of its range.
    Range,
    /// The curve has as many points as requested.
    Points,
    /// Another change of the phases occurs at the same orbit behind the last point.
    AnotherChange,
    /// No further orbit could be computed within the shortest step behind the last one.
    NoConvergence,
}

/// A curve of special periodic orbits in two parameters.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Curve {
    /// The orbit at which it begins.
    pub at: SpecialPoint,
    /// The orbits, from one end of the curve to the other.
    pub points: Vec<CurvePoint>,
    /// Index of the orbit at which it began.
    pub first: usize,
    /// Reasons for the ends of the curve before the first and behind the last orbit.
    pub stops: [CurveStop; 2],
}

/// Follows in two parameters a special orbit of a branch of periodic orbits, by its number counted
/// from 0. It is a change of the phases, a fold, a flip or a Neimark–Sacker bifurcation.
///
/// **The parameters are the last two states.** The last is the branch parameter, as in
/// [`super::continue_periodic_orbit`]; the other is fixed on the branch and has the range `other`.
/// In the plane across the curve, orbits form a branch. The function that vanishes at the special
/// orbit has a zero on it, located as on any branch: a function of the multipliers or, at a change
/// of the phases, any of the margins. So curves pass their own folds, and curves of folds pass
/// cusps. Where two contacts switch at once, the phase between them keeps the duration zero.
///
/// # Errors
/// Those of [`super::continue_periodic_orbit`]; [`Error::NotFound`] where the branch has no such
/// orbit, or no curve continues from it: a branch point has none.
pub fn continue_change<Kind>(
    system: &impl AsDynamics<Kind>,
    x: impl Components,
    (period, upwards, number): (f64, bool, usize),
    (settings, other): (&ContinuationSettings, (f64, f64)),
    options: &Options,
) -> Result<Curve, Error> {
    settings.check()?;
    ContinuationSettings::over(other.0, other.1).check()?;
    let system = &*system.dynamics();
    let x = x.vector();
    check_start(&x, 2, settings)?;
    let place = x.len() - 2;
    let value = x[place];
    let by_other = unit(place + 1, place);
    let start = (x, period, upwards);
    let fixed = Some((&by_other, value));
    let mut continuation = Continuation::begin(system, start, settings, (fixed, options), None)?;
    let not_found = |what| Error::NotFound {
        what,
        t: 0.0,
        span: period,
    };
    let junction = continuation.seek(|_| true, number);
    let junction = junction.ok_or(not_found("a special orbit on the branch"))?;
    let condition = Condition::of(&junction);
    let condition = condition.ok_or(not_found("a curve of the special orbit"))?;
    let Junction { at, cycle, .. } = junction;
    let curve = CurveContinuation {
        shooting: continuation.shooting,
        units: Units {
            other: Some(other.1 - other.0),
            ..continuation.branch.units
        },
        settings,
        place,
        other,
    };
    let first = curve.solve(&condition, &cycle.outline, (&by_other, value));
    let (first, condition) = first.ok_or(not_found("an orbit to begin the curve with"))?;
    let follow = |sign: f64| curve.follow(&first, condition.clone(), sign);
    let ((mut points, before), (behind, after)) = (follow(-1.0), follow(1.0));
    points.reverse();
    let begun = points.len();
    points.push(point(&first));
    points.extend(behind);
    Ok(Curve {
        at,
        points,
        first: begun,
        stops: [before, after],
    })
}

fn point(cycle: &Cycle) -> CurvePoint {
    let x = &cycle.outline.begin.x;
    CurvePoint {
        parameters: [x[x.len() - 2], x[x.len() - 1]],
        t: cycle.anchor.t,
        x: cycle.anchor.x.clone(),
        period: cycle.period,
    }
}

/// A function that vanishes on a curve.
#[derive(Clone)]
enum TestFunction {
    /// A margin, whose position moves along the orbit.
    Margin(Box<Margin>),
    /// A function of the multipliers.
    Multipliers(fn(&Critical) -> Option<f64>),
}

impl TestFunction {
    fn value(&self, cycle: &Cycle, shooting: &Shooting<'_>) -> Option<f64> {
        match self {
            TestFunction::Margin(margin) => Some(cycle.margin_like(margin)?.value),
            TestFunction::Multipliers(function) => function(&critical(cycle, shooting)),
        }
    }

    /// The function near another orbit of the curve.
    fn near(self, cycle: &Cycle) -> Self {
        match self {
            TestFunction::Margin(margin) => {
                let near = cycle.margin_like(&margin).cloned();
                TestFunction::Margin(near.map_or(margin, Box::new))
            }
            of_multipliers => of_multipliers,
        }
    }
}

/// Condition that all orbits of a curve meet.
#[derive(Clone)]
enum Condition {
    /// A segment has no duration: two contacts switch at once.
    NoDuration(usize),
    /// A function vanishes. It was located on this line across the curve.
    Zero(TestFunction, TangentLine),
}

impl Condition {
    fn of(junction: &Junction) -> Option<Self> {
        let multipliers: fn(&Critical) -> Option<f64> = match (&junction.at.what, &junction.margin)
        {
            (CycleBifurcation::Sequence(_), Some(margin))
                if margin.kind == MarginKind::Duration =>
            {
                // Of one contact, a segment without duration determines nothing.
                margin.other?;
                return Some(Condition::NoDuration(margin.part));
            }
            (CycleBifurcation::Sequence(_), Some(margin)) => {
                let function = TestFunction::Margin(Box::new(margin.clone()));
                return Some(Condition::Zero(function, junction.line.clone()));
            }
            (CycleBifurcation::Fold, _) => |of| Some(of.one),
            (CycleBifurcation::Flip, _) => |of| Some(of.minus_one),
            (CycleBifurcation::NeimarkSacker { .. }, _) => |of| of.circle,
            (CycleBifurcation::BranchPoint | CycleBifurcation::Sequence(_), _) => return None,
        };
        let function = TestFunction::Multipliers(multipliers);
        Some(Condition::Zero(function, junction.line.clone()))
    }
}

/// One direction along a curve.
struct CurveContinuation<'a> {
    shooting: Shooting<'a>,
    units: Units,
    settings: &'a ContinuationSettings,
    /// The component of the other parameter, and its range.
    place: usize,
    other: (f64, f64),
}

impl CurveContinuation<'_> {
    /// The orbit of the curve near a guess, in a plane: on it, the product of the unknowns with a
    /// row has a given value. With the condition near that orbit.
    fn solve(
        &self,
        condition: &Condition,
        guess: &Outline,
        plane: (&Vector, f64),
    ) -> Option<(Cycle, Condition)> {
        match condition {
            Condition::NoDuration(number) => {
                let duration = guess.unit(guess.begin.x.len() + number);
                let shooting = Shooting {
                    plane: Some((&duration, 0.0)),
                    ..self.shooting
                };
                Some((shooting.solve(guess, Some(plane))?, condition.clone()))
            }
            Condition::Zero(function, line) => {
                let shooting = Shooting {
                    plane: Some(plane),
                    ..self.shooting
                };
                let value = |cycle: &Cycle| function.value(cycle, &shooting);
                let row = line.across();
                let begin = shooting.solve(guess, Some((row, row.dot(&guess.unknowns()))))?;
                let line = TangentLine::tangent(&shooting, self.units, &begin, row)?;
                let path = line.orbits(&shooting);
                let ends = path.bracket((0.0, value(&begin)?), self.settings.step, &value)?;
                let (s, found) = path.root(ends, &value)?;
                let function = function.clone().near(&found);
                let is_near = s.abs() <= self.settings.step;
                is_near.then_some((found, Condition::Zero(function, line)))
            }
        }
    }

    /// The line through the second of two orbits of the curve, in the direction from the first.
    fn secant(&self, from: &Outline, to: &Cycle) -> Option<TangentLine> {
        let direction = to.outline.unknowns() - from.unknowns();
        TangentLine::along(&self.shooting, self.units, to, direction)
    }

    /// The line on which the curve leaves its first orbit in one direction.
    fn first_line(&self, first: &Cycle, condition: &Condition, sign: f64) -> Option<TangentLine> {
        // Length of a first, short step by the other parameter, as a fraction of the longest one.
        // Chosen: over it the curve is straight, and the orbits differ by more than rounding.
        const FIRST_STEP: f64 = 1e-2;
        let row = first.outline.unit(self.place);
        let short = sign * FIRST_STEP * self.settings.step * (self.other.1 - self.other.0);
        let there = first.outline.unknowns() + &row * short;
        let guess = first.outline.with(&there);
        let (next, _) = self.solve(condition, &guess, (&row, row.dot(&there)))?;
        let direction = next.outline.unknowns() - first.outline.unknowns();
        TangentLine::along(&self.shooting, self.units, first, direction)
    }

    fn follow(
        &self,
        first: &Cycle,
        mut condition: Condition,
        sign: f64,
    ) -> (Vec<CurvePoint>, CurveStop) {
        let mut points = Vec::new();
        let Some(mut line) = self.first_line(first, &condition, sign) else {
            return (points, CurveStop::NoConvergence);
        };
        // Ratio of a step to the one before, in which no orbit was found. Chosen, as for branches.
        const SHORTER: f64 = 0.3;
        let mut step = self.settings.step;
        loop {
            if 2 * points.len() >= self.settings.most_points {
                return (points, CurveStop::Points);
            }
            if step < SHORTEST_STEP {
                let stop = match line.vanishing(step / SHORTER).is_empty() {
                    true => CurveStop::NoConvergence,
                    false => CurveStop::AnotherChange,
                };
                return (points, stop);
            }
            let found = line.plane(&self.shooting, step).and_then(|(guess, value)| {
                let (next, moved) = self.solve(&condition, &guess, (line.across(), value))?;
                let onward = self.secant(&line.from, &next)?;
                line.bends_little(&onward).then_some((next, moved, onward))
            });
            let Some((next, moved, onward)) = found else {
                step *= SHORTER;
                continue;
            };
            if let Some(end) = self.at_end(&condition, &line, step, &next) {
                points.extend(end.as_ref().map(point));
                return (points, CurveStop::Range);
            }
            if !self.shooting.is_valid(&next) {
                if step > self.settings.step * 1e-3 {
                    step *= SHORTER;
                    continue;
                }
                return (points, CurveStop::AnotherChange);
            }
            points.push(point(&next));
            condition = moved;
            let longer = if next.iterations <= 5 { 1.4 } else { 1.0 };
            step = (longer * step).min(self.settings.step);
            line = onward;
        }
    }

    /// The orbit at the end of a range, if the given orbit lies beyond it.
    fn at_end(
        &self,
        condition: &Condition,
        line: &TangentLine,
        step: f64,
        next: &Cycle,
    ) -> Option<Option<Cycle>> {
        let n = next.outline.begin.x.len();
        let own = (n - 1, parameter_of(next), self.settings.range);
        let other = (self.place, next.outline.begin.x[self.place], self.other);
        let is_beyond =
            |&(_, value, (low, high)): &(usize, f64, (f64, f64))| !(low..=high).contains(&value);
        let (place, value, (low, high)) = [own, other].into_iter().find(is_beyond)?;
        let end = value.clamp(low, high);
        let before = line.from.begin.x[place];
        let guess = line.guess(step * (end - before) / (value - before));
        let row = guess.unit(place);
        let found = self.solve(condition, &guess, (&row, end));
        Some(found.map(|(cycle, _)| cycle))
    }
}
