//! `stickslip lyapunov`: the spectrum of Lyapunov exponents.

use plot::*;
use serde_json::json;
use stickslip::analysis::{Exponent, Running, Spectrum, SpectrumOptions, lyapunov_spectrum};
use stickslip::error::readable;

use super::arguments::{PreparedRun, RunArguments, time_or};
use super::figures;
use crate::failure::{Failure, in_words};
use crate::render::{CommandOutput, Report, Table, within};
use output::terminal::with_spinner;
use stickslip_model::file::System;

/// Lyapunov exponents of an orbit, from the equations, through slips, sticks and crossings
///
/// Writes exponents.csv, convergence.csv and convergence.svg.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Transient before the measurement; default 200, or 1000 periods of a drive with a period
    /// below 0.2
    #[arg(long, value_name = "TIME")]
    transient: Option<f64>,
    /// Duration of the measurement; default 2000, or 10000 periods of a drive with a period below
    /// 0.2
    ///
    /// Exponents are printed ± four standard errors, or ± ln 30 over this time, ± the effect of
    /// rounding on the directions, or for m equal exponents ± (m - 1) ln 30 over this time,
    /// whichever is largest.
    #[arg(long, value_name = "TIME")]
    duration: Option<f64>,
    #[command(flatten)]
    run: RunArguments,
}

pub(super) fn run(arguments: &Arguments) -> Result<CommandOutput, Failure> {
    arguments.run.with_report(|prepared| {
        let transient = time_or(arguments.transient, 200.0, &prepared.system);
        let duration = time_or(arguments.duration, 2000.0, &prepared.system);
        let over = SpectrumOptions::over(transient, duration);
        report(prepared, &over.solver(prepared.options))
    })
}

fn report(prepared: &PreparedRun, settings: &SpectrumOptions) -> Result<Report, Failure> {
    let system = &prepared.system;
    let spectrum = with_spinner("measuring the spectrum", |_| {
        lyapunov_spectrum(
            system.dynamics(),
            (prepared.t, prepared.x.as_slice()),
            settings,
        )
    })?;
    let duration = spectrum.duration;
    let time = readable(duration);
    let what = format!("Lyapunov exponents, measured for {time} time units");
    let mut report = Report::of(system, what);
    let mut exponents = Vec::new();
    let rows = || spectrum.exponents.iter().zip(&spectrum.uncertainties);
    for (k, (exponent, &uncertainty)) in (1..).zip(rows()) {
        let (words, json) = match *exponent {
            Exponent::Finite { value, std_error } => (
                within(value, uncertainty),
                json!({ "value": value, "std_error": std_error, "uncertainty": uncertainty }),
            ),
            // JSON has no infinity.
            Exponent::Annihilated => (
                annihilated(system, system.states() - k),
                json!({ "value": null, "annihilated": true }),
            ),
        };
        report.line(&format!("λ{k}"), words);
        exponents.push(json);
    }
    let ended = spectrum.ended.as_ref();
    let ended = ended.map(|error| in_words(error, system));
    if let Some(error) = &ended {
        let wanted = readable(settings.duration);
        report.line("ended", format!("after {time} of {wanted}: {error}"));
    }
    report.field("ended", &ended).failure(ended);
    // The defect may have either sign; zero is printed without one.
    let defect = spectrum.defect();
    let entries = spectrum.stick_entries;
    let percent = 100.0 * spectrum.stick_fraction;
    report
        .field("exponents", exponents)
        .field("duration", duration)
        .line(
            "defect",
            format!("{:.1e}  (against the rate of volumes)", defect.abs()),
        )
        .field("defect", defect);
    if system.contacts() > 0 {
        report.line(
            "stick",
            format!("{entries} entries, {percent:.1} % of the time"),
        );
    }
    report
        .field("stick_entries", entries)
        .field("stick_fraction", spectrum.stick_fraction);

    let table = Table::new()
        .column("number", |&(k, _): &(usize, (&Exponent, &f64))| k)
        .column("exponent", |(_, row)| row.0.value())
        .column("std_error", |(_, row)| row.0.std_error())
        .column("uncertainty", |(_, row)| row.0.std_error().map(|_| *row.1));
    report.table(table.csv("exponents", (1..).zip(rows()))?);
    let numbers = (1..=spectrum.exponents.len()).map(|k| format!("lambda{k}"));
    let table = Table::new()
        .column("elapsed", |at: &&Running| at.elapsed)
        .many("lambda", numbers.collect(), |at| at.exponents.clone());
    report.table(table.csv("convergence", &spectrum.convergence)?);
    report.figure("convergence", &figure(system, &spectrum));
    Ok(report)
}

/// Cause of an exponent that is not finite, with so many others after it. The last ones are those
/// of discrete states.
fn annihilated(system: &System, after: usize) -> String {
    let discrete = &system.built.switching.discrete;
    if after < discrete.iter().filter(|is_discrete| **is_discrete).count() {
        return "-∞ (discrete states take isolated values: no orbit lies a little beside)"
            .to_owned();
    }
    let has_jump = system.file.jumps.iter().any(|jump| jump.of_stop.is_none());
    let causes = [
        (system.contacts() > 0, "stick"),
        (has_jump, "a jump"),
        (!system.file.stops.is_empty(), "rest on a stop"),
    ];
    let causes: Vec<&str> = causes
        .iter()
        .filter_map(|(is, cause)| is.then_some(*cause))
        .collect();
    format!("-∞ ({} annihilates the direction)", causes.join(" or "))
}

fn figure(system: &System, spectrum: &Spectrum) -> Figure {
    let running = &spectrum.convergence;
    let end = running.last().map_or(spectrum.duration, |at| at.elapsed);
    // The first values vary widely, so the axis is chosen from the later ones.
    let settled = running.iter().filter(|at| at.elapsed >= 0.05 * end);
    let values = settled.flat_map(|at| at.exponents.iter().copied());
    let mut panel = Panel::new(
        Axis::new(&figures::in_time(system, "time measured", ""), 0.0, end),
        figures::axis(
            &figures::in_time(system, "*λ*", "^{−1}"),
            values.chain([0.0]),
        ),
    )
    .legend(Legend::Below);
    panel.add(Guide::horizontal(0.0));
    let colours = [BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, BLACK, GREY];
    for (k, exponent) in spectrum.exponents.iter().enumerate() {
        let curve = running.iter().map(|at| (at.elapsed, at.exponents[k]));
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
    Figure::new("convergence", (640.0, 400.0), &title, &description).row(1.0, panel)
}
