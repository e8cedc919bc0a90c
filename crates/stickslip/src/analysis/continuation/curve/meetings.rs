//! Ends of curves where another condition is met: a resonance, or a change of the phases.

use super::codimension_two::CurveBifurcation;
use super::condition::CurveCondition;
use super::special::{LocatedOrbit, certain};
use super::steps::{CurveEnd, CurvePosition};
use super::{
    CurveContinuation, CurveKind, CurvePoint, CurveSpecialPoint, CurveStop, parameters, point,
};
use crate::analysis::cycle::{Cycle, Margin, MarginKind, describe, with_last_digits};
use crate::analysis::lagrange::weights;
use crate::math;

impl CurveContinuation<'_> {
    /// The end of a Neimark–Sacker curve where its pair of multipliers becomes real.
    pub(super) fn resonance(
        &self,
        at: &CurvePosition,
        next: &CurvePosition,
        orbits: usize,
    ) -> Option<CurveEnd> {
        let (before, behind) = (at.condition.sum_of_pair()?, next.condition.sum_of_pair()?);
        let (order, sum) = [(1, 2.0), (2, -2.0)]
            .into_iter()
            .find(|(_, sum)| (before - sum) * (behind - sum) < 0.0)?;
        let function = |_: &Cycle, condition: &CurveCondition| Some(condition.sum_of_pair()? - sum);
        let ends = [
            (0.0, before - sum),
            (at.line.place(&next.cycle), behind - sum),
        ];
        let located = self.located(at, ends, [&function, &certain])?;
        let what = CurveBifurcation::Resonance(order);
        Some(CurveEnd {
            s: located.s,
            stop: CurveStop::Resonance,
            last: point(&located.cycle),
            special: Some(self.described(&located, what, orbits)),
        })
    }

    /// The end of a curve of grazes where the graze becomes an inflection. Beyond, the orbits have
    /// reached the boundary before.
    pub(super) fn cubic_tangency(
        &self,
        at: &CurvePosition,
        next: &CurvePosition,
        orbits: usize,
    ) -> Option<CurveEnd> {
        let function = |cycle: &Cycle, condition: &CurveCondition| {
            cycle.acceleration_at(self.shooting.system, condition.arrival()?)
        };
        let [before, behind] = [at, next].map(|one| function(&one.cycle, &one.condition));
        let ends = [(0.0, before?), (at.line.place(&next.cycle), behind?)];
        if ends[0].1 * ends[1].1 >= 0.0 {
            return None;
        }
        let located = self.located(at, ends, [&function, &certain])?;
        let what = CurveBifurcation::CubicTangency;
        Some(CurveEnd {
            s: located.s,
            stop: CurveStop::AnotherChange,
            last: point(&located.cycle),
            special: Some(self.described(&located, what, orbits)),
        })
    }

    /// The end of the curve at the first change of the phases before the next orbit. `Err` where
    /// the step is too long to locate it.
    pub(super) fn change(
        &self,
        at: &CurvePosition,
        next: &CurvePosition,
        orbits: usize,
    ) -> Result<Option<CurveEnd>, ()> {
        let (length, options) = (at.line.place(&next.cycle), self.shooting.options);
        let violated = next.cycle.margins.iter();
        let violated = violated.filter(|margin| margin.is_violated(options));
        let mut first: Option<CurveEnd> = None;
        for margin in violated {
            // Such an orbit is another solution. It does not continue the orbits before the change.
            if next.cycle.repeats_event(options) {
                return Err(());
            }
            let before = at.cycle.margin_like(margin).ok_or(())?;
            let function =
                |cycle: &Cycle, _: &CurveCondition| Some(cycle.margin_like(margin)?.value);
            let ends = [(0.0, before.value), (length, margin.value)];
            if before.value <= 0.0 {
                return Err(());
            }
            let located = self.located(at, ends, [&function, &certain]).ok_or(())?;
            let margin = located.cycle.margin_like(margin).ok_or(())?;
            if first.as_ref().is_none_or(|first| located.s < first.s) {
                let named = describe(
                    self.shooting.system,
                    (&located.cycle, margin),
                    (0.0, 0.0),
                    [Vec::new(), Vec::new()],
                );
                let what = CurveKind::at_change(self.kind, named.bifurcation);
                let last = self.point(&located.cycle, &at.condition).ok_or(())?;
                let special = self.described(&located, what, orbits);
                // An orbit beside the end of a branch has the change beside that at the end.
                let widths = self.widths();
                let beside = (last.parameters[1] - special.parameters[1]).abs() / widths[1];
                let uncertainties = [0, 1].map(|k| special.uncertainties[k] + beside * widths[k]);
                let special = CurveSpecialPoint {
                    parameters: last.parameters,
                    uncertainties,
                    ..special
                };
                first = Some(CurveEnd {
                    s: located.s,
                    stop: CurveStop::AnotherChange,
                    last,
                    special: Some(special),
                });
            }
        }
        Ok(first)
    }

    /// The end of the curve where the orbits arrive ever more slowly at a boundary, or at the
    /// function of a jump. Their derivatives grow without bound, and no orbit next to the end can
    /// be computed. The parameters are extrapolated to the speed zero by a polynomial.
    pub(super) fn arrival(&self, at: &CurvePosition, orbits: usize) -> Option<CurveEnd> {
        const NODES: usize = 5;
        // Largest relative speed at the farthest node, and largest uncertainty as a fraction of a
        // range. Chosen: far from a graze, neither is met.
        const SLOW: f64 = 0.1;
        // Distance by which the rate of the speed is measured, as a fraction of the longest step.
        const PROBE: f64 = 1e-2;
        const RESOLVED: f64 = 1e-4;
        let margins = at.cycle.margins.iter();
        let slowest = margins.filter(|margin| margin.kind == MarginKind::Arrival);
        let slowest = slowest.min_by(|a, b| a.relative().total_cmp(&b.relative()))?;
        let is_same = |one: &&Margin| (one.kind, one.part) == (slowest.kind, slowest.part);
        let behind = |s: f64| {
            let (cycle, _) = self.on(at, -s)?;
            let speed = cycle.margins.iter().find(is_same)?.relative();
            Some((speed, parameters(&cycle)))
        };
        let probe = PROBE * self.settings.step;
        let rate = (behind(probe)?.0 - slowest.relative()) / probe;
        // Each is about twice as fast as the one before.
        let node = |k: i32| behind(slowest.relative() / rate * (math::powi(2.0, k) - 1.0));
        let nodes: Vec<(f64, [f64; 2])> = (0..NODES as i32).map_while(node).collect();
        let falls = nodes.windows(2).all(|pair| pair[0].0 < pair[1].0);
        if nodes.len() < NODES || nodes[0].0 <= 0.0 || nodes[NODES - 1].0 > SLOW || !falls {
            return None;
        }
        let extrapolated = |nodes: &[(f64, [f64; 2])], k: usize| -> f64 {
            let speeds: Vec<f64> = nodes.iter().map(|node| node.0).collect();
            let terms = weights(&speeds, 0.0).into_iter().zip(nodes);
            terms.map(|(weight, node)| weight * node.1[k]).sum()
        };
        let parameters = [0, 1].map(|k| extrapolated(&nodes, k));
        let widths = self.widths();
        let uncertainties = [0, 1].map(|k| {
            let fewer = extrapolated(&nodes[..NODES - 1], k);
            let uncertainty = (parameters[k] - fewer).abs();
            let rounding = (widths[k], at.cycle.steps);
            with_last_digits((parameters[k], uncertainty), f64::NAN, rounding)
        });
        let is_resolved = |k: usize| uncertainties[k] <= RESOLVED * widths[k];
        if !(is_resolved(0) && is_resolved(1)) {
            return None;
        }
        let named = describe(
            self.shooting.system,
            (&at.cycle, slowest),
            (0.0, 0.0),
            [Vec::new(), Vec::new()],
        );
        let special = CurveSpecialPoint {
            parameters,
            uncertainties,
            what: CurveKind::at_change(self.kind, named.bifurcation),
            behind: orbits,
            t: at.cycle.anchor.t,
            x: at.cycle.anchor.x.clone(),
            period: at.cycle.period,
        };
        Some(CurveEnd {
            s: 0.0,
            stop: CurveStop::AnotherChange,
            last: CurvePoint {
                parameters,
                ..point(&at.cycle)
            },
            special: Some(special),
        })
    }

    /// The end of the curve where a segment between two contacts vanishes before a place.
    pub(super) fn vanishing(
        &self,
        at: &CurvePosition,
        step: f64,
        orbits: usize,
    ) -> Option<CurveEnd> {
        let &(number, place) = at.line.vanishing(step).first()?;
        let is_its = |kind: MarginKind, part: usize| kind == MarginKind::Duration && part == number;
        let margins = at.cycle.margins.iter();
        let mut margins = margins.filter(|one| is_its(one.kind, one.part) && one.other.is_some());
        let margin = margins.next()?;
        let guess = at.line.guess(place);
        let row = guess.unit(guess.begin.x.len() + number);
        let (cycle, _) = self.solve(at.known(), &guess, (&row, 0.0))?;
        let (finer, _) = self.finer().solve(at.known(), &guess, (&row, 0.0))?;
        let s = at.line.place(&cycle);
        let onward = self.secant(&at.line.from, &cycle)?;
        let is_ahead = s > 0.0 && at.line.bends_little(&onward);
        if !is_ahead || !self.shooting.is_valid(&cycle) {
            return None;
        }
        let named = describe(
            self.shooting.system,
            (&cycle, margin),
            (0.0, 0.0),
            [Vec::new(), Vec::new()],
        );
        let what = CurveKind::at_change(self.kind, named.bifurcation);
        let last = point(&cycle);
        let uncertainties = self.uncertainties([&cycle, &finer], |_| 0.0);
        let located = LocatedOrbit {
            s,
            cycle,
            uncertainties,
        };
        Some(CurveEnd {
            s,
            stop: CurveStop::AnotherChange,
            last,
            special: Some(self.described(&located, what, orbits)),
        })
    }
}
