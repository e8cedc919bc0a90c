//! Where an orbit that keeps its phases loses its stability, or ends, by one of its multipliers.

use super::WhatChanges;
use super::change::{Shooting, Way, extrapolated};
use crate::analysis::continuation::Special;
use crate::analysis::critical::{Critical, Value, uncertainty_of_zero, zero_between};
use crate::analysis::monodromy::turn;
use crate::analysis::sequence::locate::Known;
use crate::analysis::sequence::of_tolerance;

/// At an end of the orbit located to 1e-10 a multiplier that goes to 1 like a root is some 1e-5 from it.
const NEAR_ONE: f64 = 1e-3;

impl Shooting<'_> {
    /// The first of its multipliers to reach the unit circle on the way.
    pub(super) fn multiplier(&self, way: &Way) -> Option<WhatChanges> {
        const ONE: usize = 0;
        const MINUS_ONE: usize = 1;
        type Function = fn(&Critical) -> Option<f64>;
        let functions: [Function; 3] = [|at| Some(at.one), |at| Some(at.minus_one), |at| at.circle];
        let critical: Vec<Option<Critical>> =
            way.good.iter().map(|orbit| self.critical(orbit)).collect();
        for (orbits, values) in way.good.windows(2).zip(critical.windows(2)) {
            let ([one, two], [Some(here), Some(there)]) = (orbits, values) else {
                continue;
            };
            // Next to a fold rounding tells the sign.
            let is_noise = here.gap_to_one().max(there.gap_to_one()) < NEAR_ONE;
            let orbit = |s: f64| {
                let (guess, period) = extrapolated(orbits, s)?;
                self.orbit(s, &guess, period)
            };
            for (kind, function) in functions.into_iter().enumerate() {
                let (Some(a), Some(b)) = (function(here), function(there)) else {
                    continue;
                };
                if a * b >= 0.0 || kind == ONE && is_noise {
                    continue;
                }
                let value = |s: f64| function(&self.critical(&orbit(s)?)?);
                let Some(zero) = zero_between((one.s, a), (two.s, b), value) else {
                    continue;
                };
                let by_slope = || {
                    const APART: f64 = 1e-4;
                    let way = APART * (two.s - one.s);
                    let at = orbit(zero)?;
                    let value = |s: f64| {
                        Some(Value {
                            function: value(s)?,
                            parameter: s,
                        })
                    };
                    let beside = [value(zero - way)?, value(zero + way)?];
                    let by_tolerance = self.by_tolerance(&at, function)?;
                    let uncertainty = uncertainty_of_zero(value(zero)?, beside, by_tolerance);
                    uncertainty.is_finite().then_some(uncertainty)
                };
                // Where another branch meets it no orbit can be computed: it lies between the two.
                let uncertainty = by_slope().unwrap_or_else(|| (two.s - one.s).abs());
                let at = orbit(zero).unwrap_or_else(|| two.clone());
                let what = match kind {
                    ONE => Special::BranchPoint,
                    MINUS_ONE => Special::Flip,
                    _ => Special::NeimarkSacker {
                        angle: self.critical(&at)?.angle,
                    },
                };
                return Some(changes((zero, uncertainty), what, &at));
            }
        }
        let (last, nearest) = (way.good.last()?, critical.last()?.as_ref()?);
        let is_fold = way.bad.is_some() && nearest.gap_to_one() < NEAR_ONE;
        is_fold.then(|| {
            let lacks = way.bad.map_or(0.0, |bad| (bad - last.s).abs());
            let uncertainty = lacks + self.fold_by_tolerance(way, &critical);
            changes((last.s, uncertainty), Special::Fold, last)
        })
    }

    /// By how much the tolerances may have a function of the multipliers off.
    fn by_tolerance(
        &self,
        orbit: &Known<()>,
        function: impl Fn(&Critical) -> Option<f64>,
    ) -> Option<f64> {
        let finer = self.finer();
        let anchor = &orbit.circuit.anchor;
        let same = finer.orbit(orbit.s, anchor, orbit.circuit.period)?;
        let [value, other] = [self.critical(orbit)?, finer.critical(&same)?];
        Some(of_tolerance(function(&value)?, function(&other)?))
    }

    /// By how much the tolerances may have a fold off at the end of the way: there the square of the multipliers' function goes to zero like the parameter.
    fn fold_by_tolerance(&self, way: &Way, critical: &[Option<Critical>]) -> f64 {
        let square = |at: &Critical| Some(at.one * at.one);
        let known = way.good.iter().zip(critical);
        let known = known.filter_map(|(orbit, at)| Some((orbit, square(at.as_ref()?)?)));
        let known: Vec<(&Known<()>, f64)> = known.collect();
        let shift = |k: usize| {
            let (orbit, value) = known[k];
            let apart = known[..k]
                .iter()
                .rev()
                .find(|other| other.1 >= 2.0 * value)?;
            let slope = (apart.0.s - orbit.s) / (apart.1 - value);
            let shift = (self.by_tolerance(orbit, square)? * slope).abs();
            shift.is_finite().then_some(shift)
        };
        let shift = (0..known.len()).rev().find_map(shift);
        // Where nothing tells, it may be as far away as the orbits known reach.
        shift.unwrap_or_else(|| match (known.first(), known.last()) {
            (Some((first, _)), Some((last, _))) => (last.s - first.s).abs(),
            _ => 0.0,
        })
    }

    fn critical(&self, orbit: &Known<()>) -> Option<Critical> {
        let system = (self.family)(orbit.s);
        let (start, options) = (&orbit.circuit.anchor, &self.options);
        let t_end = start.t + orbit.circuit.period;
        let is_autonomous = self.forced.is_none();
        let turn = turn(&*system, start, t_end, options, is_autonomous).ok()?;
        let flow = is_autonomous.then(|| start.velocity(&*system));
        Some(Critical::of(&turn.monodromy.matrix, flow.as_ref(), 0))
    }
}

fn changes((parameter, uncertainty): (f64, f64), what: Special, orbit: &Known<()>) -> WhatChanges {
    WhatChanges::Multiplier {
        parameter,
        uncertainty,
        what,
        x: orbit.circuit.anchor.x.clone(),
        period: orbit.circuit.period,
    }
}
