//! `fig07b.oscillation`: bodies put on Σ just beside the drawn curves stick on one side of them and slip on the other.

use rayon::prelude::*;

use super::{Evidence, Part};
use crate::figures::fig07::Oscillation;
use stickslip::error::Error;
use stickslip::filippov::{Options, solve};
use stickslip::models::ForcedOscillator;
use stickslip::system::{Mode, State};

/// Distances from the curves (m).
const DISTANCES: [f64; 3] = [1e-3, 1e-6, 1e-9];
/// Times of the drawn curve, at equal distances, first and last left out.
const TIMES: usize = 24;
/// Length of the runs (s).
const SPAN: f64 = 1e-2;
const TOLERANCE: f64 = 1e-13;

/// Bodies at one distance from the curves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beside {
    /// The distance (m).
    pub distance: f64,
    /// Bodies put inside a zone, over all curves and times.
    pub inside: usize,
    /// Of these, those that stick.
    pub inside_sticks: usize,
    /// Bodies put outside.
    pub outside: usize,
    /// Of these, those that slip.
    pub outside_slips: usize,
}

/// Bodies beside the drawn curves.
#[derive(Clone, Debug, PartialEq)]
pub struct BesideCurves {
    /// Curves drawn.
    pub curves: usize,
    /// Times at which bodies are put on Σ.
    pub times: usize,
    /// One for each distance, the largest first.
    pub beside: Vec<Beside>,
}

impl BesideCurves {
    /// Puts bodies beside the curves of Fig. 7b and integrates model 2.
    ///
    /// # Errors
    /// Those of [`solve`].
    pub fn compute(drawn: &Oscillation) -> Result<BesideCurves, Error> {
        BesideCurves::of(&ForcedOscillator::default(), drawn)
    }

    fn of(model: &ForcedOscillator, drawn: &Oscillation) -> Result<BesideCurves, Error> {
        let every = (drawn.times.len() / (TIMES + 1)).max(1);
        let times: Vec<usize> = (1..=TIMES)
            .map(|k| k * every)
            .filter(|&k| k < drawn.times.len())
            .collect();
        let beside = DISTANCES
            .into_par_iter()
            .map(|distance| at_distance(model, drawn, &times, distance))
            .collect::<Result<_, Error>>()?;
        Ok(BesideCurves {
            curves: drawn.positions.len(),
            times: times.len(),
            beside,
        })
    }
}

fn at_distance(
    model: &ForcedOscillator,
    drawn: &Oscillation,
    times: &[usize],
    distance: f64,
) -> Result<Beside, Error> {
    let mut found = Beside {
        distance,
        inside: 0,
        inside_sticks: 0,
        outside: 0,
        outside_slips: 0,
    };
    for (number, positions) in drawn.positions.iter().enumerate() {
        // The curves are drawn from the largest down: upper end, lower end, upper end, …
        let inward = if number % 2 == 0 { -distance } else { distance };
        for (&t, &x1) in times
            .iter()
            .filter_map(|&k| Some((drawn.times.get(k)?, positions.get(k)?)))
        {
            found.inside += 1;
            found.inside_sticks += usize::from(sticks(model, t, x1 + inward)?);
            found.outside += 1;
            found.outside_slips += usize::from(!sticks(model, t, x1 - inward)?);
        }
    }
    Ok(found)
}

/// Whether a body put on the belt there sticks to it at first.
fn sticks(model: &ForcedOscillator, t: f64, x1: f64) -> Result<bool, Error> {
    let x = State::from([x1, model.belt_speed]);
    let orbit = solve(model, t, x, t + SPAN, &Options::tol(TOLERANCE))?;
    Ok(orbit
        .phases
        .first()
        .is_some_and(|phase| phase.mode == Mode::Stick))
}

impl Evidence for BesideCurves {
    fn parts(&self) -> Vec<Part> {
        let all = |holds: fn(&Beside) -> bool| {
            self.curves == 6 && !self.beside.is_empty() && self.beside.iter().all(holds)
        };
        vec![
            Part {
                what: "bodies put just inside the drawn curves stick",
                holds: all(|one| one.inside > 0 && one.inside_sticks == one.inside),
            },
            Part {
                what: "bodies put just outside slip",
                holds: all(|one| one.outside > 0 && one.outside_slips == one.outside),
            },
        ]
    }

    fn line(&self) -> String {
        let distances: Vec<String> = self
            .beside
            .iter()
            .map(|one| {
                format!(
                    "{:.0e} m: {} of {} inside stick, {} of {} outside slip",
                    one.distance, one.inside_sticks, one.inside, one.outside_slips, one.outside
                )
            })
            .collect();
        format!(
            "model 2 integrated from Σ beside the {} drawn curves at {} times of two periods; at {}",
            self.curves,
            self.times,
            distances.join("; at ")
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figures::FigureSpec;
    use crate::figures::fig07::Fig07;
    use crate::report::evidence::Support;

    #[test]
    fn the_drawn_curves_part_stick_from_slip() {
        let drawn = Fig07::compute().unwrap().oscillation;
        let found = BesideCurves::compute(&drawn).unwrap();
        assert_eq!(found.support(), Support::Whole, "{found:?}");
        assert!(found.beside[0].inside >= 100);
    }

    #[test]
    fn displaced_curves_do_not() {
        let mut drawn = Fig07::compute().unwrap().oscillation;
        for x1 in &mut drawn.positions[2] {
            *x1 += 1e-5;
        }
        let found = BesideCurves::compute(&drawn).unwrap();
        assert_eq!(found.support(), Support::InPart, "{found:?}");
    }

    #[test]
    fn with_a_support_in_antiphase_they_do_not() {
        let drawn = Fig07::compute().unwrap().oscillation;
        let model = ForcedOscillator::default();
        let antiphase = ForcedOscillator {
            amplitude: -model.amplitude,
            ..model
        };
        let found = BesideCurves::of(&antiphase, &drawn).unwrap();
        assert_eq!(found.support(), Support::Nothing);
    }
}
