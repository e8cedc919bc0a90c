//! Attractors in words, tables and JSON.

use serde_json::{Value, json};
use stickslip::Options;
use stickslip::analysis::{RecurrenceSettings, attractor_of_many, attractors_of_many};
use stickslip::error::readable;

use crate::failure::{Failure, in_words};
use crate::render::{Table, by_state, place as within, significant_digits, state_words};
use stickslip_kernels::file::System;
use stickslip_kernels::kernel::{Motion, Outcome};

/// Attractor of the orbit from `x` at time 0, for one start of many. A start outside the domain of
/// the field or beyond the escape bound is an outcome of its own, not an error.
pub(super) fn reached_from_one_of_many(
    system: &System,
    x: &[f64],
    settings: &RecurrenceSettings,
    options: &Options,
) -> Result<Outcome, Failure> {
    let reached = attractor_of_many(system.dynamics(), x, settings, options);
    let reached = reached.map_err(|error| Failure::from(error).of(system))?;
    Ok(Outcome::of(&reached, &|error| in_words(error, system)))
}

/// The same for several starts, whose orbits are computed side by side.
pub(super) fn reached_from_many(
    system: &System,
    starts: &[Vec<f64>],
    settings: &RecurrenceSettings,
    options: &Options,
) -> Result<Vec<Outcome>, Failure> {
    let starts = starts.iter().map(Vec::as_slice);
    let reached = attractors_of_many(system.dynamics(), starts, settings, options);
    let reached = reached.map_err(|error| Failure::from(error).of(system))?;
    let outcome = |reached| Outcome::of(reached, &|error| in_words(error, system));
    Ok(reached.iter().map(outcome).collect())
}

/// Appends the phases to a text, if there are any.
pub(super) fn with_phases(text: String, between: &str, phases: &str) -> String {
    match phases.trim().is_empty() {
        true => text,
        false => text + between + phases,
    }
}

/// Adds columns for motion, period, returns, phases and fraction of time in stick to a table. Cells
/// without a value are empty.
pub(super) fn columns<'a, R>(
    system: &'a System,
    table: Table<'a, R>,
    of: impl Fn(&R) -> &Outcome + Copy + 'a,
) -> Table<'a, R> {
    let returns = |outcome: &Outcome| match outcome.motion {
        Motion::Periodic { returns, .. } => Some(returns),
        _ => None,
    };
    fn with_points(outcome: &Outcome) -> Option<&Outcome> {
        (!outcome.points.is_empty()).then_some(outcome)
    }
    table
        .column("motion", move |row| of(row).motion.word())
        .column("period", move |row| {
            rounded_period(&of(row).motion, of(row).period_uncertainty)
        })
        .column("returns", move |row| returns(of(row)))
        .column("phases", move |row| {
            with_points(of(row)).map(|outcome| system.phases(outcome))
        })
        .column("in_stick", move |row| {
            with_points(of(row)).map(|outcome| outcome.in_stick)
        })
}

/// Period of a periodic orbit, rounded to its significant digits.
pub(super) fn rounded_period(motion: &Motion, uncertainty: f64) -> Option<f64> {
    match *motion {
        Motion::Periodic { period, .. } => Some(significant_digits(period, uncertainty)),
        _ => None,
    }
}

/// State of the equilibrium, if the orbit ends in one.
pub(super) fn place(outcome: &Outcome) -> Option<String> {
    if !matches!(outcome.motion, Motion::Equilibrium | Motion::EquilibriumSet) {
        return None;
    }
    outcome.points.first().map(|(_, x)| state_words(x))
}

/// Words for the family that a periodic orbit belongs to.
pub(super) fn family_words(dimension: usize) -> String {
    format!("one of a family of periodic orbits of dimension {dimension}")
}

/// One-line description of an outcome after the time `until`.
pub(super) fn words(system: &System, outcome: &Outcome, until: f64) -> String {
    let word = outcome.motion.word();
    match (&outcome.motion, place(outcome)) {
        (Motion::Periodic { period, .. }, _) => {
            let period = within(*period, outcome.period_uncertainty);
            let text = format!("{word}, period {period}");
            with_phases(text, ", phases ", &system.phases(outcome))
        }
        (_, Some(place)) => format!("{word} at {place}"),
        // If several starts fail, the error of the first is shown.
        (Motion::Failure(error), _) => format!("{word}, first as {error}"),
        _ => since(word, until),
    }
}

/// The word for a motion. An undecided one includes the time.
pub(super) fn since(word: &str, until: f64) -> String {
    if word == Motion::Undecided.word() {
        format!("{word} after {}", readable(until))
    } else {
        word.to_owned()
    }
}

/// Outcome as JSON.
pub(super) fn json(outcome: &Outcome, system: &System) -> Value {
    let points: Vec<Value> = outcome
        .points
        .iter()
        .map(|(t, x)| json!({ "t": t, "x": by_state(system, x) }))
        .collect();
    let (period, returns) = match outcome.motion {
        Motion::Periodic { period, returns } => (Some(period), Some(returns)),
        _ => (None, None),
    };
    json!({
        "motion": outcome.motion.word(),
        "period": period,
        "period_uncertainty": period.map(|_| outcome.period_uncertainty),
        "returns": returns,
        "phases": system.phases(outcome).split_whitespace().collect::<Vec<_>>(),
        "in_stick": outcome.in_stick,
        "points": points,
    })
}
