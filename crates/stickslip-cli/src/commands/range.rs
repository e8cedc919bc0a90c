//! Ranges of states and parameters, from the command line or the file.

use std::num::NonZeroUsize;

use serde::{Deserialize, Serialize};
use stickslip::error::readable;

use super::arguments::position;
use crate::failure::Failure;
use stickslip_model::file::{System, number};

/// A range of a state.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct StateRange {
    /// Index of the state.
    pub(super) state: usize,
    /// Lower end.
    pub(super) low: f64,
    /// Upper end.
    pub(super) high: f64,
}

impl StateRange {
    /// Parses the range of `--option STATE=LOW:HIGH`. Without the option, the range of state
    /// `default` in the file is used.
    pub(super) fn new(
        option: &str,
        given: Option<&str>,
        default: usize,
        system: &System,
    ) -> Result<Self, Failure> {
        let states = &system.file.states;
        let Some(text) = given else {
            // Discrete states keep their start values from the file.
            let moving = states.iter().enumerate();
            let moving: Vec<_> = moving.filter(|(_, state)| !state.is_discrete).collect();
            let Some(&(default, state)) = moving.get(default) else {
                let help = match states.iter().find(|state| state.is_discrete) {
                    Some(state) => format!(
                        " besides discrete ones; with {option} {name}=LOW:HIGH one of these is \
                            taken, as with {option} {name}=-0.5:1.5 and two rows of --grid at 0 \
                            and 1",
                        name = state.name
                    ),
                    None => String::new(),
                };
                return Err(Failure::Usage(format!(
                    "a plane of starts needs two states, and the system has {}{help}",
                    moving.len()
                )));
            };
            let Some((low, high)) = state.range else {
                return Err(Failure::Usage(format!(
                    "the range of starts in `{}` is missing; give {option} {}=LOW:HIGH, or its \
                        range in the file",
                    state.name, state.name
                )));
            };
            return Self::checked(default, low, high, option);
        };
        let (name, low, high) = name_and_range(option, text)?;
        let names = states.iter().map(|state| state.name.as_str());
        Self::checked(position("state", &name, names)?, low, high, option)
    }

    /// The range of each state that has one in the file, except discrete ones.
    pub(super) fn of_file(system: &System) -> Vec<Self> {
        let states = system.file.states.iter().enumerate();
        let ranges = states
            .filter(|(_, state)| !state.is_discrete)
            .filter_map(|(state, one)| {
                let (low, high) = one.range?;
                Some(Self { state, low, high })
            });
        ranges.collect()
    }

    fn checked(state: usize, low: f64, high: f64, option: &str) -> Result<Self, Failure> {
        check_ends(low, high, option)?;
        Ok(Self { state, low, high })
    }

    /// The value at a fraction of the range.
    pub(super) fn at(&self, part: f64) -> f64 {
        self.low + (self.high - self.low) * part
    }

    /// The range in words, with the name of the state.
    pub(super) fn words(&self, system: &System) -> String {
        range_words(&system.file.states[self.state].name, self.low, self.high)
    }
}

/// A range in words: `x from 0 to 1`.
fn range_words(name: &str, low: f64, high: f64) -> String {
    format!("{name} from {} to {}", readable(low), readable(high))
}

/// A range of a parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct ParameterRange {
    /// Name.
    pub(super) name: String,
    /// Lower end.
    pub(super) low: f64,
    /// Upper end.
    pub(super) high: f64,
}

impl ParameterRange {
    /// Parses the range of `--option NAME=LOW:HIGH`.
    pub(super) fn new(option: &str, text: &str, system: &System) -> Result<Self, Failure> {
        let (name, low, high) = name_and_range(option, text)?;
        let number = system.file.parameter(&name)?;
        check_ends(low, high, option)?;
        let name = system.file.parameters[number].name.clone();
        Ok(Self { name, low, high })
    }

    /// The range in words, with the name of the parameter.
    pub(super) fn words(&self) -> String {
        range_words(&self.name, self.low, self.high)
    }

    /// The system with this value of the parameter.
    pub(super) fn system(&self, system: &System, value: f64) -> Result<System, Failure> {
        with_values(system, &[(&self.name, value)])
    }

    /// The value at a fraction of the range.
    pub(super) fn at(&self, part: f64) -> f64 {
        self.low + (self.high - self.low) * part
    }
}

/// The system with these values of some parameters, by name.
pub(super) fn with_values(system: &System, values: &[(&str, f64)]) -> Result<System, Failure> {
    Ok(system.with_values(values)?)
}

fn check_ends(low: f64, high: f64, option: &str) -> Result<(), Failure> {
    if low < high && low.is_finite() && high.is_finite() {
        Ok(())
    } else {
        Err(Failure::Usage(format!(
            "{option}: from {low} to {high} is no range; both ends must be finite, the lower one \
                first"
        )))
    }
}

/// Maximum number of points of a basin or cells of a map. All are held in memory at the end.
const MOST_POINTS: usize = 100_000_000;

/// Rejects numbers of points that would not fit into memory.
pub(super) fn not_too_many(option: &str, points: Option<usize>) -> Result<(), Failure> {
    if points.is_some_and(|points| points <= MOST_POINTS) {
        return Ok(());
    }
    Err(Failure::Usage(format!(
        "{option}: these are more than {MOST_POINTS} points; give fewer, or split the range"
    )))
}

/// Parses the numbers of columns and rows, such as `200x100`.
pub(super) fn grid(text: &str) -> Result<(NonZeroUsize, NonZeroUsize), Failure> {
    let numbers = text.split_once('x').and_then(|(columns, rows)| {
        Some((columns.trim().parse().ok()?, rows.trim().parse().ok()?))
    });
    let (columns, rows): (NonZeroUsize, NonZeroUsize) = numbers.ok_or_else(|| {
        Failure::Usage(format!(
            "--grid {text}: numbers of columns and rows are expected, both at least 1, as in \
                --grid 200x100"
        ))
    })?;
    not_too_many(
        &format!("--grid {text}"),
        columns.get().checked_mul(rows.get()),
    )?;
    Ok((columns, rows))
}

/// Centre of a cell, as a fraction of a row of `of` cells.
pub(super) fn middle(cell: usize, of: NonZeroUsize) -> f64 {
    (cell as f64 + 0.5) / of.get() as f64
}

/// Parses name and ends of `NAME=LOW:HIGH`.
fn name_and_range(option: &str, text: &str) -> Result<(String, f64, f64), Failure> {
    let wrong = |what: &str| {
        Failure::Usage(format!(
            "{option} {text}: {what}; a name, `=` and two ends are expected, as in {option} x=-1:1"
        ))
    };
    let (name, range) = text
        .split_once('=')
        .ok_or_else(|| wrong("there is no `=`"))?;
    let (low, high) = range
        .split_once(':')
        .ok_or_else(|| wrong("there is no `:`"))?;
    let end = |text: &str| number(text).map_err(|_| wrong(&format!("`{text}` is no number")));
    Ok((name.trim().to_owned(), end(low)?, end(high)?))
}
