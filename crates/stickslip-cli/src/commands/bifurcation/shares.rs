//! Shares of basins along the parameter.

use std::num::NonZeroUsize;
use std::ops::ControlFlow;

use numerics::SplitMix;
use plot::{Axis, Figure, Legend, Panel, Region};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use stickslip::analysis::{Attractor, SharesAt};
use stickslip::dynamics::Vector;
use stickslip::error::readable;

use super::{Bifurcation, DiagramBlock};
use crate::commands::arguments::{count, seed};
use crate::commands::range::{StateRange, not_too_many};
use crate::commands::sweeping::from_content;
use crate::commands::{attractors, figures};
use crate::failure::{Failure, in_words};
use crate::render::{Report, Table};
use crate::sweep::{Store, SweepError};
use stickslip_model::file::System;
use stickslip_model::study::{recurrence, reported};

/// Default seed.
const FIRST_SEED: u64 = 1;

/// Options of the shares.
#[derive(Debug, clap::Args)]
pub(super) struct SharesArguments {
    /// Number of random starts at each value, whose attractors give the shares of the basins
    #[arg(long, value_name = "STARTS", value_parser = count)]
    shares: Option<NonZeroUsize>,

    /// Range of a state of these starts; can be repeated. Default: each state with a range in the
    /// file; other states start at their own values
    #[arg(long, value_name = "STATE=LOW:HIGH", requires = "shares")]
    over: Vec<String>,

    /// Seed of these starts, which are the same at all values; default 1
    #[arg(long, value_name = "SEED", value_parser = seed, requires = "shares")]
    seed: Option<u64>,
}

/// Random starts at each value.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Shares {
    starts: NonZeroUsize,
    over: Vec<StateRange>,
    seed: u64,
}

impl Shares {
    pub(super) fn new(given: &SharesArguments, system: &System) -> Result<Option<Self>, Failure> {
        let Some(starts) = given.shares else {
            return Ok(None);
        };
        not_too_many(&format!("--shares {starts}"), Some(starts.get()))?;
        let over = match given.over.as_slice() {
            [] => StateRange::of_file(system),
            texts => texts
                .iter()
                .map(|text| StateRange::new("--over", Some(text), 0, system))
                .collect::<Result<_, _>>()?,
        };
        let names = |state: usize| &system.file.states[state].name;
        let twice =
            (1..over.len()).find(|&k| over[..k].iter().any(|one| one.state == over[k].state));
        if let Some(k) = twice {
            let name = names(over[k].state);
            return Err(Failure::Usage(format!(
                "--over {name} is given twice; give it once"
            )));
        }
        if over.is_empty() {
            return Err(Failure::Usage(
                "--shares: no state has a range in the file; give the region of starts, as in \
                 --over x=-1:1 --over v=-1:1"
                    .to_owned(),
            ));
        }
        Ok(Some(Self {
            starts,
            over,
            seed: given.seed.unwrap_or(FIRST_SEED),
        }))
    }

    /// The states that are drawn.
    fn replaced(&self) -> Vec<usize> {
        self.over.iter().map(|range| range.state).collect()
    }

    /// The starts, from one that has the other states.
    fn of(&self, start: &[f64]) -> Vec<Vector> {
        let random = &mut SplitMix::new(self.seed);
        let starts = (0..self.starts.get()).map(|_| {
            let mut start = start.to_vec();
            for range in &self.over {
                start[range.state] = range.at(random.uniform());
            }
            Vector::from(start)
        });
        starts.collect()
    }

    fn words(&self, system: &System) -> String {
        let over: Vec<String> = self.over.iter().map(|range| range.words(system)).collect();
        format!("{} random starts, {}", self.starts, over.join(", "))
    }
}

/// An attractor along the parameter.
struct Band {
    /// The attractor at its first value.
    first: Attractor,
    /// First and last value.
    values: (f64, f64),
    /// Number from 1, if it is an attractor.
    number: Option<usize>,
    /// Share at each value, and its standard error; 0 where it is not there.
    shares: Vec<(f64, f64)>,
}

