//! `stickslip fit`: parameters and starts from measured motion.

mod figure;
mod request;

use serde_json::{Map, Value, json};
use stickslip::Mode;
use stickslip::dynamics::Modes;
use stickslip::error::readable;
use stickslip_model::file::System;
use stickslip_model::study::fit::{
    Fit, FitError, FittedColumn, FittedValue, SeenModes, SeenPhase, ending, fit,
};
use stickslip_model::study::least_squares::LeastSquaresEnd;

use super::arguments::{PreparedRun, RunArguments, count};
use crate::failure::{Failure, in_words};
use crate::render::{CommandOutput, Report, Table, within};
use output::terminal::{note, with_spinner};
use request::Wanted;
use std::num::NonZeroUsize;

/// Fit parameters, start values and offsets to measured motion
///
/// A search by least squares on exact derivatives, through slips, sticks, crossings and jumps. It
/// begins with the values of the file, of --set and of --start.
///
/// Writes parameters.csv, correlations.csv, phases.csv (those that the data show, beside those at
/// the fit), fit.csv (data, model and residuals at each time) and fit.svg.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Fitted numbers: parameters, states for their start values, t0 for the time of the start
    #[arg(long, value_name = "NAME,...", required = true)]
    fit: String,
    /// Quantity that a column of the data measures; can be repeated
    ///
    /// A formula of states, inputs, parameters and t, with the name of the column in front where
    /// it is not the formula itself, as in force=k*z. With one contact, NAME.force is its friction.
    #[arg(long, value_name = "COLUMN=FORMULA", required = true)]
    observe: Vec<String>,
    /// Standard deviation of the noise of a column, or of all; estimated where it is not given
    #[arg(long, value_name = "COLUMN=SIGMA")]
    sigma: Vec<String>,
    /// Bounds of a value that is fitted, within the range in the file; can be repeated
    ///
    /// An end may be left out for none. LOW..HIGH is the same.
    #[arg(long, value_name = "NAME=LOW:HIGH")]
    bounds: Vec<String>,
    /// A parameter that only formulas of --observe have, as an offset, and its value
    #[arg(long, value_name = "NAME=VALUE")]
    extra: Vec<String>,
    /// Fitted parameters that each record has for itself, as starts always are
    #[arg(long, value_name = "NAME,...")]
    each: Option<String>,
    /// A parameter of one record, by the number of its file: 2:speed=0.3; can be repeated
    #[arg(long, value_name = "RECORD:NAME=VALUE")]
    set_in: Vec<String>,
    /// The start value of a state in one record, by the number of its file; can be repeated
    #[arg(long, value_name = "RECORD:STATE=VALUE")]
    start_in: Vec<String>,
    /// The table of an input in one record, from a file: 2:u=drive.csv; can be repeated
    ///
    /// The first two columns are times and values, as in a table of the system's file.
    #[arg(long, value_name = "RECORD:INPUT=FILE")]
    input_in: Vec<String>,
    /// The column of times; default t or time, else the first
    #[arg(long, value_name = "COLUMN")]
    time: Option<String>,
    /// Weight of large residuals: squares, or soft-l1:SCALE or huber:SCALE, in standard deviations
    #[arg(long, value_name = "LOSS", default_value = "squares")]
    loss: String,
    /// Also begin at as many points within the bounds, and report all minima
    #[arg(long, value_name = "COUNT", default_value_t = 0)]
    search: usize,
    /// Parts of each record for multiple shooting, with which the search begins: for chaotic or
    /// long records, some periods each
    ///
    /// Each part needs two rows with a value. A part without a run ends the fit.
    #[arg(long, value_name = "COUNT", default_value_t = 0)]
    segments: usize,
    /// Most runs of all records from one start, in all stages of the search together
    #[arg(long, value_name = "COUNT", default_value = "500", value_parser = count)]
    most_runs: NonZeroUsize,
    #[command(flatten)]
    run: RunArguments,
    /// Records: tables with a column of times
    #[arg(value_name = "DATA", required = true)]
    data: Vec<String>,
}

