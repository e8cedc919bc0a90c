//! `stickslip map`: the attractor of an orbit, over two parameters.

use std::num::NonZeroUsize;
use std::path::Path;

use plot::{Axis, Cells, Color, Figure, LIGHT_GREY, Legend, PURPLE, Panel, SKY, WHITE};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use stickslip::analysis::{Attractor, AttractorKind, Exponent};

use super::arguments::{RunArguments, SolverArguments, StartArguments};
use super::range::{ParameterRange, grid, middle, with_values};
use super::sweeping::{ExponentArguments, Sweep, SweepArguments, UntilArguments, sweep, table};
use super::{attractors, exponent, figures};
use crate::failure::{Failure, in_words};
use crate::render::{CommandOutput, Report, Table};
use crate::sweep::Store;
use stickslip_model::file::System;
use stickslip_model::study::{largest, recurrence, reported};

/// Show the attractor of the orbit from the start, over a plane of two parameters
///
/// The result has, for each cell, the kind of the attractor and its sequence of phases, the largest
/// Lyapunov exponent, and the fraction of time in stick.
///
/// Writes map.csv and map.svg. Finished blocks are in sweep/: after a kill, the same command
/// resumes from them.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Range of the first parameter
    #[arg(long, value_name = "NAME=LOW:HIGH")]
    x: String,

    /// Range of the second parameter
    #[arg(long, value_name = "NAME=LOW:HIGH")]
    y: String,

    /// Numbers of cells along the parameters; each cell is computed at its centre
    #[arg(long, value_name = "COLUMNSxROWS", default_value = "60x60")]
    grid: String,

    #[command(flatten)]
    until: UntilArguments,

    #[command(flatten)]
    exponent: ExponentArguments,

    #[command(flatten)]
    sweep: SweepArguments,
    #[command(flatten)]
    run: RunArguments,
}

pub(super) fn run(arguments: &Arguments) -> Result<CommandOutput, Failure> {
    sweep(&arguments.sweep, &arguments.run, |system| {
        Map::new(arguments, system)
    })
}

/// Everything that a map depends on, except the system.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Map {
    /// The two parameters.
    plane: [ParameterRange; 2],
    columns: NonZeroUsize,
    rows: NonZeroUsize,
    start: StartArguments,
    /// Time after which an orbit counts as undecided.
    until: f64,
    duration: f64,
    solver: SolverArguments,
}

impl Map {
    fn new(arguments: &Arguments, system: &System) -> Result<Self, Failure> {
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
            until: arguments.until.of(system),
            duration: arguments.exponent.of(system)?,
            solver: arguments.run.solver.clone(),
        };
        // Errors should be reported before the sweep, not by one of its blocks.
        map.solver.options(system)?;
        let (columns, rows) = (map.columns.get() - 1, map.rows.get() - 1);
        for (column, row) in [(0, 0), (columns, 0), (0, rows), (columns, rows)] {
            let system = map.system(system, map.parameters(column, row))?;
            recurrence(&system, map.until).check()?;
            map.start.at_zero(&system, &[])?;
        }
        Ok(map)
    }

    /// The values of the two parameters in a cell.
    fn parameters(&self, column: usize, row: usize) -> [f64; 2] {
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

    fn cell(&self, system: &System, column: usize, row: usize) -> Result<Cell, Failure> {
        let system = self.system(system, self.parameters(column, row))?;
        let (settings, options) = (
            recurrence(&system, self.until),
            self.solver.options(&system)?,
        );
        let start = self.start.at_zero(&system, &[])?;
        let reached = Attractor::of_any(system.dynamics(), &*start, &settings, &options);
        let reached = reached.map_err(|error| Failure::from(error).of(&system))?;
        let reached = reached.by_shooting(system.dynamics(), &settings, &options);
        let reached = reported(reached, |error| in_words(error, &system));
        let measured = largest::on(&system, &reached, self.duration, &options);
        let unmeasured = measured.as_ref().err();
        Ok(Cell {
            phases: system.phases(&reached),
            in_stick: reached.kind.is_attractor().then_some(reached.in_stick),
            reason: attractors::reason(&reached).or_else(|| Some(in_words(unmeasured?, &system))),
            largest: measured.unwrap_or(None),
            period_uncertainty: reached.period_uncertainty,
            kind: reached.kind,
        })
    }
}

