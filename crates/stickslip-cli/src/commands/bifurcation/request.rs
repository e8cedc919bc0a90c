//! What a bifurcation diagram is of, and what its blocks hold.

use std::num::NonZeroUsize;

use serde::{Deserialize, Serialize};
use stickslip::Options;
use stickslip::analysis::{RecurrenceSettings, SweepSettings};
use stickslip_kernels::kernel::{Change, Motion, Outcome};

use super::super::Failure;
use super::super::arguments::{OutputArguments, SolverArguments, StartArguments};
use super::super::attractors;
use super::super::exponent::Largest;
use super::super::range::{ParameterRange, not_too_many};
use super::super::sweeping::{Sweep, check_duration, from_content, to_content};
use super::{Arguments, found};
use crate::sweep::{BlockError, Store};
use crate::terminal::Said;
use stickslip_kernels::file::System;

/// Values of the parameter in a block.
const IN_BLOCK: usize = 10;

/// Ways through the range.
const WAYS: NonZeroUsize = NonZeroUsize::MIN.saturating_add(1);

/// Everything that a diagram depends on besides the system.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(in super::super) struct Bifurcation {
    pub(super) parameter: ParameterRange,
    pub(super) values: NonZeroUsize,
    start: StartArguments,
    /// Time after which an orbit is undecided.
    pub(super) until: f64,
    duration: f64,
    solver: SolverArguments,
}

/// What is found at one value.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct At {
    pub(super) value: f64,
    pub(super) outcome: Outcome,
    pub(super) largest: Largest,
}

/// A change between two neighbouring values.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Between {
    pub(super) values: (f64, f64),
    pub(super) change: Change,
}

/// Where a block ends and the next one goes on.
#[derive(Debug, Serialize, Deserialize)]
struct Last {
    value: f64,
    /// The motion there, as [`attractors::class`] has it.
    class: String,
    /// The state that the orbit there began from.
    start: Vec<f64>,
    /// The state that the orbit at the next value begins from.
    carried: Vec<f64>,
}

/// What a block holds.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Part {
    pub(super) found: Vec<At>,
    /// Changes from each value to the next, the first of them from the last value of the block before.
    pub(super) changes: Vec<Between>,
    last: Option<Last>,
}

impl Bifurcation {
    pub(super) fn new(arguments: &Arguments, system: &System) -> Result<Self, Failure> {
        let diagram = Self {
            parameter: ParameterRange::new("--parameter", &arguments.parameter, system)?,
            values: arguments.values,
            start: arguments.run.start.clone(),
            until: arguments.until,
            duration: arguments.duration,
            solver: arguments.run.solver.clone(),
        };
        // What is wrong is better told before the sweep than by one of its blocks.
        if diagram.values.get() < 2 {
            return Err(Failure::Usage(
                "--values 1: a diagram has at least 2 values".into(),
            ));
        }
        let values = diagram.values.get();
        not_too_many(&format!("--values {values}"), Some(values))?;
        diagram.solver.options()?;
        check_duration(diagram.duration)?;
        for value in [diagram.parameter.low, diagram.parameter.high] {
            let system = diagram.parameter.system(system, value)?;
            diagram.settings(&system).check()?;
            diagram.start.at_zero(&system)?;
        }
        Ok(diagram)
    }

    /// Blocks of one way.
    fn blocks(&self) -> NonZeroUsize {
        let blocks = self.values.get().div_ceil(IN_BLOCK);
        NonZeroUsize::new(blocks).unwrap_or(NonZeroUsize::MIN)
    }

    /// Whether a block is on the way up.
    pub(super) fn is_up(&self, block: usize) -> bool {
        block < self.blocks().get()
    }

