//! The table on disk. It is complete at any time and is continued after a kill.

use std::io::ErrorKind::{NotADirectory, NotFound};
use std::path::Path;

use super::plan::{self, Group, Plan};
use super::scoring::scores;
use super::table::ConfigurationRow;
use crate::terminal::{self, ProgramError};
use output::Artifact;

/// Name of the table.
pub const TABLE: &str = "readings.csv";
/// The option that chooses its folder.
pub const OPTION: &str = "--out";

/// The rows of every finished group.
pub struct Store<'a> {
    plan: &'a Plan,
    folder: &'a Path,
    done: Vec<Option<Vec<ConfigurationRow>>>,
}

impl<'a> Store<'a> {
    /// Reads the results of an earlier run in `folder`. Only complete groups count; damaged lines
    /// are ignored.
    ///
    /// # Errors
    /// A table that cannot be read, or is of another search.
    pub fn open(plan: &'a Plan, folder: &'a Path) -> Result<Store<'a>, ProgramError> {
        let path = folder.join(TABLE);
        let text = match std::fs::read(&path) {
            // Invalid UTF-8 is damage: the line will not parse.
            Ok(bytes) => String::from_utf8_lossy(&bytes).into_owned(),
            // If the path is not a folder, creating it will report that.
            Err(error) if matches!(error.kind(), NotFound | NotADirectory) => String::new(),
            Err(error) => {
                let path = path.display();
                let remedy = "choose another folder with --out";
                return Err(format!("cannot read {path}: {error}; {remedy}").into());
            }
        };
        // Cut off within the heading: nothing is lost.
        if !plan.heading().starts_with(&text) {
            same_search(&text, plan, &path)?;
        }
        let complete = text.rfind('\n').map_or("", |end| &text[..end]);
        let sound = |row: &ConfigurationRow| row.scores == scores(&row.exponents, &plan.target);
        let rows: Vec<ConfigurationRow> = complete
            .lines()
            .filter_map(ConfigurationRow::parse)
            .filter(sound)
            .collect();
        let of_group = |group: &Group| -> Option<Vec<ConfigurationRow>> {
            let find = |key: [String; 4]| rows.iter().find(|row| row.key == key).cloned();
            plan::keys(plan, group).into_iter().map(find).collect()
        };
        let done = plan.groups.iter().map(of_group).collect();
        Ok(Store { plan, folder, done })
    }

    /// Indices of the groups that are not done.
    pub fn pending(&self) -> Vec<usize> {
        let missing = |&i: &usize| self.done[i].is_none();
        (0..self.done.len()).filter(missing).collect()
    }

    /// All rows so far, in the order of the plan.
    pub fn rows(&self) -> Vec<ConfigurationRow> {
        self.done.iter().flatten().flatten().cloned().collect()
    }

    /// Adds a group and rewrites the table.
    ///
    /// # Errors
    /// As [`Store::write`].
    pub fn add(&mut self, group: usize, rows: Vec<ConfigurationRow>) -> Result<(), ProgramError> {
        self.done[group] = Some(rows);
        self.write()
    }

    /// Writes the table.
    ///
    /// # Errors
    /// A folder or file that cannot be written.
    pub fn write(&self) -> Result<(), ProgramError> {
        let mut text = self.plan.heading() + &ConfigurationRow::header();
        for row in self.done.iter().flatten().flatten() {
            text += &row.line();
        }
        let table = Artifact::text(TABLE, text);
        terminal::write(self.folder, &[table], OPTION)?;
        Ok(())
    }
}

/// Whether the lines before the table are those of this search.
fn same_search(text: &str, plan: &Plan, path: &Path) -> Result<(), String> {
    let heading = plan.heading();
    let lines = text.lines().chain(std::iter::repeat("nothing"));
    let mut pairs = (1..).zip(heading.lines().zip(lines));
    match pairs.find(|(_, (expected, actual))| expected != actual) {
        Some((line, (expected, actual))) => Err(format!(
            "{} is not of this search: its line {line} is '{actual}' and should be '{expected}'; \
             move it away or choose another folder with --out",
            path.display()
        )),
        None => Ok(()),
    }
}
