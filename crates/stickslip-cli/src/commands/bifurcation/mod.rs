//! `stickslip bifurcation`: attractors over one parameter, up and down.

mod diagram;
mod shares;

use std::num::NonZeroUsize;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use stickslip::analysis::{AttractorChange, SharesAt, WhatChanges};
use stickslip::error::readable;

use super::arguments::{RunArguments, SolverArguments, StartArguments, count};
use super::range::{ParameterRange, not_too_many};
use super::sweeping::{ExponentArguments, Sweep, SweepArguments, UntilArguments, blocks, sweep};
use super::{attractors, changes};
use crate::failure::{Failure, in_words};
use crate::render::{CommandOutput, Report, Table, place};
use crate::sweep::Store;
use diagram::DIRECTION_NAMES;
use shares::{Shares, SharesArguments};
use stickslip_model::file::System;
use stickslip_model::study::{AtValue, Diagram, Locates, recurrence};

/// Follow attractors along a parameter, up and down
///
/// The orbit at each value starts from the last state at the value before. The result has, for each
/// value, the points of the section, the sequence of phases, durations and lengths of stick, and
/// the largest Lyapunov exponent. If the two directions differ, there is more than one attractor.
///
/// A change of the phases is located and named by the event function that vanishes there. If none
/// vanishes, a multiplier on the unit circle names it: a fold, flip, Neimark-Sacker bifurcation or
/// branch point. Changes that keep the phases are located, too: attractors at neighbouring values
/// are compared with the tangents of their branches. An equilibrium is followed to where it loses
/// its stability, or comes to the boundary and ends or goes on in another mode. If one orbit ends
/// and the run reaches another that begins elsewhere, both places are reported.
///
/// With --shares, random starts at each value also give the shares of the basins of all attractors,
/// in shares.csv and shares.svg. An attractor keeps its band along the parameter if orbits from it
/// lead to it at the next value, and back.
///
/// Writes bifurcation.csv, sticks.csv, changes.csv and bifurcation.svg. In changes.csv `before` and
/// `after` are the phases of the orbit that is followed through the change. If that orbit is
/// unstable after the change, the attractor there is another one; bifurcation.csv has its phases.
/// Finished blocks are in sweep/: after a kill, the same command resumes from them.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The parameter and its range
    #[arg(long, value_name = "NAME=LOW:HIGH")]
    parameter: String,

    /// Number of values, including both ends
    #[arg(long, value_name = "NUMBER", value_parser = count, default_value = "201")]
    values: NonZeroUsize,

    /// Changes that are located
    #[arg(long, value_name = "WHICH", value_enum, default_value_t)]
    locate: Locate,

    #[command(flatten)]
    shares: SharesArguments,

    #[command(flatten)]
    until: UntilArguments,

    #[command(flatten)]
    exponent: ExponentArguments,

    #[command(flatten)]
    sweep: SweepArguments,
    #[command(flatten)]
    run: RunArguments,
}

/// Selection of the changes that are located.
#[derive(Clone, Copy, Debug, Default, clap::ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Locate {
    /// Every orbit is followed, however long it takes
    All,
    /// Orbits of few loops are followed, in about as many integration steps as the attractors take,
    /// and 1000000 more
    #[default]
    Periodic,
    /// No orbit is followed
    None,
}

impl From<Locate> for Locates {
    fn from(which: Locate) -> Locates {
        match which {
            Locate::All => Locates::All,
            Locate::Periodic => Locates::Periodic,
            Locate::None => Locates::Nothing,
        }
    }
}

pub(super) fn run(arguments: &Arguments) -> Result<CommandOutput, Failure> {
    sweep(&arguments.sweep, &arguments.run, |system| {
        Bifurcation::new(arguments, system)
    })
}

/// Number of parameter values in a block.
const IN_BLOCK: usize = 10;

/// A pass through the range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Pass {
    Up,
    Down,
    /// Upwards, with many starts at each value.
    Shares,
}

/// Everything that a diagram depends on, except the system.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Bifurcation {
    parameter: ParameterRange,
    values: NonZeroUsize,
    start: StartArguments,
    locate: Locate,
    /// Time after which an orbit counts as undecided.
    until: f64,
    duration: f64,
    /// Random starts at each value, if shares are wanted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    shares: Option<Shares>,
    solver: SolverArguments,
}

