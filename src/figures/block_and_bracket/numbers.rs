//! The rows of Figs. 10, 11 and 12.

use super::Set;
use super::against_equations::{compare, worth};
use super::compute::{Data, Literal, Measured};
use crate::figures::rows::Row;
use crate::paper::claim_id::{ClaimId, SpectrumFigure};
use crate::paper::reading::Reading;
use stickslip::analysis::Exponent;
use stickslip_series::{DataExponent, DataSpectrum, Status};

/// What becomes of an orbit that leaves every bound, in the place of a class.
pub const DIVERGES: &str = "diverges";

pub(super) fn numbers(set: &Set, data: &Data) -> Vec<Row> {
    let figure = set.figure;
    let mut rows = exponents(figure, Reading::CorrectedEquations, &data.exact);
    rows.extend(from_data(figure, data));
    let (best, equations) = (&data.best_of_readings, &data.exact.spectrum.exponents);
    rows.extend(data_exponents(
        figure,
        Reading::BestOfReadings,
        best,
        equations,
    ));
    if let Literal::Bounded(measured) = &data.literal {
        rows.extend(exponents(figure, Reading::AsPrintedEquations, measured));
    }
    rows.extend(motion(figure, Reading::Corrected, &data.exact));
    rows.extend(as_printed(figure, &data.literal));
    let evidence = &data.exact.evidence;
    for (reading, signs) in [
        (
            Reading::CorrectedEquations,
            (evidence.zeros, evidence.positive),
        ),
        (Reading::CorrectedData, signs_in_data(&data.from_data)),
    ] {
        rows.extend(statements(figure, reading, signs));
    }
    rows
}

fn exponents(figure: SpectrumFigure, reading: Reading, measured: &Measured) -> Vec<Row> {
    let exponents = &measured.spectrum.exponents;
    let row = |(exponent, id): (&Exponent, ClaimId)| {
        let status = match exponent {
            Exponent::Finite { .. } => "ok",
            Exponent::Annihilated => "annihilated",
        };
        Row::number(id, reading, exponent.value(), "1/t").status(status)
    };
    let mut rows: Vec<Row> = exponents.iter().zip(figure.exponents()).map(row).collect();
    for (i, exponent) in exponents.iter().enumerate() {
        if let Some(error) = exponent.std_error() {
            let id = format!("{}.std_error.{}", figure.name(), i + 1);
            rows.push(Row::number(id, reading, error, "1/t"));
        }
    }
    rows
}

/// The exponents, then what they are worth: standard error (statistical only), change with
/// neighbourhoods of twice the size, the fit of fixed rank, how far those that the data tell are
/// off the equations' and how far they may be, and the neighbourhoods.
fn data_exponents(
    figure: SpectrumFigure,
    reading: Reading,
    spectrum: &DataSpectrum,
    equations: &[Exponent],
) -> Vec<Row> {
    let comparisons = compare(spectrum, equations);
    let exponents = spectrum.exponents.iter().enumerate();
    let numbered = exponents.clone().zip(figure.exponents());
    let row = |((i, exponent), id): ((usize, &DataExponent), _)| {
        Row::number(id, reading, exponent.value, "1/t").status(worth(spectrum, i, &comparisons))
    };
    let mut rows: Vec<Row> = numbered.map(row).collect();
    let name = |quantity: &str| format!("{}.{quantity}", figure.name());
    for (i, exponent) in exponents {
        let fixed = exponent.fixed_rank.unwrap_or((f64::NAN, f64::NAN));
        let worth = [
            ("std_error", exponent.stderr),
            ("eps_sensitivity", exponent.eps_sensitivity),
            ("fixed_rank_lambda", fixed.0),
            ("fixed_rank_std_error", fixed.1),
        ];
        let known = worth.into_iter().filter(|(_, value)| value.is_finite());
        rows.extend(known.map(|(what, value)| {
            Row::number(name(&format!("{what}.{}", i + 1)), reading, value, "1/t")
        }));
    }
    for one in &comparisons {
        let place = one.place + 1;
        let off = name(&format!("off_equations.{place}"));
        let allowed = name(&format!("off_equations_allowed.{place}"));
        rows.push(Row::number(off, reading, one.difference(), "1/t"));
        rows.push(Row::number(allowed, reading, one.allowed, "1/t"));
    }
    let (relative, residual) = (spectrum.mean_eps / spectrum.spread, spectrum.residual_ratio);
    let count = |quantity: &str, value: usize| Row::count(name(quantity), reading, value as u64);
    rows.extend([
        Row::number(name("mean_eps"), reading, relative, "spread"),
        Row::number(name("residual_ratio"), reading, residual, "1"),
        count("median_neighbours", spectrum.neighbours.median),
        count("reference_points", spectrum.references),
        count("starved_points", spectrum.starved),
        count("tangent_directions", spectrum.dimension),
    ]);
    rows
}

