//! Inputs: the value held, and the clock.

use std::ops::Range;

use stickslip::error::readable;

use super::super::{Formula, InputEntry, InputShape};
use super::{BuildResult, Builder, Problem, no_number};
use crate::expression::{Binary, Test};
use crate::kernel::HELD_PER_INPUT;

impl Builder<'_> {
    /// The value of an input: the value held, plus its slope times its clock.
    pub(super) fn input(&mut self, number: usize, place: Range<usize>) -> BuildResult {
        let entry = &self.file.inputs[number];
        let states = self.file.states.len() + self.inputs.count_free();
        let held = states + HELD_PER_INPUT * number;
        let value = self.graph.state(held);
        let pieces = match &entry.shape {
            InputShape::Switch(_) => return Ok(value),
            InputShape::Periodic { pieces, .. } | InputShape::Table { pieces, .. } => pieces,
        };
        if pieces.iter().all(|piece| piece.slope == 0.0) {
            return Ok(value);
        }
        let (slope, clock) = (self.graph.state(held + 1), self.clock(entry)?);
        let made = self.graph.binary(Binary::Product, slope, clock);
        let made = made.and_then(|product| self.graph.binary(Binary::Sum, value, product));
        made.map_err(|error| no_number(error, place))
    }

    /// The clock of an input. For a switch, it is the function whose sign it takes.
    pub fn clock(&mut self, entry: &InputEntry) -> BuildResult {
        let time = self.graph.time();
        let (period, phase) = match &entry.shape {
            InputShape::Switch(function) => return self.formula(function),
            InputShape::Table { .. } => return Ok(time),
            InputShape::Periodic { period, phase, .. } => (self.of_input(period, "period")?, phase),
        };
        let made = self.graph.binary(Binary::Quotient, time, period);
        let mut made = made.map_err(|error| no_number(error, entry.place.clone()))?;
        if let Some(phase) = phase {
            let phase = self.of_input(phase, "phase")?;
            let sum = self.graph.binary(Binary::Sum, made, phase);
            made = sum.map_err(|error| no_number(error, entry.place.clone()))?;
        }
        Ok(made)
    }

    /// The period, phase or width of an input, which must be constant so that its clock runs
    /// uniformly.
    pub fn of_input(&mut self, formula: &Formula, what: &str) -> BuildResult {
        let made = self.formula(formula)?;
        if self.graph.depends_on_time(made) {
            let message = format!("the {what} of an input cannot depend on time");
            return Err(Problem::new(message, formula.whole())
                .help("an input with another clock is a switch: the sign of a function of time"));
        }
        if self.inputs.count_free() == 0 && self.graph.depends_on_state(made) {
            let message =
                format!("the {what} of an input cannot depend on a state or another input");
            return Err(Problem::new(message, formula.whole()).help(
                "it is an expression of parameters; what depends on states is a jump that sets a \
                 discrete state",
            ));
        }
        let asked = match what {
            "period" => Some(Test::Positive),
            "width" => Some(Test::InsideUnit),
            _ => None,
        };
        let is_wrong = asked.is_some_and(|asked| !self.graph.is(made, asked));
        match self.graph.value(made).filter(|_| is_wrong) {
            Some(period) if what == "period" => Err(Problem::new(
                format!("the period is {}, but must be positive", readable(period)),
                formula.whole(),
            )
            .help("it is the time after which the input comes again")),
            Some(width) => {
                let message = format!("the width {} is not between 0 and 1", readable(width));
                Err(Problem::new(message, formula.whole())
                    .help("it is the part of the period in which the pulse is 1"))
            }
            None => Ok(made),
        }
    }
}