impl Band {
    fn sum(&self) -> f64 {
        self.shares.iter().map(|share| share.0).sum()
    }

    /// Least and largest share from the first value to the last.
    fn extremes(&self, values: &[f64]) -> (f64, f64) {
        let (first, last) = self.values;
        let here = values.iter().zip(&self.shares);
        let here = here.filter(|(value, _)| (first..=last).contains(value));
        figures::extremes(here.map(|(_, share)| share.0))
    }
}

impl Bifurcation {
    /// The shares at the values of a block. Attractors go on from the last value of the block
    /// before.
    pub(super) fn block_of_shares(
        &self,
        shares: &Shares,
        system: &System,
        index: usize,
        before: Option<SharesAt>,
    ) -> Result<DiagramBlock, Failure> {
        let options = self.solver.options(system)?;
        let mut last = before
            .map(|before| {
                let there = self.parameter.system(system, before.parameter)?;
                Ok::<_, Failure>((there, before))
            })
            .transpose()?;
        let mut all = Vec::new();
        for value in self.values_of(index) {
            let here = self.parameter.system(system, value)?;
            let starts = shares.of(&self.start.at_zero(&here, &shares.replaced())?);
            let settings = recurrence(&here, self.until);
            let earlier = last
                .as_ref()
                .map(|(there, before)| (there.dynamics(), before));
            let found = SharesAt::of(
                here.dynamics(),
                value,
                starts,
                earlier,
                (&settings, &options),
                || ControlFlow::Continue(()),
            );
            let found = found.map_err(|error| Failure::from(error).of(&here))?;
            let Some(mut found) = found else { break };
            let reported = |one| reported(one, |error| in_words(error, &here));
            found.attractors = found.attractors.into_iter().map(reported).collect();
            all.push(found.clone());
            last = Some((here, found));
        }
        Ok(DiagramBlock {
            found: Vec::new(),
            changes: Vec::new(),
            shares: all,
        })
    }

