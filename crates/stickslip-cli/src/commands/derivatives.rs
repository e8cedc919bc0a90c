//! Derivatives of an orbit, as tables.

use serde_json::{Map, json};
use stickslip::analysis::{EventDerivatives, OrbitDerivatives, PeriodicOrbit};
use stickslip::dynamics::{Matrix, OrbitEvent};
use stickslip::error::readable;
use stickslip::nalgebra::Complex;
use stickslip_model::file::System;
use stickslip_model::study::{DerivativeError, OrbitSlopes, OrbitVariables, Variables};

use super::arguments::PreparedRun;
use super::recording::{Recording, kind_of, source_of};
use crate::failure::{Failure, in_words};
use crate::render::{Report, Table, by_state};

/// The variables of `--derivatives`, separated by commas.
pub(super) fn variables(system: &System, list: &str) -> Result<Variables, Failure> {
    let names = list.split(',').map(str::trim);
    Variables::named(system, names)
        .map_err(|error| Failure::Usage(format!("--derivatives {list}: {error}")))
}

/// Adds the tables of the derivatives of a recorded run: derivatives.csv, with a row for each of
/// steps.csv, event_derivatives.csv and, if the file has a section, section_derivatives.csv.
pub(super) fn put(
    system: &System,
    (variables, found): (&Variables, &OrbitDerivatives),
    recording: &Recording,
    report: &mut Report,
) -> Result<(), Failure> {
    let events = recording.orbit.events.iter();
    let transitions = events.filter(|at| at.transition().is_some());
    let times = recording.orbit.points().map(|(t, _)| t);
    let of_states: Vec<String> = column_names(system, variables, "").collect();
    if recording.orbit.point_count() > 0 {
        let rows = times.zip(&found.states);
        let table = Table::new().column("t", |(t, _): &(f64, &Matrix)| *t).many(
            "dx",
            of_states.clone(),
            |(_, of)| row_by_row(of),
        );
        report.table(table.csv("derivatives", rows)?);
    }
    let of_times = variables.names.iter().map(|by| format!("dt/d{by}"));
    let of_times: Vec<String> = of_times.collect();
    if !system.sections().is_empty() {
        // A passage does not change the state.
        let names = [of_times.clone(), of_states].concat();
        let table = Table::new()
            .column("t", |(_, of): &&(usize, EventDerivatives)| of.at)
            .many("derivatives", names, |(_, of)| {
                [of.t.clone(), row_by_row(&of.before)].concat()
            });
        report.table(table.csv("section_derivatives", found.passages.iter())?);
    }
    let mut names = of_times;
    names.extend(column_names(system, variables, "before_"));
    names.extend(column_names(system, variables, "after_"));
    type Row<'r> = (&'r OrbitEvent, &'r EventDerivatives);
    let table = Table::new()
        .column("t", |(at, _): &Row<'_>| at.t())
        .column("kind", |(at, _)| kind_of(system, at))
        .column("contact", |(at, _)| source_of(system, at))
        .many("derivatives", names, |(_, of)| {
            let parts = [of.t.clone(), row_by_row(&of.before), row_by_row(&of.after)];
            parts.concat()
        });
    let rows = transitions.zip(&found.transitions);
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

fn failure(error: DerivativeError) -> Failure {
    match error {
        DerivativeError::Setting(error) => error.into(),
        DerivativeError::Run(error) => error.into(),
        error => Failure::Usage(format!("--derivatives: {error}")),
    }
}

/// The parameters of `--derivatives` of a periodic orbit, separated by commas.
pub(super) fn orbit_variables(system: &System, list: &str) -> Result<OrbitVariables, Failure> {
    let names = list.split(',').map(str::trim);
    OrbitVariables::named(system, names)
        .map_err(|error| Failure::Usage(format!("--derivatives {list}: {error}")))
}

/// Adds the derivatives of a periodic orbit: lines, fields, and orbit_derivatives.csv with a row
/// for each quantity.
pub(super) fn put_of_orbit(
    prepared: &PreparedRun,
    orbit: &PeriodicOrbit,
    by: &OrbitVariables,
    report: &mut Report,
) -> Result<(), Failure> {
    let PreparedRun {
        system, options, t, ..
    } = prepared;
    let found = by.of_orbit(system, (orbit, *t), options);
    let found = found.map_err(failure)?;
    let rows = rows(system, &found);
    let lines = rows.iter().map(|(what, slopes)| {
        let slopes = found.names.iter().zip(slopes);
        let words = slopes.map(|(name, slope)| format!("by {name} {}", readable(*slope)));
        format!("{what}: {}", words.collect::<Vec<_>>().join(", "))
    });
    report.lines("derivatives", lines);
    let why = found.missing.iter().flatten().map(ToString::to_string);
    let why: Vec<String> = why.collect();
    report.lines(
        "",
        why.iter().map(|why| format!("none of multipliers: {why}")),
    );
    let extremes = found.orbit.extremes.iter();
    let extremes: Vec<[&Vec<f64>; 2]> = extremes
        .map(|pair| pair.each_ref().map(|one| &one.by))
        .collect();
    let state = |state: usize| {
        found
            .orbit
            .x
            .row(state)
            .iter()
            .copied()
            .collect::<Vec<f64>>()
    };
    let x: Vec<Vec<f64>> = (0..system.states()).map(state).collect();
    let of_one = |slopes: &Vec<Complex<f64>>| {
        let pairs = slopes.iter().map(|slope| [slope.re, slope.im]);
        json!(pairs.collect::<Vec<_>>())
    };
    let multipliers = found.names.iter().zip(&found.multipliers);
    let multipliers = multipliers.map(|(name, slopes)| (name.clone(), of_one(slopes)));
    report.field(
        "derivatives",
        json!({
            "by": found.names,
            "period": found.orbit.period,
            "x": by_state(system, &x),
            "extremes": by_state(system, &extremes),
            "multipliers": multipliers.collect::<Map<_, _>>(),
        }),
    );
    report.field("no_derivatives", why);
    let names = found.names.iter().map(|name| format!("d/d{name}"));
    type Row = (String, Vec<f64>);
    let table = Table::new()
        .column("of", |(what, _): &&Row| what.clone())
        .many("derivatives", names.collect(), |(_, slopes)| slopes.clone());
    report.table(table.csv("orbit_derivatives", &rows)?);
    Ok(())
}

/// Rows of each differentiated quantity and its derivatives.
fn rows(system: &System, found: &OrbitSlopes) -> Vec<(String, Vec<f64>)> {
    let mut rows = vec![("period".to_owned(), found.orbit.period.clone())];
    let states = system.file.states.iter().enumerate();
    for (k, state) in states.clone() {
        let slopes = found.orbit.x.row(k);
        rows.push((state.name.clone(), slopes.iter().copied().collect()));
    }
    for ((_, state), pair) in states.zip(&found.orbit.extremes) {
        for (what, one) in ["min", "max"].into_iter().zip(pair) {
            rows.push((format!("{what} {}", state.name), one.by.clone()));
        }
    }
    let count = found.multipliers.first().map_or(0, Vec::len);
    for k in 0..count {
        type Part = fn(&Complex<f64>) -> f64;
        let parts: [(&str, Part); 2] = [("re", |one| one.re), ("im", |one| one.im)];
        for (what, part) in parts {
            let slopes = found.multipliers.iter().map(|of| part(&of[k]));
            rows.push((format!("{what} multiplier {}", k + 1), slopes.collect()));
        }
    }
    rows
}
