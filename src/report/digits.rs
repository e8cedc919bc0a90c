//! Number of printed digits that a value matches.

use std::fmt;

use crate::paper::published::{Claim, Digits, scale};
use stickslip::math::pow;

/// Digits of values that are published in closed form: those that [`ROUNDING`] leaves.
///
/// [`ROUNDING`]: crate::numbers::ROUNDING
const EXACT_DIGITS: u32 = 12;

/// Agreement of a value with a published one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Agreement {
    /// Leading significant digits that agree: the value is within half a unit of the last of them.
    pub agreeing: u32,
    /// Significant digits printed. A printed zero counts as one, a closed form as 12.
    pub printed: u32,
}

impl Agreement {
    /// Whether all printed digits agree.
    pub fn complete(self) -> bool {
        self.agreeing == self.printed
    }

    /// The lesser of two agreements.
    #[must_use]
    pub fn and(self, other: Agreement) -> Agreement {
        std::cmp::min_by_key(self, other, |one| one.agreeing)
    }
}

impl fmt::Display for Agreement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of {}", self.agreeing, self.printed)
    }
}

/// Agreement of `value` with the number that `claim` publishes, or with the nearest of a set.
/// `None` for a claim without numbers.
pub fn agreement(claim: &Claim, value: f64) -> Option<Agreement> {
    let distance = |published: &f64| (value - published).abs();
    let published = claim.values().iter().copied();
    let published = published.min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    let off = distance(&published);
    let (agreeing, printed) = match claim.digits {
        Digits::None => return None,
        Digits::Exact => {
            let scale = scale(published);
            let near = |d: &u32| off <= 0.5 * pow(10.0, -f64::from(*d)) * scale;
            let agreeing = (1..=EXACT_DIGITS).take_while(near).count();
            (agreeing as u32, EXACT_DIGITS)
        }
        Digits::Decimals(decimals) => {
            let printed = significant(published, decimals);
            let near = |missing_digits: &u32| {
                off <= 0.5 * pow(10.0, f64::from(*missing_digits) - decimals as f64)
            };
            // The last digit agrees if rounding gives it, as the claim requires.
            let missing_digits = match claim.agrees(value) {
                true => 0,
                false => (1..printed).find(near).unwrap_or(printed),
            };
            (printed - missing_digits, printed)
        }
    };
    Some(Agreement { agreeing, printed })
}

/// Significant digits of a number printed with so many decimals.
fn significant(published: f64, decimals: usize) -> u32 {
    let text = format!("{:.decimals$}", published.abs());
    let digits = text.chars().filter(char::is_ascii_digit);
    digits.skip_while(|&c| c == '0').count().max(1) as u32
}

/// Replaces the hyphen before a number by a minus sign; hyphens in words remain.
pub(super) fn minus(text: &str) -> String {
    match text.strip_prefix('-') {
        Some(rest) if rest.starts_with(|c: char| c.is_ascii_digit()) => format!("−{rest}"),
        _ => text.to_owned(),
    }
}

/// A small number: its magnitude, or the word for none.
pub(super) fn small(value: f64) -> String {
    if value == 0.0 {
        "0".to_owned()
    } else {
        format!("{value:.0e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(published: &str, digits: &str, value: f64) -> String {
        let row = [
            "eq12.critical_points",
            "b",
            "set",
            published,
            digits,
            "m",
            "x",
            "sect2",
            "",
            "check",
            "algebra",
            "src/a.rs::f",
            "tests/b.rs::g",
        ];
        let claim = Claim::of_record(&csv::StringRecord::from(row.to_vec())).unwrap();
        agreement(&claim, value).unwrap().to_string()
    }

    #[test]
    fn digits_are_counted_from_the_first_that_is_not_zero() {
        assert_eq!(of("0.4697", "4", 0.46972), "4 of 4");
        assert_eq!(of("0.1663", "4", 0.16657), "3 of 4");
        assert_eq!(of("1.1746", "4", 1.1743), "4 of 5");
        assert_eq!(of("1.1746", "4", 11.0), "0 of 5");
        assert_eq!(of("-0.0004", "4", -5e-6), "0 of 1");
        assert_eq!(of("-0.0000", "4", -4e-5), "1 of 1");
        assert_eq!(of("-0.0000", "4", -6e-5), "0 of 1");
        assert_eq!(of("0.5", "4", f64::NEG_INFINITY), "0 of 4");
        assert_eq!(of("0.5", "4", f64::NAN), "0 of 4");
    }

    #[test]
    fn closed_forms_count_to_rounding() {
        assert_eq!(of("0;0.5", "exact", 0.5), "12 of 12");
        assert_eq!(of("0;0.5", "exact", 1e-17), "12 of 12");
        assert_eq!(of("0;0.5", "exact", 0.5 + 1e-9), "8 of 12");
    }

    #[test]
    fn numbers_get_a_true_minus_and_words_keep_their_hyphens() {
        assert_eq!(minus("-0.0049"), "−0.0049");
        assert_eq!(minus("quasi-periodic"), "quasi-periodic");
        assert_eq!(minus("-"), "-");
    }
}
