//! What a basin has shown: attractors and shares, as tables and words.

use std::fmt::Write;
use std::path::PathBuf;

use serde_json::json;
use stickslip::analysis::RecurrenceSettings;

use super::super::arguments::OutputArguments;
use super::super::{Failure, attractors, tables};
use super::figure;
use super::request::{Basin, Reached};
use crate::output::{Artifact, OutputError, csv_table};
use crate::sweep::{BlockError, Store, SweepError, write_whole};
use crate::system::System;
use crate::terminal::Said;
use stickslip_kernels::kernel::Outcome;

/// An attractor and the starts that lead to it.
pub(super) struct Attracting {
    pub(super) outcome: Outcome,
    pub(super) starts: usize,
    /// Part of all starts.
    pub(super) share: f64,
    /// Standard error of that part, of starts drawn at random.
    pub(super) std_error: f64,
}

/// Everything found.
pub(super) struct Found {
    pub(super) attractors: Vec<Attracting>,
    /// For each start, the number of its attractor, from 0.
    pub(super) reached: Vec<u32>,
    table: PathBuf,
}

/// The number of an attractor among those known; it is added if it is new.
pub(super) fn number(
    known: &mut Vec<Outcome>,
    outcome: Outcome,
    system: &System,
    settings: &RecurrenceSettings,
) -> usize {
    let kernel = system.kernel();
    let same = |one: &Outcome| kernel.is_same_attractor(one, &outcome, settings);
    match known.iter().position(same) {
        Some(number) => number,
        None => {
            known.push(outcome);
            known.len() - 1
        }
    }
}

impl Found {
    /// Reads the blocks one after the other, tells their attractors apart, and writes the table of all starts.
    pub(super) fn read(
        basin: &Basin,
        system: &System,
        store: &Store,
        output: &OutputArguments,
    ) -> Result<Self, Failure> {
        let settings = basin.settings(system);
        let (mut known, mut reached) = (Vec::new(), Vec::new());
        let table = PathBuf::from(&output.out).join("basin.csv");
        let names = system.file.states.iter().map(|state| state.name.clone());
        let heading: Vec<String> = names.chain(["attractor".to_owned()]).collect();
        write_whole(&table, |file| {
            let mut rows = csv::Writer::from_writer(file);
            rows.write_record(&heading).map_err(OutputError::from)?;
            store.for_each(|index, content| {
                let wrong = |source: BlockError| SweepError::Block {
                    block: index,
                    source,
                };
                let block: Reached =
                    serde_json::from_slice(content).map_err(|error| wrong(error.into()))?;
                let numbers: Vec<usize> = block
                    .attractors
                    .into_iter()
                    .map(|outcome| number(&mut known, outcome, system, &settings))
                    .collect();
                for (point, local) in basin.points.of_block(index).zip(block.starts) {
                    let attractor = *numbers
                        .get(local)
                        .ok_or_else(|| wrong(format!("it has no attractor {local}").into()))?;
                    let start = basin.start(point);
                    let fields = start.iter().map(|&value| tables::exact(value));
                    let record = fields.chain([(attractor + 1).to_string()]);
                    rows.write_record(record).map_err(OutputError::from)?;
                    reached.push(attractor as u32);
                }
                Ok::<_, Failure>(())
            })?;
            rows.flush()
                .map_err(|error| OutputError::from(csv::Error::from(error)))?;
            Ok::<_, Failure>(())
        })?;
        let all = reached.len();
        let attractors = known.into_iter().enumerate().map(|(number, outcome)| {
            let starts = reached.iter().filter(|one| **one as usize == number);
            let starts = starts.count();
            let share = starts as f64 / all as f64;
            Attracting {
                outcome,
                starts,
                share,
                std_error: (share * (1.0 - share) / all as f64).sqrt(),
            }
        });
        Ok(Self {
            attractors: attractors.collect(),
            reached,
            table,
        })
    }

    /// Writes the other files and says what was found.
    pub(super) fn written(
        self,
        basin: &Basin,
        system: &System,
        output: &OutputArguments,
    ) -> Result<Said, Failure> {
        let found = super::super::Found {
            summary: self.summary(basin, system),
            json: self.json(basin, system),
            tables: vec![self.attractors_table(system)?],
            figures: vec![("basin".to_owned(), figure::basin(&self, basin, system)?)],
            failure: None,
        };
        found.written_besides(vec![self.table], output)
    }

    fn attractors_table(&self, system: &System) -> Result<Artifact, Failure> {
        let columns = [
            "attractor",
            "motion",
            "period",
            "returns",
            "phases",
            "in_stick",
        ];
        let columns = columns.into_iter().chain(["starts", "share", "std_error"]);
        let states = system.file.states.iter().map(|state| state.name.clone());
        let heading: Vec<String> = columns.map(str::to_owned).chain(states).collect();
        let rows = self.attractors.iter().enumerate().map(|(number, one)| {
            let mut row = vec![(number + 1).to_string()];
            row.extend(attractors::fields(&one.outcome));
            row.push(one.starts.to_string());
            row.extend([one.share, one.std_error].map(tables::exact));
            match one.outcome.points.first() {
                Some((_, x)) => row.extend(x.iter().map(|&value| tables::exact(value))),
                None => row.extend(vec![String::new(); system.states()]),
            }
            row
        });
        Ok(csv_table("attractors.csv", &heading, rows)?)
    }

    fn summary(&self, basin: &Basin, system: &System) -> String {
        let starts = self.reached.len();
        let range = |k: usize| {
            let range = &basin.plane[k];
            let name = &system.file.states[range.state].name;
            format!("{name} from {} to {}", range.low, range.high)
        };
        let mut text = format!(
            "{}: {starts} starts, {}, {}\n",
            system.file.name,
            range(0),
            range(1)
        );
        // Writing into a text cannot fail.
        let _ = writeln!(text, "  attractor   share  std. error  motion");
        for (number, one) in self.attractors.iter().enumerate() {
            let _ = writeln!(
                text,
                "  {:>9}  {:.4}      {:.4}  {}",
                number + 1,
                one.share,
                one.std_error,
                attractors::words(&one.outcome)
            );
        }
        text
    }

    fn json(&self, basin: &Basin, system: &System) -> serde_json::Value {
        let attractors = self.attractors.iter().map(|one| {
            let mut json = attractors::json(&one.outcome, system);
            if let Some(object) = json.as_object_mut() {
                object.insert("starts".to_owned(), json!(one.starts));
                object.insert("share".to_owned(), json!(one.share));
                object.insert("std_error".to_owned(), json!(one.std_error));
            }
            json
        });
        let attractors: Vec<serde_json::Value> = attractors.collect();
        json!({
            "system": tables::system_json(system),
            "starts": self.reached.len(),
            "arguments": basin,
            "attractors": attractors,
        })
    }
}
