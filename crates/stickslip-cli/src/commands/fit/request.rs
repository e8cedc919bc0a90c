//! Request of a fit from the command line.

use std::collections::HashMap;

use stickslip::Options;
use stickslip_model::expression::normal;
use stickslip_model::file::{System, number, table_points};
use stickslip_model::study::fit::{FitRequest, Observable, Record, Unknown};
use stickslip_model::study::least_squares::Loss;

use super::Arguments;
use crate::commands::arguments::assignment;
use crate::failure::Failure;
use crate::table::read_record;

/// A request, and notes on how its data were read.
pub(super) struct Wanted {
    pub(super) request: FitRequest,
    pub(super) notes: Vec<String>,
}

fn wrong(option: &str, text: &str, why: &str) -> Failure {
    Failure::Usage(format!("{option} {text}: {why}"))
}

/// Names separated by commas.
fn names(list: &str) -> Vec<String> {
    list.split(',').map(|name| name.trim().to_owned()).collect()
}

/// The parts of options that may be repeated, or separated by commas.
fn parts(given: &[String]) -> impl Iterator<Item = &str> {
    given.iter().flat_map(|text| text.split(',')).map(str::trim)
}

fn loss(text: &str) -> Result<Loss, Failure> {
    let (name, scale) = match text.split_once(':') {
        Some((name, scale)) => (name, Some(scale)),
        None => (text, None),
    };
    let scale = scale.map(number).transpose();
    let scale = scale.map_err(|why| wrong("--loss", text, &format!("the scale: {why}")))?;
    match (name, scale) {
        ("squares", None) => Ok(Loss::Squares),
        ("soft-l1", scale) => Ok(Loss::SoftL1(scale.unwrap_or(1.0))),
        // With this scale the variance is 5 % above that of squares, if all noise is normal.
        ("huber", scale) => Ok(Loss::Huber(scale.unwrap_or(1.345))),
        _ => Err(wrong(
            "--loss",
            text,
            "it is squares, soft-l1:SCALE or huber:SCALE",
        )),
    }
}

/// Bounds by name.
fn bounds(given: &[String]) -> Result<HashMap<String, (f64, f64)>, Failure> {
    let mut all = HashMap::new();
    for text in parts(given) {
        let example = "NAME=LOW:HIGH is expected, as in mu0=0:1; leave an end out for none";
        let (name, range) = text
            .split_once('=')
            .ok_or_else(|| wrong("--bounds", text, example))?;
        let (low, high) = range
            .split_once(':')
            .or_else(|| range.split_once(".."))
            .ok_or_else(|| wrong("--bounds", text, example))?;
        let end = |text: &str, none: f64| match text.trim() {
            "" => Ok(none),
            end => number(end).map_err(|why| wrong("--bounds", range, &why)),
        };
        let ends = (end(low, f64::NEG_INFINITY)?, end(high, f64::INFINITY)?);
        if all.insert(normal(name.trim()), ends).is_some() {
            return Err(wrong(
                "--bounds",
                text,
                "the name stands twice; give it once",
            ));
        }
    }
    Ok(all)
}

/// Assignments to one record, by its number from 1.
fn of_records<T>(
    option: &str,
    given: &[String],
    count: usize,
    assigned: impl Fn(&str) -> Result<T, Failure>,
) -> Result<Vec<Vec<T>>, Failure> {
    let mut all: Vec<Vec<T>> = (0..count).map(|_| Vec::new()).collect();
    for text in given {
        let record = text.split_once(':').and_then(|(record, rest)| {
            let record = record.trim().parse::<usize>().ok()?.checked_sub(1)?;
            Some((all.get_mut(record)?, rest))
        });
        let Some((record, rest)) = record else {
            // What stands behind the number of a record that there is not.
            let rest = text.split_once(':').map_or(text.as_str(), |(_, rest)| rest);
            let why = format!("a record from 1 to {count} stands in front, as in 1:{rest}");
            return Err(wrong(option, text, &why));
        };
        record.push(assigned(rest)?);
    }
    Ok(all)
}

/// An input and the points of its table, from a file.
fn table(text: &str) -> Result<(String, Vec<f64>, Vec<f64>), Failure> {
    let (name, path) = text.split_once('=').ok_or_else(|| {
        let why = "an input, `=` and a file are expected, as in 2:u=drive.csv";
        wrong("--input-in", text, why)
    })?;
    let (times, values) = table_points(path.trim())?;
    Ok((name.trim().to_owned(), times, values))
}