    /// The values of the parameter in a block, in the order in which they are gone through.
    fn values_of(&self, block: usize) -> impl Iterator<Item = f64> + '_ {
        let number = self.values.get();
        let first = block % self.blocks().get() * IN_BLOCK;
        let is_up = self.is_up(block);
        (first..(first + IN_BLOCK).min(number)).map(move |k| {
            let k = if is_up { k } else { number - 1 - k };
            self.parameter.at(k as f64 / (number - 1) as f64)
        })
    }

    fn settings(&self, system: &System) -> RecurrenceSettings {
        RecurrenceSettings {
            forcing: system.built.period,
            ..RecurrenceSettings::within(self.until)
        }
    }

    fn part(
        &self,
        system: &System,
        block: usize,
        before: Option<&[u8]>,
    ) -> Result<Part, BlockError> {
        let options = self.solver.options()?;
        let mut last = match before {
            Some(before) => from_content::<Part>(before)?.last,
            None => None,
        };
        let (mut found, mut changes) = (Vec::new(), Vec::new());
        for value in self.values_of(block) {
            let here = self.parameter.system(system, value)?;
            let settings = self.settings(&here);
            let start = match &last {
                Some(last) => last.carried.clone(),
                None => self.start.at_zero(&here)?,
            };
            let outcome = attractors::reached_from(&here, &start, &settings, &options)?;
            let class = attractors::class(&outcome);
            if let Some(last) = last.filter(|last| last.class != class) {
                for change in self.changes(system, &last, value, &settings, &options)? {
                    let values = (last.value, value);
                    changes.push(Between { values, change });
                }
            }
            last = Some(Last {
                value,
                class,
                carried: carried_on(&outcome, settings.forcing.is_some())
                    .unwrap_or_else(|| start.clone()),
                start,
            });
            let largest = Largest::on(&here, &outcome, self.duration, &options);
            found.push(At {
                value,
                outcome,
                largest,
            });
        }
        Ok(Part {
            found,
            changes,
            last,
        })
    }

    /// What the attractor becomes between the last value and this one.
    fn changes(
        &self,
        system: &System,
        last: &Last,
        value: f64,
        recurrence: &RecurrenceSettings,
        options: &Options,
    ) -> Result<Vec<Change>, Failure> {
        let settings = SweepSettings {
            recurrence: *recurrence,
            ..SweepSettings::within(self.until)
        };
        // In a time in which the drive has one period, though its own may change with the parameter.
        let family = |value| {
            let there = self.parameter.system(system, value).ok()?;
            there.equations_in(recurrence.forcing).ok()
        };
        let between = (last.value, value);
        let kernel = system.kernel();
        let mut found = kernel
            .changes(&family, between, &last.start, &settings, options)
            .map_err(|error| Failure::from(error).of(system))?;
        for change in &mut found {
            if let (
                Change::Sequence {
                    parameter, period, ..
                },
                Some(reference),
            ) = (change, recurrence.forcing)
            {
                let there = self.parameter.system(system, *parameter)?;
                *period *= there.built.period.map_or(1.0, |there| there / reference);
            }
        }
        Ok(found)
    }
}

/// The state that the next value's orbit begins from; none where this one has come to no attractor.
fn carried_on(outcome: &Outcome, is_forced: bool) -> Option<Vec<f64>> {
    match outcome.motion {
        Motion::Escape | Motion::Failure(_) | Motion::Repelling | Motion::TwoFold => None,
        // At a flash of the strobe, so that the next orbit begins at the same phase of the forcing.
        _ if is_forced => outcome.points.last().map(|(_, x)| x.clone()),
        _ => Some(outcome.left_at.1.clone()),
    }
}

impl Sweep for Bifurcation {
    const COMMAND: &'static str = "bifurcation";

    fn size(&self) -> (NonZeroUsize, NonZeroUsize) {
        (WAYS, self.blocks())
    }

    fn block(
        &self,
        system: &System,
        index: usize,
        before: Option<&[u8]>,
    ) -> Result<Vec<u8>, BlockError> {
        to_content(&self.part(system, index, before)?)
    }

    fn finish(
        &self,
        system: &System,
        store: &Store,
        output: &OutputArguments,
    ) -> Result<Said, Failure> {
        found::Found::read(self, system, store, output)?.written(self, system, store, output)
    }
}
