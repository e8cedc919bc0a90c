//! `stickslip basin`: which attractor each of many starts leads to.

mod edges;
mod measures;
mod pushes;
mod returns;
mod starts;

use std::num::NonZeroUsize;
use std::path::Path;

use plot::{Axis, Cells, Figure, Legend, Markers, Panel};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use stickslip::analysis::{Attractor, AttractorKind, Attractors};
use stickslip::dynamics::Vector;

use super::arguments::{RunArguments, SolverArguments, count, seed};
use super::range::{StateRange, grid, not_too_many};
use super::sweeping::{Sweep, SweepArguments, UntilArguments, sweep, table};
use super::{attractors, figures};
use crate::failure::{Failure, in_words};
use crate::render::{CommandOutput, Report, Table, state_words};
use crate::sweep::{Store, SweepError};
use edges::EdgeShown;
use measures::{Measured, Measures};
use returns::Returns;
use starts::Points;
use stickslip_model::file::System;
use stickslip_model::study::{recurrence, reported};

/// Find which attractor each of many starts in a plane leads to
///
/// Attractors are found by recurrence and need not be known before. A "recurrent" attractor returns
/// close to each of its states but does not close. It is quasi-periodic or chaotic; `lyapunov`
/// distinguishes the two. Starts that escape, fail or are undecided have rows of their own and no
/// number.
///
/// States outside the plane start at their values in the file, or at those of --start. A discrete
/// state can be in the plane, too: --y n=-0.5:1.5 with two rows of --grid takes it as 0 and as 1.
///
/// A point of an attractor is known to a millionth of the size of each state. `orbit` finds
/// periodic ones to the tolerance of the solver.
///
/// Beside the shares, boundaries and thresholds of basins can be measured: --entropy, --dimension,
/// --return-within, --push and --edges.
///
/// Writes basin.csv with all starts, attractors.csv with the shares and their standard errors, and
/// basin.svg; with the measures also uncertain.csv, pushes.csv, edges.csv and tracks.csv. Finished
/// blocks are in sweep/: after a kill, the same command resumes from them.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Range of the first coordinate of the starts; default: the first state, with its range in the
    /// file
    #[arg(long, value_name = "STATE=LOW:HIGH")]
    x: Option<String>,

    /// Range of the second coordinate; default: the second state, with its range in the file
    #[arg(long, value_name = "STATE=LOW:HIGH")]
    y: Option<String>,

    /// Numbers of cells along the coordinates; a start lies in the middle of each cell
    #[arg(long, value_name = "COLUMNSxROWS", default_value = "100x100")]
    grid: String,

    /// Number of random starts, instead of a grid
    #[arg(long, value_name = "NUMBER", value_parser = count, conflicts_with = "grid")]
    random: Option<NonZeroUsize>,

    /// Seed of random starts; default 1
    #[arg(long, value_name = "SEED", value_parser = seed)]
    seed: Option<u64>,

    #[command(flatten)]
    until: UntilArguments,

    #[command(flatten)]
    measures: Measures,

    #[command(flatten)]
    sweep: SweepArguments,
    #[command(flatten)]
    run: RunArguments,
}

pub(super) fn run(arguments: &Arguments) -> Result<CommandOutput, Failure> {
    sweep(&arguments.sweep, &arguments.run, |system| {
        Basin::new(arguments, system)
    })
}

/// Default seed.
const FIRST_SEED: u64 = 1;

/// Everything that a basin depends on, except the system.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Basin {
    /// The coordinates of the plane.
    plane: [StateRange; 2],
    /// Points in the plane.
    points: Points,
    /// Components of the starts outside the plane.
    start: Vec<f64>,
    until: f64,
    #[serde(flatten)]
    measures: Measures,
    solver: SolverArguments,
}

/// Content of a block.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct BasinBlock {
    /// Attractors of the starts in the block, in the order of first appearance.
    attractors: Vec<Attractor>,
    /// Index of each start's attractor in `attractors`.
    starts: Vec<usize>,
    /// Time to return of each start, if it is wanted.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    returns: Vec<Option<f64>>,
}

