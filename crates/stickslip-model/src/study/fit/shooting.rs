//! Multiple shooting: parts with starts of their own, which have to meet.

use crate::study::least_squares::{
    LeastSquares, LeastSquaresEnd, LeastSquaresSettings, Loss, Residuals,
    constrained_least_squares, least_squares,
};
use rayon::prelude::*;
use stickslip::dynamics::Vector;

use super::parts::PartStart;
use super::problem::{FitProblem, Sequence};
use super::record_run::Failed;
use super::work::FitWork;
use super::{Fit, FitError, FitUncertainty, finished};

/// Weights of a mismatch over the spread of the state before the parts meet, from that of data with
/// much noise.
const WEIGHTS: [f64; 3] = [1e0, 1e1, 1e2];

/// Most evaluations at one weight, and for the start of a part alone. It is chosen: what follows
/// goes on from there.
const MOST_EVALUATIONS: usize = 40;

/// Relative tolerance at one weight.
const RELAXED: f64 = 1e-6;

/// Relative tolerance of the search in parts. It is chosen: a single orbit, where one follows, is
/// found to that of all fits.
const TOLERANCE: f64 = 1e-8;

/// Cost of a single orbit over that of its parts, up to which it is the result. Noise and mismatch
/// make it differ by less.
const SINGLE: f64 = 1.05;

/// Cost below which residuals are none: a millionth of the spread of a value.
const NO_COST: f64 = 1e-12;

/// The result of multiple shooting from a point: a single orbit, or its parts where none follows
/// the record, as none can where rounding grows beyond the noise.
pub(super) fn fit_in_parts(
    problem: &mut FitProblem<'_>,
    x: &Vector,
    settings: &LeastSquaresSettings,
    mut work: FitWork,
) -> Result<Fit, FitError> {
    let segments = problem.request.segments;
    let (mut parts, begun) = problem.in_parts(x, segments)?;
    let begun = starts_alone(&parts, begun, &mut work);
    let mut near = begun;
    for weight in WEIGHTS {
        near = relaxed(&parts, near, weight, &mut work)?;
    }
    let mut best = matched(&parts, &near, &mut work)?;
    let start = best.x.rows(0, problem.unknowns.len()).into_owned();
    let settings = LeastSquaresSettings {
        most_evaluations: work.left(),
        ..settings.clone()
    };
    if work.left() == 0 {
        best.end = LeastSquaresEnd::Evaluations;
    } else if let Ok(single) = least_squares(&start, &settings, |x| problem.residuals(x)) {
        work.add(&single);
        if single.cost <= SINGLE * parts.cost_of_data(&best.at.values) + NO_COST {
            return finished(problem, single, &settings, work, Vec::new());
        }
    }
    problem.check_interrupt()?;
    for _ in 0..super::MOST_ROUNDS {
        let scales = parts.sigmas.clone();
        let largest = parts.estimate_sigmas(&best.at.values);
        if scales == parts.sigmas {
            break;
        }
        if work.left() == 0 {
            best.end = LeastSquaresEnd::Evaluations;
            break;
        }
        best = matched(&parts, &best.x, &mut work)?;
        if largest <= super::SAME_SIGMA {
            break;
        }
    }
    let uncertainty = FitUncertainty::of(&parts, &best);
    parts.result(&best, work, uncertainty, Vec::new())
}

/// The point with the start of each part fitted alone, with the parameters held: from the best of
/// its candidates.
fn starts_alone(parts: &FitProblem<'_>, mut x: Vector, work: &mut FitWork) -> Vector {
    let nodes = parts.parts.as_ref().map_or(&[][..], |parts| &parts.nodes);
    let most = work.left();
    let alone = nodes
        .par_iter()
        .map(|node| start_alone(parts, &x, node, most));
    let alone: Vec<(Vector, usize)> = alone.collect();
    let runs: usize = alone.iter().map(|(_, runs)| runs).sum();
    // All parts together are a run.
    work.evaluations += runs.div_ceil(nodes.len().max(1));
    for (node, (start, _)) in nodes.iter().zip(alone) {
        x.rows_mut(node.first, start.len()).copy_from(&start);
    }
    x
}

