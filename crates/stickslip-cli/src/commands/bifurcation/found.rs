//! What a bifurcation diagram has shown, as tables and in words.

use std::fmt::Write;
use std::io;
use std::path::{Path, PathBuf};

use serde_json::json;
use stickslip::Mode;
use stickslip_kernels::kernel::{Change, Motion};

use super::super::arguments::OutputArguments;
use super::super::exponent::Largest;
use super::super::sweeping::for_each;
use super::super::{Failure, attractors, tables};
use super::figure;
use super::request::{At, Between, Bifurcation, Part};
use crate::output::{Artifact, OutputError, csv_table};
use crate::sweep::{Store, write_whole};
use crate::terminal::Said;
use stickslip_kernels::file::System;

/// What the figure shows of one way through the range, as points of parameter and value.
#[derive(Default)]
pub(super) struct Way {
    /// First state at the points of the section.
    pub(super) section: Vec<(f64, f64)>,
    /// Durations of sticks.
    pub(super) sticks: Vec<(f64, f64)>,
    /// Largest exponents.
    pub(super) exponents: Vec<(f64, f64)>,
    /// What changes on the way, and between which values.
    pub(super) changes: Vec<Between>,
    /// Values between which the motion stays the same, in the order of the way, and what it is.
    spans: Vec<(f64, f64, String)>,
}

/// Everything found.
pub(super) struct Found {
    pub(super) up: Way,
    pub(super) down: Way,
    files: Vec<PathBuf>,
}

type Rows<'a> = csv::Writer<&'a mut dyn io::Write>;

impl Found {
    /// Reads the blocks one after the other and writes the tables.
    pub(super) fn read(
        diagram: &Bifurcation,
        system: &System,
        store: &Store,
        output: &OutputArguments,
    ) -> Result<Self, Failure> {
        let folder = Path::new(&output.out);
        let mut found = Self {
            up: Way::default(),
            down: Way::default(),
            files: vec![folder.join("bifurcation.csv"), folder.join("sticks.csv")],
        };
        let states = system.file.states.iter().map(|state| state.name.clone());
        let states: Vec<String> = states.collect();
        let parameter = diagram.parameter.name.as_str();

        let columns = [
            "motion", "period", "returns", "phases", "in_stick", "lambda1",
        ];
        let mut heading = tables::strings(&["way", parameter]);
        heading.extend(tables::strings(&columns));
        heading.extend(tables::strings(&["std_error"]));
        heading.extend(states.clone());
        let mut ways = (Way::default(), Way::default());
        for_each(store, |block, part: Part| {
            let way = if diagram.is_up(block) {
                &mut ways.0
            } else {
                &mut ways.1
            };
            way.changes.extend(part.changes);
            Ok::<_, Failure>(())
        })?;
        table(
            &found.files[0],
            &heading,
            diagram,
            store,
            |rows, is_up, at| {
                let way = if is_up { &mut ways.0 } else { &mut ways.1 };
                way.add(at);
                for record in section_rows(is_up, at, states.len()) {
                    rows.write_record(record)?;
                }
                Ok(())
            },
        )?;
        (found.up, found.down) = ways;

        let mut heading = tables::strings(&["way", parameter, "duration"]);
        heading.extend(states.iter().map(|state| format!("{state}_length")));
        table(
            &found.files[1],
            &heading,
            diagram,
            store,
            |rows, is_up, at| {
                for record in stick_rows(is_up, at) {
                    rows.write_record(record)?;
                }
                Ok(())
            },
        )?;
        Ok(found)
    }

    /// Writes the figure and says what was found.
    pub(super) fn written(
        self,
        diagram: &Bifurcation,
        system: &System,
        store: &Store,
        output: &OutputArguments,
    ) -> Result<Said, Failure> {
        let name = "bifurcation".to_owned();
        let found = super::super::Found {
            summary: self.summary(diagram, system),
            json: self.json(diagram, system),
            tables: vec![self.changes_table(diagram, system)?],
            figures: vec![(name, figure::diagram(&self, diagram, system)?)],
            failure: None,
        };
        found.written_besides(self.files, &store.staging()?, output)
    }

