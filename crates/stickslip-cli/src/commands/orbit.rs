//! `stickslip orbit`: a periodic orbit.

use super::arguments::{PreparedRun, RunArguments};
use super::attractors::family_words;
use super::derivatives;
use super::recording::{Recording, Wanted};
use super::search::SearchArguments;
use super::trajectory;
use crate::failure::Failure;
use crate::render::{CommandOutput, Report, Table, by_state, complex_within, explained, place};
use stickslip::analysis::{Stability, multipliers};
use stickslip::error::readable;
use stickslip::math::modulus;
use stickslip_model::study::{extremes, phases_of_period};

/// Find the periodic orbit that a run approaches, by shooting
///
/// The result has its period, multipliers and sequence of phases. With a drive, the period is a
/// multiple of the period in the file. Writes orbit.csv, multipliers.csv, phases.csv,
/// transitions.csv, portrait.svg and history.svg of one period.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Also report the derivatives of period, state, extremes and multipliers by these parameters:
    /// orbit_derivatives.csv
    #[arg(long, value_name = "NAME,...")]
    derivatives: Option<String>,
    #[command(flatten)]
    search: SearchArguments,
    #[command(flatten)]
    run: RunArguments,
}

pub(super) fn run(arguments: &Arguments) -> Result<CommandOutput, Failure> {
    arguments
        .run
        .with_report(|prepared| report(prepared, arguments))
}

fn report(prepared: &PreparedRun, arguments: &Arguments) -> Result<Report, Failure> {
    let PreparedRun {
        system, options, ..
    } = prepared;
    let search = &arguments.search;
    // A wrong name is told before the search.
    let by = arguments.derivatives.as_ref();
    let by = by
        .map(|list| derivatives::orbit_variables(system, list))
        .transpose()?;
    let (orbit, periods) = search.periodic_orbit(system, (prepared.t, &prepared.x), options)?;
    let (x, t_end) = (orbit.x.as_slice(), orbit.t + orbit.period);
    let wanted = Wanted {
        figures: true,
        steps: false,
        progress: true,
    };
    let (start, quantities) = ((orbit.t, x), system.quantities(&[])?);
    let (recording, outcome) = Recording::of(
        system,
        start,
        t_end,
        options,
        wanted,
        (None, None),
        quantities,
    );
    outcome?;
    let (extremes, _) = extremes(system.dynamics(), (orbit.t, x), t_end, options)?;

    let mut report = Report::of(system, "periodic orbit");
    let drive = match periods {
        Some(1) => "  (1 period of the drive)".to_owned(),
        Some(count) => format!("  ({count} periods of the drive)"),
        None => String::new(),
    };
    report
        .line("period", format!("{}{drive}", readable(orbit.period)))
        .field("period", orbit.period)
        .field("periods_of_drive", periods)
        .line("residual", format!("{:.1e}", orbit.residual))
        .field("residual", orbit.residual)
        .field("t", orbit.t)
        .field("x", by_state(system, x))
        .field("doubtful", &recording.doubtful)
        .lines("doubtful", recording.doubtful.clone());

    // The first multiplier of an autonomous system is trivial.
    let trivial = usize::from(periods.is_none());
    let multipliers = multipliers(&orbit.monodromy);
    let (dynamics, is_forced) = (system.dynamics(), periods.is_some());
    let uncertainties = orbit.multiplier_uncertainties(dynamics, is_forced, options);
    let with_uncertainties = multipliers.iter().zip(&uncertainties).enumerate();
    let lines = with_uncertainties.map(|(k, (multiplier, &uncertainty))| {
        let note = if k < trivial {
            "  (the trivial one)"
        } else {
            ""
        };
        if multiplier.im == 0.0 {
            return format!("{}{note}", place(multiplier.re, uncertainty));
        }
        format!(
            "{}{note}",
            complex_within([multiplier.re, multiplier.im], uncertainty)
        )
    });
    let pairs: Vec<[f64; 2]> = multipliers.iter().map(|m| [m.re, m.im]).collect();
    let stability = Stability::of(multipliers.get(trivial..).unwrap_or_default()).to_string();
    report
        .lines("multipliers", lines)
        .field("multipliers", pairs)
        .field("multiplier_uncertainties", &uncertainties)
        .line("stability", &stability)
        .field("stability", stability)
        .field("family_dimension", orbit.family);
    if orbit.family > 0 {
        report.line("family", family_words(orbit.family));
    }

    let (modes, stick) = phases_of_period(&**system.dynamics(), &recording.orbit.phases);
    let percent = 100.0 * stick / orbit.period;
    if let Some(phases) = explained(system, &modes) {
        report.line("phases", phases);
    }
    if system.contacts() > 0 {
        report.line(
            "stick",
            format!("{} of the period, {percent:.1} %", readable(stick)),
        );
    }
    report
        .field("phases", system.sequence(&modes))
        .field("stick_time", stick)
        .field("extremes", by_state(system, &extremes));
    let states = system.file.states.iter().zip(&extremes).zip(x);
    for ((state, (low, high)), x) in states {
        let [low, high, x] = [low, high, x].map(|&x| readable(x));
        report.line(&state.name, format!("from {low} to {high}, at first {x}"));
    }

    let table = Table::new()
        .column("period", |()| orbit.period)
        .column("residual", |()| orbit.residual)
        .column("t", |()| orbit.t)
        .state(system, "", |()| orbit.x.clone());
    report.table(table.csv("orbit", [()])?);
    let table = Table::new()
        .column("re", |&k: &usize| multipliers[k].re)
        .column("im", |&k| multipliers[k].im)
        .column("modulus", |&k| modulus(multipliers[k]))
        .column("uncertainty", |&k| uncertainties[k]);
    report.table(table.csv("multipliers", 0..multipliers.len())?);
    if let Some(by) = by {
        derivatives::put_of_orbit(prepared, &orbit, &by, &mut report)?;
    }
    trajectory::put(system, &recording, &mut report)?;
    Ok(report)
}
