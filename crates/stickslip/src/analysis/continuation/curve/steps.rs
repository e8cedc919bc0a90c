//! The steps along a curve in one direction.

use super::super::ContinuationSettings;
use super::super::both_ways::{self, FollowedCurve};
use super::super::stepping::SHORTER;
use super::super::tangent_line::TangentLine;
use super::condition::CurveCondition;
use super::{CurveContinuation, CurvePoint, CurveSpecialPoint, CurveStop};
use crate::analysis::cycle::{Cycle, OrbitGuess};

/// An orbit of the curve, and how the curve goes on from there.
pub(super) struct CurvePosition {
    pub cycle: Cycle,
    /// The condition near this orbit.
    pub condition: CurveCondition,
    /// The line on which the next orbit is sought.
    pub line: TangentLine,
    /// The functions whose zeros are special orbits.
    pub values: Vec<Option<f64>>,
}

impl CurvePosition {
    /// The condition, and the number of steps of the orbit.
    pub fn known(&self) -> (&CurveCondition, usize) {
        (&self.condition, self.cycle.steps)
    }
}

/// An end of the curve.
pub(super) type CurveEnd = both_ways::CurveEndOf<CurvePoint, CurveSpecialPoint>;

impl CurveContinuation<'_> {
    /// The orbit of the curve in the plane across a line at a place.
    pub(super) fn on(&self, at: &CurvePosition, s: f64) -> Option<(Cycle, CurveCondition)> {
        let (guess, value) = at.line.plane(&self.shooting, s)?;
        self.solve(at.known(), &guess, (at.line.across(), value))
    }

    /// The line through the second of two orbits of the curve, in the direction from the first.
    pub(super) fn secant(&self, from: &OrbitGuess, to: &Cycle) -> Option<TangentLine> {
        let direction = to.outline.unknowns() - from.unknowns();
        TangentLine::along(&self.shooting, &self.units, to, direction)
    }

    /// The line on which the curve leaves its first orbit in one direction.
    fn first_line(
        &self,
        first: &Cycle,
        condition: &CurveCondition,
        sign: f64,
    ) -> Option<TangentLine> {
        // Length of a first, short step by the other parameter, as a fraction of the longest one.
        // Chosen: over it the curve is straight, and the orbits differ by more than rounding.
        const FIRST_STEP: f64 = 1e-2;
        let row = first.outline.unit(self.place);
        let short = sign * FIRST_STEP * self.settings.step * (self.other.1 - self.other.0);
        let there = first.outline.unknowns() + &row * short;
        let guess = first.outline.with(&there);
        let known = (condition, first.steps);
        let (next, _) = self.solve(known, &guess, (&row, row.dot(&there)))?;
        let direction = next.outline.unknowns() - first.outline.unknowns();
        TangentLine::along(&self.shooting, &self.units, first, direction)
    }
}

impl FollowedCurve for CurveContinuation<'_> {
    type First = (Cycle, CurveCondition);
    type At = CurvePosition;
    type Point = CurvePoint;
    type Special = CurveSpecialPoint;

    fn settings(&self) -> &ContinuationSettings {
        self.settings
    }

    fn begin(&self, (first, condition): &Self::First, sign: f64) -> Option<CurvePosition> {
        Some(CurvePosition {
            cycle: first.clone(),
            values: self.values(first, condition),
            condition: condition.clone(),
            line: self.first_line(first, condition, sign)?,
        })
    }

    fn next(&self, at: &CurvePosition, step: f64) -> Option<(CurvePosition, CurvePoint, usize)> {
        let (cycle, condition) = self.on(at, step)?;
        let line = self.secant(&at.line.from, &cycle)?;
        if !at.line.bends_little(&line) {
            return None;
        }
        let point = self.point(&cycle, &condition)?;
        let iterations = cycle.iterations;
        let next = CurvePosition {
            values: self.values(&cycle, &condition),
            cycle,
            condition,
            line,
        };
        Some((next, point, iterations))
    }

    fn end_before(&self, at: &CurvePosition, step: f64, orbits: usize) -> Option<CurveEnd> {
        self.vanishing(at, step, orbits)
    }

    fn ends(
        &self,
        (at, next): (&CurvePosition, &CurvePosition),
        (first, _): &Self::First,
        (step, orbits): (f64, usize),
    ) -> Result<Vec<CurveEnd>, Option<CurveStop>> {
        // Shortest step in which a change of the phases must be located, as a fraction of the
        // longest one. Chosen, as where branches are.
        const DECISIVE_STEP: f64 = 1e-3;
        let half = self.flip_of_half(at, next, orbits);
        let resonance = match half {
            Some(_) => None,
            None => self.resonance(at, next, orbits),
        };
        let closed = match orbits {
            ..=3 => None,
            _ => self.closes(at, next, first),
        };
        let tangency = self.cubic_tangency(at, next, orbits);
        let ends = [half, resonance, closed, tangency];
        let mut ends: Vec<CurveEnd> = ends.into_iter().flatten().collect();
        let is_short = step <= self.settings.step * DECISIVE_STEP;
        let change = self.change(at, next, orbits);
        let range = self.is_outside(&next.cycle);
        let range = range.then(|| self.end_of_range(at, next, step));
        match (change, range) {
            (Err(()), _) if ends.is_empty() && is_short => Err(Some(CurveStop::AnotherChange)),
            // Without an orbit at the end of the range, the curve has not come there.
            (Err(()), _) | (_, Some(None)) if ends.is_empty() => Err(None),
            (change, range) => {
                ends.extend(change.ok().flatten());
                ends.extend(range.flatten());
                Ok(ends)
            }
        }
    }

    fn special(
        &self,
        (at, next): (&CurvePosition, &CurvePosition),
        (_, orbits): (f64, usize),
    ) -> Vec<(f64, CurveSpecialPoint)> {
        self.special_between(at, next, orbits)
    }

    fn last_end(
        &self,
        at: &CurvePosition,
        step: f64,
        orbits: usize,
    ) -> Result<CurveEnd, CurveStop> {
        let is_alone = || at.line.vanishing(step / SHORTER).is_empty();
        self.arrival(at, orbits).ok_or_else(|| match is_alone() {
            true => CurveStop::NoConvergence,
            false => CurveStop::AnotherChange,
        })
    }
}