/// The best start of a part with the parameters held, and the number of its runs. After those of
/// the candidates there are at most so many.
fn start_alone(
    parts: &FitProblem<'_>,
    x: &Vector,
    node: &PartStart,
    most: usize,
) -> (Vector, usize) {
    let states = node.candidates.first().map_or(0, Vector::len);
    let residuals = |start: &Vector| {
        let mut x = x.clone();
        x.rows_mut(node.first, states).copy_from(start);
        parts.of_part(node, &x)
    };
    let cost = |start: &Vector| {
        let loss = parts.request.loss;
        let sum = |at: Residuals<Sequence>| at.values.iter().map(|r| loss.of(*r).0).sum();
        residuals(start).map_or(f64::INFINITY, sum)
    };
    let rated = node.candidates.iter().map(|start| (cost(start), start));
    let best = rated.reduce(|one, other| if other.0 < one.0 { other } else { one });
    let best = best.map_or_else(|| Vector::zeros(states), |(_, start)| start.clone());
    let tried = node.candidates.len();
    let left = most.saturating_sub(tried).max(1);
    let settings = LeastSquaresSettings {
        bounds: vec![(f64::NEG_INFINITY, f64::INFINITY); states],
        ..settings(parts.request.loss, MOST_EVALUATIONS.min(left))
    };
    match least_squares(&best, &settings, residuals) {
        Ok(found) => (found.x, tried + found.evaluations),
        Err(_) => (best, tried + 1),
    }
}

/// The minimum near a point where a mismatch costs its weighted square (relaxed as by Ribeiro et
/// al., *Automatica* 121 (2020) 109158).
fn relaxed(
    parts: &FitProblem<'_>,
    x: Vector,
    weight: f64,
    work: &mut FitWork,
) -> Result<Vector, FitError> {
    let count = MOST_EVALUATIONS.min(work.left());
    if count == 0 {
        return Ok(x);
    }
    let settings = LeastSquaresSettings {
        bounds: parts.unknowns.bounds(),
        tolerance: RELAXED,
        ..settings(parts.request.loss, count)
    };
    let found = least_squares(&x, &settings, |x| {
        let mut at = parts.residuals(x)?;
        let from = at.values.len() - at.constraints;
        at.values.rows_range_mut(from..).scale_mut(weight);
        at.jacobian.rows_range_mut(from..).scale_mut(weight);
        Ok::<_, Failed>(at)
    });
    let found = found.map_err(|error| parts.failed(error));
    parts.check_interrupt()?;
    let found = found?;
    work.add(&found);
    match found.end {
        LeastSquaresEnd::NotFinite => Err(parts.lost(&found.x)),
        _ => Ok(found.x),
    }
}

/// The minimum of multiple shooting near a point, at which the parts meet (Bock, *Modelling of
/// Chemical Reaction Systems*, 1981, 102).
pub(super) fn matched(
    parts: &FitProblem<'_>,
    x: &Vector,
    work: &mut FitWork,
) -> Result<LeastSquares<Sequence>, FitError> {
    let settings = LeastSquaresSettings {
        bounds: parts.unknowns.bounds(),
        ..settings(parts.request.loss, work.left().max(1))
    };
    let found = constrained_least_squares(x, &settings, |x| parts.residuals(x));
    let found = found.map_err(|error| parts.failed(error));
    parts.check_interrupt()?;
    let found = found?;
    work.add(&found);
    match found.end {
        LeastSquaresEnd::NotFinite => Err(parts.lost(&found.x)),
        _ => Ok(found),
    }
}

fn settings(loss: Loss, most_evaluations: usize) -> LeastSquaresSettings {
    LeastSquaresSettings {
        bounds: Vec::new(),
        loss,
        tolerance: TOLERANCE,
        most_evaluations,
    }
}
