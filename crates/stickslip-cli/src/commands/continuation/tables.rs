//! The tables `branch.csv` and `special.csv`.

use stickslip_model::file::System;
use stickslip_model::study::{BranchOrbit, SideBranch, SpecialRow, TwoSidedBranch};

use crate::render::Table;

/// A row of `special.csv`, with the number of its branch and of those that begin there.
pub(super) type NumberedRow = (usize, String, SpecialRow);

/// The columns of `special.csv`: special orbits and ends that are bifurcations. Each has the number
/// of rows of its branch that come before it in `branch.csv`.
pub(super) fn special_columns<'a>(
    system: &System,
    parameter: &str,
    is_numbered: bool,
) -> Table<'a, NumberedRow> {
    let table = numbered(is_numbered, |(number, ..): &NumberedRow| *number);
    let table = match is_numbered {
        true => table.column("branches", |(_, branches, _)| branches.clone()),
        false => table,
    };
    table
        .column("behind", |(.., row)| row.behind)
        .column(parameter, |(.., row)| row.parameter)
        .column("what", |(.., row)| row.name.clone())
        .column("contacts", |(.., row)| row.contacts.clone())
        .column("angle", |(.., row)| row.angle)
        .column("criticality", |(.., row)| row.criticality.clone())
        .column("uncertainty", |(.., row)| row.uncertainty)
        .column("before", |(.., row)| row.phases[0].clone())
        .column("after", |(.., row)| row.phases[1].clone())
        .column("period", |(.., row)| row.period)
        .state(system, "", |(.., row)| row.x.clone())
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
    let parts = ["re", "im", "uncertainty"];
    let parts = numbers.flat_map(|k| parts.map(|part| format!("multiplier{k}_{part}")));
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
            let multipliers = at.orbit.multipliers.iter().zip(&at.uncertainties);
            multipliers
                .flat_map(|(one, &uncertainty)| [one.re, one.im, uncertainty])
                .collect()
        })
}

/// Rows of the special orbits of a branch with its number, at which other branches may begin.
pub(super) fn rows(
    (number, branch): (usize, &TwoSidedBranch),
    others: &[SideBranch],
    system: &System,
) -> Vec<NumberedRow> {
    let rows = branch.special_rows(system);
    // The first row may be an end of the branch.
    let first = usize::from(branch.ends()[0].bifurcation.is_some());
    let rows = rows.into_iter().enumerate();
    rows.map(|(k, row)| (number, begins(others, (number, k.checked_sub(first))), row))
        .collect()
}

/// The numbers of the branches that begin at a special orbit of a branch.
fn begins(others: &[SideBranch], (parent, at): (usize, Option<usize>)) -> String {
    let numbered = (1..)
        .zip(others)
        .filter(|(_, other)| other.parent == parent && Some(other.from) == at);
    let numbers = numbered.map(|(number, _)| i32::to_string(&number));
    numbers.collect::<Vec<String>>().join(" ")
}