impl Sweep for Map {
    const COMMAND: &'static str = "map";

    type Block = Vec<Cell>;

    fn size(&self) -> (NonZeroUsize, NonZeroUsize) {
        (self.rows, NonZeroUsize::MIN)
    }

    fn block(
        &self,
        system: &System,
        row: usize,
        _: Option<Vec<Cell>>,
    ) -> Result<Vec<Cell>, Failure> {
        let columns = 0..self.columns.get();
        columns
            .map(|column| self.cell(system, column, row))
            .collect()
    }

    fn report(&self, system: &System, store: &Store, out: &Path) -> Result<Report, Failure> {
        let path = out.join("map.csv");
        let found = self.read(store, &path)?;
        let all = found.cells.len();
        let [x, y] = self.plane.each_ref().map(ParameterRange::words);
        let mut report = Report::of(system, format!("{all} cells, {x}, {y}"));
        report.field("cells", all).file(path);
        // Attractors come first, in the order of first appearance; other outcomes follow.
        let mut in_order: Vec<&MotionClass> = found.classes.iter().collect();
        in_order.sort_by_key(|class| !class.is_attractor);
        for class in &in_order {
            let percent = 100.0 * class.cells as f64 / all as f64;
            let name = attractors::since(&class.name, self.until);
            let none = if class.is_attractor {
                ""
            } else {
                "no attractor: "
            };
            report.note(format!("{percent:6.2} %  {none}{name}"));
        }
        let classes = in_order.iter().map(|class| {
            json!({
                "motion": class.name,
                "is_attractor": class.is_attractor,
                "cells": class.cells,
            })
        });
        report.field("classes", classes.collect::<Vec<Value>>());
        report.figure("map", &self.figure(&found, system));
        Ok(report)
    }
}

/// Result at one pair of parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Cell {
    kind: AttractorKind,
    period_uncertainty: f64,
    /// The phases of a period, independent of where it begins. Empty where phases do not
    /// distinguish motions.
    phases: String,
    /// Fraction of time in stick, if there is an attractor.
    in_stick: Option<f64>,
    largest: Option<Exponent>,
    /// Error of a failed run, or of the measurement of the exponent.
    reason: Option<String>,
}

impl Cell {
    /// The kind of motion; for an attractor also its phases.
    fn class(&self) -> String {
        let word = self.kind.word();
        if self.phases.is_empty() {
            return word.to_owned();
        }
        // Long sequences would be wider than a figure. The number of phases distinguishes most of
        // them.
        let number = self.phases.split(' ').count();
        if number > 8 {
            format!("{word}, {number} phases")
        } else {
            format!("{word}, {}", self.phases)
        }
    }
}

/// Data of a cell for the figure.
#[derive(Clone, Copy)]
struct CellShown {
    /// Index of the class.
    class: usize,
    in_stick: Option<f64>,
    largest: Option<Exponent>,
}

/// Cells of one kind of motion.
struct MotionClass {
    /// Name of the motion; for an attractor also its phases.
    name: String,
    /// Whether this is a kind of attractor. Orbits that escape, end, fail or are undecided reach
    /// none.
    is_attractor: bool,
    /// Number of cells.
    cells: usize,
}

/// Results of a map.
struct MapResults {
    /// Classes in the order of first appearance.
    classes: Vec<MotionClass>,
    /// Row by row from the lowest second parameter.
    cells: Vec<CellShown>,
}

