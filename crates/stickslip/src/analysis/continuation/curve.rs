//! Curves of special orbits in two parameters.

use std::ops::ControlFlow;

use super::line::{Line, Units};
use super::walk::{Junction, SHORTEST, Vanishing, Walk};
use super::{ContinuationSettings, Special, SpecialPoint, check_start, critical, parameter_of};
use crate::analysis::critical::Critical;
use crate::analysis::cycle::{Cycle, Extra, Margin, Outline, Path, Shooting};
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

/// Why the continuation of a curve stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum CurveStop {
    /// One of the parameters has reached an end of its range.
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
    /// Why the curve ends before the first and behind the last orbit.
    pub stops: [CurveStop; 2],
}

/// Follows in two parameters a special orbit of a branch of periodic orbits, by its number counted
/// from 0. It is a change of the phases, a fold, a flip or a Neimark–Sacker bifurcation.
///
/// **The parameters are the last two states.** The last is the branch parameter, as in
/// [`super::continue_periodic_orbit`]; the other is fixed on the branch and has the range `other`.
/// At a change of the phases, the vanishing margin is added to the equations, with its gradient
/// from dual numbers (Thota & Dankowicz 2008). A function of the multipliers vanishes at one orbit
/// of the branch in the plane across the curve; it is located as on any branch. So curves pass
/// their own folds, and curves of folds pass cusps.
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
    let by_other = Vector::from_fn(place + 1, |i, _| f64::from(u8::from(i == place)));
    let fixed = Extra::Plane(&by_other, value);
    let start = (x, period, upwards);
    let mut walk = Walk::begin(system, start, settings, (fixed, options))?;
    walk.wanted = Some((|_| true, number));
    walk.go_on(&mut |_| ControlFlow::Continue(()));
    let not_found = |what| Error::NotFound {
        what,
        t: 0.0,
        span: period,
    };
    let junction = walk.junction.take();
    let Junction { at, cycle, by } = junction.ok_or(not_found("a special orbit on the branch"))?;
    let condition = Condition::of(&at.what, by);
    let condition = condition.ok_or(not_found("a curve through the branch point"))?;
    let way = CurveWalk {
        shooting: walk.shooting,
        units: Units {
            other: Some(other.1 - other.0),
            ..walk.branch.units
        },
        settings,
        place,
        other,
    };
    let first = way.solve(&condition, &cycle.outline, (&by_other, value));
    let (first, condition) = first.ok_or(not_found("an orbit to begin the curve with"))?;
    let follow = |sign: f64| way.follow(&first, condition.clone(), sign);
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

/// The function that vanishes on a curve.
#[derive(Clone)]
enum Condition {
    /// A margin, whose position moves along the orbit.
    Margin(Margin),
    /// A function of the multipliers, and the line across the curve on which it was located.
    Multiplier(fn(&Critical) -> Option<f64>, Line),
}

impl Condition {
    fn of(what: &Special, by: Vanishing) -> Option<Self> {
        let line = match by {
            Vanishing::Margin(margin) => return Some(Condition::Margin(margin)),
            Vanishing::Multiplier(line) => line,
        };
        let function: fn(&Critical) -> Option<f64> = match what {
            Special::Fold => |of| Some(of.one),
            Special::Flip => |of| Some(of.minus_one),
            Special::NeimarkSacker { .. } => |of| of.circle,
            Special::BranchPoint | Special::Sequence(_) => return None,
        };
        Some(Condition::Multiplier(function, line))
    }
}

/// One direction along a curve.
struct CurveWalk<'a> {
    shooting: Shooting<'a>,
    units: Units,
    settings: &'a ContinuationSettings,
    /// The component of the other parameter, and its range.
    place: usize,
    other: (f64, f64),
}

