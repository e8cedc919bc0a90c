//! `s4.found_by_appendix`: whether the Appendix's procedure finds the published trajectory.

use super::{Evidence, EvidenceError, Part};
use crate::paper::claim_id::ClaimId;
use crate::paper::listing::{Defects, Motion, Setup, run};
use crate::paper::published::Claims;

/// What the procedure leads to.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundByAppendix {
    /// Motion of the listing as printed.
    pub printed: Motion,
    /// Its two lengths (m) and durations (s).
    pub numbers: Option<[f64; 4]>,
    /// How many of the four are the published ones to all printed digits.
    pub published_digits: usize,
    /// Motion of the listing with every defect mended: the procedure as Sect. 3 describes it.
    pub mended: Motion,
}

impl FoundByAppendix {
    /// Runs both.
    ///
    /// # Errors
    /// [`EvidenceError`] if the listing cannot run or the table of claims lacks a number.
    pub fn compute() -> Result<FoundByAppendix, EvidenceError> {
        FoundByAppendix::of(Defects::AS_PRINTED)
    }

    fn of(defects: Defects) -> Result<FoundByAppendix, EvidenceError> {
        let with = |defects| {
            run(&Setup {
                defects,
                ..Setup::default()
            })
        };
        let printed = with(defects)?;
        let numbers = printed.four_numbers();
        let claims = Claims::committed()?;
        let mut published_digits = 0;
        for (id, value) in ClaimId::FOUR.into_iter().zip(numbers.into_iter().flatten()) {
            published_digits += usize::from(claims.of(id).agrees(value));
        }
        Ok(FoundByAppendix {
            printed: printed.motion,
            numbers,
            published_digits,
            mended: with(Defects::MENDED)?.motion,
        })
    }
}

impl Evidence for FoundByAppendix {
    fn parts(&self) -> Vec<Part> {
        vec![
            Part {
                what: "the Appendix's program as printed gives the published trajectory",
                holds: self.printed == Motion::PUBLISHED
                    && self.published_digits == ClaimId::FOUR.len(),
            },
            Part {
                what: "so does the procedure that the text describes: the same program without its defects",
                holds: self.mended == Motion::PUBLISHED,
            },
        ]
    }

    fn line(&self) -> String {
        format!(
            "listing as printed: {}, {} of {} published numbers to all digits; with its defects mended: {}",
            words(self.printed),
            self.published_digits,
            ClaimId::FOUR.len(),
            words(self.mended),
        )
    }
}

fn words(motion: Motion) -> String {
    match motion {
        Motion::StickSlip { sticks, period } => {
            format!("stick–slip, stick phases in {period} forcing periods: {sticks}")
        }
        Motion::SlipOnly { period } => format!("slip only, period {period}"),
        Motion::Stalled { t } => format!("the clock stands at {t:.4} s"),
        Motion::Escaped { t } => format!("escapes at {t:.4} s"),
        Motion::BrokenDown { t } => format!("breaks down at {t:.4} s"),
        _ => "no pattern repeats".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper::listing::Defect;
    use crate::report::evidence::Support;

    #[test]
    fn the_program_finds_it_and_the_procedure_does_not() {
        let found = FoundByAppendix::compute().unwrap();
        assert_eq!(found.support(), Support::InPart, "{found:?}");
        assert!(found.parts()[0].holds);
    }

    #[test]
    fn with_its_stages_mended_the_program_does_not_either() {
        let defects = Defects::AS_PRINTED.flipped(Defect::InPlaceStages);
        let found = FoundByAppendix::of(defects).unwrap();
        assert_eq!(found.support(), Support::Nothing, "{found:?}");
    }
}
