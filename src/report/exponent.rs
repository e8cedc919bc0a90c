//! A published exponent against the settings of the estimator that the paper does not state: their
//! range, and the sign by the equations.

use std::fmt;

use super::digits::minus;
use crate::paper::published::{Claim, Digits};
use crate::text::described;
use stickslip::math;

described! {
    /// Sign of a Lyapunov exponent; zero within its error.
    Sign: &'static str as name {
        /// Nearby orbits separate.
        Positive = "positive",
        /// Neither.
        Zero = "zero",
        /// Nearby orbits approach each other.
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

/// Evidence of the estimator's settings, which the paper does not state, on published digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OverSettings {
    /// Nothing, or they agree to a unit of the last digit: the findings decide.
    Decided,
    /// The settings move the value and their range holds the digits; or none identifies it, and the
    /// digits have the sign of the equations.
    Undetermined,
    /// No setting gives the digits: they lie outside the range, or have another sign.
    Excluded,
}

/// Range of a value over the settings that identify it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SettingsRange {
    /// Smallest and largest value; `None` if no setting identifies it.
    pub ends: Option<[f64; 2]>,
    /// Standard errors of the two estimates.
    pub errors: [f64; 2],
    /// Settings that identify it.
    pub identifying: usize,
    /// All settings.
    pub settings: usize,
}

impl SettingsRange {
    /// Number of standard errors by which a range is widened.
    pub const STANDARD_ERRORS: f64 = 2.0;

    /// The range, widened at both ends by [`SettingsRange::STANDARD_ERRORS`].
    pub fn widened(&self) -> Option<[f64; 2]> {
        let [below, above] = self.errors.map(|one| Self::STANDARD_ERRORS * one);
        self.ends
            .map(|[least, largest]| [least - below, largest + above])
    }

    fn sentence(&self, what: &str) -> String {
        let (identifying, settings) = (self.identifying, self.settings);
        match self.ends {
            None => format!("none of {settings} {what} identifies it"),
            Some(ends) => {
                let [least, largest] = ends.map(rounded);
                format!(
                    "{identifying} of {settings} {what} identify it and give {least} to {largest}"
                )
            }
        }
    }
}

/// A published exponent or ratio of two, compared with the equations' sign and the estimator's
/// settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExponentCheck {
    /// The published number.
    pub published: f64,
    /// Sign of the exponent from the corrected equations; zero within its error.
    pub sign: Sign,
    /// Value by the corrected equations and its standard error; `None` where it is −∞.
    pub equations: Option<[f64; 2]>,
    /// Range over all settings.
    pub range: SettingsRange,
    /// Range over the settings with Eq. (25) as printed, which has no affine term.
    pub linear: SettingsRange,
}

impl ExponentCheck {
    /// Whether the published number has the computed sign. A small nonzero number has a sign.
    pub fn sign_agrees(&self) -> bool {
        Sign::printed(self.published) == self.sign
    }

    /// Whether the published digits, half a unit of the last either way, meet the widened range.
    pub fn within_range(&self, claim: &Claim) -> bool {
        let half = 0.5 * unit(claim);
        let meets = |[least, largest]: [f64; 2]| {
            self.published + half >= least && self.published - half <= largest
        };
        self.range.widened().is_some_and(meets)
    }

    /// Whether the widened range and the value by the equations, with as many of its standard
    /// errors, have no number in common.
    pub fn data_disagree(&self) -> bool {
        let apart = |([least, largest], [value, error]): ([f64; 2], [f64; 2])| {
            let error = SettingsRange::STANDARD_ERRORS * error;
            value + error < least || value - error > largest
        };
        self.range.widened().zip(self.equations).is_some_and(apart)
    }

    /// Evidence of the settings on the published digits.
    pub fn over_settings(&self, claim: &Claim) -> OverSettings {
        let SettingsRange {
            ends,
            identifying,
            settings,
            ..
        } = self.range;
        let Some([least, largest]) = ends else {
            return match self.sign_agrees() {
                true => OverSettings::Undetermined,
                false => OverSettings::Excluded,
            };
        };
        match self.within_range(claim) {
            false => OverSettings::Excluded,
            true if identifying < settings || largest - least > unit(claim) => {
                OverSettings::Undetermined
            }
            true => OverSettings::Decided,
        }
    }

