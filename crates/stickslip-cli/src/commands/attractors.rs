//! Attractors in words, tables and JSON.

use serde_json::{Value, json};
use stickslip::analysis::{Attractor, AttractorKind};
use stickslip::error::readable;

use crate::render::{Table, by_state, place as within, significant_digits, state_words};
use stickslip_model::file::System;

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
    of: impl Fn(&R) -> &Attractor + Copy + 'a,
) -> Table<'a, R> {
    fn attractor(reached: &Attractor) -> Option<&Attractor> {
        Some(reached).filter(|reached| reached.kind.is_attractor())
    }
    table
        .column("motion", move |row| of(row).kind.word())
        .column("period", move |row| {
            rounded_period(&of(row).kind, of(row).period_uncertainty)
        })
        .column("returns", move |row| match of(row).kind {
            AttractorKind::Periodic { returns, .. } => Some(returns),
            _ => None,
        })
        .column("phases", move |row| {
            attractor(of(row)).map(|one| system.phases(one))
        })
        .column("in_stick", move |row| {
            attractor(of(row)).map(|one| one.in_stick)
        })
}

/// Error of a failed run, in words.
pub(super) fn reason(reached: &Attractor) -> Option<String> {
    match &reached.kind {
        AttractorKind::Failure(error) => Some(error.to_string()),
        _ => None,
    }
}

/// Period of a periodic orbit, rounded to its significant digits.
pub(super) fn rounded_period(kind: &AttractorKind, uncertainty: f64) -> Option<f64> {
    match *kind {
        AttractorKind::Periodic { period, .. } => Some(significant_digits(period, uncertainty)),
        _ => None,
    }
}

/// Words for the family that a periodic orbit belongs to.
pub(super) fn family_words(dimension: usize) -> String {
    format!("one of a family of periodic orbits of dimension {dimension}")
}

/// One-line description of what an orbit has reached after the time `until`.
pub(super) fn words(system: &System, reached: &Attractor, until: f64) -> String {
    let word = reached.kind.word();
    match (&reached.kind, reached.points.first()) {
        (AttractorKind::Periodic { period, .. }, _) => {
            let period = within(*period, reached.period_uncertainty);
            let text = format!("{word}, period {period}");
            with_phases(text, ", phases ", &system.phases(reached))
        }
        (AttractorKind::Equilibrium | AttractorKind::EquilibriumSet, Some(at)) => {
            format!("{word} at {}", state_words(at.x.as_slice()))
        }
        // If several starts fail, the error of the first is shown.
        (AttractorKind::Failure(error), _) => format!("{word}, first as {error}"),
        _ => since(word, until),
    }
}

/// The word for a motion. An undecided one includes the time.
pub(super) fn since(word: &str, until: f64) -> String {
    if word == AttractorKind::Undecided.word() {
        format!("{word} after {}", readable(until))
    } else {
        word.to_owned()
    }
}

/// An attractor as JSON.
pub(super) fn json(reached: &Attractor, system: &System) -> Value {
    let points = reached.points.iter();
    let points = points.map(|at| json!({ "t": at.t, "x": by_state(system, at.x.as_slice()) }));
    let (period, returns) = match reached.kind {
        AttractorKind::Periodic { period, returns } => (Some(period), Some(returns)),
        _ => (None, None),
    };
    json!({
        "motion": reached.kind.word(),
        "period": period,
        "period_uncertainty": period.map(|_| reached.period_uncertainty),
        "returns": returns,
        "phases": system.phases(reached).split_whitespace().collect::<Vec<_>>(),
        "in_stick": reached.in_stick,
        "points": points.collect::<Value>(),
    })
}
