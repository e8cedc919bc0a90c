//! "Estimated with high accuracy": the errors of the times of arrival on Σ (Eq. 14) and of release from stick (Eq. 15) against exact
//! ones, by the method as the text states it, with corrections, and by the listing.

mod arrival;
mod errors;
mod findings;
mod release;

pub use errors::EventErrors;
pub use release::{Release, Releases};

use arrival::Arrival;

use crate::paper::listing::{Defect, Defects, ListingError};
use stickslip::error::Error;
use stickslip::models::ForcedOscillator;
use stickslip::system::Side;

const TOLERANCE: f64 = 1e-14;

/// Errors of event times on the stated models' own orbits.
#[derive(Clone, Debug, PartialEq)]
pub struct Accuracy {
    /// Arrival by RK4 with fixed step, then one Hénon step onto Σ with the step in velocity `vp − x2`, from below and from above.
    pub stated: [EventErrors; 2],
    /// The same with the step in velocity that Sect. 3 prints: from above it is `x2 − vp`.
    pub text: [EventErrors; 2],
    /// One Hénon step alone from an exact state, from either side: a step errs by one order more.
    pub single: [EventErrors; 2],
    /// The listing with the sign of its step from above as printed and all else mended.
    pub printed_sign: EventErrors,
    /// Arrival by the listing as printed, from either side.
    pub as_printed: [EventErrors; 2],
    /// Release from stick.
    pub release: Releases,
}

/// Why the accuracy could not be measured.
#[derive(Debug, thiserror::Error)]
pub enum AccuracyError {
    /// The solver failed.
    #[error(transparent)]
    Solver(#[from] Error),
    /// The listing cannot run.
    #[error(transparent)]
    Listing(#[from] ListingError),
}

impl Accuracy {
    /// Measures all errors.
    ///
    /// # Errors
    /// [`AccuracyError`].
    pub fn compute() -> Result<Accuracy, AccuracyError> {
        let model = ForcedOscillator::default();
        let up = Arrival::from(&model, Side::Below)?;
        let down = Arrival::from(&model, Side::Above)?;
        let sign_alone = Defects::MENDED.flipped(Defect::S2StepSign);
        let printed = "arrival in the listing as printed from";
        Ok(Accuracy {
            stated: [up.stated(&model)?, down.stated(&model)?],
            text: [up.as_in_the_text(&model)?, down.as_in_the_text(&model)?],
            single: [up.single(&model)?, down.single(&model)?],
            printed_sign: down.listing(
                "arrival in the listing with only the sign of the Hénon step as printed from",
                sign_alone,
            )?,
            as_printed: [
                up.listing(printed, Defects::AS_PRINTED)?,
                down.listing(printed, Defects::AS_PRINTED)?,
            ],
            release: Releases::compute()?,
        })
    }

    /// Whether arrival is accurate as Sect. 3 states it, from both sides.
    pub fn arrival_as_stated(&self) -> bool {
        self.text.iter().all(EventErrors::is_accurate)
    }

    /// Whether arrival is accurate with the sign of the step corrected.
    pub fn arrival_corrected(&self) -> bool {
        self.stated.iter().all(EventErrors::is_accurate)
    }

    /// Whether release is accurate by Eq. (15) as printed, on the system that Sect. 3 is about.
    pub fn release_as_stated(&self) -> bool {
        self.release.belt.literal_is_accurate()
    }

    /// Whether it is with 1/x2, on the same system.
    pub fn release_corrected(&self) -> bool {
        self.release.belt.corrected.is_accurate()
    }

    /// Whether it is with 1/x2 on model 2, whose tangent points move.
    pub fn release_corrected_on_forced(&self) -> bool {
        self.release.forced.corrected.is_accurate()
    }

    /// Whether both are accurate in the listing as printed.
    pub fn listing_is_accurate(&self) -> bool {
        self.as_printed
            .iter()
            .chain([&self.release.listing])
            .all(EventErrors::is_accurate)
    }

    /// All measurements of arrival.
    pub fn of_arrival(&self) -> impl Iterator<Item = &EventErrors> {
        let stated = self.text.iter().chain(&self.stated).chain(&self.single);
        stated.chain([&self.printed_sign]).chain(&self.as_printed)
    }

    /// All measurements of release, each with the model it is made on.
    pub fn of_release(&self) -> impl Iterator<Item = (&'static str, &EventErrors)> {
        let release = &self.release;
        let forced = [&release.moving, &release.listing, &release.listing_mended];
        let belt = release.belt.all().map(|one| ("model 1", one));
        let others = release.forced.all().chain(forced);
        belt.chain(others.map(|one| ("model 2", one)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_method_is_accurate_with_both_corrections_and_not_without() {
        let found = Accuracy::compute().unwrap();
        assert!(found.text[0].is_accurate(), "{}", found.text[0].line());
        assert!(!found.text[1].is_accurate(), "{}", found.text[1].line());
        assert!(found.arrival_corrected() && !found.arrival_as_stated());
        assert!(found.release_corrected() && !found.release_as_stated());
        assert!(!found.listing_is_accurate());
    }
}
