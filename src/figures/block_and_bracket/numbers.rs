//! The rows of Figs. 10, 11 and 12. Exponents from data stand beside those from the equations,
//! wherever the estimator reports that the data determine them.

use super::compute::{AsPrintedOutcome, BoundedMotion, Data};
use crate::figures::rows::Row;
use crate::paper::claim_id::{ClaimId, SpectrumFigure};
use crate::paper::reading::Reading;
use stickslip::analysis::Exponent;
use stickslip_series::{DataExponent, DataSpectrum, Status};

/// Reported instead of a class for an orbit that diverges.
pub const DIVERGES: &str = "diverges";

pub(super) fn numbers(data: &Data) -> Vec<Row> {
    let by = |reading| FigureReading {
        figure: data.set.figure,
        reading,
    };
    let equations = &data.exact.spectrum.exponents;
    let mut rows = by(Reading::CorrectedEquations).exponents(&data.exact);
    let from_data = by(Reading::CorrectedData);
    rows.extend(from_data.data_exponents(&data.from_data, equations));
    rows.push(from_data.count("samples", data.states.len()));
    rows.extend(by(Reading::BestOfReadings).data_exponents(&data.best_of_readings, equations));
    if let AsPrintedOutcome::Bounded(measured) = &data.literal {
        rows.extend(by(Reading::AsPrintedEquations).exponents(measured));
    }
    rows.extend(by(Reading::Corrected).motion(&data.exact));
    let as_printed = by(Reading::AsPrinted);
    match &data.literal {
        AsPrintedOutcome::Diverges(t) => {
            rows.push(as_printed.number("diverges_at", *t, "t"));
            rows.push(as_printed.class(DIVERGES));
        }
        AsPrintedOutcome::Bounded(measured) => {
            let when = as_printed.name("diverges_at");
            rows.push(Row::word(when, Reading::AsPrinted, "never"));
            rows.extend(as_printed.motion(measured));
        }
    }
    let evidence = &data.exact.evidence;
    rows.extend(by(Reading::CorrectedEquations).statements(evidence.zeros, evidence.positive));
    let (zeros, positive) = signs_in_data(&data.from_data);
    rows.extend(from_data.statements(zeros, positive));
    rows
}

/// The spectrum with its exponents by size, those that the data do not identify last. Golden files
/// and picture number them in this order. The estimator's own order is that of its directions.
pub(super) fn by_size(mut spectrum: DataSpectrum) -> DataSpectrum {
    let exponents = &spectrum.exponents;
    let is_unidentified = |i: usize| exponents[i].status == Status::Unidentified;
    let mut order: Vec<usize> = (0..exponents.len()).collect();
    order.sort_by(|&one, &other| {
        let by_value = exponents[other].value.total_cmp(&exponents[one].value);
        let by_status = is_unidentified(one).cmp(&is_unidentified(other));
        by_status.then(by_value)
    });
    spectrum.exponents = order.iter().map(|&i| exponents[i].clone()).collect();
    for at in &mut spectrum.convergence {
        at.exponents = order.iter().map(|&i| at.exponents[i]).collect();
    }
    spectrum
}

/// The rows of a figure under one reading.
struct FigureReading {
    figure: SpectrumFigure,
    reading: Reading,
}

impl FigureReading {
    fn name(&self, quantity: &str) -> String {
        format!("{}.{quantity}", self.figure.name())
    }

    fn number(&self, quantity: &str, value: f64, unit: &'static str) -> Row {
        Row::number(self.name(quantity), self.reading, value, unit)
    }

    fn count(&self, quantity: &str, value: usize) -> Row {
        Row::count(self.name(quantity), self.reading, value)
    }

    fn class(&self, class: &str) -> Row {
        Row::word(self.figure.class(), self.reading, class)
    }

    fn exponent(&self, index: usize, value: f64, quality: &'static str) -> Row {
        let id = self.figure.exponents()[index];
        Row::number(id, self.reading, value, "1/t").status(quality)
    }

    fn exponents(&self, measured: &BoundedMotion) -> Vec<Row> {
        let exponents = measured.spectrum.exponents.iter().take(4).enumerate();
        let values = exponents.clone().map(|(i, exponent)| {
            let quality = match exponent {
                Exponent::Finite { .. } => "ok",
                Exponent::Annihilated => "annihilated",
            };
            self.exponent(i, exponent.value(), quality)
        });
        let errors = exponents.filter_map(|(i, exponent)| {
            let error = exponent.std_error()?;
            Some(self.number(&format!("std_error.{}", i + 1), error, "1/t"))
        });
        values.chain(errors).collect()
    }

