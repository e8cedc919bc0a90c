//! Attractors in words, tables and JSON.

use serde_json::{Value, json};

use super::tables::{exact, letters, state_json};
use crate::system::System;
use stickslip_kernels::kernel::{Motion, Outcome};

/// The phases of a period, or the modes of a rest, as signs; of other motions, whose phases are only the last ones, nothing.
pub(super) fn sequence(outcome: &Outcome) -> String {
    match outcome.motion {
        Motion::Periodic { .. } => {
            let phases: Vec<String> = outcome.sequence().iter().map(letters).collect();
            phases.join(" ")
        }
        Motion::Equilibrium | Motion::EquilibriumSet => letters(&outcome.modes),
        _ => String::new(),
    }
}

/// As [`sequence`], and the same text wherever in a cycle the phases begin.
pub(super) fn cycle(outcome: &Outcome) -> String {
    let phases: Vec<String> = outcome.sequence().iter().map(letters).collect();
    let turned = |by: usize| {
        let (end, begin) = phases.split_at(by);
        [begin, end].concat().join(" ")
    };
    let all = (0..phases.len()).map(turned);
    all.min().unwrap_or_default()
}

/// The kind of motion, of a periodic orbit with the cycle of its phases.
pub(super) fn class(outcome: &Outcome) -> String {
    let word = outcome.motion.word();
    match outcome.motion {
        Motion::Periodic { .. } => format!("{word}, {}", cycle(outcome)),
        _ => word.to_owned(),
    }
}

/// Motion, period, returns, phases, and part of the time in stick; empty where there is none.
pub(super) fn fields(outcome: &Outcome) -> [String; 5] {
    let (period, returns) = match outcome.motion {
        Motion::Periodic { period, returns } => (exact(period), returns.to_string()),
        _ => (String::new(), String::new()),
    };
    let (phases, in_stick) = if outcome.points.is_empty() {
        (String::new(), String::new())
    } else {
        (sequence(outcome), exact(outcome.in_stick))
    };
    let motion = outcome.motion.word().to_owned();
    [motion, period, returns, phases, in_stick]
}

/// What it is, in one line.
pub(super) fn words(outcome: &Outcome) -> String {
    let word = outcome.motion.word();
    match &outcome.motion {
        Motion::Periodic { period, .. } => {
            format!("{word}, period {period:.9}, phases {}", sequence(outcome))
        }
        Motion::Equilibrium | Motion::EquilibriumSet => {
            let at = outcome.points.first();
            let at: Vec<String> = at
                .iter()
                .flat_map(|at| &at.1)
                .map(|x| format!("{x:.9}"))
                .collect();
            format!("{word} at ({})", at.join(", "))
        }
        Motion::Failure(error) => format!("{word}: {error}"),
        _ => word.to_owned(),
    }
}

/// For other programs.
pub(super) fn json(outcome: &Outcome, system: &System) -> Value {
    let points: Vec<Value> = outcome
        .points
        .iter()
        .map(|(t, x)| json!({ "t": t, "x": state_json(system, x) }))
        .collect();
    let (period, returns) = match outcome.motion {
        Motion::Periodic { period, returns } => (Some(period), Some(returns)),
        _ => (None, None),
    };
    json!({
        "motion": outcome.motion.word(),
        "period": period,
        "returns": returns,
        "phases": sequence(outcome).split_whitespace().collect::<Vec<_>>(),
        "in_stick": outcome.in_stick,
        "points": points,
    })
}