impl CurveWalk<'_> {
    fn with<'b>(&'b self, extra: Extra<'b>) -> Shooting<'b> {
        Shooting {
            extra,
            ..self.shooting
        }
    }

    /// The orbit of the curve near a guess at which the product of the unknowns with `row` has a
    /// given value, with the function that vanishes there.
    fn solve(
        &self,
        condition: &Condition,
        guess: &Outline,
        (row, value): (&Vector, f64),
    ) -> Option<(Cycle, Condition)> {
        match condition {
            Condition::Margin(margin) => {
                let shooting = self.with(Extra::Zero(margin));
                let found = shooting.solve(guess, Some((row, value)))?;
                let moved = found.margin_like(margin).unwrap_or(margin).clone();
                Some((found, Condition::Margin(moved)))
            }
            Condition::Multiplier(function, line) => {
                let shooting = self.with(Extra::Plane(row, value));
                let value = |cycle: &Cycle| function(&critical(cycle, &shooting));
                let row = line.across();
                let begin = shooting.solve(guess, Some((row, row.dot(&guess.unknowns()))))?;
                let line = Line::tangent(&shooting, self.units, &begin, row)?;
                let path = line.orbits(&shooting);
                let ends = path.bracket((0.0, value(&begin)?), self.settings.step, &value)?;
                let (s, found) = path.root(ends, &value)?;
                let is_near = s.abs() <= self.settings.step;
                is_near.then_some((found, Condition::Multiplier(*function, line)))
            }
        }
    }

    /// The line on which the curve continues from an orbit behind another one.
    fn goes_on(&self, condition: &Condition, from: &Line, next: &Cycle) -> Option<Line> {
        match condition {
            Condition::Margin(margin) => {
                from.goes_on(&self.with(Extra::Zero(margin)), self.units, next)
            }
            Condition::Multiplier(..) => {
                let way = next.outline.unknowns() - from.from.unknowns();
                Line::along(&self.shooting, self.units, next, way)
            }
        }
    }

    /// The line on which the curve leaves its first orbit in one direction.
    fn leaves(&self, first: &Cycle, condition: &Condition, sign: f64) -> Option<Line> {
        // Fraction of a step over which the curve is straight.
        const SHORT: f64 = 1e-2;
        let row = first.outline.unit(self.place);
        if let Condition::Margin(margin) = condition {
            let shooting = self.with(Extra::Zero(margin));
            return Line::tangent(&shooting, self.units, first, &(row * sign));
        }
        let short = sign * SHORT * self.settings.step * (self.other.1 - self.other.0);
        let there = first.outline.unknowns() + &row * short;
        let guess = first.outline.with(&there);
        let (next, _) = self.solve(condition, &guess, (&row, row.dot(&there)))?;
        let way = next.outline.unknowns() - first.outline.unknowns();
        Line::along(&self.shooting, self.units, first, way)
    }

    fn follow(
        &self,
        first: &Cycle,
        mut condition: Condition,
        sign: f64,
    ) -> (Vec<CurvePoint>, CurveStop) {
        let mut points = Vec::new();
        let Some(mut line) = self.leaves(first, &condition, sign) else {
            return (points, CurveStop::NoConvergence);
        };
        // Ratio of a step to one in which no orbit was found.
        const SHORTER: f64 = 0.3;
        let mut step = self.settings.step;
        loop {
            if 2 * points.len() >= self.settings.most_points {
                return (points, CurveStop::Points);
            }
            if step < SHORTEST {
                let stop = match line.vanishing(step / SHORTER).is_empty() {
                    true => CurveStop::NoConvergence,
                    false => CurveStop::AnotherChange,
                };
                return (points, stop);
            }
            let found = line.plane(step).and_then(|(guess, value)| {
                let (next, moved) = self.solve(&condition, &guess, (line.across(), value))?;
                let onward = self.goes_on(&condition, &line, &next)?;
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

    /// The orbit at the end of the range, if the given orbit lies beyond it.
    fn at_end(
        &self,
        condition: &Condition,
        line: &Line,
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