    /// The exponents, then their quality. It includes the standard error (statistical only), the
    /// change with neighbourhoods of twice the size, and the fit of fixed rank. It also includes
    /// the differences from the equations' exponents with the allowed differences, and the
    /// neighbourhoods.
    fn data_exponents(&self, spectrum: &DataSpectrum, equations: &[Exponent]) -> Vec<Row> {
        let comparisons = compare(spectrum, equations);
        let exponents = spectrum.exponents.iter().take(4).enumerate();
        let value = |(i, exponent): (usize, &DataExponent)| {
            self.exponent(i, exponent.value, quality(spectrum, i, &comparisons))
        };
        let mut rows: Vec<Row> = exponents.clone().map(value).collect();
        for (i, exponent) in exponents {
            let fixed = exponent.fixed_rank.unwrap_or((f64::NAN, f64::NAN));
            let quality = [
                ("std_error", exponent.stderr),
                ("eps_sensitivity", exponent.eps_sensitivity),
                ("fixed_rank_lambda", fixed.0),
                ("fixed_rank_std_error", fixed.1),
            ];
            let estimated = quality.into_iter().filter(|(_, value)| value.is_finite());
            let row = |(what, value)| self.number(&format!("{what}.{}", i + 1), value, "1/t");
            rows.extend(estimated.map(row));
        }
        for one in &comparisons {
            let index = one.index + 1;
            let allowed = format!("off_equations_allowed.{index}");
            rows.push(self.number(&format!("off_equations.{index}"), one.difference(), "1/t"));
            rows.push(self.number(&allowed, one.allowed, "1/t"));
        }
        let relative = spectrum.mean_eps / spectrum.spread;
        rows.extend([
            self.number("mean_eps", relative, "spread"),
            self.number("residual_ratio", spectrum.residual_ratio, "1"),
            self.count("median_neighbours", spectrum.neighbours.median),
            self.count("reference_points", spectrum.references),
            self.count("starved_points", spectrum.starved),
            self.count("tangent_directions", spectrum.dimension),
        ]);
        rows
    }

    fn motion(&self, measured: &BoundedMotion) -> Vec<Row> {
        let (evidence, spectrum) = (&measured.evidence, &measured.spectrum);
        vec![
            self.class(&measured.class.to_string()),
            self.count("section_returns", evidence.returns),
            self.count("section_points", evidence.distinct),
            self.number("return_time", evidence.return_time, "t"),
            self.count("zero_exponents", evidence.zeros),
            self.number("stick_fraction", spectrum.stick_fraction, "1"),
            self.count("stick_entries", spectrum.stick_entries),
            self.number("min_normal_force", measured.least_force, "mg"),
            self.count("contact_losses", measured.contact_losses as usize),
            self.number("lifted_fraction", measured.lifted_fraction, "1"),
        ]
    }

    /// The statements of Sect. 5.2 on the spectra.
    fn statements(&self, zeros: usize, positive: bool) -> Vec<Row> {
        let mut parts = Vec::new();
        let what = "an exponent is zero within its error";
        parts.push((ClaimId::S5ZeroExponent, what, zeros >= 1));
        match self.figure {
            SpectrumFigure::Fig10 => {}
            SpectrumFigure::Fig11 => {
                let what = "two exponents are zero within their errors";
                parts.push((ClaimId::S5TwoZeroExponents, what, zeros == 2));
            }
            SpectrumFigure::Fig12 => {
                let what = "the first exponent is positive beyond its error";
                parts.push((ClaimId::S5PositiveExponent, what, positive));
            }
        }
        let row = |(id, what, holds)| Row::statement(id, self.reading, [(what, holds)]);
        parts.into_iter().map(row).collect()
    }
}

/// Signs by the estimate from data: the number of zero exponents, and whether the first is
/// positive.
fn signs_in_data(spectrum: &DataSpectrum) -> (usize, bool) {
    let is_determined = |one: &&DataExponent| one.status == Status::Ok;
    let error = |one: &DataExponent| STANDARD_ERRORS * one.stderr + one.eps_sensitivity.abs();
    let exponents = spectrum.exponents.iter().filter(is_determined);
    let zeros = exponents.filter(|one| one.value.abs() <= error(one));
    let first = spectrum.exponents.first().filter(is_determined);
    let positive = first.is_some_and(|one| one.value > error(one));
    (zeros.count(), positive)
}

/// Allowed difference of two estimates of one number, in standard errors. By chance, 0.3 % of the
/// comparisons exceed it.
const STANDARD_ERRORS: f64 = 3.0;

/// An exponent that both methods give.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExponentComparison {
    /// Index in the spectrum, from 0.
    pub index: usize,
    /// Exponent from data, per unit of `t`.
    pub from_data: f64,
    /// Exponent from the equations, per unit of `t`.
    pub from_equations: f64,
    /// Largest difference explained by the known errors, per unit of `t`; see [`compare`].
    pub allowed: f64,
}

