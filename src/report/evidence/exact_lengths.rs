//! `s4.exact_lengths`: whether the set (24) gives lengths and durations of the stick phases.

use super::stick_phases::Followed;
use super::{Evidence, EvidenceError, Part, TangentSet, small};
use crate::paper::listing::{Setup, run};
use stickslip::models::ForcedOscillator;

/// Differences within this are none (s): the solver's tolerance, with room for it to grow.
const NONE: f64 = 1e-9;
/// Forcing periods within which a body on the belt is certain to meet a tangent point.
const SPAN: f64 = 3.0;

/// What the set determines.
#[derive(Clone, Debug, PartialEq)]
pub struct ExactLengths {
    /// Stick phases of the stated model from a grid of starts.
    pub phases: usize,
    /// Those whose end the equation `x1 + vp (t − t_entry) = z_k + A sin(ωt)` does not give within three forcing periods.
    pub without_prediction: usize,
    /// Largest difference between the end by that equation, from the entry alone, and the end located (s).
    pub largest_error: f64,
    /// Stick phases of the listing's settled pattern.
    pub listing_phases: usize,
    /// Largest difference of that kind among them (s); infinite where there is no prediction.
    pub listing_error: f64,
}

impl ExactLengths {
    /// Predicts the ends of the stick phases followed, and of the listing's settled ones.
    ///
    /// # Errors
    /// [`EvidenceError`] if the listing cannot run or the table of claims lacks a number.
    pub fn compute(followed: &Followed) -> Result<ExactLengths, EvidenceError> {
        let (model, set) = (ForcedOscillator::default(), TangentSet::published()?);
        let span = SPAN * model.period();
        let error = |entry: (f64, f64), t_exit: f64| {
            let predicted = set.first_meeting(&model, entry, span);
            predicted.map(|t| (t - t_exit).abs())
        };
        let sticks = &followed.model;
        let errors: Vec<Option<f64>> = sticks
            .iter()
            .map(|stick| error(stick.entry, stick.exit.0))
            .collect();
        let outcome = run(&Setup::default())?;
        let of_listing = outcome.settled_phases().iter().map(|phase| {
            error((phase.entry.t, phase.entry.x1), phase.exit.t).unwrap_or(f64::INFINITY)
        });
        Ok(ExactLengths {
            phases: sticks.len(),
            without_prediction: errors.iter().filter(|one| one.is_none()).count(),
            largest_error: errors.iter().flatten().copied().fold(0.0, f64::max),
            listing_phases: outcome.settled_phases().len(),
            listing_error: of_listing.fold(0.0, f64::max),
        })
    }
}

impl Evidence for ExactLengths {
    fn parts(&self) -> Vec<Part> {
        let predicted = self.phases > 0 && self.without_prediction == 0;
        vec![Part {
            what: "given where and when it begins, the set gives length and duration of a stick phase of the stated model",
            holds: predicted && self.largest_error <= NONE,
        }]
    }

    fn as_printed(&self) -> Vec<Part> {
        vec![Part {
            what: "given where and when it begins, the set gives length and duration of the listing's stick phases, which are the published ones",
            holds: self.listing_phases > 0 && self.listing_error <= NONE,
        }]
    }

    fn line(&self) -> String {
        format!(
            "ends of {} stick phases of the stated model by the scalar equation from the set and the begin: off by at most {} s; of the {} \
             of Fig. 8's motion, which the listing makes and which are another reading of the sentence: by up to {:.3} s",
            self.phases,
            small(self.largest_error),
            self.listing_phases,
            self.listing_error,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::evidence::Support;

    #[test]
    fn the_set_gives_the_stated_models_phases_and_not_the_listings() {
        let found = ExactLengths::compute(&Followed::compute().unwrap()).unwrap();
        assert_eq!(found.support(), Support::Whole);
        assert!(found.listing_error > 0.01 && !found.as_printed()[0].holds);
    }

    #[test]
    fn another_belt_speed_spoils_the_prediction() {
        let model = ForcedOscillator::default();
        let slower = ForcedOscillator {
            belt_speed: 0.39,
            ..model
        };
        let set = TangentSet::published().unwrap();
        let sticks = crate::report::evidence::stick_phases::of_model(&model).unwrap();
        let off = sticks.iter().filter(|stick| {
            let t = set.first_meeting(&slower, stick.entry, SPAN * model.period());
            t.is_none_or(|t| (t - stick.exit.0).abs() > NONE)
        });
        assert!(off.count() > sticks.len() / 2);
    }
}
