//! Special orbits on curves: bifurcations of codimension two.

use std::cell::LazyCell;

use super::super::critical;
use super::codimension_two::{
    CodimensionTwoTest, CurveBifurcation, CurveSpecialPoint, angle_of, others,
};
use super::condition::CurveCondition;
use super::steps::CurvePosition;
use super::{CurveContinuation, CurveKind, parameters};
use crate::analysis::critical::{RESOLVED_PLACE, zero_between};
use crate::analysis::cycle::{Cycle, SAFETY, closeness, with_last_digits};
use crate::analysis::lagrange::weights;
use crate::analysis::normal_form::{CriticalPair, NormalForm, ReturnMap};
use crate::dynamics::Vector;

/// A special orbit that was located, and its place on the line.
pub(super) struct LocatedOrbit {
    pub s: f64,
    pub cycle: Cycle,
    pub uncertainties: [f64; 2],
}

/// A coefficient of more than so many uncertainties has a sign that is right at all of many orbits.
/// Chosen: where it vanishes all along a curve, its noise exceeds one uncertainty at some.
const KNOWN_SIGN: f64 = 10.0;

/// A function of the orbits of a curve.
type OrbitFunction<'f> = dyn Fn(&Cycle, &CurveCondition) -> Option<f64> + 'f;

/// The uncertainty of a function that has none besides its rounding.
pub(super) fn certain(_: &Cycle, _: &CurveCondition) -> Option<f64> {
    Some(0.0)
}

