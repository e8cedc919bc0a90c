//! What a map has shown, as a table and in words.

use std::fmt::Write;
use std::path::PathBuf;

use serde_json::json;

use super::super::arguments::OutputArguments;
use super::super::exponent::Largest;
use super::super::sweeping::for_each;
use super::super::{Failure, attractors, tables};
use super::cell::Cell;
use super::figure;
use super::request::Map;
use crate::output::OutputError;
use crate::sweep::{Store, write_whole};
use crate::terminal::Said;
use stickslip_kernels::file::System;

/// What the figure shows of a cell.
#[derive(Clone, Copy)]
pub(super) struct Shown {
    /// Which of the classes.
    pub(super) class: usize,
    pub(super) in_stick: Option<f64>,
    pub(super) largest: Largest,
}

/// Cells of one kind of motion.
pub(super) struct Class {
    /// What it is, of an attractor with its phases.
    pub(super) name: String,
    /// Whether it is a kind of attractor: orbits that escape, end, fail or are undecided have come to none.
    pub(super) is_attractor: bool,
    /// Number of cells.
    pub(super) cells: usize,
}

/// Everything found.
pub(super) struct Found {
    /// In the order in which they are met first.
    pub(super) classes: Vec<Class>,
    /// Row by row from the lowest second parameter.
    pub(super) cells: Vec<Shown>,
    table: PathBuf,
}

impl Found {
    /// Reads the blocks one after the other and writes the table.
    pub(super) fn read(
        map: &Map,
        store: &Store,
        output: &OutputArguments,
    ) -> Result<Self, Failure> {
        let table = PathBuf::from(&output.out).join("map.csv");
        let (mut classes, mut shown): (Vec<Class>, _) = (Vec::new(), Vec::new());
        let columns = [
            "motion",
            "period",
            "phases",
            "in_stick",
            "lambda1",
            "std_error",
        ];
        let names = map.plane.iter().map(|range| range.name.as_str());
        let heading: Vec<&str> = names.chain(columns).collect();
        write_whole(&table, &store.staging()?, |file| {
            let mut rows = csv::Writer::from_writer(file);
            rows.write_record(&heading).map_err(OutputError::from)?;
            for_each(store, |row, cells: Vec<Cell>| {
                for (column, cell) in cells.iter().enumerate() {
                    let values = map.parameters(column, row).map(tables::exact);
                    let record = values.into_iter().chain(cell.fields());
                    rows.write_record(record).map_err(OutputError::from)?;
                    let name = cell.class();
                    let known = classes.iter().position(|known| known.name == name);
                    let class = known.unwrap_or_else(|| {
                        classes.push(Class {
                            name,
                            is_attractor: attractors::is_attractor(&cell.motion),
                            cells: 0,
                        });
                        classes.len() - 1
                    });
                    classes[class].cells += 1;
                    shown.push(Shown {
                        class,
                        in_stick: cell.in_stick,
                        largest: cell.largest,
                    });
                }
                Ok::<_, Failure>(())
            })?;
            rows.flush()
                .map_err(|error| OutputError::from(csv::Error::from(error)))?;
            Ok::<_, Failure>(())
        })?;
        Ok(Self {
            classes,
            cells: shown,
            table,
        })
    }

    /// Writes the figure and says what was found.
    pub(super) fn written(
        self,
        map: &Map,
        system: &System,
        store: &Store,
        output: &OutputArguments,
    ) -> Result<Said, Failure> {
        let found = super::super::Found {
            summary: self.summary(map, system),
            json: self.json(map, system),
            tables: Vec::new(),
            figures: vec![("map".to_owned(), figure::map(&self, map, system)?)],
            failure: None,
        };
        found.written_besides(vec![self.table], &store.staging()?, output)
    }

    fn summary(&self, map: &Map, system: &System) -> String {
        let all = self.cells.len();
        let range = |k: usize| {
            let range = &map.plane[k];
            format!("{} from {} to {}", range.name, range.low, range.high)
        };
        let mut text = format!(
            "{}: {all} cells, {}, {}\n",
            system.file.name,
            range(0),
            range(1)
        );
        for class in self.in_order() {
            let percent = 100.0 * class.cells as f64 / all as f64;
            let name = attractors::since(&class.name, map.until);
            // Writing into a text cannot fail.
            let _ = match class.is_attractor {
                true => writeln!(text, "  {percent:6.2} %  {name}"),
                false => writeln!(text, "  {percent:6.2} %  no attractor: {name}"),
            };
        }
        text
    }

    /// Attractors as they are met first, and behind them what is none.
    fn in_order(&self) -> impl Iterator<Item = &Class> {
        let of = |is_attractor: bool| {
            let all = self.classes.iter();
            all.filter(move |class| class.is_attractor == is_attractor)
        };
        of(true).chain(of(false))
    }

    fn json(&self, map: &Map, system: &System) -> serde_json::Value {
        let classes: Vec<serde_json::Value> = self
            .in_order()
            .map(|class| json!({ "motion": class.name, "is_attractor": class.is_attractor, "cells": class.cells }))
            .collect();
        json!({
            "system": tables::system_json(system),
            "arguments": map,
            "cells": self.cells.len(),
            "classes": classes,
        })
    }
}
