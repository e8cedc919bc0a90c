//! What a basin is of, and what its blocks hold.

use std::num::NonZeroUsize;

use serde::{Deserialize, Serialize};
use stickslip::analysis::RecurrenceSettings;

use super::super::Failure;
use super::super::arguments::{OutputArguments, SolverArguments};
use super::super::attractors::reached_from_one_of_many;
use super::super::range::{StateRange, grid, not_too_many};
use super::super::sweeping::{Sweep, to_content};
use super::starts::Points;
use super::{Arguments, found};
use crate::sweep::{BlockError, Store};
use crate::terminal::Said;
use stickslip_kernels::file::System;
use stickslip_kernels::kernel::Outcome;

/// Seed where none is given.
const FIRST_SEED: u64 = 1;

/// Everything that a basin depends on besides the system.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(in super::super) struct Basin {
    /// The coordinates of the plane.
    pub(super) plane: [StateRange; 2],
    /// The points in it.
    pub(super) points: Points,
    /// The other components of the starts.
    start: Vec<f64>,
    pub(super) until: f64,
    pub(super) solver: SolverArguments,
}

/// What a block holds.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Reached {
    /// The attractors that its starts lead to, in the order in which they do so first.
    pub(super) attractors: Vec<Outcome>,
    /// Which of these each start leads to.
    pub(super) starts: Vec<usize>,
}

impl Basin {
    pub(super) fn new(arguments: &Arguments, system: &System) -> Result<Self, Failure> {
        let plane = [
            StateRange::new("--x", arguments.x.as_deref(), 0, system)?,
            StateRange::new("--y", arguments.y.as_deref(), 1, system)?,
        ];
        if plane[0].state == plane[1].state {
            let name = &system.file.states[plane[0].state].name;
            return Err(Failure::Usage(format!(
                "--x and --y are both `{name}`; a plane has two states"
            )));
        }
        for range in &plane {
            let name = &system.file.states[range.state].name;
            if arguments.run.start.sets(name) {
                return Err(Failure::Usage(format!(
                    "--start {name}=… has no effect: the starts go through {name} from {} to {}; leave it out, or choose another plane with --x \
                     and --y",
                    range.low, range.high
                )));
            }
        }
        let points = match (arguments.random, arguments.seed) {
            (Some(number), seed) => {
                not_too_many(&format!("--random {number}"), Some(number.get()))?;
                Points::Random {
                    number,
                    seed: seed.unwrap_or(FIRST_SEED),
                }
            }
            (None, Some(seed)) => {
                return Err(Failure::Usage(format!(
                    "--seed {seed} has no effect on a grid; leave it out, or give --random"
                )));
            }
            (None, None) => {
                let (columns, rows) = grid(&arguments.grid)?;
                Points::Grid { columns, rows }
            }
        };
        let start = arguments.run.start.at_zero(system)?;
        let basin = Self {
            plane,
            points,
            start,
            until: arguments.until,
            solver: arguments.run.solver.clone(),
        };
        basin.settings(system).check()?;
        // A wrong option is better told before the sweep than by its first block.
        basin.solver.options()?;
        Ok(basin)
    }

    pub(super) fn settings(&self, system: &System) -> RecurrenceSettings {
        RecurrenceSettings {
            forcing: system.built.period,
            ..RecurrenceSettings::within(self.until)
        }
    }

    /// The state that point `index` of the plane stands for.
    pub(super) fn start(&self, index: usize) -> Vec<f64> {
        let mut start = self.start.clone();
        let at = self.points.at(index, &self.plane);
        for (range, value) in self.plane.iter().zip(at) {
            start[range.state] = value;
        }
        start
    }
}

impl Sweep for Basin {
    const COMMAND: &'static str = "basin";

    fn size(&self) -> (NonZeroUsize, NonZeroUsize) {
        (self.points.blocks(), NonZeroUsize::MIN)
    }

    fn block(
        &self,
        system: &System,
        index: usize,
        _before: Option<&[u8]>,
    ) -> Result<Vec<u8>, BlockError> {
        let settings = self.settings(system);
        let options = self.solver.options()?;
        let mut reached = Reached {
            attractors: Vec::new(),
            starts: Vec::new(),
        };
        for point in self.points.of_block(index) {
            let start = self.start(point);
            let outcome = reached_from_one_of_many(system, &start, &settings, &options)?;
            let number = found::number(
                &mut reached.attractors,
                outcome,
                system,
                &settings,
                &options,
            );
            reached.starts.push(number);
        }
        to_content(&reached)
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