impl CurveContinuation<'_> {
    fn tests(&self) -> &'static [CodimensionTwoTest] {
        self.kind.map_or(&[], CurveKind::tests)
    }

    /// The functions at an orbit of the curve.
    pub(super) fn values(&self, cycle: &Cycle, condition: &CurveCondition) -> Vec<Option<f64>> {
        let value = |test: &CodimensionTwoTest| match test {
            // Only a sign that is known tells anything.
            CodimensionTwoTest::Coefficient => {
                let form = self.normal_form(cycle, condition)?;
                let is_known = form.coefficient.abs() > KNOWN_SIGN * form.uncertainty;
                is_known.then_some(form.coefficient)
            }
            test => self.value(*test, cycle, condition),
        };
        self.tests().iter().map(value).collect()
    }

    /// The normal form at an orbit of a curve of flips or of Neimark–Sacker bifurcations.
    fn normal_form(&self, cycle: &Cycle, condition: &CurveCondition) -> Option<NormalForm> {
        let of = match condition.sum_of_pair() {
            Some(sum) => CriticalPair::Angle(angle_of(sum)?),
            None => CriticalPair::Flip,
        };
        ReturnMap::of(cycle, &self.shooting)?.normal_form(of, &[1.0])
    }

    fn value(
        &self,
        test: CodimensionTwoTest,
        cycle: &Cycle,
        condition: &CurveCondition,
    ) -> Option<f64> {
        if condition.arrival().is_some() {
            return None;
        }
        let of = || critical(cycle, &self.shooting);
        match (test, self.kind?) {
            (CodimensionTwoTest::Fold, CurveKind::Fold) => Some(others(&of()?.multipliers, 1.0)),
            (CodimensionTwoTest::Flip, CurveKind::Flip) => Some(others(&of()?.multipliers, -1.0)),
            // The product of the other multipliers, less 1 each, does not see the pair.
            (CodimensionTwoTest::Fold, CurveKind::Torus) => {
                Some(of()?.one / (2.0 - condition.sum_of_pair()?))
            }
            (CodimensionTwoTest::Flip, CurveKind::Torus) => {
                Some(of()?.minus_one / (2.0 + condition.sum_of_pair()?))
            }
            (CodimensionTwoTest::Fold, _) => Some(of()?.one),
            (CodimensionTwoTest::Flip, _) => Some(of()?.minus_one),
            (CodimensionTwoTest::Torus, _) => of()?.circle,
            (CodimensionTwoTest::Sum(sum), _) => Some(condition.sum_of_pair()? - sum),
            (CodimensionTwoTest::Coefficient, _) => {
                Some(self.normal_form(cycle, condition)?.coefficient)
            }
        }
    }

    /// The special orbits between two orbits of the curve, in their order, with their places.
    pub(super) fn special_between(
        &self,
        at: &CurvePosition,
        next: &CurvePosition,
        orbits: usize,
    ) -> Vec<(f64, CurveSpecialPoint)> {
        let length = at.line.place(&next.cycle);
        let mut found = Vec::new();
        // The functions a step before, where one has no sign at the last orbit.
        let before = LazyCell::new(|| {
            let (cycle, condition) = self.on(at, -length)?;
            Some(self.values(&cycle, &condition))
        });
        for (k, &test) in self.tests().iter().enumerate() {
            let Some(b) = next.values[k] else {
                continue;
            };
            let begin = match at.values[k] {
                Some(a) if a != 0.0 => Some((0.0, a)),
                _ => before
                    .as_ref()
                    .and_then(|values| Some((-length, values[k]?))),
            };
            let Some((begin, a)) = begin.filter(|(_, a)| a * b < 0.0) else {
                continue;
            };
            let function =
                |cycle: &Cycle, condition: &CurveCondition| self.value(test, cycle, condition);
            let doubt = |cycle: &Cycle, condition: &CurveCondition| match test {
                CodimensionTwoTest::Coefficient => {
                    Some(self.normal_form(cycle, condition)?.uncertainty)
                }
                _ => Some(0.0),
            };
            let located = self.located(at, [(begin, a), (length, b)], [&function, &doubt]);
            found.extend(located.and_then(|located| {
                let what = self.kind?.named(test);
                let behind = if located.s < 0.0 { orbits - 1 } else { orbits };
                Some((located.s, self.described(&located, what, behind)))
            }));
        }
        if self.kind == Some(CurveKind::Fold) {
            found.extend(self.cusp(at, next, length).map(|located| {
                let behind = if located.s < 0.0 { orbits - 1 } else { orbits };
                let what = CurveBifurcation::Cusp;
                (located.s, self.described(&located, what, behind))
            }));
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        found
    }

    pub(super) fn described(
        &self,
        located: &LocatedOrbit,
        what: CurveBifurcation,
        behind: usize,
    ) -> CurveSpecialPoint {
        let cycle = &located.cycle;
        CurveSpecialPoint {
            parameters: parameters(cycle),
            uncertainties: located.uncertainties,
            what,
            behind,
            t: cycle.anchor.t,
            x: cycle.anchor.x.clone(),
            period: cycle.period,
        }
    }

    /// A copy with steps of half the length.
    pub(super) fn finer(&self) -> Self {
        CurveContinuation {
            shooting: self.shooting.finer(),
            units: self.units.clone(),
            ..*self
        }
    }

    /// The orbit of the curve at which a function with an uncertainty vanishes, between two places
    /// on a line.
    pub(super) fn located(
        &self,
        at: &CurvePosition,
        [a, b]: [(f64, f64); 2],
        [function, doubt]: [&OrbitFunction<'_>; 2],
    ) -> Option<LocatedOrbit> {
        // Value at a zero, as a fraction of those at the ends. Chosen, as for branches: at a jump
        // of the function it is about 1.
        const AT_ZERO: f64 = 1e-3;
        // Distance of the places between which the slope is measured, as a fraction of the step.
        // Chosen: the curvature then changes the slope by about as much.
        const NEIGHBOUR: f64 = 1e-3;
        let value = |s: f64| {
            let (cycle, condition) = self.on(at, s)?;
            Some((function(&cycle, &condition)?, cycle, condition))
        };
        let s = zero_between(a, b, |s| Some(value(s)?.0))?;
        let (here, cycle, condition) = value(s)?;
        let doubt = doubt(&cycle, &condition)?;
        if here.abs() > doubt + AT_ZERO * a.1.abs().max(b.1.abs()) {
            return None;
        }
        let apart = NEIGHBOUR * (b.0 - a.0);
        let [before, behind] = [value(s - apart)?, value(s + apart)?];
        // Beside the zero, if half the steps find no orbit there.
        let mut beside = [0.0, 1.0, -1.0, 10.0, -10.0].into_iter();
        let finer = beside.find_map(|times| {
            let place = s + times * apart;
            let (finer, condition) = self.finer().on(at, place)?;
            Some((value(place)?, function(&finer, &condition)?, finer))
        });
        // Otherwise it is known as well as orbits close.
        let by_tolerance = closeness(self.shooting.options);
        let of_steps = match &finer {
            Some((coarse, finer, _)) => SAFETY * (finer - coarse.0).abs(),
            None => by_tolerance * a.1.abs().max(b.1.abs()),
        };
        let curved = (before.0 - 2.0 * here + behind.0).abs();
        let error = here.abs() + curved + of_steps + doubt;
        let slope = (behind.0 - before.0) / (2.0 * apart);
        let of_place = (error / slope).abs();
        let ends = [&before.1, &behind.1].map(parameters);
        let rate = |k: usize| (ends[1][k] - ends[0][k]).abs() / (2.0 * apart);
        let uncertainties = match &finer {
            Some((coarse, _, finer)) => {
                self.uncertainties([&coarse.1, finer], |k| rate(k) * of_place)
            }
            None => {
                let widths = self.widths();
                self.uncertainties([&cycle; 2], |k| {
                    rate(k) * of_place + by_tolerance * widths[k]
                })
            }
        };
        Some(LocatedOrbit {
            s,
            cycle,
            uncertainties,
        })
    }

    /// The uncertainties of both parameters of an orbit: the error of integration, which half the
    /// steps show, with what the place on the curve and rounding leave.
    pub(super) fn uncertainties(
        &self,
        [cycle, finer]: [&Cycle; 2],
        of_place: impl Fn(usize) -> f64,
    ) -> [f64; 2] {
        let (values, finer, widths) = (parameters(cycle), parameters(finer), self.widths());
        [0, 1].map(|k| {
            // Places on the curve and across it are located to so much of the ranges.
            let resolved = 2.0 * RESOLVED_PLACE * widths[k];
            let of_steps = SAFETY * (finer[k] - values[k]).abs();
            let uncertainty = of_place(k) + of_steps + resolved;
            let rounding = (widths[k], cycle.steps);
            with_last_digits((values[k], uncertainty), f64::NAN, rounding)
        })
    }

    /// The cusp near an orbit of a curve of folds, if the parameters turn back between the one
    /// before it and the next.
    ///
    /// There the parameters are stationary along the curve. They are interpolated by a polynomial.
    fn cusp(&self, at: &CurvePosition, next: &CurvePosition, length: f64) -> Option<LocatedOrbit> {
        const NODES_EACH_SIDE: i32 = 4;
        // Rate of the parameters at a cusp, as a fraction of that at the nodes. Chosen: where the
        // curve only turns, it is about 1.
        const AT_REST: f64 = 1e-2;
        let widths = self.widths();
        let scaled = |line: &Vector| [0, 1].map(|k| line[self.place + k] / widths[k]);
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        let [before, behind] = [at, next].map(|one| scaled(&one.line.direction));
        if dot(before, behind) >= 0.0 {
            return None;
        }
        let places = -NODES_EACH_SIDE..=NODES_EACH_SIDE;
        let places = places.map(|k| length * f64::from(k) / f64::from(NODES_EACH_SIDE));
        let node = |s: f64| Some((s, self.scaled(&self.on(at, s)?.0)));
        let nodes: Vec<(f64, [f64; 2])> = places.filter_map(node).collect();
        // Without some of them the polynomial would not resolve it.
        if nodes.len() <= NODES_EACH_SIDE as usize {
            return None;
        }
        let places: Vec<f64> = nodes.iter().map(|node| node.0).collect();
        let value = |s: f64| {
            let terms = weights(&places, s).into_iter().zip(&nodes);
            terms.fold([0.0; 2], |sum, (weight, (_, at))| {
                [sum[0] + weight * at[0], sum[1] + weight * at[1]]
            })
        };
        let apart = 1e-3 * length;
        let rate = |s: f64| {
            let [a, b] = [value(s - apart), value(s + apart)];
            [0, 1].map(|k| (b[k] - a[k]) / (2.0 * apart))
        };
        let along = |s: f64| dot(rate(s), before);
        let ends = [-length, length].map(|s| (s, along(s)));
        if ends[0].1 * ends[1].1 >= 0.0 {
            return None;
        }
        let s = zero_between(ends[0], ends[1], |s| Some(along(s)))?;
        let size = |s: f64| dot(rate(s), rate(s)).sqrt();
        if size(s) > AT_REST * size(-length).max(size(length)) {
            return None;
        }
        let (cycle, _) = self.on(at, s)?;
        let (finer, _) = self.finer().on(at, s)?;
        // The parameters are quadratic in the place, so that its error moves them little: by the
        // rate that is left.
        let left = size(s) * apart;
        let uncertainties = self.uncertainties([&cycle, &finer], |k| left * widths[k]);
        Some(LocatedOrbit {
            s,
            cycle,
            uncertainties,
        })
    }
}
