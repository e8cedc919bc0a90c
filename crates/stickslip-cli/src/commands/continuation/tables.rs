//! The tables `branch.csv` and `special.csv`.

use stickslip_kernels::file::System;
use stickslip_kernels::study::{BranchOrbit, WholeBranch};

use super::branch::SideBranch;
use super::ends::EndDescription;
use super::special::SpecialRow;
use crate::render::Table;

/// The columns of `special.csv`: special orbits and ends that are bifurcations. Each has the number
/// of rows of its branch that come before it in `branch.csv`.
pub(super) fn special_columns<'a>(
    system: &System,
    parameter: &str,
    is_numbered: bool,
) -> Table<'a, SpecialRow> {
    let phases =
        |k: usize| move |row: &SpecialRow| row.phases.as_ref().map(|phases| phases[k].clone());
    let table = numbered(is_numbered, |row: &SpecialRow| row.branch);
    let table = match is_numbered {
        true => table.column("branches", |row| row.branches.clone()),
        false => table,
    };
    table
        .column("behind", |row| row.behind)
        .column(parameter, |row| row.parameter)
        .column("what", |row| row.what.clone())
        .column("contacts", |row| row.contacts.clone())
        .column("angle", |row| row.angle)
        .column("uncertainty", |row| row.uncertainty)
        .column("before", phases(0))
        .column("after", phases(1))
        .column("period", |row| row.period)
        .state(system, "", |row| row.x.clone())
}

/// A table with a column for the number of the branch, if `is_numbered`.
fn numbered<'a, R>(is_numbered: bool, number: impl Fn(&R) -> usize + 'a) -> Table<'a, R> {
    match is_numbered {
        true => Table::new().column("branch", number),
        false => Table::new(),
    }
}

/// The columns of `branch.csv`: one row per orbit, from the lower to the upper end of the branch.
pub(super) fn columns<'a>(
    system: &'a System,
    parameter: &str,
    (is_numbered, points): (bool, &[(usize, &BranchOrbit)]),
) -> Table<'a, &'a (usize, &'a BranchOrbit)> {
    let states = system.file.states.iter().map(|state| &state.name);
    let ends = states.flat_map(|name| ["low", "high"].map(|end| format!("{name}_{end}")));
    let of_points = points.iter().map(|(_, at)| at.orbit.multipliers.len());
    let multipliers = of_points.max();
    let numbers = 1..=multipliers.unwrap_or(0);
    let parts = numbers.flat_map(|k| ["re", "im"].map(|part| format!("multiplier{k}_{part}")));
    numbered(is_numbered, |(number, _): &&(usize, &BranchOrbit)| *number)
        .column(parameter, |(_, at)| at.orbit.parameter)
        .column("period", |(_, at)| at.orbit.period)
        .column("stability", |(_, at)| at.orbit.stability().to_string())
        .column("phases", |(_, at)| system.sequence(&at.orbit.sequence))
        .column("t", |(_, at)| at.orbit.t)
        .state(system, "", |(_, at)| at.orbit.x.clone())
        .many("extremes", ends.collect(), |(_, at)| -> Vec<f64> {
            at.extremes
                .iter()
                .flat_map(|&(low, high)| [low, high])
                .collect()
        })
        .many("multipliers", parts.collect(), |(_, at)| -> Vec<f64> {
            at.orbit
                .multipliers
                .iter()
                .flat_map(|one| [one.re, one.im])
                .collect()
        })
}

/// Rows of the special orbits of a branch with its number, at which other branches may begin. Ends
/// that are bifurcations come before and after them.
pub(super) fn rows(
    (number, branch): (usize, &WholeBranch),
    others: &[SideBranch],
    system: &System,
    name: &str,
) -> Vec<SpecialRow> {
    let [first, last] = branch
        .stops
        .each_ref()
        .map(|stop| EndDescription::of(stop, system, name));
    let special = branch.special.iter().enumerate().map(|(k, at)| SpecialRow {
        branches: begins(others, k),
        ..SpecialRow::of(at, system)
    });
    let rows = first.row(0).into_iter().chain(special);
    let rows = rows.chain(last.row(branch.points.len()));
    rows.map(|row| SpecialRow {
        branch: number,
        ..row
    })
    .collect()
}

/// The numbers of the branches that begin at a special orbit.
fn begins(others: &[SideBranch], at: usize) -> String {
    let numbered = (1..).zip(others).filter(|(_, other)| other.from == at);
    let numbers = numbered.map(|(number, _)| i32::to_string(&number));
    numbers.collect::<Vec<String>>().join(" ")
}
