//! `fig08.start` and `s4.length_is_way`: where Fig. 8's motion starts, and whether its lengths are
//! the belt's way in its durations.

use super::grid::{ESCAPE, TOLERANCE};
use super::{Evidence, EvidenceError, Part, small};
use crate::paper::claim_id::ClaimId;
use crate::paper::listing::{Params, Setup, run};
use crate::paper::pattern::two_periodic;
use crate::paper::published::Claims;
use crate::report::evidence::stick_phases::Followed;
use crate::report::readme::decimals;
use stickslip::analysis::{Destination, destination};
use stickslip::filippov::Options;
use stickslip::models::ForcedOscillator;
use stickslip::system::State;

/// Differences within this are none (s): the solver's tolerance, with room for it to grow.
const NONE: f64 = 1e-9;
/// Forcing periods that a start of the stated model is followed over, and the distance of states
/// that count as equal.
const SETTLING: (usize, f64) = (60, 1e-5);

/// The program and the stated model from one start on Σ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FromPoint {
    /// Where it is (m).
    pub x1: f64,
    /// When the listing first releases the body (s).
    pub first_release: f64,
    /// Of the four published numbers, those that the listing settles on to all printed digits.
    pub digits: usize,
    /// Whether the stated model settles on stick–slip of period two.
    pub model_two_periodic: bool,
}

/// The caption's start, the third tangent point, and the listing's, which is `T[3]`, the fourth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// From the third point.
    pub captioned: FromPoint,
    /// From the fourth.
    pub listed: FromPoint,
}

/// Durations less lengths over the belt's speed (s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Way {
    /// Of the two published pairs.
    pub published: [f64; 2],
    /// Of the listing's settled motion.
    pub listing: [f64; 2],
    /// What rounding of the published numbers explains: half a unit of the last printed digit in
    /// each.
    pub rounding: f64,
    /// Stick phases of the stated model from a grid of starts, and the largest difference among
    /// them.
    pub model: (usize, f64),
}

impl Start {
    /// Runs the listing and the stated model from both points.
    ///
    /// # Errors
    /// [`EvidenceError`] if the listing cannot run, the solver fails or the table of claims lacks a number.
    pub fn compute() -> Result<Start, EvidenceError> {
        let points = Params::default().tangent_points;
        Ok(Start {
            captioned: from(points[2])?,
            listed: from(points[3])?,
        })
    }
}

fn from(x1: f64) -> Result<FromPoint, EvidenceError> {
    let (claims, model) = (Claims::committed()?, ForcedOscillator::default());
    let params = Params {
        x1,
        ..Params::default()
    };
    let outcome = run(&Setup {
        params,
        ..Setup::default()
    })?;
    let numbers = ClaimId::FOUR
        .into_iter()
        .zip(outcome.four_numbers().into_iter().flatten());
    let start = (0.0, State::from([x1, model.belt_speed]));
    let options = Options::tol(TOLERANCE).escape(ESCAPE);
    let (periods, same) = SETTLING;
    let end = destination(&model, start, model.period(), periods, same, &options)?;
    Ok(FromPoint {
        x1,
        first_release: outcome
            .phases
            .first()
            .map_or(f64::NAN, |phase| phase.exit.t),
        digits: numbers
            .filter(|(id, value)| claims.of(*id).agrees(*value))
            .count(),
        model_two_periodic: matches!(end, Destination::Periodic { period, sticks, .. } if two_periodic(sticks, period)),
    })
}

impl Way {
    /// From the published numbers, the listing's and the stick phases followed.
    ///
    /// # Errors
    /// [`EvidenceError`] if the listing cannot run or the table of claims lacks a number.
    pub fn compute(followed: &Followed) -> Result<Way, EvidenceError> {
        let claims = Claims::committed()?;
        let belt = ForcedOscillator::default().belt_speed;
        let excess = |four: [f64; 4]| [four[2] - four[0] / belt, four[3] - four[1] / belt];
        let of_model = followed.model.iter().map(|stick| {
            let (length, duration) = (stick.exit.1 - stick.entry.1, stick.exit.0 - stick.entry.0);
            (duration - length / belt).abs()
        });
        Ok(Way {
            published: excess(ClaimId::FOUR.map(|id| claims.value(id))),
            listing: excess(
                run(&Setup::default())?
                    .four_numbers()
                    .unwrap_or([f64::NAN; 4]),
            ),
            rounding: 0.5e-4 + 0.5e-4 / belt,
            model: (followed.model.len(), of_model.fold(0.0, f64::max)),
        })
    }

    fn within(&self, excess: [f64; 2]) -> bool {
        excess.iter().all(|one| one.abs() <= self.rounding)
    }

    /// Whether each stick phase of the stated model is as long as the belt's way.
    pub fn holds_in_the_model(&self) -> bool {
        self.model.0 > 0 && self.model.1 <= NONE
    }
}

impl Evidence for Start {
    fn parts(&self) -> Vec<Part> {
        vec![Part {
            what: "from the third tangent point the stated model settles on stick–slip of period two",
            holds: self.captioned.model_two_periodic,
        }]
    }

    fn as_printed(&self) -> Vec<Part> {
        vec![Part {
            what: "the program settles on the published trajectory with the third point put in the place of its own start, the fourth",
            holds: self.captioned.digits == ClaimId::FOUR.len(),
        }]
    }

    fn line(&self) -> String {
        let of = |one: &FromPoint| {
            format!(
                "from x1 = {} m the program releases the body first at {:.4} s and settles on {} of the four published numbers",
                decimals(one.x1, 4),
                one.first_release,
                one.digits
            )
        };
        format!(
            "{}; {}; the Appendix starts at the latter, T[3], which is the fourth point: another reading of the caption",
            of(&self.captioned),
            of(&self.listed)
        )
    }
}

impl Evidence for Way {
    fn parts(&self) -> Vec<Part> {
        vec![Part {
            what: "the published lengths are vp times the published durations, as far as rounding lets tell",
            holds: self.within(self.published),
        }]
    }

    fn as_printed(&self) -> Vec<Part> {
        vec![Part {
            what: "the lengths of the program's settled stick phases are",
            holds: self.within(self.listing),
        }]
    }

    fn line(&self) -> String {
        let four = |[one, other]: [f64; 2]| format!("{:.2} and {:.2} ms", 1e3 * one, 1e3 * other);
        format!(
            "durations less lengths/vp: published {}, the program {}, {:.2} ms can be rounding; of {} stick phases of the stated model, which are \
             another reading of the sentence, at most {} s",
            four(self.published),
            four(self.listing),
            1e3 * self.rounding,
            self.model.0,
            small(self.model.1),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_of_another_belt_would_be_its_way() {
        let found = Way::compute(&Followed::compute().unwrap()).unwrap();
        assert!(
            found.holds_in_the_model() && !found.parts()[0].holds && !found.as_printed()[0].holds
        );
        let right = Way {
            published: [0.9 * found.rounding, -0.9 * found.rounding],
            ..found
        };
        assert!(right.parts()[0].holds);
    }

    #[test]
    fn the_listing_settles_on_the_published_numbers_from_its_own_start() {
        let found = Start::compute().unwrap();
        assert_eq!(found.listed.digits, 4);
        assert!((found.captioned.first_release - found.listed.first_release).abs() > 1e-3);
        // Between the zones nothing sticks, and the program has no zone to release the body from.
        assert_ne!(from(0.5).unwrap(), found.captioned);
    }
}
