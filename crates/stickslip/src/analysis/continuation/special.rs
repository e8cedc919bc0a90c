//! The special orbits between two on a branch, by their multipliers.

use super::corrector::{OnBranch, parameter};
use super::line::Line;
use super::walk::Walk;
use super::{Special, SpecialPoint};
use crate::analysis::critical::{Critical, Value, uncertainty_of_zero, zero_between};
use crate::analysis::lagrange::weights;
use crate::analysis::sequence::of_tolerance;
use crate::dynamics::Vector;

impl Walk<'_> {
    /// Goes on from this orbit, and tells what is special between the last one and it, by the multipliers.
    pub(super) fn follow(&mut self, next: OnBranch) {
        let behind = self.points.len();
        self.take(next);
        let line = self.line();
        let is_forced = self.settings.forced.is_some();
        let of = |orbit: &OnBranch| orbit.branch.critical(is_forced);
        let (here, there) = (of(&self.before), of(&self.last));
        type Function = fn(&Critical) -> Option<f64>;
        let functions: [Function; 3] = [|c| Some(c.one), |c| Some(c.minus_one), |c| c.circle];
        let mut found = Vec::new();
        for (kind, function) in functions.into_iter().enumerate() {
            let (Some(a), Some(b)) = (function(&here), function(&there)) else {
                continue;
            };
            if a * b >= 0.0 {
                continue;
            }
            let value = |s: f64| self.on(&line, s).and_then(|orbit| function(&of(&orbit)));
            let zero = zero_between((-line.length, a), (0.0, b), value);
            let by_polynomial =
                |rough: f64| self.interpolated(&line, rough, |orbit| function(&of(orbit)));
            let place = zero
                .and_then(|zero| self.next_to(&line, zero))
                .map(|orbit| self.with_uncertainty(&line, &orbit, |one| function(&of(one))))
                .or_else(|| by_polynomial(-line.length * b / (b - a)));
            let Some(mut place) = place else {
                continue;
            };
            let what = match kind {
                0 => self.fold_or_branch(&line, &place),
                1 => Special::Flip,
                _ => Special::NeimarkSacker {
                    angle: self
                        .next_to(&line, place.s)
                        .map_or(there.angle, |orbit| of(&orbit).angle),
                },
            };
            // Next to it orbits are worse than about it.
            if what == Special::BranchPoint
                && let Some(better) = by_polynomial(place.s)
            {
                place = better;
            }
            found.push((
                place.s,
                SpecialPoint {
                    parameter: parameter(&place.x),
                    uncertainty: place.uncertainty,
                    what,
                    behind,
                    x: place.x,
                    period: place.period,
                },
            ));
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        self.special
            .extend(found.into_iter().map(|(_, point)| point));
    }

    /// The place of an orbit at which a function of the multipliers is zero, with what the function lacks of it over its slope.
    fn with_uncertainty(
        &self,
        line: &Line,
        at: &OnBranch,
        function: impl Fn(&OnBranch) -> Option<f64>,
    ) -> Place {
        const APART: f64 = 1e-4;
        let way = APART * line.length;
        let value = |orbit: &OnBranch| {
            Some(Value {
                function: function(orbit)?,
                parameter: orbit.parameter(),
            })
        };
        let beside = |way: f64| value(&self.on(line, at.s + way)?);
        let by_slope = || {
            let beside = [beside(-way)?, beside(way)?];
            let shift = self.by_tolerance(line, at, &function)?;
            let along = uncertainty_of_zero(value(at)?, beside, shift.function);
            let both = along + shift.parameter;
            both.is_finite().then_some(both)
        };
        let place = Place::of(at);
        Place {
            uncertainty: self.at_least(&place.x, by_slope()),
            ..place
        }
    }

    /// By how much the tolerances may have a function of the multipliers and the parameter off, at an orbit's place.
    fn by_tolerance(
        &self,
        line: &Line,
        at: &OnBranch,
        function: impl Fn(&OnBranch) -> Option<f64>,
    ) -> Option<Value> {
        let finer = self.corrector.finer(&line.guess(at.s), at.s)?;
        Some(Value {
            function: of_tolerance(function(at)?, function(&finer)?),
            parameter: of_tolerance(at.parameter(), finer.parameter()),
        })
    }

    /// The orbit at a place, or, where another branch meets this one and Newton's matrix is singular, next to it.
    fn next_to(&self, line: &Line, s: f64) -> Option<OnBranch> {
        const PARTS: [f64; 5] = [0.0, 1e-10, -1e-10, 1e-9, -1e-9];
        let mut places = PARTS.iter().map(|part| s + part * line.length);
        places.find_map(|place| self.on(line, place))
    }

    /// Where a function of the multipliers is zero near a place, by a polynomial through orbits about it: where another branch meets this one Newton's matrix
    /// is singular, and no orbit is found next to it.
    fn interpolated(
        &self,
        line: &Line,
        rough: f64,
        function: impl Fn(&OnBranch) -> Option<f64>,
    ) -> Option<Place> {
        // So far apart, in parts of the distance between the last two orbits, and so many each way.
        const APART: f64 = 0.15;
        const EACH_WAY: i32 = 4;
        const FEWEST: usize = 5;
        let wanted = self.last.circuit.sequence();
        let mut nodes: Vec<(f64, Place)> = Vec::new();
        let mut shift = None;
        for k in (-EACH_WAY..=EACH_WAY).filter(|k| *k != 0) {
            let s = rough + APART * line.length * f64::from(k);
            let found = self.on(line, s);
            if let Some(orbit) = found.filter(|one| one.circuit.sequence() == wanted)
                && let Some(value) = function(&orbit)
            {
                shift = shift.or_else(|| self.by_tolerance(line, &orbit, &function));
                nodes.push((value, Place::of(&orbit)));
            }
        }
        if nodes.len() < FEWEST {
            return None;
        }
        let place = zero_of_polynomial(&nodes)?;
        let parameter = |place: &Place| parameter(&place.x);
        let known = || {
            let fewer = zero_of_polynomial(nodes.get(1..nodes.len() - 1)?)?;
            let (first, last) = (nodes.first()?, nodes.last()?);
            let slope = (last.0 - first.0) / (parameter(&last.1) - parameter(&first.1));
            let Value {
                function,
                parameter: along,
            } = shift?;
            let lacks = (parameter(&place) - parameter(&fewer)).abs();
            let uncertainty = lacks + (function / slope).abs() + along;
            uncertainty.is_finite().then_some(uncertainty)
        };
        let uncertainty = self.at_least(&place.x, known());
        Some(Place {
            uncertainty,
            ..place
        })
    }

    /// An uncertainty, which is no less than what Newton's iteration leaves of a parameter's last places; where there is none, the place lies between the last two.
    fn at_least(&self, x: &Vector, uncertainty: Option<f64>) -> f64 {
        const ROUNDING: f64 = 16.0 * f64::EPSILON;
        let [before, last] = [&self.before, &self.last].map(OnBranch::parameter);
        let uncertainty = uncertainty.unwrap_or((last - before).abs());
        uncertainty.max(ROUNDING * parameter(x).abs().max(self.width))
    }

    /// Whether the parameter turns back at a place between the last two orbits.
    fn fold_or_branch(&self, line: &Line, at: &Place) -> Special {
        // Not next to it: there another branch may be.
        let away = 0.5 * line.length;
        let at_place = |s: f64, end: &OnBranch| {
            let found = self.on(line, s);
            let orbit = found.filter(|one| one.circuit.sequence() == end.circuit.sequence());
            orbit.as_ref().unwrap_or(end).parameter()
        };
        let before = at_place(at.s - away, &self.before);
        let behind = at_place(at.s + away, &self.last);
        let here = parameter(&at.x);
        if (before - here) * (behind - here) < 0.0 {
            Special::BranchPoint
        } else {
            Special::Fold
        }
    }
}