impl Basin {
    fn new(arguments: &Arguments, system: &System) -> Result<Self, Failure> {
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
                    "--start {name}=… has no effect: the starts go through {}; leave it out, or \
                     choose another plane with --x and --y",
                    range.words(system)
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
        let replaced = plane.map(|range| range.state);
        let start = arguments.run.start.at_zero(system, &replaced)?;
        let basin = Self {
            plane,
            points,
            start,
            until: arguments.until.of(system),
            measures: arguments.measures.clone(),
            solver: arguments.run.solver.clone(),
        };
        recurrence(system, basin.until).check()?;
        // A wrong option should be reported before the sweep, not by its first block.
        basin.solver.options(system)?;
        basin.measures.check(&basin.points, &basin.plane, system)?;
        Ok(basin)
    }

    /// Start state at point `index` of the plane.
    fn start(&self, index: usize) -> Vec<f64> {
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

    type Block = BasinBlock;

    fn size(&self) -> (NonZeroUsize, NonZeroUsize) {
        (self.points.blocks(), NonZeroUsize::MIN)
    }

    fn block(
        &self,
        system: &System,
        index: usize,
        _: Option<BasinBlock>,
    ) -> Result<BasinBlock, Failure> {
        let settings = recurrence(system, self.until);
        let options = self.solver.options(system)?;
        let points = self.points.of_block(index);
        let starts: Vec<Vector> = points
            .map(|point| Vector::from(self.start(point)))
            .collect();
        let of_system = |error: stickslip::Error| Failure::from(error).of(system);
        let reached = Attractor::of_all(system.dynamics(), &starts, &settings, &options);
        let reached = reached.map_err(of_system)?;
        let returns = self
            .measures
            .return_within
            .map_or(Ok(Vec::new()), |distance| {
                let each = starts.iter().zip(&reached).map(|(start, one)| {
                    one.return_time(system.dynamics(), start, distance, &settings, &options)
                });
                each.collect::<Result<Vec<_>, _>>().map_err(of_system)
            })?;
        let mut distinct = Attractors::new(system.dynamics(), &settings, &options);
        let starts = reached.into_iter().map(|one| {
            let one = reported(one, |error| in_words(error, system));
            distinct.number(one)
        });
        Ok(BasinBlock {
            starts: starts.collect(),
            attractors: distinct.into_vec(),
            returns,
        })
    }

    fn report(&self, system: &System, store: &Store, out: &Path) -> Result<Report, Failure> {
        let path = out.join("basin.csv");
        let (attractors, reached) = self.read(system, store, &path)?;
        let starts = reached.len();
        let [x, y] = self.plane.map(|range| range.words(system));
        let mut report = Report::of(system, format!("{starts} starts, {x}, {y}"));
        report.field("starts", starts).file(path);
        report.note("attractor   share  std. error  motion");
        // Attractors come first, by number; outcomes that are no attractor follow.
        let mut in_order: Vec<&OutcomeShare> = attractors.iter().collect();
        in_order.sort_by_key(|one| one.number.is_none());
        let words: Vec<String> = in_order
            .iter()
            .map(|one| attractors::words(system, &one.reached, self.until))
            .collect();
        for (one, own) in in_order.iter().zip(&words) {
            // A state tells apart what has the same words.
            let is_alone = words.iter().filter(|other| *other == own).count() == 1;
            let state = one.reached.points.first().filter(|_| !is_alone);
            let state = state.map(|at| format!(", through {}", state_words(at.x.as_slice())));
            let number = one.number.map(|number| number.to_string());
            report.note(format!(
                "{:>9}  {:.4}      {:.4}  {own}{}",
                number.as_deref().unwrap_or("none"),
                one.share,
                one.std_error,
                state.as_deref().unwrap_or_default()
            ));
            if let (Some(at), 1..) = (one.reached.points.first(), one.family()) {
                let family = attractors::family_words(one.family());
                let at = state_words(at.x.as_slice());
                report.note(format!("{:32}{family}, here the one through {at};", ""));
                report.note(format!("{:32}another family may count as this one", ""));
            }
            let returns = self.measures.return_within;
            if let Some(words) = returns.and_then(|distance| one.returns.words(distance)) {
                report.note(format!("{:32}{words}", ""));
            }
        }
        let json = |is_one: bool| -> Vec<Value> {
            let these = in_order.iter().filter(|one| one.number.is_some() == is_one);
            these.map(|one| self.json(one, system)).collect()
        };
        report
            .field("attractors", json(true))
            .field("no_attractor", json(false));
        let table = Table::new().column("attractor", |one: &&OutcomeShare| one.number);
        let table = attractors::columns(system, table, |one| &one.reached)
            .column("starts", |one| one.starts)
            .column("share", |one| one.share)
            .column("std_error", |one| one.std_error)
            .state(system, "", |one| {
                one.reached.points.first().map(|at| at.x.clone())
            })
            .column("reason", |one| attractors::reason(&one.reached));
        let table = match self.measures.return_within {
            Some(_) => table
                .column("mean_return", |one| one.returns.mean())
                .column("mean_return_error", |one| one.returns.std_error())
                .column("largest_return", |one| one.returns.largest()),
            None => table,
        };
        report.table(table.csv("attractors", in_order.iter().copied())?);
        let measured = Measured {
            system,
            settings: recurrence(system, self.until),
            options: self.solver.options(system)?,
            plane: &self.plane,
            points: self.points,
            attractors: &attractors,
            reached: &reached,
        };
        let edges = self.measures.report(&measured, &mut report)?;
        report.figure("basin", &self.figure(&attractors, &reached, &edges, system));
        Ok(report)
    }
}

/// An attractor, or an outcome that is no attractor (such as escape), with the starts that lead to
/// it.
struct OutcomeShare {
    reached: Attractor,
    /// Number of the attractor, from 1; `None` for other outcomes.
    number: Option<usize>,
    starts: usize,
    /// Fraction of all starts.
    share: f64,
    /// Standard error of the fraction: [`Points::std_error`].
    std_error: f64,
    /// Times to return of the starts, if they are wanted.
    returns: Returns,
}

impl OutcomeShare {
    /// Dimension of the family of periodic orbits that this attractor represents. The first orbit
    /// of a family represents it.
    fn family(&self) -> usize {
        self.reached.family.unwrap_or(0)
    }
}

/// Numbers the attractors from 1, in order. Other outcomes have no number.
fn numbers_of(known: &[Attractor]) -> Vec<Option<usize>> {
    let mut last = 0;
    let number = |reached: &Attractor| {
        reached.kind.is_attractor().then(|| {
            last += 1;
            last
        })
    };
    known.iter().map(number).collect()
}

impl Basin {
    /// Reads the blocks in order, identifies the attractors, and writes the table of all starts.
    /// Returns the attractors in the order of first appearance, and for each start the index of its
    /// attractor, from 0.
    fn read(
        &self,
        system: &System,
        store: &Store,
        path: &Path,
    ) -> Result<(Vec<OutcomeShare>, Vec<u32>), Failure> {
        let settings = recurrence(system, self.until);
        let options = self.solver.options(system)?;
        let mut distinct = Attractors::new(system.dynamics(), &settings, &options);
        let mut reached = Vec::new();
        let mut returns: Vec<Returns> = Vec::new();
        type Row = (Vec<f64>, Option<usize>, &'static str, Option<f64>);
        let starts = Table::new()
            .state(system, "", |(start, ..): &Row| start.clone())
            .column("attractor", |&(_, number, ..)| number)
            .column("motion", |&(_, _, word, _)| word);
        let starts = match self.measures.return_within {
            Some(_) => starts.column("return_time", |&(.., time)| time),
            None => starts,
        };
        table(store, path, &starts, |index, block: BasinBlock| {
            let found = block.attractors.into_iter();
            let numbers: Vec<usize> = found.map(|one| distinct.number(one)).collect();
            let known = distinct.all();
            let known_numbers = numbers_of(known);
            returns.resize(known.len(), Returns::default());
            let times = block.returns.into_iter().chain(std::iter::repeat(None));
            let points = self.points.of_block(index).zip(block.starts).zip(times);
            let row = |((point, local), time): ((usize, usize), Option<f64>)| {
                let attractor = *numbers.get(local).ok_or_else(|| SweepError::Block {
                    block: index,
                    source: format!("it has no attractor {local}").into(),
                })?;
                reached.push(attractor as u32);
                let word = known[attractor].kind.word();
                let start = self.start(point);
                if let Some(time) = time {
                    returns[attractor].add(&start, time);
                }
                Ok((start, known_numbers[attractor], word, time))
            };
            points.map(row).collect()
        })?;
        let known = distinct.into_vec();
        let mut starts = vec![0; known.len()];
        for &attractor in &reached {
            starts[attractor as usize] += 1;
        }
        let (numbers, all) = (numbers_of(&known), reached.len() as f64);
        let share_of = |(k, attractor): (usize, Attractor)| OutcomeShare {
            reached: attractor,
            number: numbers[k],
            starts: starts[k],
            share: starts[k] as f64 / all,
            std_error: self.points.std_error(&reached, k as u32),
            returns: returns[k].clone(),
        };
        let attractors = known.into_iter().enumerate().map(share_of).collect();
        Ok((attractors, reached))
    }

    fn json(&self, one: &OutcomeShare, system: &System) -> Value {
        let mut json = match &one.reached.kind {
            kind if kind.is_attractor() => attractors::json(&one.reached, system),
            AttractorKind::Failure(error) => {
                json!({ "motion": "failure", "first_error": error.to_string() })
            }
            AttractorKind::Undecided => json!({ "motion": "undecided", "after": self.until }),
            kind => json!({ "motion": kind.word() }),
        };
        if one.number.is_some() {
            json["family_dimension"] = json!(one.family());
        }
        json["starts"] = json!(one.starts);
        json["share"] = json!(one.share);
        json["std_error"] = json!(one.std_error);
        if let Some(distance) = self.measures.return_within {
            json["return_time"] = one.returns.json(distance);
        }
        json
    }

    /// The plane of starts, coloured by attractor.
    fn figure(
        &self,
        attractors: &[OutcomeShare],
        reached: &[u32],
        edges: &[EdgeShown],
        system: &System,
    ) -> Figure {
        let axis = |k: usize| {
            let range = &self.plane[k];
            let state = &system.file.states[range.state];
            let label = match (state.unit.as_str(), system.file.time.unit.as_deref()) {
                ("" | "1", None | Some("" | "1")) => {
                    format!("{}, dimensionless", figures::symbol(&state.name))
                }
                (unit, _) => figures::with_unit(&state.name, unit),
            };
            Axis::new(&label, range.low, range.high)
        };
        let mut panel = Panel::new(axis(0), axis(1)).legend(Legend::Below);
        let classes = figures::by_size(
            attractors,
            |one| one.starts,
            |one| one.number.is_none().then(|| one.reached.kind.word()),
            |one| self.legend(system, &one.reached, one.share),
            |rest| {
                let share: f64 = rest.iter().map(|&number| attractors[number].share).sum();
                format!("{} further attractors, {:.2} %", rest.len(), 100.0 * share)
            },
        );
        for class in &classes {
            let is_in = |number: &u32| class.kinds.contains(&(*number as usize));
            match self.points {
                Points::Grid { columns, .. } => {
                    let [x, y] = self.plane.map(|range| (range.low, range.high));
                    let set = reached.iter().map(is_in);
                    let cells = Cells::new(x, y, columns.get(), set).fill(class.colour);
                    panel.add(cells.legend(&class.legend));
                }
                Points::Random { .. } => {
                    let points = reached.iter().enumerate().filter(|one| is_in(one.1));
                    let points = points.map(|(index, _)| self.points.at(index, &self.plane).into());
                    let markers = Markers::new(points).color(class.colour).size(2.4);
                    panel.add(markers.legend(&class.legend));
                }
            }
        }
        EdgeShown::draw(edges, &mut panel);
        let title = format!("{}: basins of attraction", system.file.name);
        let shown: Vec<&str> = classes.iter().map(|class| class.legend.as_str()).collect();
        let shown = shown.join("; ");
        let description = format!("The plane of starts, coloured by where they lead: {shown}.");
        let height = 440.0 + 16.0 * classes.len() as f64;
        Figure::new("basin", (520.0, height), &title, &description).row(1.0, panel)
    }

    /// Name of an attractor in the legend.
    fn legend(&self, system: &System, reached: &Attractor, share: f64) -> String {
        let word = reached.kind.word();
        let percent = 100.0 * share;
        let AttractorKind::Periodic { period, .. } = reached.kind else {
            return format!("{}: {percent:.2} %", attractors::since(word, self.until));
        };
        let phases = system.phases(reached);
        // Long sequences would be wider than the figure.
        let phases = if phases.len() > 24 {
            format!("{} phases", reached.phases.len())
        } else {
            figures::plain(&phases)
        };
        // Plain text has the computed width in every viewer.
        let text = format!("{word}, period {period:.4}");
        let text = attractors::with_phases(text, ", ", &phases);
        format!("{text}: {percent:.2} %")
    }
}
