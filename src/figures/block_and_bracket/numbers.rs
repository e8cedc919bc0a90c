//! The rows of Figs. 10, 11 and 12.

use super::Set;
use super::compute::{Data, Literal, Measured};
use crate::figures::rows::Row;
use stickslip::analysis::Exponent;
use stickslip::analysis::data_spectrum::DataSpectrum;

const EQUATIONS: &str = "exact/equations";
const FROM_DATA: &str = "exact/data";
const BEST: &str = "best-of-readings";
const EXACT: &str = "exact";
const AS_PRINTED: &str = "as-printed";
const AS_PRINTED_EQUATIONS: &str = "as-printed/equations";

pub(super) fn numbers(set: &Set, data: &Data) -> Vec<Row> {
    let figure = set.figure;
    let mut rows = exponents(figure, EQUATIONS, &data.exact);
    rows.extend(from_data(figure, data));
    rows.extend(data_exponents(figure, BEST, &data.best_of_readings));
    if let Literal::Bounded(measured) = &data.literal {
        rows.extend(exponents(figure, AS_PRINTED_EQUATIONS, measured));
    }
    rows.extend(motion(figure, EXACT, &data.exact));
    rows.extend(as_printed(figure, &data.literal));
    rows.extend(statements(figure, &data.exact));
    rows
}

/// Name of the `i`-th exponent, counted from 0.
fn lambda(figure: &str, i: usize) -> String {
    format!("{figure}.lambda.{}", i + 1)
}

fn exponents(figure: &str, reading: &str, measured: &Measured) -> Vec<Row> {
    let exponents = &measured.spectrum.exponents;
    let mut rows: Vec<Row> = exponents
        .iter()
        .enumerate()
        .map(|(i, exponent)| {
            let id = lambda(figure, i);
            let status = match exponent {
                Exponent::Finite { .. } => "ok",
                Exponent::Annihilated => "annihilated",
            };
            Row::number(&id, reading, exponent.value(), "1/t")
                .against(&id)
                .status(status)
        })
        .collect();
    for (i, exponent) in exponents.iter().enumerate() {
        if let Some(error) = exponent.std_error() {
            let id = format!("{figure}.std_error.{}", i + 1);
            rows.push(Row::number(&id, reading, error, "1/t"));
        }
    }
    rows
}

/// The exponents, then what they are worth: standard error (statistical only), change with neighbourhoods of twice the size,
/// the fit of fixed rank, and the neighbourhoods.
fn data_exponents(figure: &str, reading: &str, spectrum: &DataSpectrum) -> Vec<Row> {
    let exponents = spectrum.exponents.iter().enumerate();
    let mut rows: Vec<Row> = exponents
        .clone()
        .map(|(i, exponent)| {
            let id = lambda(figure, i);
            Row::number(&id, reading, exponent.value, "1/t")
                .against(&id)
                .status(exponent.status.word())
        })
        .collect();
    for (i, exponent) in exponents {
        let fixed = exponent.fixed_rank.unwrap_or((f64::NAN, f64::NAN));
        let worth = [
            ("std_error", exponent.stderr),
            ("eps_sensitivity", exponent.eps_sensitivity),
            ("fixed_rank_lambda", fixed.0),
            ("fixed_rank_std_error", fixed.1),
        ];
        let known = worth.into_iter().filter(|(_, value)| value.is_finite());
        rows.extend(known.map(|(name, value)| {
            Row::number(&format!("{figure}.{name}.{}", i + 1), reading, value, "1/t")
        }));
    }
    let name = |quantity: &str| format!("{figure}.{quantity}");
    let relative = spectrum.mean_eps / spectrum.spread;
    let count = |quantity: &str, value: usize| Row::count(&name(quantity), reading, value as u64);
    rows.extend([
        Row::number(&name("mean_eps"), reading, relative, "spread"),
        Row::number(
            &name("residual_ratio"),
            reading,
            spectrum.residual_ratio,
            "1",
        ),
        count("median_neighbours", spectrum.neighbours.median),
        count("reference_points", spectrum.references),
        count("starved_points", spectrum.starved),
        count("tangent_directions", spectrum.dimension),
    ]);
    rows
}

fn from_data(figure: &str, data: &Data) -> Vec<Row> {
    let mut rows = data_exponents(figure, FROM_DATA, &data.from_data);
    let samples = format!("{figure}.samples");
    rows.push(Row::count(&samples, FROM_DATA, data.samples as u64));
    rows
}

fn motion(figure: &str, reading: &str, measured: &Measured) -> Vec<Row> {
    let name = |quantity: &str| format!("{figure}.{quantity}");
    let class = name("class");
    let evidence = &measured.evidence;
    vec![
        Row::word(&class, reading, &measured.class.to_string()).against(&class),
        Row::count(&name("section_returns"), reading, evidence.returns as u64),
        Row::count(&name("section_points"), reading, evidence.distinct as u64),
        Row::number(&name("return_time"), reading, evidence.return_time, "t"),
        Row::count(&name("zero_exponents"), reading, evidence.zeros as u64),
        Row::number(
            &name("stick_fraction"),
            reading,
            measured.spectrum.stick_fraction,
            "1",
        ),
        Row::count(
            &name("stick_entries"),
            reading,
            measured.spectrum.stick_entries as u64,
        ),
        Row::number(
            &name("min_normal_force"),
            reading,
            measured.least_force,
            "mg",
        ),
        Row::count(&name("contact_losses"), reading, measured.contact_losses),
    ]
}

fn as_printed(figure: &str, literal: &Literal) -> Vec<Row> {
    let when = format!("{figure}.diverges_at");
    let class = format!("{figure}.class");
    match literal {
        Literal::Diverges(t) => vec![
            Row::number(&when, AS_PRINTED, *t, "t"),
            Row::word(&class, AS_PRINTED, "diverges").against(&class),
        ],
        Literal::Bounded(measured) => {
            let mut rows = vec![Row::word(&when, AS_PRINTED, "never")];
            rows.extend(motion(figure, AS_PRINTED, measured));
            rows
        }
    }
}

/// What Sect. 5.2 says of the spectra, member by member where it speaks of each.
fn statements(figure: &str, measured: &Measured) -> Vec<Row> {
    let evidence = &measured.evidence;
    let zero = format!("s5.zero_exponent.{figure}");
    let mut rows = vec![Row::statement(&zero, EQUATIONS, evidence.zeros >= 1)];
    match figure {
        "fig11" => {
            let id = "s5.two_zero_exponents";
            rows.push(Row::statement(id, EQUATIONS, evidence.zeros == 2));
        }
        "fig12" => {
            let id = "s5.positive_exponent";
            rows.push(Row::statement(id, EQUATIONS, evidence.positive));
        }
        _ => {}
    }
    rows
}