/// A place on the branch.
struct Place {
    s: f64,
    uncertainty: f64,
    /// A state on the orbit there.
    x: Vector,
    period: f64,
}

impl Place {
    fn of(orbit: &OnBranch) -> Self {
        Place {
            s: orbit.s,
            uncertainty: 0.0,
            x: orbit.circuit.anchor.x.clone(),
            period: orbit.circuit.period,
        }
    }
}

/// Where the polynomial through values of a function is zero between two of them.
fn zero_of_polynomial(nodes: &[(f64, Place)]) -> Option<Place> {
    let places: Vec<f64> = nodes.iter().map(|(_, place)| place.s).collect();
    let value = |s: f64| -> f64 {
        let terms = weights(&places, s).into_iter().zip(nodes);
        terms.map(|(weight, (value, _))| weight * value).sum()
    };
    let mut pairs = nodes.windows(2);
    let ends = pairs.find(|two| two[0].0 * two[1].0 < 0.0)?;
    let [a, b] = [&ends[0], &ends[1]].map(|(value, place)| (place.s, *value));
    let s = zero_between(a, b, |s| Some(value(s)))?;
    let states = nodes.first()?.1.x.len();
    let weighted = || weights(&places, s).into_iter().zip(nodes);
    Some(Place {
        s,
        uncertainty: 0.0,
        x: weighted().fold(Vector::zeros(states), |sum, (weight, (_, place))| {
            sum + &place.x * weight
        }),
        period: weighted()
            .map(|(weight, (_, place))| weight * place.period)
            .sum(),
    })
}