    /// Where changes were located, on either way.
    pub(super) fn located(&self) -> impl Iterator<Item = f64> + '_ {
        let changes = self.up.changes.iter().chain(&self.down.changes);
        changes.filter_map(|between| located(&between.change))
    }

    fn changes_table(&self, diagram: &Bifurcation, system: &System) -> Result<Artifact, Failure> {
        let columns = [
            "from",
            "to",
            "what",
            "contacts",
            "uncertainty",
            "before",
            "after",
        ];
        let mut heading = tables::strings(&["way", diagram.parameter.name.as_str()]);
        heading.extend(tables::strings(&columns));
        heading.extend(system.file.states.iter().map(|state| state.name.clone()));
        let mut rows = Vec::new();
        for (name, way) in [("up", &self.up), ("down", &self.down)] {
            for between in &way.changes {
                let mut row = tables::strings(&[name]);
                row.push(
                    located(&between.change)
                        .map(tables::exact)
                        .unwrap_or_default(),
                );
                row.extend([between.values.0, between.values.1].map(tables::exact));
                row.push(tables::change_name(&between.change));
                row.push(tables::changed_contacts(system, &between.change));
                let x = match &between.change {
                    Change::Sequence {
                        uncertainty,
                        before,
                        after,
                        x,
                        ..
                    } => {
                        row.push(tables::exact(*uncertainty));
                        row.extend([before, after].map(|modes| tables::sequence(modes)));
                        &x[..]
                    }
                    Change::Multiplier { uncertainty, x, .. } => {
                        row.push(tables::exact(*uncertainty));
                        row.extend(vec![String::new(); 2]);
                        &x[..]
                    }
                    Change::Equilibrium { x, .. } | Change::BoundaryEquilibrium { x, .. } => {
                        row.extend(vec![String::new(); 3]);
                        &x[..]
                    }
                    Change::Unlocated => {
                        row.extend(vec![String::new(); 3]);
                        &[]
                    }
                };
                let states = 0..system.states();
                row.extend(
                    states.map(|k| x.get(k).copied().map(tables::exact).unwrap_or_default()),
                );
                rows.push(row);
            }
        }
        Ok(csv_table("changes.csv", &heading, rows)?)
    }

    fn summary(&self, diagram: &Bifurcation, system: &System) -> String {
        let range = &diagram.parameter;
        let mut text = format!(
            "{}: {} values of {} from {} to {}, up and down\n",
            system.file.name, diagram.values, range.name, range.low, range.high
        );
        for (name, way) in [("up", &self.up), ("down", &self.down)] {
            for (first, last, motion) in &way.spans {
                // Writing into a text cannot fail.
                let [first, last] = [*first, *last].map(tables::rounded);
                let motion = attractors::since(motion, diagram.until);
                let _ = writeln!(text, "  {name:<4}  {first} to {last}: {motion}");
            }
            for Between { values, change } in &way.changes {
                let _ = match located(change) {
                    Some(value) => writeln!(
                        text,
                        "  {name:<4}  at {}: {}",
                        tables::place(value, uncertainty(change)),
                        tables::change_words(system, change)
                    ),
                    None => writeln!(
                        text,
                        "  {name:<4}  between {} and {}: {}",
                        tables::rounded(values.0),
                        tables::rounded(values.1),
                        tables::change_words(system, change)
                    ),
                };
            }
        }
        text
    }

    fn json(&self, diagram: &Bifurcation, system: &System) -> serde_json::Value {
        let spans = |way: &Way| -> Vec<serde_json::Value> {
            let spans = way.spans.iter();
            spans
                .map(|(first, last, motion)| json!({ "from": first, "to": last, "motion": motion }))
                .collect()
        };
        let changes = |way: &Way| -> Vec<serde_json::Value> {
            let changes = way.changes.iter();
            changes
                .map(|Between { values, change }| {
                    json!({ "values": values, "change": tables::change_json(system, change) })
                })
                .collect()
        };
        json!({
            "system": tables::system_json(system),
            "arguments": diagram,
            "up": { "motions": spans(&self.up), "changes": changes(&self.up) },
            "down": { "motions": spans(&self.down), "changes": changes(&self.down) },
        })
    }
}

