//! Curves of the ends of branches at which the period is infinite or zero.

use std::ops::ControlFlow;

use super::condition::CurveCondition;
use super::{Curve, CurveContinuation, CurveSettings, follow_from};
use crate::analysis::continuation::tangent_line::{TangentLine, Units};
use crate::analysis::continuation::{
    ContinuationSettings, CycleBifurcation, SpecialPoint, Stop, parameter_of,
};
use crate::analysis::cycle::{Cycle, SAFETY, Shooting};
use crate::analysis::lagrange::weights;
use crate::dynamics::{AsDynamics, Components, Vector};
use crate::error::Error;
use crate::filippov::Options;

/// Distance from a homoclinic end, as a fraction of the range, at which the orbits of its curve
/// begin. Chosen: the extrapolation leaves its square, and nearer orbits are determined to fewer
/// digits.
const NEAR: f64 = 1e-6;

/// Precision to which the end must be extrapolated from each orbit, as a fraction of the range.
/// Chosen: a hundredth of the distance at which the orbits begin.
const RESOLVED: f64 = 1e-8;

/// An end of a branch that has a curve: the period there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum EndPeriod {
    Infinite,
    Zero,
}

impl EndPeriod {
    /// Periods of the orbits from which the end is extrapolated, in that of the nearest.
    fn nodes(self) -> Vec<f64> {
        // Difference of the periods near infinity, as a fraction. Chosen: where the distance is
        // 1e-6, it then grows by about 2 from one to the next.
        const SHORTER: f64 = 0.05;
        // Number of orbits near zero; each period is twice the one before. Chosen, as where the
        // end of the branch is extrapolated.
        const NODES: i32 = 5;
        match self {
            EndPeriod::Infinite => (0..4).map(|k| 1.0 - SHORTER * f64::from(k)).collect(),
            EndPeriod::Zero => (0..NODES).map(|k| f64::from(1 << k)).collect(),
        }
    }

    /// The limit of a parameter at the nodes, the nearest first, and one from fewer of them.
    fn limits(self, values: &[f64]) -> [f64; 2] {
        match self {
            EndPeriod::Infinite => [aitken(&values[..3]), aitken(&values[1..])],
            EndPeriod::Zero => [values.len(), values.len() - 1].map(|count| {
                let weights = weights(&self.nodes()[..count], 0.0).into_iter();
                weights
                    .zip(values)
                    .map(|(weight, value)| weight * value)
                    .sum()
            }),
        }
    }

