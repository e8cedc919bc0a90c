//! A spectrum as a table to read, as CSV and as JSON.

use std::fmt::Write;

use serde_json::{Value, json};

use super::balance;
use super::error::SpectrumError;
use super::findings::Findings;
use super::opinion;
use super::read::Table;
use super::warnings::warnings;
use crate::figures::FigureError;
use stickslip::analysis::data_spectrum::{
    DataExponent, DataSpectrum, Estimator, Neighbourhood, Status,
};
use stickslip::error::readable;

/// What is called ok was held against the truth on series of so many points and more.
const COUNTED_POINTS: usize = 5000;

/// An exponent that is called ok is within so many standard errors of the truth nine times in ten.
const STANDARD_ERRORS: f64 = 2.0;

/// What exponents are measured in.
const UNIT: &str = "natural logarithms of growth per unit of the time that dt is given in";

/// The spectrum and its evidence, for the terminal.
pub fn table(findings: &Findings, source: &Table) -> String {
    let spectrum = &findings.spectrum;
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "{}: {} points of ({}), dt = {}{}",
        source.input,
        rows(source),
        source.names.join(", "),
        readable(source.dt),
        source
            .time
            .as_ref()
            .map_or(String::new(), |name| format!(" from column {name}")),
    );
    if let Some(embedded) = &findings.embedded {
        text += &embedded.text(source);
    }
    text.push('\n');
    let _ = writeln!(
        text,
        "{:>5}  {:>12}  {:>10}  {:>15}  {:<13} {:>15}  {:<10} {:>5}",
        "index",
        "exponent",
        "stderr",
        "eps_sensitivity",
        "status",
        format!("by rank {}", spectrum.fixed_rank),
        "direction",
        "slope"
    );
    let directions = spectrum.directions.iter();
    for (i, (exponent, direction)) in spectrum.exponents.iter().zip(directions).enumerate() {
        let _ = writeln!(
            text,
            "{:>5}  {:>12}  {:>10}  {:>15}  {:<13} {:>15}  {:<10} {:>5}",
            i + 1,
            value(exponent, findings.is_spurious(i)),
            short(exponent.stderr),
            short(exponent.eps_sensitivity),
            findings.status(i),
            exponent
                .fixed_rank
                .map_or("–".into(), |(value, _)| short(value)),
            direction.kind.word(),
            if direction.slope.is_nan() {
                "–".into()
            } else {
                format!("{:.2}", direction.slope)
            },
        );
    }
    let _ = writeln!(
        text,
        "\n{} tangent direction{}: {}; a value in brackets is none of the system's.\n\
         {}; eps_sensitivity is the change with neighbourhoods of twice the size, a measure of bias.\n\
         Exponents are {UNIT}.",
        spectrum.dimension,
        if spectrum.dimension == 1 { "" } else { "s" },
        determined(findings),
        estimator(spectrum)
    );
    if let Some(embedded) = &findings.embedded {
        text += &embedded.origins(spectrum);
    }
    if let Some((divergence, balance)) = &findings.balance {
        text += &balance::line(spectrum, *divergence, balance);
    }
    if let Some(divergence) = &findings.divergence {
        text += &opinion::divergence_text(divergence);
    }
    for note in notes(findings, source) {
        let _ = writeln!(text, "{note}");
    }
    if let Some(test) = &findings.surrogates {
        text += &opinion::surrogates_text(test);
    }
    let counts = &spectrum.neighbours;
    let settings = &spectrum.settings;
    let _ = writeln!(
        text,
        "{} reference points, {} starved; residual ratio {}; neighbours {} to {}, median {}; mean eps {} ({} of the spread); \
         {}, Theiler window {}, step {}, {}",
        spectrum.references,
        spectrum.starved,
        short(spectrum.residual_ratio),
        counts.min,
        counts.max,
        counts.median,
        short(spectrum.mean_eps),
        short(spectrum.mean_eps / spectrum.spread),
        neighbourhood(&settings.neighbours),
        settings.theiler.unwrap_or(0),
        settings.step,
        if settings.affine { "affine" } else { "linear" },
    );
    if (0..spectrum.exponents.len()).any(|i| findings.status(i) != Status::Ok.word()) {
        text += "What the statuses mean: --help\n";
    }
    text
}