pub(super) fn run(arguments: &Arguments) -> Result<CommandOutput, Failure> {
    let system = arguments.run.system()?;
    let options = arguments.run.solver.options(&system)?;
    let wanted = request::wanted(arguments, &system, options)?;
    wanted.notes.iter().for_each(|line| note(line));
    // States of the start may be what is fitted.
    let prepared = PreparedRun {
        t: system.built.t_start,
        x: Vec::new(),
        system,
        options,
    };
    let report = |prepared: &PreparedRun| {
        let found = with_spinner("fitting", |_| fit(&wanted.request));
        let found = found.map_err(|error| failure(error, &prepared.system))?;
        report(&prepared.system, &wanted, &found)
    };
    arguments.run.with_report_of(&prepared, report)
}

fn failure(error: FitError, system: &System) -> Failure {
    match error {
        FitError::Setting(error) => error.into(),
        FitError::File(error) => error.into(),
        FitError::Start { ref cause, .. }
        | FitError::NoDerivatives { ref cause, .. }
        | FitError::Part {
            cause: Some(ref cause),
            ..
        } => Failure::Fit(format!("{error}: {}", in_words(cause, system))),
        FitError::NoStart { .. }
        | FitError::Ends { .. }
        | FitError::Part { .. }
        | FitError::Interrupted => Failure::Fit(error.to_string()),
        error => Failure::Usage(error.to_string()),
    }
}

/// A value with its standard error, or why there is none.
fn value_in_words(one: &FittedValue) -> String {
    match (one.std_error, one.interval) {
        (Some(error), Some((low, high))) => {
            let shown = within(one.value, error);
            format!(
                "{shown}  (95 %: {} to {})",
                rounded(low, error),
                rounded(high, error)
            )
        }
        _ if one.is_at_bound => format!("{} (on its bound)", readable(one.value)),
        _ => format!("{} (no standard error)", readable(one.value)),
    }
}

/// A number to a tenth of an uncertainty.
fn rounded(value: f64, uncertainty: f64) -> String {
    let text = within(value, 0.1 * uncertainty);
    text.split(" ±").next().unwrap_or_default().to_owned()
}

/// Successive phases in letters. Equal ones, as before impacts that accumulate, are counted.
fn counted(system: &System, modes: &[Modes]) -> String {
    let runs = modes.chunk_by(|one, next| one == next).map(|run| {
        let letters = system.letters(&run[0]);
        match run.len() {
            1 => letters,
            count => format!("{letters} × {count}"),
        }
    });
    runs.collect::<Vec<_>>().join(" ")
}