    /// The parameter at the end of the branch of an orbit, and its uncertainty. That is the
    /// difference of both limits, with the error of integration. `None` where the limits differ by
    /// more than a fraction of the range. Next to a saddle whose orbits oscillate, they differ by
    /// about the distance.
    fn place(
        self,
        (shooting, units): (&Shooting<'_>, &Units),
        cycle: &Cycle,
        resolved: f64,
    ) -> Option<(f64, f64)> {
        // With the derivatives in the plane of this branch.
        let mut at = shooting.evaluated(&cycle.outline)?;
        let mut values = Vec::new();
        for node in self.nodes() {
            at = with_period(shooting, units, at, node * cycle.period)?;
            values.push(parameter_of(&at));
        }
        let [limit, fewer] = self.limits(&values);
        let of_limit = (limit - fewer).abs();
        let plane = (&cycle.outline.by_duration(), cycle.period);
        let finer = shooting.finer().solve(&cycle.outline, Some(plane))?;
        let of_steps = SAFETY * (parameter_of(&finer) - values[0]).abs();
        (of_limit <= resolved * units.width).then_some((limit, of_limit + of_steps))
    }
}

/// The limit of a geometric sequence, its last element first (Aitken 1926).
fn aitken(values: &[f64]) -> f64 {
    let (last, before) = (values[0] - values[1], values[1] - values[2]);
    let ratio = last / before;
    let falls = ratio > 0.0 && ratio < 1.0;
    values[0]
        + if falls {
            last * ratio / (1.0 - ratio)
        } else {
            0.0
        }
}

impl Curve {
    /// Follows in two parameters the end of a branch of periodic orbits: a homoclinic orbit, a
    /// heteroclinic cycle, or a two-fold to which crossing orbits shrink.
    ///
    /// **The parameters are the last two states**, as in [`super::Curve::of_special`]. The curve is
    /// that of orbits of one period, long near a saddle and short near a two-fold (Doedel &
    /// Kernévez 1986). The parameter of the branch is extrapolated at each of them, to an infinite
    /// period or to zero, from orbits of other periods with the same other parameter.
    /// [`super::CurvePoint::uncertainty`] says how well. The curve ends where that does not
    /// determine the end to 1e-8 of the range. State and period are those of the orbit.
    ///
    /// # Errors
    /// Those of [`crate::analysis::continue_periodic_orbit`]; [`Error::NotFound`] where the branch
    /// has another end, or no curve continues from it.
    pub fn of_end<Kind>(
        system: &impl AsDynamics<Kind>,
        x: impl Components,
        (period, upwards): (f64, bool),
        (settings, other): (&ContinuationSettings, (f64, f64)),
        options: &Options,
    ) -> Result<Curve, Error> {
        let system = &*system.dynamics();
        let start = (x.vector(), period, upwards);
        let how = CurveSettings { settings, other };
        follow_from(system, start, how, options, |continuation| {
            let mut cycles: Vec<Cycle> = Vec::new();
            let stop = continuation.go_on(&mut |branch| {
                cycles.push(branch.last.clone());
                ControlFlow::Continue(())
            });
            let last = &continuation.branch.last;
            let at = stop.as_special(&last.anchor.x, last.period)?;
            let end = match at.what {
                CycleBifurcation::Homoclinic { .. } => EndPeriod::Infinite,
                _ => EndPeriod::Zero,
            };
            let near = NEAR * continuation.branch.units.width;
            let is_near = |one: &Cycle| (parameter_of(one) - at.parameter).abs() <= near;
            let (shooting, units) = (&continuation.shooting, &continuation.branch.units);
            // Farther along the curve it may be resolved less.
            let is_resolved = |one: &Cycle| {
                let place = end.place((shooting, units), one, 1e-2 * RESOLVED);
                place.is_some()
            };
            let cycle = match end {
                EndPeriod::Infinite => cycles
                    .into_iter()
                    .find(|one| is_near(one) && is_resolved(one)),
                EndPeriod::Zero => None,
            };
            let cycle = cycle.unwrap_or_else(|| last.clone());
            Some((at, CurveCondition::Period(cycle.period, end), cycle))
        })
    }
}

impl Stop {
    /// The end as a special orbit, if it has a curve in two parameters: with a state and the period
    /// of the last orbit. Its `behind` is 0.
    pub fn as_special(&self, x: &Vector, period: f64) -> Option<SpecialPoint> {
        let (parameter, uncertainty, what) = match *self {
            Stop::Homoclinic {
                parameter,
                uncertainty,
                saddles,
                ..
            } => {
                let what = CycleBifurcation::Homoclinic { saddles };
                (parameter, uncertainty, what)
            }
            Stop::TwoFold {
                parameter,
                uncertainty,
            } => (parameter, uncertainty, CycleBifurcation::TwoFold),
            _ => return None,
        };
        Some(SpecialPoint {
            parameter,
            uncertainty,
            what,
            behind: 0,
            x: x.clone(),
            period,
            normal_form: None,
        })
    }
}

impl CurveContinuation<'_> {
    /// The parameter of the branch at the end that the orbits of a curve approach, with the other
    /// one fixed, and its uncertainty.
    pub(super) fn at_end(&self, cycle: &Cycle, end: EndPeriod) -> Option<(f64, f64)> {
        let row = cycle.outline.unit(self.place);
        let value = cycle.outline.begin.x[self.place];
        let shooting = Shooting {
            plane: Some((&row, value)),
            ..self.shooting
        };
        end.place((&shooting, &self.units), cycle, RESOLVED)
    }
}

/// The orbit of another period on the branch of an orbit.
fn with_period(
    shooting: &Shooting<'_>,
    units: &Units,
    mut at: Cycle,
    period: f64,
) -> Option<Cycle> {
    // Largest relative change of the period in a step. Chosen: Newton's iteration converges from
    // the tangent.
    const LARGEST: f64 = 0.2;
    while at.period != period {
        let row = at.outline.by_duration();
        let (least, most) = (at.period * (1.0 - LARGEST), at.period * (1.0 + LARGEST));
        let next = period.clamp(least, most);
        let line = TangentLine::tangent(shooting, units, &at, &row)?;
        let rate = row.dot(&line.direction);
        let guess = line.guess((next - at.period) / rate);
        let found = shooting.solve(&guess, Some((&row, next)))?;
        // The sum of the durations is the period but for rounding.
        at = Cycle {
            period: next,
            ..found
        };
    }
    Some(at)
}