/// Content of a block.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct DiagramBlock {
    found: Vec<AtValue>,
    /// Changes from each value to the next. The first begins at the last value of the block before.
    changes: Vec<AttractorChange>,
    /// Shares at each value, in blocks of the pass that computes them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    shares: Vec<SharesAt>,
}

impl Bifurcation {
    fn new(arguments: &Arguments, system: &System) -> Result<Self, Failure> {
        let diagram = Self {
            parameter: ParameterRange::new("--parameter", &arguments.parameter, system)?,
            values: arguments.values,
            start: arguments.run.start.clone(),
            locate: arguments.locate,
            until: arguments.until.of(system),
            duration: arguments.exponent.of(system)?,
            shares: Shares::new(&arguments.shares, system)?,
            solver: arguments.run.solver.clone(),
        };
        // Errors should be reported before the sweep, not by one of its blocks.
        if diagram.values.get() < 2 {
            return Err(Failure::Usage(
                "--values 1: a diagram has at least 2 values".into(),
            ));
        }
        let values = diagram.values.get();
        not_too_many(&format!("--values {values}"), Some(values))?;
        diagram.solver.options(system)?;
        for value in [diagram.parameter.low, diagram.parameter.high] {
            let system = diagram.parameter.system(system, value)?;
            recurrence(&system, diagram.until).check()?;
            diagram.start.at_zero(&system, &[])?;
        }
        Ok(diagram)
    }

    /// Number of blocks of one pass.
    fn blocks(&self) -> NonZeroUsize {
        blocks(self.values, IN_BLOCK)
    }

    /// The pass to which a block belongs.
    fn pass(&self, block: usize) -> Pass {
        match block / self.blocks().get() {
            0 => Pass::Up,
            1 => Pass::Down,
            _ => Pass::Shares,
        }
    }

    /// Parameter values of a block, in the order of the pass.
    fn values_of(&self, block: usize) -> impl Iterator<Item = f64> + '_ {
        let number = self.values.get();
        let first = block % self.blocks().get() * IN_BLOCK;
        let is_down = self.pass(block) == Pass::Down;
        (first..(first + IN_BLOCK).min(number)).map(move |k| {
            let k = if is_down { number - 1 - k } else { k };
            self.parameter.at(k as f64 / (number - 1) as f64)
        })
    }
}

impl Sweep for Bifurcation {
    const COMMAND: &'static str = "bifurcation";

    type Block = DiagramBlock;

    fn size(&self) -> (NonZeroUsize, NonZeroUsize) {
        let passes = if self.shares.is_some() { 3 } else { 2 };
        (NonZeroUsize::MIN.saturating_add(passes - 1), self.blocks())
    }

    fn block(
        &self,
        system: &System,
        index: usize,
        before: Option<DiagramBlock>,
    ) -> Result<DiagramBlock, Failure> {
        if let (Pass::Shares, Some(shares)) = (self.pass(index), &self.shares) {
            let before = before.and_then(|mut before| before.shares.pop());
            return self.block_of_shares(shares, system, index, before);
        }
        let options = self.solver.options(system)?;
        let last = before.and_then(|mut before| before.found.pop());
        let diagram = Diagram {
            system,
            parameter: &self.parameter.name,
            until: self.until,
            duration: Some(self.duration),
            locates: self.locate.into(),
            values: self.values.get() as u64,
            options: &options,
        };
        let (mut found, mut changes) = (Vec::new(), Vec::new());
        for value in self.values_of(index) {
            let start = |here: &System| self.start.at_zero(here, &[]);
            let at = diagram.at(value, found.last().or(last.as_ref()), start, &in_words);
            let (at, between) = at.map_err(|error: Failure| error.of(system))?;
            found.push(at);
            changes.extend(between);
        }
        Ok(DiagramBlock {
            found,
            changes,
            shares: Vec::new(),
        })
    }