fn report(system: &System, wanted: &Wanted, found: &Fit) -> Result<Report, Failure> {
    let request = &wanted.request;
    let values: usize = found.columns.iter().map(|column| column.count).sum();
    let what = format!(
        "{} values fitted to {values} measured ones",
        found.values.len()
    );
    let mut report = Report::of(system, what);
    for one in &found.values {
        report.line(&one.name, value_in_words(one));
    }
    let fitted = Table::new()
        .column("name", |one: &&FittedValue| one.name.clone())
        .column("value", |one| one.value)
        .column("std_error", |one| one.std_error)
        .column("low", |one| one.interval.map(|of| of.0))
        .column("high", |one| one.interval.map(|of| of.1))
        .column("start", |one| one.start)
        .column("lower_bound", |one| {
            Some(one.bounds.0).filter(|b| b.is_finite())
        })
        .column("upper_bound", |one| {
            Some(one.bounds.1).filter(|b| b.is_finite())
        });
    report.table(fitted.csv("parameters", &found.values)?);
    report.field("values", fitted.json(&found.values));
    uncertainties(&mut report, found)?;
    columns(&mut report, (system, wanted), found)?;
    let modes = found.phases.iter();
    let modes = modes.map(|phases| phases.iter().map(|phase| phase.2).collect());
    let modes: Vec<Vec<Modes>> = modes.collect();
    if system.contacts() + system.file.jumps.len() > 0 {
        let counted = modes.iter().map(|modes| counted(system, modes));
        report.lines("phases", counted);
    }
    let sequences = modes.iter().map(|modes| system.sequence(modes));
    report.field("phases", sequences.collect::<Vec<_>>());
    seen(&mut report, (system, wanted), found)?;
    let others = found.others.iter().map(|other| {
        let pairs = found.values.iter().zip(&other.values);
        let values = pairs.map(|(one, &value)| {
            let end = if one.is_bound(value) {
                " (on its bound)"
            } else {
                ""
            };
            format!("{} = {}{end}", one.name, readable(value))
        });
        let words: Vec<String> = values.collect();
        let line = format!("{}, cost {:.4e}", words.join(", "), other.cost);
        (line, json!({ "values": other.values, "cost": other.cost }))
    });
    report.list("other minima", others);
    let work = format!(
        "{}: {} steps, {} runs, {} of which failed",
        ending(found.end),
        found.steps,
        found.evaluations,
        found.failures
    );
    report.line("search", work);
    if found.crossings + found.jumps > 0 {
        let roots = match found.grazes {
            None => "; grazing impacts are not looked for in parts".to_owned(),
            Some(0) => String::new(),
            Some(grazes) => {
                format!("; grazing impacts, at which they have a square root: {grazes}")
            }
        };
        let words = format!(
            "the sequence of phases changed in {} steps; the residuals jumped at {} changes{roots}",
            found.crossings, found.jumps
        );
        report.line("", words);
    }
    report.fields(json!({
        "cost": found.cost,
        "freedom": found.freedom,
        "end": format!("{:?}", found.end).to_lowercase(),
        "steps": found.steps,
        "runs": found.evaluations,
        "failures": found.failures,
        "crossings": found.crossings,
        "jumps": found.jumps,
        "grazes": found.grazes,
    }));
    if let Some(mismatch) = found.mismatch {
        let words = format!(
            "{} parts, as no single orbit follows the record; mismatch {mismatch:.0e} of the \
             spread",
            request.segments
        );
        report.line("shooting", words);
    }
    report.field("mismatch", found.mismatch);
    for (number, record) in request.records.iter().enumerate() {
        let name = match request.records.len() {
            1 => "fit".to_owned(),
            _ => format!("fit_{}", number + 1),
        };
        let of_record = found
            .columns
            .iter()
            .filter(|column| column.record == number);
        let of_record: Vec<&FittedColumn> = of_record.collect();
        let names = request
            .observables
            .iter()
            .flat_map(|one| ["", "_fit", "_residual"].map(|what| format!("{}{what}", one.name)));
        let table = Table::new()
            .column("t", |&row: &usize| record.times[row])
            .many("columns", names.collect(), |&row| {
                let cells = of_record.iter().enumerate().flat_map(|(k, column)| {
                    [
                        record.columns[k][row],
                        column.model[row],
                        column.residuals[row],
                    ]
                });
                cells.collect::<Vec<f64>>()
            });
        report.table(table.csv(&name, 0..record.times.len())?);
        let figure = figure::figure(system, wanted, found, number, &name);
        report.figure(&name, &figure);
    }
    let failure = match found.end {
        LeastSquaresEnd::NotFinite => Some(
            "the run has no derivatives where the search begins: begin elsewhere, by --set or \
             --start"
                .to_owned(),
        ),
        LeastSquaresEnd::Evaluations => Some(format!(
            "no minimum was found in {} runs: begin nearer to it, give bounds, or allow more with \
             --most-runs",
            found.evaluations
        )),
        _ => None,
    };
    report.field("error", &failure).failure(failure);
    Ok(report)
}