/// How many of the tangent directions have an exponent to be trusted.
fn determined(findings: &Findings) -> String {
    let ok = (0..findings.spectrum.dimension)
        .filter(|&i| findings.status(i) == Status::Ok.word())
        .count();
    if findings.is_noise() {
        "noise has as many as are looked at, and no exponent".to_owned()
    } else {
        match ok {
            0 => "no exponent is ok".to_owned(),
            1 => "1 exponent is ok".to_owned(),
            _ => format!("{ok} exponents are ok"),
        }
    }
}

/// What is to be known of the exponents that are ok.
fn notes(findings: &Findings, source: &Table) -> Vec<String> {
    let notes = [near_zero(findings), short_of_points(findings, rows(source))];
    notes.into_iter().flatten().collect()
}

/// Which exponents are ok and have no sign for certain.
fn near_zero(findings: &Findings) -> Option<String> {
    let exponents = (1..).zip(&findings.spectrum.exponents);
    let near: Vec<String> = exponents
        .filter(|(i, exponent)| {
            findings.status(i - 1) == Status::Ok.word()
                && exponent.value.abs() <= STANDARD_ERRORS * exponent.stderr
        })
        .map(|(i, _)| i.to_string())
        .collect();
    let plural = if near.len() > 1 { "s" } else { "" };
    (!near.is_empty()).then(|| {
        format!(
            "Zero is within two stderr of exponent{plural} {}: that it is ok says nothing of its sign.",
            near.join(", ")
        )
    })
}

/// That nobody counted what "ok" is worth of so few points.
fn short_of_points(findings: &Findings, rows: usize) -> Option<String> {
    let spectrum = &findings.spectrum;
    let is_ok = (0..spectrum.exponents.len()).any(|i| findings.status(i) == Status::Ok.word());
    (is_ok && rows < COUNTED_POINTS && spectrum.sizes.is_some()).then(|| {
        format!("What ok is worth was counted on series of {COUNTED_POINTS} points and more, and not on {rows}.")
    })
}

/// Rows of a table.
fn rows(table: &Table) -> usize {
    table.values.len() / table.names.len().max(1)
}

/// Which estimator it is, and what its error holds.
fn estimator(spectrum: &DataSpectrum) -> String {
    let Some(sizes) = &spectrum.sizes else {
        let why = match spectrum.settings.estimator {
            Estimator::SanoSawada => "",
            Estimator::Extrapolated { .. } => {
                " (no direction is tangent, and nothing to extrapolate)"
            }
        };
        return format!("Sano-Sawada, Eqs. (25) and (26){why}: stderr is statistical only");
    };
    let uncorrected: Vec<String> = spectrum
        .exponents
        .iter()
        .take(spectrum.dimension)
        .map(|exponent| short(exponent.sano_sawada.0))
        .collect();
    let ([few, many], [near, far]) = (sizes.neighbours, sizes.radius);
    format!(
        "Extrapolated to size zero from {} maps of {few} and {many} neighbours, mean distance {} and {}; by Sano-Sawada, Eqs. (25) and \
         (26), no correction: {}.\nstderr holds scatter over time and extrapolation",
        sizes.degree.word(),
        short(near),
        short(far),
        uncorrected.join(", ")
    )
}

fn neighbourhood(neighbours: &Neighbourhood) -> String {
    match neighbours {
        Neighbourhood::Ball { eps, min, max } => {
            format!("eps {}, neighbours {min}-{max}", readable(*eps))
        }
        Neighbourhood::Nearest(k) => format!("nearest {k}"),
    }
}

fn value(exponent: &DataExponent, is_spurious: bool) -> String {
    match exponent.status {
        _ if is_spurious => format!("({})", short(exponent.value)),
        Status::Ok
        | Status::Unstable
        | Status::Starved
        | Status::Undetermined
        | Status::Noisy
        | Status::Unpredictable => short(exponent.value),
        Status::Annihilated => "-inf".into(),
        Status::Unidentified if exponent.value.is_nan() => "–".into(),
        Status::Unidentified => format!("({})", short(exponent.value)),
    }
}

/// Five significant digits or five decimals, whichever is shorter.
pub(super) fn short(v: f64) -> String {
    if v.is_nan() {
        "–".into()
    } else if !v.is_finite() || v == 0.0 {
        format!("{v}")
    } else if (1e-3..1e5).contains(&v.abs()) {
        format!("{v:.5}")
    } else {
        format!("{v:.2e}")
    }
}