impl Map {
    /// Reads the blocks in order and writes the table.
    fn read(&self, store: &Store, path: &Path) -> Result<MapResults, Failure> {
        let (mut classes, mut shown): (Vec<MotionClass>, _) = (Vec::new(), Vec::new());
        type Row = ([f64; 2], Cell);
        let [x, y] = &self.plane;
        let columns = Table::new()
            .column(&x.name, |(at, _): &Row| at[0])
            .column(&y.name, |(at, _)| at[1])
            .column("motion", |(_, cell)| cell.kind.word())
            .column("period", |(_, cell)| {
                attractors::rounded_period(&cell.kind, cell.period_uncertainty)
            })
            .column("phases", |(_, cell)| cell.phases.clone())
            .column("in_stick", |(_, cell)| cell.in_stick);
        let columns = exponent::columns(columns, self.duration, |(_, cell)| cell.largest);
        let columns = columns.column("reason", |(_, cell)| cell.reason.clone());
        table(store, path, &columns, |row, cells: Vec<Cell>| {
            for cell in &cells {
                let name = cell.class();
                let known = classes.iter().position(|known| known.name == name);
                let class = known.unwrap_or_else(|| {
                    classes.push(MotionClass {
                        name,
                        is_attractor: cell.kind.is_attractor(),
                        cells: 0,
                    });
                    classes.len() - 1
                });
                classes[class].cells += 1;
                shown.push(CellShown {
                    class,
                    in_stick: cell.in_stick,
                    largest: cell.largest,
                });
            }
            let cells = cells.into_iter().enumerate();
            Ok(cells
                .map(|(column, cell)| (self.parameters(column, row), cell))
                .collect())
        })?;
        Ok(MapResults {
            classes,
            cells: shown,
        })
    }

    /// Plots the plane three times: attractor, exponent, fraction of time in stick.
    fn figure(&self, found: &MapResults, system: &System) -> Figure {
        let axis = |k: usize| {
            let range = &self.plane[k];
            let label = figures::parameter_label(system, &range.name);
            Axis::new(&label, range.low, range.high)
        };
        // All panels share the axis of the second parameter, which the first panel shows.
        let panel = |label: &str, title: &str, layers: Vec<Layer>| {
            let is_first = label == "(a)";
            let second = &self.plane[1];
            let y = if is_first {
                axis(1)
            } else {
                Axis::new("", second.low, second.high).bare()
            };
            let mut panel = Panel::new(axis(0), y)
                .label(label)
                .title(title)
                .legend(Legend::Below);
            let [x, y] = [0, 1].map(|k: usize| (self.plane[k].low, self.plane[k].high));
            for layer in layers {
                let cells = Cells::new(x, y, self.columns.get(), layer.set);
                panel.add(cells.fill(layer.colour).legend(&layer.legend));
            }
            (if is_first { 1.2 } else { 1.0 }, panel.into())
        };
        let panels = vec![
            panel("(a)", "attractor", kinds(found, self.until)),
            panel("(b)", "largest exponent", exponents(&found.cells)),
            panel("(c)", "part of time in stick", sticks(&found.cells)),
        ];
        let title = format!("{}: map of two parameters", system.file.name);
        let classes: Vec<&str> = found
            .classes
            .iter()
            .map(|class| class.name.as_str())
            .collect();
        let description = format!(
            "What the orbit from the start comes to, over {} and {}: {}; its largest Lyapunov \
                exponent; and the part of time in stick.",
            self.plane[0].name,
            self.plane[1].name,
            classes.join("; ")
        );
        Figure::new("map", (770.0, 440.0), &title, &description).columns(1.0, panels)
    }
}

/// Colours of negative exponents, darker for larger size.
const BLUES: [Color; 4] = [
    Color(200, 224, 242),
    Color(132, 184, 222),
    Color(48, 132, 190),
    Color(0, 76, 130),
];

/// Colours of positive exponents and of fractions of time, darker for larger values.
const REDS: [Color; 4] = [
    Color(252, 226, 184),
    Color(243, 178, 98),
    Color(213, 94, 0),
    Color(128, 48, 0),
];

/// The cells of one colour.
struct Layer {
    set: Vec<bool>,
    colour: Color,
    legend: String,
}

/// A layer for each kind of attractor, the largest first. Other outcomes follow, one layer each.
fn kinds(found: &MapResults, until: f64) -> Vec<Layer> {
    let classes = figures::by_size(
        &found.classes,
        |class| class.cells,
        |class| (!class.is_attractor).then_some(class.name.as_str()),
        |class| match class.is_attractor {
            // Figures use the minus sign, which is as wide as a plus sign.
            true => figures::plain(&class.name),
            false => attractors::since(&class.name, until),
        },
        |rest| format!("{} further kinds", rest.len()),
    );
    let layer = |class: figures::Class| Layer {
        set: {
            let cells = found.cells.iter();
            cells
                .map(|cell| class.kinds.contains(&cell.class))
                .collect()
        },
        colour: class.colour,
        legend: class.legend,
    };
    classes.into_iter().map(layer).collect()
}