impl ExponentComparison {
    /// Estimate from data minus that from the equations, per unit of `t`.
    pub fn difference(&self) -> f64 {
        self.from_data - self.from_equations
    }

    /// Whether the known errors explain the difference.
    pub fn agrees(&self) -> bool {
        self.difference().abs() <= self.allowed
    }
}

/// Compares every exponent that is [`Status::Ok`] in the data and finite by both methods.
///
/// Two errors are known without the equations' exponents. Statistical: three standard errors of the
/// difference, combined in quadrature. Both estimates from one orbit are correlated, so this is an
/// upper bound. Bias of the data: a linear map fitted to a ball of radius ε neglects terms of
/// second order in the distance. So its slopes, and an exponent, are off by `c εᵖ` with p ≥ 1. With
/// twice the radius the error is `2ᵖ c εᵖ`; the change, `(2ᵖ − 1) c εᵖ`, is at least the bias. The
/// estimator also runs with twice the radius and reports that change.
///
/// A larger difference is a bias that doubling the neighbourhoods does not show. This may happen
/// where no power of ε dominates yet.
pub fn compare(data: &DataSpectrum, equations: &[Exponent]) -> Vec<ExponentComparison> {
    let pairs = data.exponents.iter().zip(equations).enumerate();
    pairs
        .filter(|(_, (from_data, _))| from_data.status == Status::Ok)
        .filter_map(|(index, (from_data, from_equations))| {
            let own = from_equations.std_error()?;
            let statistical = (from_data.stderr * from_data.stderr + own * own).sqrt();
            Some(ExponentComparison {
                index,
                from_data: from_data.value,
                from_equations: from_equations.value(),
                allowed: STANDARD_ERRORS * statistical + from_data.eps_sensitivity.abs(),
            })
        })
        .collect()
}

/// The quality of an exponent from data, in a word: the estimator's status, or `biased` where the
/// status is `ok` and the equations disagree.
pub(super) fn quality(
    data: &DataSpectrum,
    index: usize,
    comparisons: &[ExponentComparison],
) -> &'static str {
    let off = |one: &ExponentComparison| one.index == index && !one.agrees();
    if comparisons.iter().any(off) {
        return "biased";
    }
    let exponent = data.exponents.get(index);
    exponent.map_or("", |exponent| exponent.status.word())
}

#[cfg(test)]
mod tests {
    use super::*;
    use stickslip::math;
    use stickslip_series::{DataSettings, Series, data_spectrum};

    /// A circle sampled at a golden number of radians: one exponent, zero.
    fn circle() -> DataSpectrum {
        let rows = (0..4000).map(|k| {
            let angle = 0.618_034 * f64::from(k);
            [math::cos(angle), math::sin(angle), 0.0, 0.0]
        });
        let series = Series::from_rows(rows, 0.1).unwrap();
        data_spectrum(&series, &DataSettings::sano_sawada()).unwrap()
    }

    #[test]
    fn only_determined_exponents_are_compared_and_a_wrong_one_disagrees() {
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
        let indices: Vec<usize> = compared.iter().map(|one| one.index).collect();
        assert_eq!(indices, [0]);
        assert!(compared[0].agrees(), "{compared:?}");
        assert_eq!(quality(&data, 0, &compared), "ok");
        assert_eq!(quality(&data, 1, &compared), "unidentified");
        let off = 2.0 * compared[0].allowed;
        let wrong = [finite(off), right[1], right[2], right[3]];
        let compared = compare(&data, &wrong);
        assert!(!compared[0].agrees(), "{compared:?}");
        assert_eq!(quality(&data, 0, &compared), "biased");
    }

    #[test]
    fn exponents_are_numbered_by_size_with_the_unidentified_last() {
        let mut data = circle();
        let values = [-0.1, 0.2, -0.3, 0.4];
        let statuses = [
            Status::Ok,
            Status::Ok,
            Status::Unidentified,
            Status::Unidentified,
        ];
        for (exponent, (value, status)) in data
            .exponents
            .iter_mut()
            .zip(values.into_iter().zip(statuses))
        {
            (exponent.value, exponent.status) = (value, status);
        }
        let before = data.convergence[0].exponents.clone();
        let sorted = by_size(data);
        let found: Vec<f64> = sorted.exponents.iter().map(|one| one.value).collect();
        assert_eq!(found, [0.2, -0.1, 0.4, -0.3]);
        let running = [1, 0, 3, 2].map(|i: usize| before[i].to_bits());
        assert_eq!(
            sorted.convergence[0]
                .exponents
                .iter()
                .map(|v| v.to_bits())
                .collect::<Vec<_>>(),
            running
        );
    }

    #[test]
    fn an_unknown_error_allows_no_difference() {
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
