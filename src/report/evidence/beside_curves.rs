//! `fig07b.oscillation`: the motion of bodies that are placed on Σ beside the drawn curves.

use rayon::prelude::*;

use crate::figures::fig07::TangentPointMotion;
use crate::paper::TOLERANCE;
use crate::paper::models::ForcedOscillator;
use crate::paper::reading::Reading::Exact;
use crate::report::finding::{Finding, statement};
use crate::text::joined;
use stickslip::{Error, Mode, Options, State, solve};

/// Distances from the curves (m).
const DISTANCES: [f64; 3] = [1e-3, 1e-6, 1e-9];
/// Equidistant times of the drawn curve, without the first and the last.
const BESIDE_TIMES: usize = 24;
/// Length of the runs (s). Only the first phase matters.
const RUN_LENGTH: f64 = 1e-2;

/// Bodies at one distance from the curves.
#[derive(Default)]
struct BodiesBesideCurves {
    /// The distance (m).
    distance: f64,
    /// Bodies placed inside a zone, and as many outside.
    pairs: usize,
    /// Bodies inside that stick, and bodies outside that slip.
    inside_sticks: usize,
    outside_slips: usize,
}

/// Whether bodies placed on Σ just beside the drawn curves stick on one side of them and slip on
/// the other.
pub(super) fn beside_curves(
    model: &ForcedOscillator,
    drawn: &TangentPointMotion,
) -> Result<Vec<Finding>, Error> {
    let all = drawn.times.len();
    let every = (all / (BESIDE_TIMES + 1)).max(1);
    let times: Vec<usize> = (1..=BESIDE_TIMES)
        .map(|k| k * every)
        .filter(|&k| k < all)
        .collect();
    let beside = DISTANCES
        .into_par_iter()
        .map(|distance| at_distance(model, drawn, &times, distance))
        .collect::<Result<Vec<BodiesBesideCurves>, Error>>()?;
    let curves = drawn.positions.len();
    let all = |right: fn(&BodiesBesideCurves) -> usize| {
        let holds = |one: &BodiesBesideCurves| one.pairs > 0 && right(one) == one.pairs;
        curves == 6 && beside.iter().all(holds)
    };
    let sticks = all(|one| one.inside_sticks);
    let slips = all(|one| one.outside_slips);
    let parts = [
        ("bodies put just inside the drawn curves stick", sticks),
        ("bodies put just outside them slip", slips),
    ];
    let distances = beside.iter().map(|one| {
        let (distance, pairs) = (one.distance, one.pairs);
        let (inside, outside) = (one.inside_sticks, one.outside_slips);
        format!(
            "{distance:.0e} m: {inside} of {pairs} inside stick, {outside} of {pairs} outside slip"
        )
    });
    let (times, distances) = (times.len(), joined(distances, "; at "));
    let line = format!(
        "model 2 integrated from Σ beside the {curves} drawn curves at {times} times of two \
            periods; at {distances}"
    );
    Ok(vec![statement(Exact, parts, line)])
}

fn at_distance(
    model: &ForcedOscillator,
    drawn: &TangentPointMotion,
    times: &[usize],
    distance: f64,
) -> Result<BodiesBesideCurves, Error> {
    let mut beside = BodiesBesideCurves {
        distance,
        ..BodiesBesideCurves::default()
    };
    for (number, positions) in drawn.positions.iter().enumerate() {
        // The curves are drawn from the largest down: upper end, lower end, upper end, …
        let inward = if number % 2 == 0 { -distance } else { distance };
        let at = |&k: &usize| Some((*drawn.times.get(k)?, *positions.get(k)?));
        for (t, x1) in times.iter().filter_map(at) {
            beside.pairs += 1;
            beside.inside_sticks += usize::from(sticks(model, t, x1 + inward)?);
            beside.outside_slips += usize::from(!sticks(model, t, x1 - inward)?);
        }
    }
    Ok(beside)
}

/// Whether a body placed on the belt there sticks at first.
fn sticks(model: &ForcedOscillator, t: f64, x1: f64) -> Result<bool, Error> {
    let x = State::from([x1, model.belt_speed]);
    let orbit = solve(model, t, x, t + RUN_LENGTH, &Options::tol(TOLERANCE))?;
    let first = orbit.phases.first();
    Ok(first.is_some_and(|phase| phase.mode == Mode::Stick))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figures::fig07::FIG07;

    fn sticks_and_slips(model: &ForcedOscillator, drawn: &TangentPointMotion) -> Vec<bool> {
        beside_curves(model, drawn).unwrap()[0].parts()
    }

    #[test]
    fn the_drawn_curves_part_stick_from_slip_and_displaced_ones_do_not() {
        let model = ForcedOscillator::default();
        let mut drawn = FIG07.compute().unwrap().oscillation;
        assert_eq!(sticks_and_slips(&model, &drawn), [true, true]);
        let antiphase = ForcedOscillator {
            amplitude: -model.amplitude,
            ..model
        };
        assert_eq!(sticks_and_slips(&antiphase, &drawn), [false, false]);
        for x1 in &mut drawn.positions[2] {
            *x1 += 1e-5;
        }
        let displaced = sticks_and_slips(&model, &drawn);
        assert!(displaced.contains(&true) && displaced.contains(&false));
    }
}