impl Way {
    fn add(&mut self, at: &At) {
        let value = at.value;
        let points = at.outcome.points.iter();
        self.section.extend(points.map(|(_, x)| (value, x[0])));
        let sticks = sticks(at).map(|phase| (value, phase.t_end - phase.t_start));
        self.sticks.extend(sticks);
        if let Largest::Finite {
            value: exponent, ..
        } = at.largest
        {
            self.exponents.push((value, exponent));
        }
        let motion = attractors::class(&at.outcome);
        match self.spans.last_mut() {
            Some(last) if last.2 == motion => last.1 = value,
            _ => self.spans.push((value, value, motion)),
        }
    }
}

/// The phases of a periodic orbit in which a contact sticks.
fn sticks(at: &At) -> impl Iterator<Item = &stickslip_kernels::kernel::PhaseThere> {
    let is_periodic = matches!(at.outcome.motion, Motion::Periodic { .. });
    let phases = at.outcome.phases.iter().filter(move |_| is_periodic);
    phases.filter(|phase| phase.modes.to_vec().contains(&Mode::Stick))
}

/// Where a change is.
fn located(change: &Change) -> Option<f64> {
    match *change {
        Change::Sequence { parameter, .. }
        | Change::Equilibrium { parameter, .. }
        | Change::BoundaryEquilibrium { parameter, .. }
        | Change::Multiplier { parameter, .. } => Some(parameter),
        Change::Unlocated => None,
    }
}

/// By how much that parameter may be off, as far as it is told.
fn uncertainty(change: &Change) -> f64 {
    match *change {
        Change::Sequence { uncertainty, .. } | Change::Multiplier { uncertainty, .. } => {
            uncertainty
        }
        _ => 0.0,
    }
}

fn way_name(is_up: bool) -> &'static str {
    if is_up { "up" } else { "down" }
}

/// A row for each point of the section; one without a state where there is none.
fn section_rows(is_up: bool, at: &At, states: usize) -> Vec<Vec<String>> {
    let mut row = tables::strings(&[way_name(is_up)]);
    row.push(tables::exact(at.value));
    row.extend(attractors::fields(&at.outcome));
    row.extend(at.largest.fields());
    if at.outcome.points.is_empty() {
        row.extend(vec![String::new(); states]);
        return vec![row];
    }
    let points = at.outcome.points.iter().map(|(_, x)| {
        let x = x.iter().map(|&value| tables::exact(value));
        row.iter().cloned().chain(x).collect()
    });
    points.collect()
}

/// A row for each stick: how long it lasts, and how far each state goes in it.
fn stick_rows(is_up: bool, at: &At) -> Vec<Vec<String>> {
    let row = |phase: &stickslip_kernels::kernel::PhaseThere| {
        let mut row = tables::strings(&[way_name(is_up)]);
        row.push(tables::exact(at.value));
        row.push(tables::exact(phase.t_end - phase.t_start));
        let ends = phase.x_end.iter().zip(&phase.x_start);
        row.extend(ends.map(|(end, start)| tables::exact(end - start)));
        row
    };
    sticks(at).map(row).collect()
}

/// Writes a table of rows that `each` makes of what was found at each value.
fn table(
    path: &Path,
    heading: &[String],
    diagram: &Bifurcation,
    store: &Store,
    mut each: impl FnMut(&mut Rows<'_>, bool, &At) -> Result<(), csv::Error>,
) -> Result<(), Failure> {
    write_whole(path, &store.staging()?, |file| {
        let mut rows = csv::Writer::from_writer(file);
        rows.write_record(heading).map_err(OutputError::from)?;
        for_each(store, |block, part: Part| {
            for at in &part.found {
                each(&mut rows, diagram.is_up(block), at).map_err(OutputError::from)?;
            }
            Ok::<_, Failure>(())
        })?;
        let flushed = rows.flush().map_err(csv::Error::from);
        flushed.map_err(OutputError::from)?;
        Ok::<_, Failure>(())
    })
}