fn uncertainties(report: &mut Report, found: &Fit) -> Result<(), Failure> {
    /// A correlation that is told of: the errors of one are those of the other.
    const STRONG: f64 = 0.95;
    let names: Vec<&str> = found.values.iter().map(|one| &*one.name).collect();
    let uncertainty = &found.uncertainty;
    let correlations = uncertainty.correlations();
    let undetermined = uncertainty.undetermined.iter().map(|direction| {
        let parts = direction
            .iter()
            .map(|(name, part)| format!("{name} by {part:+.3}"));
        let parts: Vec<String> = parts.collect();
        let words = format!(
            "the data stay with relative changes of {}",
            parts.join(", ")
        );
        let parts = direction
            .iter()
            .map(|(name, part)| (name.clone(), json!(part)));
        (words, json!(parts.collect::<Map<_, _>>()))
    });
    report.list("undetermined", undetermined);
    if let Some(why) = &uncertainty.none {
        report.line("errors", format!("none: {why}"));
    } else if let Some(bend) = uncertainty.bend.filter(|_| uncertainty.is_doubtful()) {
        let percent = 100.0 * bend;
        report.line(
            "errors",
            format!(
                "doubtful: within one of them the model departs from a linear one by {percent:.0} %"
            ),
        );
    }
    report
        .field("no_errors", &uncertainty.none)
        .field("bend", uncertainty.bend);
    let pairs = (0..names.len()).flat_map(|i| (0..i).map(move |k| (k, i)));
    let strong = pairs.filter(|&(k, i)| correlations[(k, i)].abs() > STRONG);
    let strong = strong.map(|(k, i)| {
        let correlation = correlations[(k, i)];
        format!("{} and {}: {correlation:+.3}", names[k], names[i])
    });
    report.lines("correlated", strong.collect::<Vec<_>>());
    let all: Vec<Vec<Option<f64>>> = (0..names.len())
        .map(|i| {
            let row = (0..names.len()).map(|k| Some(correlations[(i, k)]));
            row.map(|value| value.filter(|value| value.is_finite()))
                .collect()
        })
        .collect();
    report.field("correlations", &all);
    let columns = names.iter().map(|name| (*name).to_owned()).collect();
    let table = Table::new()
        .column("name", |&i: &usize| names[i])
        .many("with", columns, |&i| {
            let row = (0..names.len()).map(|k| correlations[(i, k)]);
            row.collect::<Vec<f64>>()
        });
    report.table(table.csv("correlations", 0..names.len())?);
    Ok(())
}

/// Adds the phases that the data show beside those at the fit.
fn seen(
    report: &mut Report,
    (system, wanted): (&System, &Wanted),
    found: &Fit,
) -> Result<(), Failure> {
    let request = &wanted.request;
    let letter = |mode: Mode| Modes::from(mode).to_string();
    let letters = |phases: &[SeenPhase]| {
        let letters = phases.iter().map(|phase| letter(phase.2));
        letters.collect::<Vec<_>>().join(" ")
    };
    let told = |one: &SeenModes| {
        let contact = system.contact_name(one.contact);
        let column = &request.observables[one.observable].name;
        let of = match request.records.len() {
            1 => String::new(),
            _ => format!(" of {}", request.records[one.record].name),
        };
        let [data, fit] = one.sticks();
        let compared = match one.is_same() {
            true => format!("as at the fit, {data} sticks: {}", letters(&one.data)),
            false => format!(
                "another sequence: sticks in the data {data}, at the fit {fit}: {} and {}",
                letters(&one.data),
                letters(&one.fit)
            ),
        };
        let list = |phases: &[SeenPhase]| {
            let phases = phases.iter();
            let phases = phases.map(|(from, to, mode)| json!([from, to, letter(*mode)]));
            phases.collect::<Vec<Value>>()
        };
        let json = json!({
            "record": one.record + 1,
            "contact": contact,
            "column": column,
            "sigma": one.sigma,
            "same": one.is_same(),
            "data": list(&one.data),
            "fit": list(&one.fit),
        });
        (format!("{contact} from {column}{of}: {compared}"), json)
    };
    report.list("seen", found.seen.iter().map(told));
    if found.seen.is_empty() && system.contacts() > 0 {
        let why = "no phases: no column is the slip or the way of a contact, or its noise hides it";
        report.line("seen", why);
    }
    let rows = found.seen.iter().flat_map(|one| {
        let rows = |what: &'static str, phases: &[SeenPhase]| {
            let rows = phases.iter().map(move |phase| (one, what, *phase));
            rows.collect::<Vec<_>>()
        };
        [rows("data", &one.data), rows("fit", &one.fit)].concat()
    });
    type Row<'a> = (&'a SeenModes, &'static str, SeenPhase);
    let table = Table::new()
        .column("record", |row: &Row<'_>| row.0.record + 1)
        .column("contact", |row| system.contact_name(row.0.contact))
        .column("column", |row| {
            request.observables[row.0.observable].name.clone()
        })
        .column("of", |row| row.1)
        .column("from", |row| row.2.0)
        .column("to", |row| row.2.1)
        .column("mode", |row| letter(row.2.2));
    report.table(table.csv("phases", rows)?);
    Ok(())
}

