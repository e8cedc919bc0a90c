//! The steps along a curve in one direction.

use super::super::steps::SHORTEST_STEP;
use super::super::tangent_line::TangentLine;
use super::condition::CurveCondition;
use super::{CurveContinuation, CurvePoint, CurveSpecialPoint, CurveStop};
use crate::analysis::cycle::{Cycle, Outline};

/// The part of a curve in one direction from its first orbit.
pub(super) struct Way {
    /// The orbits behind the first.
    pub points: Vec<CurvePoint>,
    /// The special orbits; `behind` counts the orbits of this direction, with the first.
    pub special: Vec<CurveSpecialPoint>,
    pub stop: CurveStop,
}

impl Way {
    /// A direction in which there is no orbit.
    pub fn empty(stop: CurveStop) -> Self {
        Way {
            points: Vec::new(),
            special: Vec::new(),
            stop,
        }
    }

    /// Ends it.
    fn end(&mut self, end: CurveEnd) {
        self.points.push(end.last);
        self.special.extend(end.special);
        self.stop = end.stop;
    }
}

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
pub(super) struct CurveEnd {
    /// Place on the line.
    pub s: f64,
    pub stop: CurveStop,
    /// The last orbit.
    pub last: CurvePoint,
    /// Special orbit that the last point is, if any.
    pub special: Option<CurveSpecialPoint>,
}

impl CurveContinuation<'_> {
    /// The orbit of the curve in the plane across a line at a place.
    pub(super) fn on(&self, at: &CurvePosition, s: f64) -> Option<(Cycle, CurveCondition)> {
        let (guess, value) = at.line.plane(&self.shooting, s)?;
        self.solve(at.known(), &guess, (at.line.across(), value))
    }

    /// The line through the second of two orbits of the curve, in the direction from the first.
    pub(super) fn secant(&self, from: &Outline, to: &Cycle) -> Option<TangentLine> {
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

    /// The next orbit, if the curve bends little on the way to it.
    fn next(&self, at: &CurvePosition, step: f64) -> Option<CurvePosition> {
        let (cycle, condition) = self.on(at, step)?;
        let line = self.secant(&at.line.from, &cycle)?;
        at.line.bends_little(&line).then(|| CurvePosition {
            values: self.values(&cycle, &condition),
            cycle,
            condition,
            line,
        })
    }

    pub(super) fn follow(&self, first: &Cycle, condition: CurveCondition, sign: f64) -> Way {
        let mut way = Way::empty(CurveStop::NoConvergence);
        let Some(line) = self.first_line(first, &condition, sign) else {
            return way;
        };
        let mut at = CurvePosition {
            cycle: first.clone(),
            values: self.values(first, &condition),
            condition,
            line,
        };
        // Ratio of a step to the one before, in which no orbit was found. Chosen, as for branches.
        const SHORTER: f64 = 0.3;
        // Shortest step in which a change of the phases must be located, as a fraction of the
        // longest one. Chosen, as where branches are.
        const DECISIVE_STEP: f64 = 1e-3;
        let mut step = self.settings.step;
        loop {
            if 2 * way.points.len() >= self.settings.most_points {
                way.stop = CurveStop::Points;
                return way;
            }
            if step < SHORTEST_STEP {
                if let Some(end) = self.arrival(&at, 1 + way.points.len()) {
                    way.end(end);
                } else if !at.line.vanishing(step / SHORTER).is_empty() {
                    way.stop = CurveStop::AnotherChange;
                }
                return way;
            }
            let orbits = 1 + way.points.len();
            let Some(next) = self.next(&at, step) else {
                match self.vanishing(&at, step, orbits) {
                    Some(end) => {
                        way.end(end);
                        return way;
                    }
                    None => step *= SHORTER,
                }
                continue;
            };
            let Some(next_point) = self.point(&next.cycle, &next.condition) else {
                step *= SHORTER;
                continue;
            };
            let half = self.flip_of_half(&at, &next, orbits);
            let resonance = match half {
                Some(_) => None,
                None => self.resonance(&at, &next, orbits),
            };
            let closed = match orbits {
                ..=3 => None,
                _ => self.closes(&at, &next, first),
            };
            let tangency = self.cubic_tangency(&at, &next, orbits);
            let ends = [half, resonance, closed, tangency];
            let mut ends: Vec<CurveEnd> = ends.into_iter().flatten().collect();
            let is_short = step <= self.settings.step * DECISIVE_STEP;
            let change = self.change(&at, &next, orbits);
            let range = self.is_outside(&next.cycle);
            let range = range.then(|| self.end_of_range(&at, &next, step));
            match (change, range) {
                // Without an orbit at the end of the range, the curve has not come there.
                (_, Some(None)) | (Err(()), _) if ends.is_empty() && !is_short => {
                    step *= SHORTER;
                    continue;
                }
                (Err(()), _) if ends.is_empty() => {
                    way.stop = CurveStop::AnotherChange;
                    return way;
                }
                (_, Some(None)) if ends.is_empty() => {
                    step *= SHORTER;
                    continue;
                }
                (change, range) => {
                    ends.extend(change.ok().flatten());
                    ends.extend(range.flatten());
                }
            }
            let special = self.special(&at, &next, orbits);
            let end = ends.into_iter().min_by(|a, b| a.s.total_cmp(&b.s));
            let before = |s: f64| end.as_ref().is_none_or(|end| s < end.s);
            let special = special.into_iter().filter(|(s, _)| before(*s));
            way.special.extend(special.map(|(_, one)| one));
            if let Some(end) = end {
                way.end(end);
                return way;
            }
            way.points.push(next_point);
            let longer = if next.cycle.iterations <= 5 { 1.4 } else { 1.0 };
            step = (longer * step).min(self.settings.step);
            at = next;
        }
    }
}
