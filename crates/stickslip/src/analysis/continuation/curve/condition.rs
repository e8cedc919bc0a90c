//! The condition that all orbits of a curve meet, and the orbit of the curve in a plane.

use super::super::steps::Junction;
use super::super::tangent_line::TangentLine;
use super::super::{CycleBifurcation, critical};
use super::{CurveContinuation, EndPeriod};
use crate::analysis::critical::{Critical, Pair};
use crate::analysis::cycle::{
    Cycle, Margin, MarginKind, OrbitGuess, Shooting, SolutionsOnLine, StepBudget,
};
use crate::dynamics::Vector;

/// A function that vanishes on a curve.
#[derive(Clone)]
pub(super) enum TestFunction {
    /// A margin, whose position moves along the orbit.
    Margin(Box<Margin>),
    /// A function of the multipliers.
    Multipliers(fn(&Critical) -> Option<f64>),
    /// The product of a pair of multipliers, less 1. Near an orbit of the curve the pair has this
    /// sum.
    Pair(f64),
}

impl TestFunction {
    fn value(&self, cycle: &Cycle, shooting: &Shooting<'_>) -> Option<f64> {
        match self {
            TestFunction::Margin(margin) => Some(cycle.margin_like(margin)?.value),
            TestFunction::Multipliers(function) => function(&critical(cycle, shooting)?),
            TestFunction::Pair(sum) => Some(Pair::near(&critical(cycle, shooting)?, *sum)?.beyond),
        }
    }

    /// The function near another orbit of the curve.
    fn near(self, cycle: &Cycle, shooting: &Shooting<'_>) -> Self {
        match self {
            TestFunction::Margin(margin) => {
                let near = cycle.margin_like(&margin).cloned();
                TestFunction::Margin(near.map_or(margin, Box::new))
            }
            TestFunction::Pair(sum) => {
                let near = critical(cycle, shooting).and_then(|of| Pair::near(&of, sum));
                TestFunction::Pair(near.map_or(sum, |pair| pair.sum))
            }
            of_multipliers => of_multipliers,
        }
    }
}

/// Condition that all orbits of a curve meet.
#[derive(Clone)]
pub(super) enum CurveCondition {
    /// A segment has no duration: two contacts switch at once.
    NoDuration(usize),
    /// The period has this value, near an end of a branch.
    Period(f64, EndPeriod),
    /// A function vanishes. It was located on this line across the curve.
    Zero(TestFunction, TangentLine),
}

impl CurveCondition {
    pub(super) fn of(junction: &Junction) -> Option<Self> {
        let function = match (&junction.at.what, &junction.margin) {
            (CycleBifurcation::Sequence(_), Some(margin))
                if margin.kind == MarginKind::Duration =>
            {
                // Of one contact, a segment without duration determines nothing.
                margin.other?;
                return Some(CurveCondition::NoDuration(margin.part));
            }
            (CycleBifurcation::Sequence(_), Some(margin)) => {
                TestFunction::Margin(Box::new(margin.clone()))
            }
            (CycleBifurcation::Fold, _) => TestFunction::Multipliers(|of| Some(of.one)),
            (CycleBifurcation::Flip, _) => TestFunction::Multipliers(|of| Some(of.minus_one)),
            (CycleBifurcation::NeimarkSacker { angle }, _) => {
                TestFunction::Pair(2.0 * crate::math::cos(*angle))
            }
            _ => return None,
        };
        Some(CurveCondition::Zero(function, junction.line.clone()))
    }

    /// The margin, where the orbits arrive at a boundary, or at the function of a jump, without
    /// speed. Their derivatives are unbounded.
    pub(super) fn arrival(&self) -> Option<&Margin> {
        match self {
            CurveCondition::Zero(TestFunction::Margin(margin), _) => {
                (margin.kind == MarginKind::Arrival).then_some(margin)
            }
            _ => None,
        }
    }

    /// The sum of the pair of multipliers with the product 1, on a Neimark–Sacker curve.
    pub(super) fn sum_of_pair(&self) -> Option<f64> {
        match self {
            CurveCondition::Zero(TestFunction::Pair(sum), _) => Some(*sum),
            _ => None,
        }
    }
}

impl CurveContinuation<'_> {
    /// The orbit of the curve near a guess, in a plane: on it, the product of the unknowns with a
    /// row has a given value. With the condition near that orbit. A known orbit of the curve has
    /// so many steps.
    pub(super) fn solve(
        &self,
        (condition, steps): (&CurveCondition, usize),
        guess: &OrbitGuess,
        plane: (&Vector, f64),
    ) -> Option<(Cycle, CurveCondition)> {
        // Orbits that a solution may compute. Chosen: far more than it does, also by half steps.
        // Where there is none, Newton's iteration may come to states from which an orbit has
        // millions of steps.
        const MOST_ORBITS: u64 = 2000;
        let cost = 1 + StepBudget::with_tangents(guess.begin.x.len());
        let budget = StepBudget::of(MOST_ORBITS * cost * steps as u64);
        let held = |row: &Vector, value: f64| {
            let shooting = Shooting {
                plane: Some((row, value)),
                budget: Some(&budget),
                ..self.shooting
            };
            Some((shooting.solve(guess, Some(plane))?, condition.clone()))
        };
        match condition {
            CurveCondition::NoDuration(number) => {
                held(&guess.unit(guess.begin.x.len() + number), 0.0)
            }
            CurveCondition::Period(period, _) => held(&guess.by_duration(), *period),
            CurveCondition::Zero(function, line) => {
                let shooting = Shooting {
                    plane: Some(plane),
                    budget: Some(&budget),
                    ..self.shooting
                };
                let value = |cycle: &Cycle| function.value(cycle, &shooting);
                let row = line.across();
                let begin = shooting.solve(guess, Some((row, row.dot(&guess.unknowns()))))?;
                let line = TangentLine::tangent(&shooting, &self.units, &begin, row)?;
                let path = line.orbits(&shooting);
                let ends = path.bracket((0.0, value(&begin)?), self.settings.step, &value)?;
                let (s, found) = path.root(ends, &value)?;
                let function = function.clone().near(&found, &shooting);
                let is_near = s.abs() <= self.settings.step;
                is_near.then_some((found, CurveCondition::Zero(function, line)))
            }
        }
    }
}