fn from_data(figure: SpectrumFigure, data: &Data) -> Vec<Row> {
    let equations = &data.exact.spectrum.exponents;
    let reading = Reading::CorrectedData;
    let mut rows = data_exponents(figure, reading, &data.from_data, equations);
    let samples = format!("{}.samples", figure.name());
    rows.push(Row::count(samples, reading, data.samples as u64));
    rows
}

fn motion(figure: SpectrumFigure, reading: Reading, measured: &Measured) -> Vec<Row> {
    let name = |quantity: &str| format!("{}.{quantity}", figure.name());
    let count = |quantity: &str, value: usize| Row::count(name(quantity), reading, value as u64);
    let number = |quantity: &str, value, unit| Row::number(name(quantity), reading, value, unit);
    let (evidence, spectrum) = (&measured.evidence, &measured.spectrum);
    vec![
        Row::word(figure.class(), reading, &measured.class.to_string()),
        count("section_returns", evidence.returns),
        count("section_points", evidence.distinct),
        number("return_time", evidence.return_time, "t"),
        count("zero_exponents", evidence.zeros),
        number("stick_fraction", spectrum.stick_fraction, "1"),
        count("stick_entries", spectrum.stick_entries),
        number("min_normal_force", measured.least_force, "mg"),
        count("contact_losses", measured.contact_losses as usize),
    ]
}

fn as_printed(figure: SpectrumFigure, literal: &Literal) -> Vec<Row> {
    let when = format!("{}.diverges_at", figure.name());
    match literal {
        Literal::Diverges(t) => vec![
            Row::number(when, Reading::AsPrinted, *t, "t"),
            Row::word(figure.class(), Reading::AsPrinted, DIVERGES),
        ],
        Literal::Bounded(measured) => {
            let mut rows = vec![Row::word(when, Reading::AsPrinted, "never")];
            rows.extend(motion(figure, Reading::AsPrinted, measured));
            rows
        }
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

/// What Sect. 5.2 says of the spectra.
fn statements(
    figure: SpectrumFigure,
    reading: Reading,
    (zeros, positive): (usize, bool),
) -> Vec<Row> {
    let statement = |id, what, holds| Row::statement(id, reading, [(what, holds)]);
    let mut rows = Vec::new();
    // How near to zero an estimate from data comes is the estimator's doing, not the motion's.
    if reading != Reading::CorrectedData {
        rows.push(statement(
            ClaimId::S5ZeroExponent,
            "an exponent is zero within its error",
            zeros >= 1,
        ));
    }
    match figure {
        SpectrumFigure::Fig10 => {}
        SpectrumFigure::Fig11 => rows.push(statement(
            ClaimId::S5TwoZeroExponents,
            "two exponents are zero within their errors",
            zeros == 2,
        )),
        SpectrumFigure::Fig12 => rows.push(statement(
            ClaimId::S5PositiveExponent,
            "the first exponent is positive beyond its error",
            positive,
        )),
    }
    rows
}
