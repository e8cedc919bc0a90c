//! Remarks on a published exponent that are no verdict: its sign, and how far the estimator's unstated settings move it.

use std::fmt;

use super::digits::ten_to;
use crate::paper::published::{Claim, Digits};

/// Sign of a Lyapunov exponent, zero within its error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sign {
    /// Nearby orbits separate.
    Positive,
    /// Neither.
    Zero,
    /// They approach each other.
    Negative,
}

impl Sign {
    /// Of a printed number, whose zero is a zero.
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
        f.write_str(match self {
            Sign::Positive => "positive",
            Sign::Zero => "zero",
            Sign::Negative => "negative",
        })
    }
}

/// How far an estimate moves over settings that the paper does not state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Least finite estimate.
    pub least: f64,
    /// The one in the middle.
    pub median: f64,
    /// Largest finite estimate.
    pub largest: f64,
    /// Settings tried.
    pub settings: usize,
    /// Of these, how many leave the exponent unidentified.
    pub unidentified: usize,
}

impl Range {
    /// Whether a value lies in it.
    pub fn holds(&self, value: f64) -> bool {
        (self.least..=self.largest).contains(&value)
    }

    /// Whether it is wider than a unit of the last digit that is printed.
    pub fn exceeds_digits(&self, claim: &Claim) -> bool {
        match claim.digits {
            Digits::Decimals(decimals) => self.largest - self.least > ten_to(-(decimals as f64)),
            Digits::Exact | Digits::None => false,
        }
    }
}

/// What is remarked of a published exponent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Remark {
    /// The published number.
    pub published: f64,
    /// Sign of the exponent from the corrected equations, zero within its error.
    pub sign: Sign,
    /// Over the estimator's settings; nothing where no estimate is finite.
    pub range: Option<Range>,
}

impl Remark {
    /// Whether the published number has the computed sign; a small number that is not zero has a sign.
    pub fn sign_agrees(&self) -> bool {
        Sign::printed(self.published) == self.sign
    }

    /// Whether the published number lies within what the settings give.
    pub fn within_range(&self) -> bool {
        self.range.is_some_and(|range| range.holds(self.published))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_is_held_against_a_unit_of_the_last_printed_digit() {
        let claims = crate::paper::published::Claims::committed().unwrap();
        let claim = claims.of(crate::paper::claim_id::ClaimId::Fig10Lambda1);
        let range = |least: f64, largest: f64| Range {
            least,
            median: least,
            largest,
            settings: 2,
            unidentified: 0,
        };
        assert!(range(-0.0002, -0.00005).exceeds_digits(claim));
        assert!(!range(-0.0002, -0.00015).exceeds_digits(claim));
    }

    #[test]
    fn a_small_negative_number_is_no_zero() {
        let of = |published, sign| {
            Remark {
                published,
                sign,
                range: None,
            }
            .sign_agrees()
        };
        assert!(of(-0.0, Sign::Zero) && of(-0.0004, Sign::Negative) && of(0.0025, Sign::Positive));
        assert!(!of(-0.0004, Sign::Zero) && !of(-0.0019, Sign::Positive));
    }
}