/// Adds the residuals of each column, and what their order says.
fn columns(
    report: &mut Report,
    (system, wanted): (&System, &Wanted),
    found: &Fit,
) -> Result<(), Failure> {
    let request = &wanted.request;
    let name = |column: &FittedColumn| {
        let observable = &request.observables[column.observable].name;
        match request.records.len() {
            1 => observable.clone(),
            _ => format!("{observable} of {}", request.records[column.record].name),
        }
    };
    let lines = found.columns.iter().map(|column| {
        let kind = match request.observables[column.observable].sigma {
            Some(sigma) => format!("of a noise of {}", readable(sigma)),
            None => "from which the noise is estimated".to_owned(),
        };
        let order = match column.runs {
            None => String::new(),
            Some(runs) if runs.is_systematic() => format!(
                "; a systematic remainder: {} runs of one sign where noise has {:.0} (p = {:.0e})",
                runs.runs, runs.expected, runs.p_value
            ),
            Some(runs) => format!("; no systematic remainder (p = {:.2})", runs.p_value),
        };
        let name = name(column);
        let phases = &found.phases[column.record];
        let off = column.off.iter().map(|one| {
            let (from, to, modes) = phases[one.phase];
            json!({
                "phase": one.phase + 1,
                "from": from,
                "to": to,
                "modes": system.letters(&modes),
                "count": one.count,
                "ratio": one.ratio,
                "p_value": one.p_value,
            })
        });
        let off: Vec<Value> = off.collect();
        let of_phases = match column.off.iter().max_by(|a, b| a.ratio.total_cmp(&b.ratio)) {
            None => String::new(),
            Some(worst) => {
                let (from, to, modes) = phases[worst.phase];
                format!(
                    "; too large in {} of {} phases, most in phase {} ({}, {from:.4} to {to:.4}): \
                     {:.1} of the noise",
                    off.len(),
                    phases.len(),
                    worst.phase + 1,
                    system.letters(&modes),
                    worst.ratio
                )
            }
        };
        let line = format!(
            "{name}: rms {:.3e} in {} values, {kind}{order}{of_phases}",
            column.rms, column.count
        );
        let json = json!({
            "record": column.record + 1,
            "column": request.observables[column.observable].name,
            "count": column.count,
            "rms": column.rms,
            "sigma": column.sigma,
            "runs": column.runs.map(|runs| json!({
                "runs": runs.runs,
                "expected": runs.expected,
                "p_value": runs.p_value,
            })),
            "phases_off": off,
        });
        (line, json)
    });
    let lines: Vec<_> = lines.collect();
    report.list("residuals", lines);
    Ok(())
}
