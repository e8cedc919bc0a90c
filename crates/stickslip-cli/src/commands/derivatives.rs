//! Derivatives of an orbit, as tables.

use stickslip::analysis::EventDerivatives;
use stickslip::dynamics::Matrix;
use stickslip_model::file::System;
use stickslip_model::study::{DerivativeError, Variables};

use super::arguments::PreparedRun;
use super::recording::{Occurrence, Recording};
use crate::failure::{Failure, in_words};
use crate::render::{Report, Table};

/// The variables of `--derivatives`, separated by commas.
pub(super) fn variables(system: &System, list: &str) -> Result<Variables, Failure> {
    let names = list.split(',').map(str::trim);
    Variables::named(system, names)
        .map_err(|error| Failure::Usage(format!("--derivatives {list}: {error}")))
}

/// Computes the derivatives of a recorded run that begins at its start, and adds their tables:
/// derivatives.csv, with a row for each of steps.csv, and event_derivatives.csv.
pub(super) fn put(
    prepared: &PreparedRun,
    t_end: f64,
    variables: &Variables,
    recording: &Recording,
    report: &mut Report,
) -> Result<(), Failure> {
    let PreparedRun {
        system,
        options,
        t,
        x,
    } = prepared;
    let times = recording.steps.chunks_exact(1 + system.states());
    let times: Vec<f64> = times.map(|row| row[0]).collect();
    let found = variables.along(system, ((*t, x), t_end), (&times, &[]), options);
    let mut found = found.map_err(|error| match error {
        DerivativeError::Setting(error) => Failure::from(error),
        DerivativeError::Run(error) => Failure::from(error),
    })?;
    let is_transition = |at: &&Occurrence| matches!(at, Occurrence::Transition(_));
    let transitions: Vec<_> = recording.transitions.iter().filter(is_transition).collect();
    variables.fit(system, &mut found, transitions.iter().map(|at| at.t()));
    let of_states: Vec<String> = column_names(system, variables, "").collect();
    if !times.is_empty() {
        let rows = times.iter().copied().zip(&found.states);
        let table = Table::new().column("t", |(t, _): &(f64, &Matrix)| *t).many(
            "dx",
            of_states.clone(),
            |(_, of)| row_by_row(of),
        );
        report.table(table.csv("derivatives", rows)?);
    }
    let mut names: Vec<String> = variables
        .names
        .iter()
        .map(|by| format!("dt/d{by}"))
        .collect();
    names.extend(column_names(system, variables, "before_"));
    names.extend(column_names(system, variables, "after_"));
    type Row<'r> = (&'r Occurrence, &'r EventDerivatives);
    let table = Table::new()
        .column("t", |(at, _): &Row<'_>| at.t())
        .column("kind", |(at, _)| at.kind(system))
        .column("contact", |(at, _)| at.of(system))
        .many("derivatives", names, |(_, of)| {
            let parts = [of.t.clone(), row_by_row(&of.before), row_by_row(&of.after)];
            parts.concat()
        });
    let rows = transitions.into_iter().zip(&found.transitions);
    report.table(table.csv("event_derivatives", rows)?);
    if let Some(why) = &found.lost {
        let why = in_words(why, system);
        report.line("derivatives", format!("none from there on: {why}"));
        report.field("no_derivatives", why);
    }
    Ok(())
}

/// Names as `dx/dmu0`: for each state, all variables.
fn column_names<'n>(
    system: &'n System,
    variables: &'n Variables,
    prefix: &'n str,
) -> impl Iterator<Item = String> + 'n {
    let states = system.file.states.iter();
    states.flat_map(move |state| {
        let names = variables.names.iter();
        names.map(move |by| format!("{prefix}d{}/d{by}", state.name))
    })
}

fn row_by_row(of: &Matrix) -> Vec<f64> {
    of.transpose().as_slice().to_vec()
}
