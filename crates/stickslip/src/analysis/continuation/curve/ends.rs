//! Ends of a curve: at an end of a range, at its beginning, or where both halves of its orbits
//! become one orbit.

use super::super::ends::{SAME_ORBIT, is_same, offset_from};
use super::steps::{CurveEnd, CurvePosition};
use super::{CurveContinuation, CurvePoint, CurveSpecialPoint, CurveStop, parameters};
use crate::analysis::cycle::{Cycle, SAFETY, closeness, with_last_digits};
use crate::analysis::lagrange::weights;
use crate::dynamics::Vector;

impl CurveContinuation<'_> {
    /// Widths of the ranges of both parameters.
    pub(super) fn widths(&self) -> [f64; 2] {
        let (low, high) = self.settings.range;
        [self.other.1 - self.other.0, high - low]
    }

    /// Both parameters of an orbit, in units of the widths of their ranges.
    pub(super) fn scaled(&self, cycle: &Cycle) -> [f64; 2] {
        let (values, widths) = (parameters(cycle), self.widths());
        [values[0] / widths[0], values[1] / widths[1]]
    }

    /// Whether an orbit lies beyond an end of a range.
    pub(super) fn is_outside(&self, cycle: &Cycle) -> bool {
        self.passed_end(cycle).is_some()
    }

    /// The component of a parameter that lies beyond an end of its range, its width and that end.
    fn passed_end(&self, cycle: &Cycle) -> Option<(usize, f64, f64)> {
        let ([other, own], widths) = (parameters(cycle), self.widths());
        let ranges = [
            (self.place + 1, own, widths[1], self.settings.range),
            (self.place, other, widths[0], self.other),
        ];
        let passed = ranges
            .into_iter()
            .find(|(_, value, _, (low, high))| !(*low..=*high).contains(value));
        let (place, value, width, (low, high)) = passed?;
        Some((place, width, value.clamp(low, high)))
    }

    /// The end of the curve at an end of a range, beyond which the next orbit lies. `None` where no
    /// orbit was found there.
    pub(super) fn end_of_range(
        &self,
        at: &CurvePosition,
        next: &CurvePosition,
        step: f64,
    ) -> Option<CurveEnd> {
        let (place, width, end) = self.passed_end(&next.cycle)?;
        let value = |cycle: &Cycle| cycle.outline.begin.x[place];
        let (before, beyond) = (value(&at.cycle), value(&next.cycle));
        let s = step * (end - before) / (beyond - before);
        let guess = at.line.guess(s);
        let row = guess.unit(place);
        let found = self.solve(at.known(), &guess, (&row, end));
        let found = found.map(|(cycle, _)| cycle);
        let last = found.or_else(|| self.toward(at, (step, beyond), (place, end, width)))?;
        // Another end may have been passed, too.
        if self
            .passed_end(&last)
            .is_some_and(|(other, ..)| other != place)
        {
            return None;
        }
        let mut last = self.point(&last, &at.condition)?;
        // Of the end of a branch, the orbit beside it is at the end of the range.
        let off = (end - last.x[place]).abs();
        last.uncertainty = last.uncertainty.map(|known| known + off);
        last.x[place] = end;
        last.parameters[place - self.place] = end;
        Some(CurveEnd {
            s,
            stop: CurveStop::Range,
            last,
            special: None,
        })
    }

    /// The orbit at an end of a range, to within the tolerances, by the false position along the
    /// line. At the end itself, the condition may determine no orbit: without a drive, orbits have
    /// any phase.
    fn toward(
        &self,
        at: &CurvePosition,
        beyond: (f64, f64),
        (place, end, width): (usize, f64, f64),
    ) -> Option<Cycle> {
        const MOST_STEPS: usize = 40;
        let allowed = closeness(self.shooting.options) * width;
        let value = |cycle: &Cycle| cycle.outline.begin.x[place] - end;
        let (mut a, mut b) = ((0.0, value(&at.cycle)), (beyond.0, beyond.1 - end));
        for _ in 0..MOST_STEPS {
            let s = b.0 - b.1 * (b.0 - a.0) / (b.1 - a.1);
            let (cycle, _) = self.on(at, s)?;
            let off = value(&cycle);
            if off.abs() <= allowed {
                return Some(cycle);
            }
            if off * b.1 < 0.0 {
                a = b;
            } else {
                a.1 *= 0.5;
            }
            b = (s, off);
        }
        None
    }

    /// The end of a closed curve: between two of its orbits it passes the first one.
    pub(super) fn closes(
        &self,
        at: &CurvePosition,
        next: &CurvePosition,
        first: &Cycle,
    ) -> Option<CurveEnd> {
        // Distance by which a straight line between both orbits may miss it, as a fraction of its
        // length. Chosen: the curve bends little in a step.
        const LARGEST_MISS: f64 = 0.1;
        let [from, to, begin] = [&at.cycle, &next.cycle, first].map(|one| self.scaled(one));
        let way = [to[0] - from[0], to[1] - from[1]];
        let off = [begin[0] - from[0], begin[1] - from[1]];
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        let square = dot(way, way);
        let part = dot(off, way) / square;
        let miss = [off[0] - part * way[0], off[1] - part * way[1]];
        let is_passed =
            (0.0..=1.0).contains(&part) && dot(miss, miss) <= LARGEST_MISS * LARGEST_MISS * square;
        if !is_passed {
            return None;
        }
        // The orbit of the curve beside the first one.
        let widths = self.widths();
        let s = part * at.line.place(&next.cycle);
        let guess = at.line.guess(s);
        let row = guess.unit(self.place) * (way[0] / widths[0])
            + guess.unit(self.place + 1) * (way[1] / widths[1]);
        let [other, own] = parameters(first);
        let value = row[self.place] * other + row[self.place + 1] * own;
        let (found, _) = self.solve(at.known(), &guess, (&row, value))?;
        let near = SAME_ORBIT.max(closeness(self.shooting.options));
        let is_at = self.scaled(&found).into_iter().zip(begin);
        let is_at = is_at.fold(true, |all, (a, b)| all && (a - b).abs() <= near);
        let off = offset_from(&self.shooting, &first.anchor, &found)?;
        let options = self.shooting.options;
        let is_first = is_same(&off, &first.anchor.x, &self.units.states, options);
        let last = self.point(first, &at.condition)?;
        (is_at && is_first).then_some(CurveEnd {
            s,
            stop: CurveStop::Closed,
            last,
            special: None,
        })
    }

    /// The end of the curve where both halves of its orbits become one orbit, between two of them:
    /// the difference of the halves passes through zero.
    ///
    /// Near that end the parameters are even functions of the difference, and Newton's matrix is
    /// singular there. So they are extrapolated from orbits farther away.
    pub(super) fn flip_of_half(
        &self,
        at: &CurvePosition,
        next: &CurvePosition,
        orbits: usize,
    ) -> Option<CurveEnd> {
        // Distance of the nodes, as a fraction of the step. Chosen: shorter, the closing errors
        // would decide; longer, the degree of the polynomial.
        const SPACING: f64 = 0.15;
        const NODES: usize = 6;
        // Largest difference of the halves that the extrapolation leaves, as a fraction of that at
        // the ends. Chosen: where they only turn, it is about 1.
        const LARGEST_LEFT: f64 = 0.2;
        let kind = self.kind?;
        let [before, behind] = [at.cycle.halves()?, next.cycle.halves()?];
        if before.len() != behind.len() {
            return None;
        }
        let direction = behind.normalize();
        let part = |one: &Cycle| Some(one.halves()?.dot(&direction));
        let (a, b) = (part(&at.cycle)?, part(&next.cycle)?);
        let is_resolved =
            before.amax() > at.cycle.closes_to && behind.amax() > next.cycle.closes_to;
        if !is_resolved || a >= 0.0 {
            return None;
        }
        let length = at.line.place(&next.cycle);
        let s = length * a / (a - b);
        let node = |k: usize| {
            let (cycle, _) = self.on(at, s - SPACING * length * k as f64)?;
            Some((part(&cycle)?, cycle))
        };
        let nodes: Vec<(f64, Cycle)> = (1..=NODES).map_while(node).collect();
        if nodes.len() < NODES {
            return None;
        }
        let (even, odd): (Vec<f64>, Vec<f64>) =
            nodes.iter().map(|(part, _)| (part * part, *part)).unzip();
        let at_zero = |places: &[f64], of: &dyn Fn(&Cycle) -> f64| -> f64 {
            let terms = weights(places, 0.0).into_iter().zip(&nodes);
            terms.map(|(weight, (_, cycle))| weight * of(cycle)).sum()
        };
        let left = weights(&odd, 0.0).into_iter().zip(&nodes);
        let left = left.map(|(weight, (_, cycle))| Some(cycle.halves()? * weight));
        let left = left.sum::<Option<Vector>>()?;
        if left.norm() > LARGEST_LEFT * before.norm().max(behind.norm()) {
            return None;
        }
        let value = |k: usize| move |cycle: &Cycle| parameters(cycle)[k];
        let parameters = [0, 1].map(|k| at_zero(&even, &value(k)));
        // Without the farthest node, the result differs by the polynomial's error.
        let fewer = [0, 1].map(|k| at_zero(&even[..NODES - 1], &value(k)));
        // What integration leaves of the nearest node is amplified by the weights.
        let finer = self.finer().on(at, s - SPACING * length);
        let of_steps = |k: usize| {
            let finer = finer
                .as_ref()
                .map_or(f64::NAN, |(cycle, _)| value(k)(cycle));
            let weights = weights(&even, 0.0).into_iter();
            SAFETY * (finer - value(k)(&nodes[0].1)).abs() * weights.map(f64::abs).sum::<f64>()
        };
        let uncertainties = [0, 1].map(|k| {
            let uncertainty = (fewer[k] - parameters[k]).abs() + of_steps(k);
            let rounding = (self.widths()[k], at.cycle.steps);
            with_last_digits((parameters[k], uncertainty), f64::NAN, rounding)
        });
        let states = at.cycle.anchor.x.len();
        let mut x = Vector::from_fn(states, |i, _| at_zero(&odd, &|one| one.anchor.x[i]));
        (x[states - 2], x[states - 1]) = (parameters[0], parameters[1]);
        let last = CurvePoint {
            parameters,
            uncertainty: None,
            t: at_zero(&odd, &|one| one.anchor.t),
            x,
            period: at_zero(&even, &|one| one.period),
        };
        Some(CurveEnd {
            s,
            stop: CurveStop::Flip,
            special: Some(CurveSpecialPoint {
                parameters,
                uncertainties,
                what: kind.of_half(),
                behind: orbits,
                t: last.t,
                x: last.x.clone(),
                period: last.period,
            }),
            last,
        })
    }
}
