//! Exponents from data beside those from the equations, wherever the estimator says that the data tell them.

use stickslip::analysis::Exponent;
use stickslip_series::{DataSpectrum, Status};

/// Standard errors that two estimates of one number may differ by: three leave chance 0.3 % of each comparison.
const STANDARD_ERRORS: f64 = 3.0;

/// An exponent that both ways give.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Place in the spectrum, counted from 0.
    pub place: usize,
    /// From data, per unit of `t`.
    pub from_data: f64,
    /// From the equations, per unit of `t`.
    pub from_equations: f64,
    /// Largest difference that errors known beforehand explain, per unit of `t`; see [`compare`].
    pub allowed: f64,
}

impl Comparison {
    /// By how much the data are above the equations, per unit of `t`.
    pub fn difference(&self) -> f64 {
        self.from_data - self.from_equations
    }

    /// Whether known errors explain the difference.
    pub fn agrees(&self) -> bool {
        self.difference().abs() <= self.allowed
    }
}

/// Compares every exponent that is [`Status::Ok`] and finite by both.
///
/// Two errors are known without the equations' answer. Statistical: three standard errors of the difference, both
/// estimates' own in quadrature; where both come from one orbit they rise and fall together, and that is more than enough.
/// Bias of the data: a linear map fitted to a ball of radius ε leaves out terms of second order in the distance, so that its
/// slopes are off by `c εᵖ` with p ≥ 1, and so is an exponent. With twice the radius it is off by `2ᵖ c εᵖ`: the change
/// is `(2ᵖ − 1) c εᵖ`, at least the bias itself. The estimator runs with twice the radius, too, and tells that change.
///
/// What differs by more has a bias that doubling the neighbourhoods does not show, as it may where no power of ε rules
/// yet.
pub fn compare(data: &DataSpectrum, equations: &[Exponent]) -> Vec<Comparison> {
    let pairs = data.exponents.iter().zip(equations).enumerate();
    pairs
        .filter(|(_, (from_data, _))| from_data.status == Status::Ok)
        .filter_map(|(place, (from_data, from_equations))| {
            let own = from_equations.std_error()?;
            let statistical = (from_data.stderr * from_data.stderr + own * own).sqrt();
            Some(Comparison {
                place,
                from_data: from_data.value,
                from_equations: from_equations.value(),
                allowed: STANDARD_ERRORS * statistical + from_data.eps_sensitivity.abs(),
            })
        })
        .collect()
}

/// What an exponent from data is worth, in a word: the estimator's, or `biased` where it says `ok` and the equations say
/// otherwise.
pub(super) fn worth(data: &DataSpectrum, place: usize, comparisons: &[Comparison]) -> &'static str {
    let off = |one: &Comparison| one.place == place && !one.agrees();
    if comparisons.iter().any(off) {
        "biased"
    } else {
        data.exponents
            .get(place)
            .map_or("", |exponent| exponent.status.word())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stickslip::math;
    use stickslip_series::{DataSettings, Series, data_spectrum};

    /// A circle run through at a golden number of radians per sample: one exponent, zero.
    fn circle() -> DataSpectrum {
        let rows = (0..4000).map(|k| {
            let angle = 0.618_034 * f64::from(k);
            [math::cos(angle), math::sin(angle), 0.0, 0.0]
        });
        let series = Series::from_rows(rows, 0.1).unwrap();
        data_spectrum(&series, &DataSettings::sano_sawada()).unwrap()
    }

    #[test]
    fn only_what_the_data_tell_is_compared_and_a_wrong_number_is_found() {
        let data = circle();
        assert_eq!(data.exponents[0].status, Status::Ok);
        let finite = |value| Exponent::Finite {
            value,
            std_error: 1e-6,
        };
        let right = [
            finite(0.0),
            finite(-1.0),
            finite(-2.0),
            Exponent::Annihilated,
        ];
        let compared = compare(&data, &right);
        let places: Vec<usize> = compared.iter().map(|one| one.place).collect();
        assert_eq!(places, [0]);
        assert!(compared[0].agrees(), "{compared:?}");
        assert_eq!(worth(&data, 0, &compared), "ok");
        assert_eq!(worth(&data, 1, &compared), "unidentified");
        let off = 2.0 * compared[0].allowed;
        let wrong = [finite(off), right[1], right[2], right[3]];
        let compared = compare(&data, &wrong);
        assert!(!compared[0].agrees(), "{compared:?}");
        assert_eq!(worth(&data, 0, &compared), "biased");
    }

    #[test]
    fn what_is_not_known_passes_nothing() {
        let mut data = circle();
        data.exponents[0].eps_sensitivity = f64::NAN;
        let finite = Exponent::Finite {
            value: 0.0,
            std_error: 1e-6,
        };
        assert!(!compare(&data, &[finite; 4])[0].agrees());
        assert!(compare(&data, &[Exponent::Annihilated; 4]).is_empty());
    }
}
