//! What a map is of, and what its blocks hold.

use std::num::NonZeroUsize;

use serde::{Deserialize, Serialize};
use stickslip::analysis::RecurrenceSettings;

use super::super::Failure;
use super::super::arguments::{OutputArguments, SolverArguments, StartArguments};
use super::super::range::{ParameterRange, grid, middle, with_values};
use super::super::sweeping::{Sweep, check_duration, to_content};
use super::cell::Cell;
use super::{Arguments, found};
use crate::sweep::{BlockError, Store};
use crate::terminal::Said;
use stickslip_kernels::file::System;

/// Everything that a map depends on besides the system.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(in super::super) struct Map {
    /// The two parameters.
    pub(super) plane: [ParameterRange; 2],
    pub(super) columns: NonZeroUsize,
    rows: NonZeroUsize,
    start: StartArguments,
    /// Time after which an orbit is undecided.
    pub(super) until: f64,
    duration: f64,
    solver: SolverArguments,
}

impl Map {
    pub(super) fn new(arguments: &Arguments, system: &System) -> Result<Self, Failure> {
        let plane = [
            ParameterRange::new("--x", &arguments.x, system)?,
            ParameterRange::new("--y", &arguments.y, system)?,
        ];
        if plane[0].name == plane[1].name {
            let name = &plane[0].name;
            return Err(Failure::Usage(format!(
                "--x and --y are both `{name}`; a map has two parameters"
            )));
        }
        let (columns, rows) = grid(&arguments.grid)?;
        let map = Self {
            plane,
            columns,
            rows,
            start: arguments.run.start.clone(),
            until: arguments.until,
            duration: arguments.duration,
            solver: arguments.run.solver.clone(),
        };
        // What is wrong is better told before the sweep than by one of its blocks.
        map.solver.options()?;
        check_duration(map.duration)?;
        let (columns, rows) = (map.columns.get() - 1, map.rows.get() - 1);
        for (column, row) in [(0, 0), (columns, 0), (0, rows), (columns, rows)] {
            let system = map.system(system, map.parameters(column, row))?;
            map.settings(&system).check()?;
            map.start.at_zero(&system)?;
        }
        Ok(map)
    }

    /// The values of the two parameters in a cell.
    pub(super) fn parameters(&self, column: usize, row: usize) -> [f64; 2] {
        let [x, y] = &self.plane;
        [
            x.at(middle(column, self.columns)),
            y.at(middle(row, self.rows)),
        ]
    }

    /// The system with these values of the two parameters.
    fn system(&self, system: &System, values: [f64; 2]) -> Result<System, Failure> {
        let [x, y] = &self.plane;
        with_values(system, &[(&x.name, values[0]), (&y.name, values[1])])
    }

    fn settings(&self, system: &System) -> RecurrenceSettings {
        RecurrenceSettings {
            forcing: system.built.period,
            ..RecurrenceSettings::within(self.until)
        }
    }

    fn cell(&self, system: &System, column: usize, row: usize) -> Result<Cell, Failure> {
        let system = self.system(system, self.parameters(column, row))?;
        let (settings, options) = (self.settings(&system), self.solver.options()?);
        let start = self.start.at_zero(&system)?;
        Cell::at(&system, &start, &settings, self.duration, &options)
    }
}

impl Sweep for Map {
    const COMMAND: &'static str = "map";

    fn size(&self) -> (NonZeroUsize, NonZeroUsize) {
        (self.rows, NonZeroUsize::MIN)
    }

    fn block(
        &self,
        system: &System,
        index: usize,
        _before: Option<&[u8]>,
    ) -> Result<Vec<u8>, BlockError> {
        let cells = (0..self.columns.get()).map(|column| self.cell(system, column, index));
        let cells: Vec<Cell> = cells.collect::<Result<_, _>>()?;
        to_content(&cells)
    }

    fn finish(
        &self,
        system: &System,
        store: &Store,
        output: &OutputArguments,
    ) -> Result<Said, Failure> {
        found::Found::read(self, store, output)?.written(self, system, store, output)
    }
}
