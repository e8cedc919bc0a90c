//! `fig07b.oscillation`: bodies put on Σ just beside the drawn curves stick on one side of them and
//! slip on the other.

use rayon::prelude::*;

use super::statement;
use crate::figures::fig07::Oscillation;
use crate::paper::reading::Reading::Exact;
use crate::report::finding::Finding;
use crate::text::joined;
use stickslip::models::ForcedOscillator;
use stickslip::{Error, Mode, Options, State, solve};

/// Distances from the curves (m).
const DISTANCES: [f64; 3] = [1e-3, 1e-6, 1e-9];
/// Times of the drawn curve, at equal distances, first and last left out.
const TIMES: usize = 24;
/// Length of the runs (s).
const SPAN: f64 = 1e-2;
const TOLERANCE: f64 = 1e-13;

/// Bodies at one distance from the curves.
#[derive(Default)]
struct Beside {
    /// The distance (m).
    distance: f64,
    /// Bodies put inside a zone, and as many outside.
    pairs: usize,
    /// Of those inside the ones that stick, of those outside the ones that slip.
    inside_sticks: usize,
    outside_slips: usize,
}

/// Puts bodies beside the curves and integrates the model.
pub(super) fn oscillation(
    model: &ForcedOscillator,
    drawn: &Oscillation,
) -> Result<Vec<Finding>, Error> {
    let all = drawn.times.len();
    let every = (all / (TIMES + 1)).max(1);
    let times: Vec<usize> = (1..=TIMES)
        .map(|k| k * every)
        .filter(|&k| k < all)
        .collect();
    let beside = DISTANCES
        .into_par_iter()
        .map(|distance| at_distance(model, drawn, &times, distance))
        .collect::<Result<Vec<Beside>, Error>>()?;
    let curves = drawn.positions.len();
    let all = |right: fn(&Beside) -> usize| {
        let holds = |one: &Beside| one.pairs > 0 && right(one) == one.pairs;
        curves == 6 && beside.iter().all(holds)
    };
    let sticks = all(|one| one.inside_sticks);
    let slips = all(|one| one.outside_slips);
    let parts = [
        ("bodies put just inside the drawn curves stick", sticks),
        ("bodies put just outside slip", slips),
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
        "model 2 integrated from Σ beside the {curves} drawn curves at {times} times of two periods; at {distances}"
    );
    Ok(vec![statement(Exact, parts, line)])
}

fn at_distance(
    model: &ForcedOscillator,
    drawn: &Oscillation,
    times: &[usize],
    distance: f64,
) -> Result<Beside, Error> {
    let mut found = Beside {
        distance,
        ..Beside::default()
    };
    for (number, positions) in drawn.positions.iter().enumerate() {
        // The curves are drawn from the largest down: upper end, lower end, upper end, …
        let inward = if number % 2 == 0 { -distance } else { distance };
        let places = |&k: &usize| Some((*drawn.times.get(k)?, *positions.get(k)?));
        for (t, x1) in times.iter().filter_map(places) {
            found.pairs += 1;
            found.inside_sticks += usize::from(sticks(model, t, x1 + inward)?);
            found.outside_slips += usize::from(!sticks(model, t, x1 - inward)?);
        }
    }
    Ok(found)
}

/// Whether a body put on the belt there sticks to it at first.
fn sticks(model: &ForcedOscillator, t: f64, x1: f64) -> Result<bool, Error> {
    let x = State::from([x1, model.belt_speed]);
    let orbit = solve(model, t, x, t + SPAN, &Options::tol(TOLERANCE))?;
    let first = orbit.phases.first();
    Ok(first.is_some_and(|phase| phase.mode == Mode::Stick))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figures::fig07::FIG07;

    fn parts(model: &ForcedOscillator, drawn: &Oscillation) -> Vec<bool> {
        oscillation(model, drawn).unwrap()[0].parts()
    }

    #[test]
    fn the_drawn_curves_part_stick_from_slip_and_displaced_ones_do_not() {
        let model = ForcedOscillator::default();
        let mut drawn = FIG07.compute().unwrap().oscillation;
        assert_eq!(parts(&model, &drawn), [true, true]);
        let antiphase = ForcedOscillator {
            amplitude: -model.amplitude,
            ..model
        };
        assert_eq!(parts(&antiphase, &drawn), [false, false]);
        for x1 in &mut drawn.positions[2] {
            *x1 += 1e-5;
        }
        let displaced = parts(&model, &drawn);
        assert!(displaced.contains(&true) && displaced.contains(&false));
    }
}
