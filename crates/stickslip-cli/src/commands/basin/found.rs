//! What a basin has shown: attractors and shares, as tables and words.

use std::fmt::Write;
use std::path::PathBuf;

use serde_json::json;
use stickslip::Options;
use stickslip::analysis::RecurrenceSettings;

use super::super::arguments::OutputArguments;
use super::super::sweeping::for_each;
use super::super::{Failure, attractors, tables};
use super::figure;
use super::request::{Basin, Reached};
use crate::output::{Artifact, OutputError, csv_table};
use crate::sweep::{Store, SweepError, write_whole};
use crate::terminal::Said;
use stickslip_kernels::file::System;
use stickslip_kernels::kernel::{Motion, Outcome};

/// An attractor and the starts that lead to it; or the starts that lead to none in one way, as by escape.
pub(super) struct Attracting {
    pub(super) outcome: Outcome,
    /// Dimension of the family of periodic orbits of which this is the one that was met first.
    family: usize,
    /// Which attractor it is, from 1; none where it is none.
    pub(super) number: Option<usize>,
    pub(super) starts: usize,
    /// Part of all starts.
    pub(super) share: f64,
    /// Standard error of that part, of starts drawn at random.
    pub(super) std_error: f64,
}

/// Everything found.
pub(super) struct Found {
    /// In the order in which starts lead to them first.
    pub(super) attractors: Vec<Attracting>,
    /// For each start, which of these, from 0.
    pub(super) reached: Vec<u32>,
    table: PathBuf,
}

/// The number of an attractor among those known; it is added if it is new.
pub(super) fn number(
    known: &mut Vec<Outcome>,
    mut outcome: Outcome,
    system: &System,
    settings: &RecurrenceSettings,
    options: &Options,
) -> usize {
    let kernel = system.kernel();
    let same = |one: &Outcome| kernel.is_same_attractor(one, &outcome, settings, options);
    match known.iter().position(same) {
        Some(number) => number,
        None => {
            // Once: each further orbit is compared with it.
            outcome.family = Some(kernel.family(&outcome, settings, options));
            known.push(outcome);
            known.len() - 1
        }
    }
}

/// The attractors' numbers from 1, in their order; what is none has none.
fn numbers_of(known: &[Outcome]) -> Vec<Option<usize>> {
    let mut last = 0;
    let number = |outcome: &Outcome| {
        attractors::is_attractor(&outcome.motion).then(|| {
            last += 1;
            last
        })
    };
    known.iter().map(number).collect()
}

/// A number in a table, empty where there is none.
fn shown(number: Option<usize>) -> String {
    number.map_or_else(String::new, |number| number.to_string())
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
        let options = basin.solver.options()?;
        let (mut known, mut reached) = (Vec::new(), Vec::new());
        let table = PathBuf::from(&output.out).join("basin.csv");
        let names = system.file.states.iter().map(|state| state.name.clone());
        let columns = ["attractor", "motion"].map(str::to_owned);
        let heading: Vec<String> = names.chain(columns).collect();
        write_whole(&table, &store.staging()?, |file| {
            let mut rows = csv::Writer::from_writer(file);
            rows.write_record(&heading).map_err(OutputError::from)?;
            for_each(store, |index, block: Reached| {
                let numbers: Vec<usize> = block
                    .attractors
                    .into_iter()
                    .map(|outcome| number(&mut known, outcome, system, &settings, &options))
                    .collect();
                let known_numbers = numbers_of(&known);
                for (point, local) in basin.points.of_block(index).zip(block.starts) {
                    let attractor = *numbers.get(local).ok_or_else(|| SweepError::Block {
                        block: index,
                        source: format!("it has no attractor {local}").into(),
                    })?;
                    let start = basin.start(point);
                    let fields = start.iter().map(|&value| tables::exact(value));
                    let word = known[attractor].motion.word().to_owned();
                    let record = fields.chain([shown(known_numbers[attractor]), word]);
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
        let numbers = numbers_of(&known);
        let attractors = known.into_iter().zip(numbers).enumerate();
        let attractors = attractors.map(|(index, (outcome, number))| {
            let starts = reached.iter().filter(|one| **one as usize == index);
            let starts = starts.count();
            let share = starts as f64 / all as f64;
            Attracting {
                family: outcome.family.unwrap_or(0),
                outcome,
                number,
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
        store: &Store,
        output: &OutputArguments,
    ) -> Result<Said, Failure> {
        let found = super::super::Found {
            summary: self.summary(basin, system),
            json: self.json(basin, system),
            tables: vec![self.attractors_table(system)?],
            figures: vec![("basin".to_owned(), figure::basin(&self, basin, system)?)],
            failure: None,
        };
        found.written_besides(vec![self.table], &store.staging()?, output)
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
        let rows = self.in_order().map(|one| {
            let mut row = vec![shown(one.number)];
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
        for one in self.in_order() {
            let _ = writeln!(
                text,
                "  {:>9}  {:.4}      {:.4}  {}",
                one.number
                    .map_or_else(|| "none".to_owned(), |number| number.to_string()),
                one.share,
                one.std_error,
                attractors::words(&one.outcome, basin.until)
            );
            if one.family > 0
                && let Some((_, x)) = one.outcome.points.first()
            {
                let (family, at) = (
                    attractors::family_words(one.family),
                    attractors::state_words(x),
                );
                let _ = writeln!(text, "{:34}{family}, here the one through {at}", "");
            }
        }
        text
    }

    /// The attractors by number, and behind them what is none.
    fn in_order(&self) -> impl Iterator<Item = &Attracting> {
        let of = |is_numbered: bool| {
            let all = self.attractors.iter();
            all.filter(move |one| one.number.is_some() == is_numbered)
        };
        of(true).chain(of(false))
    }

    fn json(&self, basin: &Basin, system: &System) -> serde_json::Value {
        let told = |one: &Attracting| {
            let mut json = match &one.outcome.motion {
                motion if attractors::is_attractor(motion) => {
                    attractors::json(&one.outcome, system)
                }
                Motion::Failure(error) => json!({ "motion": "failure", "first_error": error }),
                Motion::Undecided => json!({ "motion": "undecided", "after": basin.until }),
                motion => json!({ "motion": motion.word() }),
            };
            if let Some(object) = json.as_object_mut() {
                if one.number.is_some() {
                    object.insert("family_dimension".to_owned(), json!(one.family));
                }
                object.insert("starts".to_owned(), json!(one.starts));
                object.insert("share".to_owned(), json!(one.share));
                object.insert("std_error".to_owned(), json!(one.std_error));
            }
            json
        };
        let (found, none): (Vec<&Attracting>, Vec<&Attracting>) =
            self.in_order().partition(|one| one.number.is_some());
        let [attractors, none] =
            [found, none].map(|these| these.into_iter().map(told).collect::<Vec<_>>());
        json!({
            "system": tables::system_json(system),
            "starts": self.reached.len(),
            "arguments": basin,
            "attractors": attractors,
            "no_attractor": none,
        })
    }
}