    /// The settings and what they say, in words.
    pub fn sentence(&self, claim: &Claim) -> String {
        let all = self.range.sentence("settings of the estimator");
        let linear = self
            .linear
            .sentence("with Eq. (25) as printed, without an affine term,");
        let says = match (self.range.widened(), self.over_settings(claim)) {
            (Some(widened), _) => {
                let [least, largest] = widened.map(rounded);
                let lie = match self.within_range(claim) {
                    true => "the published digits lie in that range",
                    false => "no setting tried gives the published digits",
                };
                format!("widened by two standard errors of its ends, {least} to {largest}: {lie}")
            }
            (None, OverSettings::Excluded) => {
                "the published sign is not that of the equations".into()
            }
            (None, _) => "the published sign is that of the equations".into(),
        };
        let equations = match self.equations {
            None => "; the equations give −∞, which no estimate from data can: only the sign is \
                     judged"
                .to_owned(),
            Some([value, _]) if self.data_disagree() => format!(
                "; data and equations disagree: the equations give {}",
                rounded(value)
            ),
            Some(_) => String::new(),
        };
        format!("{all}; {says}{equations}; {linear}")
    }
}

/// Unit of the last printed digit.
fn unit(claim: &Claim) -> f64 {
    match claim.digits {
        Digits::Decimals(decimals) => math::pow(10.0, -(decimals as f64)),
        Digits::Exact | Digits::None => 0.0,
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

    fn of(published: f64, sign: Sign, ends: Option<[f64; 2]>) -> ExponentCheck {
        let range = SettingsRange {
            ends,
            errors: [1e-5; 2],
            identifying: 2 * usize::from(ends.is_some()),
            settings: 2,
        };
        ExponentCheck {
            published,
            sign,
            equations: None,
            range,
            linear: range,
        }
    }

    #[test]
    fn published_digits_decide_between_open_and_excluded() {
        use OverSettings::{Decided, Excluded, Undetermined};
        let claims = crate::paper::published::Claims::committed().unwrap();
        let claim = claims.of(crate::paper::claim_id::ClaimId::Fig10Lambda1);
        let says = |published, ends| of(published, Sign::Negative, ends).over_settings(claim);
        let wide = Some([-0.002, -0.001]);
        // Half a unit of the last digit and two standard errors reach 7e-5 beyond the range.
        for (published, expected) in [
            (-0.0015, Undetermined),
            (-0.00206, Undetermined),
            (-0.00208, Excluded),
            (-0.00094, Undetermined),
            (-0.00092, Excluded),
            (7.0, Excluded),
        ] {
            assert_eq!(says(published, wide), expected, "{published}");
        }
        assert_eq!(says(-0.0015, Some([-0.00152, -0.00148])), Decided);
        // Where no setting identifies it, the sign decides.
        assert_eq!(
            (says(-0.3, None), says(0.3, None)),
            (Undetermined, Excluded)
        );
        let sentence = |published| of(published, Sign::Negative, wide).sentence(claim);
        assert!(sentence(-0.0015).contains("lie in that range"));
        assert!(sentence(7.0).contains("no setting tried"));
    }

    #[test]
    fn data_and_equations_disagree_where_their_ranges_are_apart() {
        let claims = crate::paper::published::Claims::committed().unwrap();
        let claim = claims.of(crate::paper::claim_id::ClaimId::Fig10Lambda2);
        // Two standard errors of either widen the range to 2e-5 beyond its ends, and the value.
        let says = |ends, value| ExponentCheck {
            equations: Some([value, 1e-4]),
            ..of(-0.0049, Sign::Negative, ends)
        };
        let data = Some([-0.002, -0.001]);
        for (value, expected) in [
            (-0.01144, true),
            (-0.00223, true),
            (-0.00221, false),
            (-0.0015, false),
            (-0.00079, false),
            (-0.00077, true),
        ] {
            let check = says(data, value);
            assert_eq!(check.data_disagree(), expected, "{value}");
            let word = check
                .sentence(claim)
                .contains("data and equations disagree");
            assert_eq!(word, expected);
            // Where no setting identifies it, there is nothing to compare.
            assert!(!says(None, value).data_disagree());
        }
    }

    #[test]
    fn a_small_negative_number_is_no_zero() {
        let of = |published, sign| of(published, sign, None).sign_agrees();
        assert!(of(-0.0, Sign::Zero) && of(-0.0004, Sign::Negative) && of(0.0025, Sign::Positive));
        assert!(!of(-0.0004, Sign::Zero) && !of(-0.0019, Sign::Positive));
    }
}
