//! The table on disk: complete at any time, continued after a kill.

use std::io::ErrorKind;
use std::path::Path;

use super::error::ReadingsError;
use super::plan::{Group, Plan, reading_name, settings_name};
use super::row::Row;
use crate::figures::output::{Artifact, write_all};

/// Name of the table.
pub const TABLE: &str = "readings.csv";

/// The rows of every group, once it is done.
pub struct Store<'a> {
    plan: &'a Plan,
    folder: &'a Path,
    done: Vec<Option<Vec<Row>>>,
}

/// The keys of a group's rows, in order.
pub fn keys(plan: &Plan, group: &Group) -> Vec<[String; 4]> {
    let key = |(part, settings): &(super::plan::Part, _)| {
        [
            part.name().to_owned(),
            reading_name(&group.reading),
            group.integrator.name(),
            settings_name(settings),
        ]
    };
    plan.settings_of(group).iter().map(key).collect()
}

impl<'a> Store<'a> {
    /// What an earlier run has left in `folder`: whole groups only; a line cut short counts for nothing.
    ///
    /// # Errors
    /// [`ReadingsError::Read`], [`ReadingsError::Foreign`].
    pub fn open(plan: &'a Plan, folder: &'a Path) -> Result<Store<'a>, ReadingsError> {
        let path = folder.join(TABLE);
        let text = match std::fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == ErrorKind::NotFound => String::new(),
            // Making the folder will say what is wrong.
            Err(error) if error.kind() == ErrorKind::NotADirectory => String::new(),
            Err(source) => return Err(ReadingsError::Read { path, source }),
        };
        let heading = plan.heading();
        let first = text.lines().next().unwrap_or(&heading);
        if first != heading && !heading.starts_with(&text) {
            return Err(ReadingsError::Foreign { path, heading });
        }
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        let rows: Vec<Row> = whole.lines().filter_map(Row::parse).collect();
        let of_group = |group: &Group| -> Option<Vec<Row>> {
            let find = |key: [String; 4]| rows.iter().find(|row| row.key == key).cloned();
            keys(plan, group).into_iter().map(find).collect()
        };
        let done = plan.groups.iter().map(of_group).collect();
        Ok(Store { plan, folder, done })
    }

    /// Indices of the groups that are still to be done.
    pub fn pending(&self) -> Vec<usize> {
        let missing = |&i: &usize| self.done[i].is_none();
        (0..self.done.len()).filter(missing).collect()
    }

    /// All rows there are, in the order of the plan.
    pub fn rows(&self) -> Vec<Row> {
        self.done.iter().flatten().flatten().cloned().collect()
    }

    /// Takes in a group and writes the table anew.
    ///
    /// # Errors
    /// [`ReadingsError::Output`].
    pub fn add(&mut self, group: usize, rows: Vec<Row>) -> Result<(), ReadingsError> {
        self.done[group] = Some(rows);
        self.write()
    }

    /// Writes the table.
    ///
    /// # Errors
    /// [`ReadingsError::Output`].
    pub fn write(&self) -> Result<(), ReadingsError> {
        let mut text = self.plan.heading() + "\n" + &Row::header();
        for row in self.done.iter().flatten().flatten() {
            text += &row.line();
        }
        let table = Artifact {
            name: TABLE.into(),
            bytes: text.into_bytes(),
        };
        write_all(self.folder, &[table])?;
        Ok(())
    }
}