pub(super) fn wanted(
    arguments: &Arguments,
    system: &System,
    options: Options,
) -> Result<Wanted, Failure> {
    let mut observables: Vec<Observable> = Vec::new();
    for text in &arguments.observe {
        let (name, formula) = text.split_once('=').unwrap_or((text, text));
        let name = name.trim().to_owned();
        if observables.iter().any(|known| known.name == name) {
            return Err(wrong(
                "--observe",
                text,
                "the column stands twice; give it once",
            ));
        }
        observables.push(Observable {
            name,
            formula: formula.trim().to_owned(),
            sigma: None,
        });
    }
    for text in parts(&arguments.sigma) {
        let (name, value) = match text.split_once('=') {
            Some((name, value)) => (Some(name.trim()), value),
            None => (None, text),
        };
        let sigma = number(value).map_err(|why| wrong("--sigma", text, &why))?;
        let mut is_known = false;
        for observable in &mut observables {
            if name.is_none_or(|name| name == observable.name) {
                (observable.sigma, is_known) = (Some(sigma), true);
            }
        }
        if !is_known {
            return Err(wrong("--sigma", text, "--observe has no such column"));
        }
    }
    let mut bounds = bounds(&arguments.bounds)?;
    let mut each = names(arguments.each.as_deref().unwrap_or_default());
    each.retain(|name| !name.is_empty());
    let mut unknowns = Vec::new();
    for name in names(&arguments.fit) {
        let is_own = |one: &String| normal(one) == normal(&name);
        let is_each = each.iter().any(is_own);
        each.retain(|one| !is_own(one));
        unknowns.push(Unknown {
            start: None,
            bounds: bounds
                .remove(&normal(&name))
                .unwrap_or((f64::NEG_INFINITY, f64::INFINITY)),
            each: is_each,
            name,
        });
    }
    // In order, so that the message is the same each time.
    let mut left: Vec<String> = bounds.into_keys().collect();
    left.sort();
    let left = [("--bounds", left.first()), ("--each", each.first())];
    for (option, name) in left {
        if let Some(name) = name {
            return Err(wrong(option, name, "it is not fitted: add it to --fit"));
        }
    }
    let extra = arguments
        .extra
        .iter()
        .map(|text| assignment("--extra", text));
    let extra = extra.collect::<Result<Vec<_>, _>>()?;
    let count = arguments.data.len();
    let values = |option: &str, given: &[String]| {
        of_records(option, given, count, |text| assignment(option, text))
    };
    let set_in = values("--set-in", &arguments.set_in)?;
    let start_in = values("--start-in", &arguments.start_in)?;
    let input_in = of_records("--input-in", &arguments.input_in, count, table)?;
    for of_record in &input_in {
        let mut names: Vec<&String> = of_record.iter().map(|(name, ..)| name).collect();
        names.sort();
        if let Some(twice) = names.windows(2).find(|two| two[0] == two[1]) {
            let why = "the input stands twice for one record; give it once";
            return Err(wrong("--input-in", twice[0], why));
        }
    }
    let columns: Vec<&str> = observables.iter().map(|one| &*one.name).collect();
    let common = arguments.run.start.assignments()?;
    let mut notes = Vec::new();
    let mut records = Vec::new();
    let own = set_in.into_iter().zip(start_in).zip(input_in);
    for (path, ((set, start), inputs)) in arguments.data.iter().zip(own) {
        let read = read_record(path, &columns, arguments.time.as_deref())?;
        notes.extend(read.notes.iter().map(|line| format!("{path}: {line}")));
        let is_own = |name: &str| start.iter().any(|(own, _)| normal(own) == normal(name));
        let others = common.iter().filter(|(name, _)| !is_own(name));
        records.push(Record {
            name: path.clone(),
            times: read.times,
            columns: read.columns,
            set,
            start: others.chain(&start).cloned().collect(),
            t_start: arguments.run.start.time(),
            inputs,
        });
    }
    let parameters = system.file.parameters.iter().zip(&system.values);
    let request = FitRequest {
        file: system.file.as_ref().clone(),
        set: parameters
            .map(|(one, value)| (one.name.clone(), *value))
            .collect(),
        extra,
        observables,
        records,
        unknowns,
        loss: loss(&arguments.loss)?,
        search: arguments.search,
        segments: arguments.segments,
        most_evaluations: arguments.most_runs.get(),
        options,
        interrupt: None,
    };
    Ok(Wanted { request, notes })
}