/// `index,exponent,stderr,status`, full precision; `-inf` for an annihilated direction, an empty cell where there is no value.
///
/// # Errors
/// [`FigureError::Csv`] if the writer refuses a field.
pub fn csv(findings: &Findings) -> Result<String, SpectrumError> {
    let spectrum = &findings.spectrum;
    let number = |v: f64| {
        if v.is_nan() {
            String::new()
        } else {
            format!("{v:?}")
        }
    };
    let mut writer = csv::Writer::from_writer(Vec::new());
    let header = ["index", "exponent", "stderr", "status"];
    writer.write_record(header).map_err(FigureError::from)?;
    for (i, exponent) in spectrum.exponents.iter().enumerate() {
        let record = [
            (i + 1).to_string(),
            number(exponent.value),
            number(exponent.stderr),
            findings.status(i).to_owned(),
        ];
        writer.write_record(record).map_err(FigureError::from)?;
    }
    let bytes = writer
        .into_inner()
        .map_err(|error| FigureError::from(csv::Error::from(error.into_error())))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// An object with `settings`, `exponents` (a list of `index`, `exponent`, `stderr`, `status` and more), `directions`,
/// `neighbourhoods`, `residual_ratio`, `warnings` and `notes`, which the table has at its end. Infinity and what has no value are `null`, as JSON has no word for them; `status` tells which.
///
/// # Errors
/// [`SpectrumError::Json`].
pub fn json(findings: &Findings, source: &Table) -> Result<String, SpectrumError> {
    let spectrum = &findings.spectrum;
    let exponents: Vec<Value> = spectrum
        .exponents
        .iter()
        .enumerate()
        .map(|(i, exponent)| {
            json!({
                "index": i + 1,
                "exponent": exponent.value,
                "stderr": exponent.stderr,
                "eps_sensitivity": exponent.eps_sensitivity,
                "status": findings.status(i),
                "fixed_rank": exponent.fixed_rank.map(|(value, _)| value),
                "fixed_rank_stderr": exponent.fixed_rank.map(|(_, stderr)| stderr),
                "collapses": exponent.collapses,
                "undetermined": exponent.undetermined,
                "sano_sawada": exponent.sano_sawada.0,
                "sano_sawada_stderr": exponent.sano_sawada.1,
            })
        })
        .collect();
    let directions: Vec<Value> = spectrum
        .directions
        .iter()
        .map(|direction| json!({ "kind": direction.kind.word(), "slope": direction.slope }))
        .collect();
    let settings = &spectrum.settings;
    let (eps, min, max) = match settings.neighbours {
        Neighbourhood::Ball { eps, min, max } => (Some(eps), min, max),
        Neighbourhood::Nearest(k) => (None, k, k),
    };
    let document = json!({
        "settings": {
            "estimator": settings.estimator.words(),
            "dt": source.dt,
            "columns": source.names,
            "eps": eps,
            "min_neighbours": min,
            "max_neighbours": max,
            "theiler": settings.theiler,
            "step": settings.step,
            "affine": settings.affine,
            "rank_tolerance": settings.rank_tolerance,
            "ridge": settings.ridge,
            "fixed_rank": settings.fixed_rank,
            "stride": settings.stride,
            "references": settings.references,
        },
        "unit": UNIT,
        "exponents": exponents,
        "sum": spectrum.sum.0,
        "sum_stderr": spectrum.sum.1,
        "balance": findings.balance.as_ref().map(|(_, balance)| balance::value(balance)),
        "sizes": spectrum.sizes.as_ref().map(|sizes| json!({
            "degree": sizes.degree.word(),
            "neighbours": sizes.neighbours,
            "radius": sizes.radius,
        })),
        "dimension": spectrum.dimension,
        "directions": directions,
        "neighbourhoods": {
            "spread": spectrum.spread,
            "mean_eps": spectrum.mean_eps,
            "min": spectrum.neighbours.min,
            "median": spectrum.neighbours.median,
            "max": spectrum.neighbours.max,
            "starved": spectrum.starved,
        },
        "residual_ratio": spectrum.residual_ratio,
        "embedding": findings.embedded.as_ref().map(|embedded| embedded.json()),
        "diverging_neighbours": findings.divergence.as_ref().map(opinion::divergence_json),
        "surrogates": findings.surrogates.as_ref().map(opinion::surrogates_json),
        "warnings": warnings(findings, source),
        "notes": notes(findings, source),
    });
    Ok(format!("{}\n", serde_json::to_string_pretty(&document)?))
}
