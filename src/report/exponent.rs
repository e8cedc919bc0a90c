//! Additions to the verdict on a published exponent: its sign, and how far the estimator's unstated
//! settings move it.

use std::fmt;

use super::digits::minus;
use crate::paper::published::{Claim, Digits};
use crate::readings::{ExponentSpread, ValueRange};
use crate::text::described;
use stickslip::math;

described! {
    /// Sign of a Lyapunov exponent; zero within its error.
    Sign: &'static str as name {
        /// Nearby orbits separate.
        Positive = "positive",
        /// Neither.
        Zero = "zero",
        /// They approach each other.
        Negative = "negative",
    }
}

impl Sign {
    /// Sign of a printed number; only 0 counts as zero.
    pub fn printed(value: f64) -> Sign {
        if value > 0.0 {
            Sign::Positive
        } else if value < 0.0 {
            Sign::Negative
        } else {
            Sign::Zero
        }
    }
}

impl fmt::Display for Sign {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A published exponent, compared with the equations' sign and the estimator's spread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExponentCheck {
    /// The published number.
    pub published: f64,
    /// Sign of the exponent from the corrected equations; zero within its error.
    pub sign: Sign,
    /// Values from the estimator's settings.
    pub spread: ExponentSpread,
}

impl ExponentCheck {
    /// Whether the published number has the computed sign. A small nonzero number has a sign.
    pub fn sign_agrees(&self) -> bool {
        Sign::printed(self.published) == self.sign
    }

    /// Whether the published number is within the range of the settings that identify the exponent.
    pub fn within_range(&self) -> bool {
        let within = |of: ValueRange| (of.least..=of.largest).contains(&self.published);
        self.spread.values.is_some_and(within)
    }

    /// Whether the settings decide it. Some leave it unidentified, or the others move it by more
    /// than a unit of the last printed digit.
    pub fn is_undetermined(&self, claim: &Claim) -> bool {
        let Digits::Decimals(decimals) = claim.digits else {
            return false;
        };
        let wide = |of: ValueRange| of.largest - of.least > math::pow(10.0, -(decimals as f64));
        self.spread.unidentified > 0 || self.spread.values.is_none_or(wide)
    }

    /// The values from the settings, in words.
    pub fn sentence(&self) -> String {
        let ExponentSpread {
            values,
            settings,
            unidentified,
            agreeing,
            ..
        } = self.spread;
        let Some(values) = values else {
            return format!(
                "none of {settings} settings of the estimator identifies it; {agreeing} give the \
                 published digits"
            );
        };
        let (least, largest) = (rounded(values.least), rounded(values.largest));
        let identifying = settings - unidentified;
        let contains = match self.within_range() {
            true => "contains",
            false => "does not contain",
        };
        format!(
            "{identifying} of {settings} settings of the estimator identify an exponent in this \
             place and give {least} to {largest}, which {contains} the published value; {agreeing} \
             of all settings give the published digits"
        )
    }
}

/// Four decimals as the paper prints; two significant digits where these would be zero.
fn rounded(value: f64) -> String {
    if value != 0.0 && value.abs() < 1e-3 {
        minus(&format!("{value:.1e}"))
    } else {
        minus(&format!("{value:.4}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(published: f64, sign: Sign, range: Option<(f64, f64)>) -> ExponentCheck {
        let values = range.map(|(least, largest)| ValueRange {
            least,
            median: least,
            largest,
        });
        let spread = ExponentSpread {
            values,
            settings: 2,
            unidentified: 2 * usize::from(range.is_none()),
            doubtful: 0,
            agreeing: 0,
        };
        ExponentCheck {
            published,
            sign,
            spread,
        }
    }

    #[test]
    fn settings_decide_where_they_move_the_last_digit_or_identify_nothing() {
        let claims = crate::paper::published::Claims::committed().unwrap();
        let claim = claims.of(crate::paper::claim_id::ClaimId::Fig10Lambda1);
        let with = |range| of(-0.0004, Sign::Zero, range);
        assert!(with(Some((-0.0002, -0.00005))).is_undetermined(claim));
        assert!(!with(Some((-0.0002, -0.00015))).is_undetermined(claim));
        assert!(with(None).is_undetermined(claim));
        let sentence = |range| with(Some(range)).sentence();
        assert!(sentence((-0.0005, -0.0003)).contains("which contains"));
        assert!(sentence((0.0, 0.1)).contains("does not contain"));
    }

    #[test]
    fn a_small_negative_number_is_no_zero() {
        let of = |published, sign| of(published, sign, None).sign_agrees();
        assert!(of(-0.0, Sign::Zero) && of(-0.0004, Sign::Negative) && of(0.0025, Sign::Positive));
        assert!(!of(-0.0004, Sign::Zero) && !of(-0.0019, Sign::Positive));
    }
}
