//! The rows of Figs. 10, 11 and 12.

use super::against_equations::{compare, worth};
use super::compute::{Data, Literal, Measured};
use crate::figures::rows::Row;
use crate::paper::claim_id::{ClaimId, SpectrumFigure};
use crate::paper::reading::Reading;
use stickslip::analysis::Exponent;
use stickslip_series::{DataExponent, DataSpectrum, Status};

/// What becomes of an orbit that leaves every bound, in the place of a class.
pub const DIVERGES: &str = "diverges";

pub(super) fn numbers(data: &Data) -> Vec<Row> {
    let by = |reading| Named {
        figure: data.set.figure,
        reading,
    };
    let equations = &data.exact.spectrum.exponents;
    let mut rows = by(Reading::CorrectedEquations).exponents(&data.exact);
    let from_data = by(Reading::CorrectedData);
    rows.extend(from_data.data_exponents(&data.from_data, equations));
    rows.push(from_data.count("samples", data.samples));
    rows.extend(by(Reading::BestOfReadings).data_exponents(&data.best_of_readings, equations));
    if let Literal::Bounded(measured) = &data.literal {
        rows.extend(by(Reading::AsPrintedEquations).exponents(measured));
    }
    rows.extend(by(Reading::Corrected).motion(&data.exact));
    let as_printed = by(Reading::AsPrinted);
    match &data.literal {
        Literal::Diverges(t) => {
            rows.push(as_printed.number("diverges_at", *t, "t"));
            rows.push(as_printed.class(DIVERGES));
        }
        Literal::Bounded(measured) => {
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

/// The rows of a figure under one reading.
struct Named {
    figure: SpectrumFigure,
    reading: Reading,
}

impl Named {
    fn name(&self, quantity: &str) -> String {
        format!("{}.{quantity}", self.figure.name())
    }

    fn number(&self, quantity: &str, value: f64, unit: &'static str) -> Row {
        Row::number(self.name(quantity), self.reading, value, unit)
    }

    fn count(&self, quantity: &str, value: usize) -> Row {
        Row::count(self.name(quantity), self.reading, value as u64)
    }

    fn class(&self, class: &str) -> Row {
        Row::word(self.figure.class(), self.reading, class)
    }

    fn exponent(&self, place: usize, value: f64, worth: &'static str) -> Row {
        let id = self.figure.exponents()[place];
        Row::number(id, self.reading, value, "1/t").status(worth)
    }

    fn exponents(&self, measured: &Measured) -> Vec<Row> {
        let exponents = measured.spectrum.exponents.iter().take(4).enumerate();
        let values = exponents.clone().map(|(i, exponent)| {
            let worth = match exponent {
                Exponent::Finite { .. } => "ok",
                Exponent::Annihilated => "annihilated",
            };
            self.exponent(i, exponent.value(), worth)
        });
        let errors = exponents.filter_map(|(i, exponent)| {
            let error = exponent.std_error()?;
            Some(self.number(&format!("std_error.{}", i + 1), error, "1/t"))
        });
        values.chain(errors).collect()
    }

    /// The exponents, then what they are worth: standard error (statistical only), change with
    /// neighbourhoods of twice the size, the fit of fixed rank, how far those that the data tell
    /// are off the equations' and how far they may be, and the neighbourhoods.
    fn data_exponents(&self, spectrum: &DataSpectrum, equations: &[Exponent]) -> Vec<Row> {
        let comparisons = compare(spectrum, equations);
        let exponents = spectrum.exponents.iter().take(4).enumerate();
        let value = |(i, exponent): (usize, &DataExponent)| {
            self.exponent(i, exponent.value, worth(spectrum, i, &comparisons))
        };
        let mut rows: Vec<Row> = exponents.clone().map(value).collect();
        for (i, exponent) in exponents {
            let fixed = exponent.fixed_rank.unwrap_or((f64::NAN, f64::NAN));
            let worth = [
                ("std_error", exponent.stderr),
                ("eps_sensitivity", exponent.eps_sensitivity),
                ("fixed_rank_lambda", fixed.0),
                ("fixed_rank_std_error", fixed.1),
            ];
            let known = worth.into_iter().filter(|(_, value)| value.is_finite());
            let row = |(what, value)| self.number(&format!("{what}.{}", i + 1), value, "1/t");
            rows.extend(known.map(row));
        }
        for one in &comparisons {
            let place = one.place + 1;
            let allowed = format!("off_equations_allowed.{place}");
            rows.push(self.number(&format!("off_equations.{place}"), one.difference(), "1/t"));
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

    fn motion(&self, measured: &Measured) -> Vec<Row> {
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
        ]
    }

    /// What Sect. 5.2 says of the spectra.
    fn statements(&self, zeros: usize, positive: bool) -> Vec<Row> {
        let mut parts = Vec::new();
        // How near to zero an estimate from data comes is the estimator's doing, not the motion's.
        if self.reading != Reading::CorrectedData {
            let what = "an exponent is zero within its error";
            parts.push((ClaimId::S5ZeroExponent, what, zeros >= 1));
        }
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

/// How many exponents are zero, and whether the first is positive, as the estimate from data tells.
fn signs_in_data(spectrum: &DataSpectrum) -> (usize, bool) {
    let told = |one: &&DataExponent| one.status == Status::Ok;
    let error = |one: &DataExponent| 3.0 * one.stderr + one.eps_sensitivity.abs();
    let exponents = spectrum.exponents.iter().filter(told);
    let zeros = exponents
        .filter(|one| one.value.abs() <= error(one))
        .count();
    let first = spectrum.exponents.first().filter(told);
    (zeros, first.is_some_and(|one| one.value > error(one)))
}
