//! Curves of a change of the phases in two parameters.

use std::ops::ControlFlow;

use super::change::Change;
use super::line::{Line, Units, unit};
use super::walk::{SHORTEST, Walk};
use super::{ContinuationSettings, Special, Stop, parameter_of};
use crate::analysis::cycle::{Cycle, Extra, Margin, SequenceChange, Shooting};
use crate::dynamics::{AsDynamics, Components, Vector};
use crate::error::Error;
use crate::filippov::Options;

/// An orbit on a curve of changes.
#[derive(Clone, Debug, PartialEq)]
pub struct CurvePoint {
    /// The two parameters, which are the last two states: the one of the branch last.
    pub parameters: [f64; 2],
    /// A time and a state on the orbit.
    pub t: f64,
    /// See `t`.
    pub x: Vector,
    /// Period.
    pub period: f64,
}

/// Why a curve was followed no further.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveStop {
    /// One of the parameters has come to an end of its range.
    Range,
    /// There are as many points as asked for.
    Points,
    /// Another change of the phases comes to the same orbit behind the last point.
    AnotherChange,
    /// No further orbit was found within the shortest step behind the last one.
    NoConvergence,
}

/// A curve on which the phases of a periodic orbit change, in two parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// The change that it begins with.
    pub change: SequenceChange,
    /// The orbits, from one end of the curve to the other.
    pub points: Vec<CurvePoint>,
    /// Which of them it was begun with.
    pub first: usize,
    /// Why there are no more before the first and behind the last.
    pub stops: [CurveStop; 2],
}

/// Follows the change of the phases with a number, counted from 0, that a branch of periodic orbits
/// meets, in two parameters.
///
/// **The parameters are the last two states**, of which the last is that of the branch, as in
/// [`super::continue_periodic_orbit`]; the other keeps its value on the branch and has the range
/// `other`. The margin that is zero at the change is added to the equations, with its gradient from
/// dual numbers, so that the curve passes its own folds (Thota & Dankowicz 2008).
///
/// # Errors
/// Those of [`super::continue_periodic_orbit`]; [`Error::NotFound`] where the branch does not come
/// to such a change, or no curve goes on from it.
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
    let Some(place) = x.len().checked_sub(2).filter(|place| *place > 0) else {
        return Err(Error::Parameter {
            name: "the number of states",
            value: x.len() as f64,
            bound: "at least 3: one state, and two parameters behind it",
        });
    };
    let fixed = Extra::Fixed(place, x[place]);
    let start = x.clone();
    let mut walk = Walk::begin(system, x, period, settings, (fixed, options))?;
    walk.wanted = Some(number);
    let stop = walk.go(upwards, &mut |_| ControlFlow::Continue(()));
    let not_found = |what| Error::NotFound {
        what,
        t: 0.0,
        span: period,
    };
    let found = walk.kept.take().filter(|_| stop == Stop::Points);
    let Change { at, margin, .. } =
        found.ok_or(not_found("a change of the phases on the branch"))?;
    let changes = walk.special.iter().rev();
    let mut changes = changes.filter_map(|special| match &special.what {
        Special::Sequence(change) => Some((**change).clone()),
        _ => None,
    });
    let change = changes.next();
    let change = change.ok_or(not_found("a change of the phases on the branch"))?;
    let shooting = Shooting {
        extra: Extra::Zero(&margin),
        ..walk.shooting
    };
    let mut units = walk.units;
    units.other = Some(other.1 - other.0);
    let by_other = unit(&at.cycle.outline, place);
    let row = Some((&by_other, start[place]));
    let first = shooting.solve(&at.cycle.outline, row);
    let first = first.ok_or(not_found("an orbit at the change of the phases"))?;
    let follow = |sign: f64| {
        let line = Line::tangent(&shooting, units, &first, &(&by_other * sign));
        Way {
            shooting: walk.shooting,
            units,
            settings,
            other,
        }
        .follow(line, &margin)
    };
    let ((mut points, before), (behind, after)) = (follow(-1.0), follow(1.0));
    points.reverse();
    let begun = points.len();
    points.push(point(&first));
    points.extend(behind);
    Ok(Curve {
        change,
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

/// One way along a curve.
struct Way<'a> {
    shooting: Shooting<'a>,
    units: Units,
    settings: &'a ContinuationSettings,
    other: (f64, f64),
}

impl Way<'_> {
    fn follow(&self, line: Option<Line>, margin: &Margin) -> (Vec<CurvePoint>, CurveStop) {
        let mut points = Vec::new();
        // It moves along the orbit.
        let mut margin = margin.clone();
        let Some(mut line) = line else {
            return (points, CurveStop::NoConvergence);
        };
        let mut step = self.settings.step;
        // Whether the duration of a segment would have vanished in the last one that was tried.
        let mut was_vanishing = false;
        loop {
            if 2 * points.len() >= self.settings.most_points {
                return (points, CurveStop::Points);
            }
            let vanishes = !line.vanishing(step).is_empty();
            if step < SHORTEST {
                let stop = if was_vanishing {
                    CurveStop::AnotherChange
                } else {
                    CurveStop::NoConvergence
                };
                return (points, stop);
            }
            was_vanishing = vanishes;
            let shooting = Shooting {
                extra: Extra::Zero(&margin),
                ..self.shooting
            };
            let found = line.on(&shooting, step);
            let onward = found.as_ref().and_then(|next| {
                let onward = line.goes_on(&shooting, self.units, next)?;
                line.bends_little(&onward).then_some(onward)
            });
            let (Some(next), Some(onward)) = (found, onward) else {
                step *= 0.3;
                continue;
            };
            if let Some(end) = self.at_end(&shooting, &line, step, &next) {
                points.extend(end.as_ref().map(point));
                return (points, CurveStop::Range);
            }
            if !shooting.is_valid(&next) {
                if step > self.settings.step * 1e-3 {
                    step *= 0.3;
                    continue;
                }
                return (points, CurveStop::AnotherChange);
            }
            points.push(point(&next));
            if let Some(moved) = next.margin_like(&margin) {
                margin = moved.clone();
            }
            let longer = if next.iterations <= 5 { 1.4 } else { 1.0 };
            step = (longer * step).min(self.settings.step);
            line = onward;
        }
    }

    /// The orbit at the end of the range that an orbit lies beyond, if it does.
    fn at_end(
        &self,
        shooting: &Shooting<'_>,
        line: &Line,
        step: f64,
        next: &Cycle,
    ) -> Option<Option<Cycle>> {
        let n = next.outline.begin.x.len();
        let own = (n - 1, parameter_of(next), self.settings.range);
        let other = (n - 2, next.outline.begin.x[n - 2], self.other);
        let is_beyond =
            |&(_, value, (low, high)): &(usize, f64, (f64, f64))| !(low..=high).contains(&value);
        let (place, value, (low, high)) = [own, other].into_iter().find(is_beyond)?;
        let end = value.clamp(low, high);
        let before = line.from.begin.x[place];
        let guess = line.guess(step * (end - before) / (value - before));
        let row = unit(&guess, place);
        Some(shooting.solve(&guess, Some((&row, end))))
    }
}