    /// Reads the shares, reports them, and writes their table and figure.
    pub(super) fn report_shares(
        &self,
        shares: &Shares,
        system: &System,
        store: &Store,
        report: &mut Report,
    ) -> Result<(), Failure> {
        let mut all: Vec<SharesAt> = Vec::new();
        store.for_each(|block, content| {
            let held: Result<DiagramBlock, _> = from_content(content);
            let held = held.map_err(|source| SweepError::Block { block, source })?;
            all.extend(held.shares);
            Ok::<_, Failure>(())
        })?;
        let bands = bands(&all);
        let values: Vec<f64> = all.iter().map(|at| at.parameter).collect();
        report.note(format!("shares of basins: {}", shares.words(system)));
        for band in &bands {
            let (first, last) = band.values;
            let (least, most) = band.extremes(&values);
            let name = match band.number {
                Some(number) => format!("band {number}"),
                None => "no attractor".to_owned(),
            };
            report.note(format!(
                "{name}, {} to {}: {least:.4} to {most:.4}, {}",
                readable(first),
                readable(last),
                attractors::since(&system.class(&band.first), self.until)
            ));
        }
        let json = bands.iter().map(|band| {
            let of_values = all.iter().zip(&band.shares).map(|(at, (share, error))| {
                json!({ "value": at.parameter, "share": share, "std_error": error })
            });
            json!({
                "band": band.number,
                "motion": system.class(&band.first),
                "from": band.values.0,
                "to": band.values.1,
                "shares": of_values.collect::<Value>(),
            })
        });
        report.field("shares", json.collect::<Value>());
        type Row<'r> = (&'r SharesAt, usize);
        fn reached<'r>(row: &Row<'r>) -> &'r Attractor {
            &row.0.attractors[row.1]
        }
        let table = Table::new()
            .column(&self.parameter.name, |row: &Row<'_>| row.0.parameter)
            .column("band", |row| bands[row.0.bands[row.1]].number);
        let table = table
            .column("motion", |row| reached(row).kind.word())
            .column("phases", |row| system.phases(reached(row)))
            .column("starts", |row| row.0.starts[row.1])
            .column("share", |row| row.0.share(row.1).part)
            .column("std_error", |row| row.0.share(row.1).std_error)
            .state(system, "", |row| {
                reached(row).points.first().map(|at| at.x.clone())
            })
            .column("reason", |row| attractors::reason(reached(row)));
        let rows = all
            .iter()
            .flat_map(|at| (0..at.attractors.len()).map(move |number| (at, number)));
        report.table(table.csv("shares", rows)?);
        report.figure("shares", &self.figure_of_shares(&bands, &values, system));
        Ok(())
    }

    /// Stacked bands of the shares.
    fn figure_of_shares(&self, bands: &[Band], values: &[f64], system: &System) -> Figure {
        let range = &self.parameter;
        let axis = figures::parameter_axis(system, &range.name, (range.low, range.high), true);
        let mut panel = Panel::new(axis, Axis::new("share of starts", 0.0, 1.0));
        let classes = figures::by_size(
            bands,
            |band| (1e6 * band.sum()) as usize,
            |band| band.number.is_none().then(|| band.first.kind.word()),
            |band| match band.number {
                Some(number) => figures::plain(&format!("{number}: {}", system.class(&band.first))),
                None => attractors::since(band.first.kind.word(), self.until),
            },
            |rest| format!("{} further attractors", rest.len()),
        );
        let mut below = vec![0.0; values.len()];
        for class in &classes {
            let share = |k: usize| {
                class
                    .kinds
                    .iter()
                    .map(|&kind| bands[kind].shares[k].0)
                    .sum()
            };
            let shares = (0..values.len()).map(share);
            let above: Vec<f64> = below
                .iter()
                .zip(shares)
                .map(|(at, own): (_, f64)| at + own)
                .collect();
            let curve = |heights: &[f64]| -> Vec<(f64, f64)> {
                values
                    .iter()
                    .copied()
                    .zip(heights.iter().copied())
                    .collect()
            };
            let region = Region::between(curve(&below), curve(&above));
            panel.add(region.fill(class.colour).legend(&class.legend));
            below = above;
        }
        let panel = panel.legend(Legend::Below);
        let title = format!("{}: shares of basins", system.file.name);
        let legends: Vec<&str> = classes.iter().map(|class| class.legend.as_str()).collect();
        let description = format!(
            "Shares of random starts that lead to each attractor, stacked, over {} from {} to {}: \
             {}.",
            range.name,
            range.low,
            range.high,
            legends.join("; ")
        );
        let height = 300.0 + 16.0 * classes.len() as f64;
        Figure::new("shares", (640.0, height), &title, &description).row(1.0, panel)
    }
}

/// The bands, in the order of their first values.
fn bands(all: &[SharesAt]) -> Vec<Band> {
    let mut bands: Vec<Band> = Vec::new();
    let mut last = 0;
    for (k, at) in all.iter().enumerate() {
        for (number, (&band, attractor)) in at.bands.iter().zip(&at.attractors).enumerate() {
            // New bands of a value come in order.
            if band == bands.len() {
                let number = attractor.kind.is_attractor().then(|| {
                    last += 1;
                    last
                });
                bands.push(Band {
                    first: attractor.clone(),
                    values: (at.parameter, at.parameter),
                    number,
                    shares: vec![(0.0, 0.0); all.len()],
                });
            }
            if let Some(one) = bands.get_mut(band) {
                let share = at.share(number);
                one.values.1 = at.parameter;
                one.shares[k] = (share.part, share.std_error);
            }
        }
    }
    bands
}