/// Layer of the cells that satisfy a condition, if there are any.
fn layer(
    cells: &[CellShown],
    is_in: impl Fn(&CellShown) -> bool,
    colour: Color,
    legend: impl Into<String>,
) -> Option<Layer> {
    let set: Vec<bool> = cells.iter().map(is_in).collect();
    set.contains(&true).then(|| Layer {
        set,
        colour,
        legend: legend.into(),
    })
}

/// Layers of exponents of one sign, in quarters of their range from zero.
fn quarters(cells: &[CellShown], sign: f64, colours: [Color; 4]) -> Vec<Option<Layer>> {
    let size = |cell: &CellShown| match cell.largest {
        Some(one @ Exponent::Finite { value, .. }) if !largest::is_zero(one) => Some(sign * value),
        _ => None,
    };
    let most = cells.iter().filter_map(size).fold(0.0, f64::max);
    let quarter = |(k, colour): (usize, Color)| {
        let [low, high] = [k, k + 1].map(|k| most * k as f64 / colours.len() as f64);
        let is_last = k + 1 == colours.len();
        // The largest belongs to the last quarter, even if rounding makes its end smaller.
        let holds = |size: f64| size > low && (size <= high || is_last);
        let ends = if sign < 0.0 {
            [-high, -low]
        } else {
            [low, high]
        };
        let [from, to] = ends.map(|end| plot::number(end, decimals(most)));
        let legend = format!("{from} to {to}");
        layer(cells, |cell| size(cell).is_some_and(holds), colour, legend)
    };
    colours.into_iter().enumerate().map(quarter).collect()
}

fn exponents(cells: &[CellShown]) -> Vec<Layer> {
    let is = |what: Option<Exponent>| move |cell: &CellShown| cell.largest == what;
    let annihilated = is(Some(Exponent::Annihilated));
    let zero = |cell: &CellShown| cell.largest.is_some_and(largest::is_zero);
    let mut layers = vec![layer(cells, annihilated, PURPLE, "−∞: stick takes all")];
    // The most negative first.
    layers.extend(quarters(cells, -1.0, BLUES).into_iter().rev());
    layers.push(layer(cells, zero, LIGHT_GREY, "0 within its error"));
    layers.extend(quarters(cells, 1.0, REDS));
    layers.push(layer(cells, is(None), WHITE, "no attractor"));
    layers.into_iter().flatten().collect()
}

/// Number of decimal places that distinguishes the quarters of a range.
fn decimals(most: f64) -> usize {
    let mut decimals = 1;
    let mut unit = 0.1;
    while decimals < 9 && unit > most / 40.0 {
        unit /= 10.0;
        decimals += 1;
    }
    decimals
}

fn sticks(cells: &[CellShown]) -> Vec<Layer> {
    type IsIn = fn(f64) -> bool;
    let [first, second, third, fourth] = REDS;
    let parts: [(IsIn, Color, &str); 6] = [
        (|part| part <= 0.0, LIGHT_GREY, "no stick"),
        (|part| part > 0.0 && part <= 0.25, first, "up to 25 %"),
        (|part| part > 0.25 && part <= 0.5, second, "25 to 50 %"),
        (|part| part > 0.5 && part <= 0.75, third, "50 to 75 %"),
        (|part| part > 0.75 && part < 1.0, fourth, "75 to 100 %"),
        (|part| part >= 1.0, SKY, "always in stick"),
    ];
    let parts = parts.map(|(is_in, colour, legend)| {
        let is_in = |cell: &CellShown| cell.in_stick.is_some_and(is_in);
        layer(cells, is_in, colour, legend)
    });
    let none = |cell: &CellShown| cell.in_stick.is_none();
    let none = layer(cells, none, WHITE, "no attractor");
    parts.into_iter().chain([none]).flatten().collect()
}