    fn report(&self, system: &System, store: &Store, out: &Path) -> Result<Report, Failure> {
        let paths = ["bifurcation.csv", "sticks.csv"].map(|name| out.join(name));
        let directions = self.read(system, store, &paths)?;
        let range = &self.parameter;
        let (values, name) = (self.values, &range.name);
        let what = format!("{values} values of {}, up and down", range.words());
        let mut report = Report::of(system, what);
        for (name, way) in DIRECTION_NAMES.into_iter().zip(&directions) {
            for span in &way.spans {
                let [first, last] = [span.values.0, span.values.1].map(readable);
                let motion = attractors::since(&span.class, self.until);
                let reason = span.reason.as_ref();
                let reason = reason.map_or(String::new(), |why| format!(", first as {why}"));
                report.note(format!("{name:<4}  {first} to {last}: {motion}{reason}"));
            }
            let mut flip = None;
            for AttractorChange { between, what } in &way.changes {
                flip = changes::period_of_flip(what).or(flip);
                let at = match what.parameter() {
                    Some(value) => {
                        let uncertainty = what.uncertainty().unwrap_or(0.0);
                        format!("at {}", place(value, uncertainty))
                    }
                    None => format!(
                        "between {} and {}",
                        readable(between.0),
                        readable(between.1)
                    ),
                };
                let words = match (what, changes::sequence(what)) {
                    (_, Some(change)) => changes::words(system, change),
                    (WhatChanges::NotFollowed(_), _) if way.is_doubled(between.0, flip) => {
                        format!("{what}, behind a flip: further flips may follow up to there")
                    }
                    _ => what.to_string(),
                };
                report.note(format!("{name:<4}  {at}: {words}"));
            }
            let is_left_out = |at: &AttractorChange| matches!(at.what, WhatChanges::NotFollowed(_));
            if way.changes.iter().any(is_left_out) {
                report.note(format!(
                    "{name:<4}  `--locate all` follows what was not followed, however long it takes"
                ));
            }
            for one in &way.replacements {
                let between = way.changes.iter().filter(|at| at.between == one.values);
                let between: Vec<_> = between.map(|at| &at.what).collect();
                if changes::lose_attractor(system, &between, &one.class) {
                    let [from, to] = [one.values.0, one.values.1].map(readable);
                    report.note(format!(
                        "{name:<4}  between {from} and {to}: lost {}; reached {}",
                        one.lost, one.reached
                    ));
                }
            }
            let spans = way.spans.iter().map(|span| {
                let (from, to) = span.values;
                json!({ "from": from, "to": to, "motion": span.class, "reason": span.reason })
            });
            let changes = way.changes.iter().map(|AttractorChange { between, what }| {
                json!({ "values": between, "change": changes::json(system, what) })
            });
            let [spans, changes] = [spans.collect::<Value>(), changes.collect()];
            report.field(name, json!({ "motions": spans, "changes": changes }));
        }
        for path in paths {
            report.file(path);
        }
        type Row<'a> = (&'static str, &'a AttractorChange);
        let sequence = |(_, at): &Row<'_>| changes::sequence(&at.what).cloned();
        let phases = |k: usize| {
            move |row: &Row<'_>| Some(changes::phases(system, &sequence(row)?)[k].clone())
        };
        let table = Table::new()
            .column("way", |(name, _): &Row<'_>| *name)
            .column(name, |(_, at)| at.what.parameter())
            .column("from", |(_, at)| at.between.0)
            .column("to", |(_, at)| at.between.1)
            .column("what", |(_, at)| at.what.to_string())
            .column("contacts", |row| {
                sequence(row).map(|change| system.contact_names(&change.contacts))
            })
            .column("uncertainty", |(_, at)| at.what.uncertainty())
            .column("criticality", |(_, at)| {
                at.what.criticality().map(|side| side.to_string())
            })
            .column("before", phases(0))
            .column("after", phases(1))
            .state(system, "", |(_, at)| at.what.state().cloned());
        let rows = DIRECTION_NAMES.into_iter().zip(&directions);
        let rows = rows.flat_map(|(name, way)| way.changes.iter().map(move |at| (name, at)));
        report.table(table.csv("changes", rows)?);
        report.figure("bifurcation", &self.figure(&directions, system));
        if let Some(shares) = &self.shares {
            self.report_shares(shares, system, store, &mut report)?;
        }
        Ok(report)
    }
}
