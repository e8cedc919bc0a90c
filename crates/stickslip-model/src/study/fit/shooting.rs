//! Multiple shooting: segments with starts of their own, which are matched more and more tightly.

use rayon::prelude::*;
use stickslip::analysis::{
    LeastSquares, LeastSquaresEnd, LeastSquaresSettings, Loss, Residuals, least_squares,
};
use stickslip::dynamics::Vector;

use super::problem::{Failed, Problem, Sequence};

/// Weights of a mismatch over the spread of the state, from that of data with much noise to one
/// that leaves a millionth.
const WEIGHTS: [f64; 7] = [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6];

/// Most evaluations at one weight. It is chosen: the next weight goes on from there.
const MOST_EVALUATIONS: usize = 40;

/// States along the first run from which a segment may begin.
const CANDIDATES: usize = 40;

/// Relative tolerance at one weight.
const TOLERANCE: f64 = 1e-6;

/// The minimum of multiple shooting, and its problem (Bock, *Modelling of
/// Chemical Reaction Systems*, 1981, 102; relaxed as by Ribeiro et al., *Automatica* 121 (2020)
/// 109158): the record in `segments` parts, each with a start of its own. A mismatch costs more
/// from stage to stage, until the parts are one orbit.
///
/// None where a run of the parts fails, or a discrete state would need a start.
pub(super) fn shot<'r>(
    problem: &Problem<'r>,
    x: &Vector,
    segments: usize,
) -> Option<(Problem<'r>, LeastSquares<Sequence>)> {
    let (mut parts, mut whole) = problem.in_segments(x, segments, CANDIDATES)?;
    // Each segment alone, with the parameters held.
    let begun: Vec<(usize, Vector)> = parts
        .nodes()
        .into_par_iter()
        .map(|node| {
            let (instance, from, candidates) = (node.instance, node.first, node.candidates);
            let states = candidates.first().map_or(0, Vector::len);
            let placed = |of: &Vector| {
                let mut x = whole.clone();
                x.rows_mut(from, states).copy_from(of);
                x
            };
            let alone = |of: &Vector| parts.of_instance(instance, &placed(of));
            let cost = |of: &Vector| {
                let at: Result<Residuals<Sequence>, Failed> = alone(of);
                at.map_or(f64::INFINITY, |at| at.values.norm_squared())
            };
            let rated = candidates.into_iter().map(|of| (cost(&of), of));
            let best = rated.reduce(|one, other| if other.0 < one.0 { other } else { one });
            let best = best.map_or_else(|| Vector::zeros(states), |(_, of)| of);
            let free = vec![(f64::NEG_INFINITY, f64::INFINITY); states];
            let local = least_squares(&best, &settings(MOST_EVALUATIONS, free), |of| {
                let mut at = alone(of)?;
                at.jacobian = at.jacobian.columns(from, states).into_owned();
                Ok::<_, Failed>(at)
            });
            (from, local.map_or(best, |local| local.x))
        })
        .collect();
    for (from, of) in begun {
        whole.rows_mut(from, of.len()).copy_from(&of);
    }
    let mut last = None;
    for weight in WEIGHTS {
        parts.set_weight(weight);
        let found = tightened(&parts, &whole)?;
        whole = found.x.clone();
        last = Some(found);
    }
    Some((parts, last?))
}

/// The minimum near a point at the present weight.
pub(super) fn tightened(parts: &Problem<'_>, x: &Vector) -> Option<LeastSquares<Sequence>> {
    let settings = settings(MOST_EVALUATIONS, parts.bounds());
    let found = least_squares(x, &settings, |x| parts.residuals(x)).ok();
    found.filter(|found| found.end != LeastSquaresEnd::NotFinite)
}

fn settings(count: usize, bounds: Vec<(f64, f64)>) -> LeastSquaresSettings {
    LeastSquaresSettings {
        bounds,
        loss: Loss::Squares,
        tolerance: TOLERANCE,
        most_evaluations: count,
    }
}
