//! `stickslip lyapunov`: the spectrum of Lyapunov exponents.

use std::fmt::Write;

use plot::*;
use serde_json::json;
use stickslip::analysis::{Exponent, SpectrumOptions};

use super::arguments::{Ready, RunArguments};
use super::{Failure, Found, figures, tables};
use crate::output::{Artifact, OutputError, csv_table};
use crate::terminal::{Said, patiently};
use stickslip_kernels::file::System;
use stickslip_kernels::kernel::SpectrumFound;

/// Lyapunov exponents of an orbit, from the equations, through slips, sticks and crossings
///
/// Writes exponents.csv, convergence.csv and convergence.svg.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Time before measuring
    #[arg(long, value_name = "TIME", default_value_t = 200.0)]
    transient: f64,
    /// Time measured. Exponents are told with four standard errors, and no digits beyond what a
    /// direction shows in that time that grows without a rate
    #[arg(long, value_name = "TIME", default_value_t = 2000.0)]
    duration: f64,
    #[command(flatten)]
    run: RunArguments,
}

pub(super) fn run(arguments: &Arguments) -> Result<Said, Failure> {
    let over = SpectrumOptions::over(arguments.transient, arguments.duration);
    arguments
        .run
        .answered(|ready| found(ready, &over.solver(ready.options)))
}

fn found(ready: &Ready, settings: &SpectrumOptions) -> Result<Found, Failure> {
    let system = &ready.system;
    let spectrum = patiently("measuring the spectrum", |_| {
        system.kernel().spectrum(ready.t, &ready.x, settings)
    })?;
    Ok(Found {
        summary: summary(system, &spectrum),
        json: json(system, &spectrum),
        tables: csv(&spectrum)?,
        figures: vec![("convergence".to_owned(), figure(system, &spectrum)?)],
        failure: None,
    })
}

fn summary(system: &System, spectrum: &SpectrumFound) -> String {
    let mut text = format!(
        "{}: Lyapunov exponents, measured for {} time units\n",
        system.file.name, spectrum.duration
    );
    for (k, exponent) in spectrum.exponents.iter().enumerate() {
        let number = k + 1;
        // Writing into a text cannot fail.
        let _ = match *exponent {
            Exponent::Finite { value, .. } => {
                let uncertainty = exponent.uncertainty(spectrum.duration);
                let value = tables::within(value, uncertainty);
                writeln!(text, "  λ{number}           {value}")
            }
            Exponent::Annihilated => writeln!(
                text,
                "  λ{number}           -∞ (stick takes the direction to zero)"
            ),
        };
    }
    let _ = writeln!(
        text,
        "  defect       {:.1e}  (against the rate of volumes)",
        // Of either sign, and zero has none.
        spectrum.defect.abs()
    );
    let _ = writeln!(
        text,
        "  stick        {} entries, {:.1} % of the time",
        spectrum.stick_entries,
        100.0 * spectrum.stick_fraction
    );
    text
}

fn json(system: &System, spectrum: &SpectrumFound) -> serde_json::Value {
    let exponents = spectrum.exponents.iter().map(|exponent| match *exponent {
        Exponent::Finite { value, std_error } => {
            let uncertainty = exponent.uncertainty(spectrum.duration);
            json!({ "value": value, "std_error": std_error, "uncertainty": uncertainty })
        }
        // JSON has no infinity.
        Exponent::Annihilated => json!({ "value": null, "annihilated": true }),
    });
    let exponents: Vec<serde_json::Value> = exponents.collect();
    json!({
        "system": tables::system_json(system),
        "exponents": exponents,
        "defect": spectrum.defect,
        "stick_entries": spectrum.stick_entries,
        "stick_fraction": spectrum.stick_fraction,
        "duration": spectrum.duration,
    })
}

fn csv(spectrum: &SpectrumFound) -> Result<Vec<Artifact>, OutputError> {
    let heading = ["number", "exponent", "std_error"].map(str::to_owned);
    let rows = spectrum.exponents.iter().enumerate().map(|(k, exponent)| {
        let std_error = exponent.std_error().map_or_else(String::new, tables::exact);
        vec![
            (k + 1).to_string(),
            tables::exact(exponent.value()),
            std_error,
        ]
    });
    let exponents = csv_table("exponents.csv", &heading, rows)?;
    let numbers = 1..=spectrum.exponents.len();
    let heading: Vec<String> = std::iter::once("elapsed".to_owned())
        .chain(numbers.map(|k| format!("lambda{k}")))
        .collect();
    let rows = spectrum.convergence.iter().map(|(elapsed, exponents)| {
        let values = std::iter::once(elapsed).chain(exponents);
        values.map(|&value| tables::exact(value)).collect()
    });
    Ok(vec![
        exponents,
        csv_table("convergence.csv", &heading, rows)?,
    ])
}

fn figure(system: &System, spectrum: &SpectrumFound) -> Result<String, OutputError> {
    let running = &spectrum.convergence;
    let end = running
        .last()
        .map_or(spectrum.duration, |(elapsed, _)| *elapsed);
    // The beginning swings far out; what is looked at is where the exponents go.
    let settled = running.iter().filter(|(elapsed, _)| *elapsed >= 0.05 * end);
    let values = settled.flat_map(|(_, exponents)| exponents.iter().copied());
    let unit = system.file.time.unit.as_deref().unwrap_or_default();
    let label = if unit.is_empty() {
        "*λ*".to_owned()
    } else {
        format!("*λ*, 1/{unit}")
    };
    let mut panel = Panel::new(
        Axis::new(
            &format!(
                "time measured{}",
                if unit.is_empty() {
                    String::new()
                } else {
                    format!(", {unit}")
                }
            ),
            0.0,
            end,
        ),
        figures::axis(&label, values.chain([0.0])),
    )
    .legend(Legend::Below);
    panel.add(Guide::horizontal(0.0));
    let colours = [BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, BLACK, GREY];
    for (k, exponent) in spectrum.exponents.iter().enumerate() {
        let curve = running
            .iter()
            .map(|(elapsed, exponents)| (*elapsed, exponents[k]));
        let name = match exponent {
            Exponent::Finite { .. } => format!("*λ*_{}", k + 1),
            Exponent::Annihilated => format!("*λ*_{} = −∞", k + 1),
        };
        panel.add(
            Curve::new(curve)
                .color(colours[k % colours.len()])
                .legend(&name),
        );
    }
    let title = format!("{}: Lyapunov exponents", system.file.name);
    let description = format!(
        "The running means of {} Lyapunov exponents against the time measured, {end}.",
        spectrum.exponents.len()
    );
    let figure = Figure::new("convergence", (640.0, 400.0), &title, &description).row(1.0, panel);
    Ok(figure.render()?)
}
