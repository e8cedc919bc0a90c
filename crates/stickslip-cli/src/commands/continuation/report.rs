//! The report of a branch and of those that begin on it: notes, values for programs, tables and the
//! figure.

use serde_json::{Value, json};
use stickslip::analysis::SpecialPoint;
use stickslip::error::readable;
use stickslip_model::file::System;
use stickslip_model::study::{BranchOrbit, SideBranch, TwoSidedBranch};

use super::super::attractors::family_words;
use super::super::range::ParameterRange;
use super::ends::EndDescription;
use super::figure;
use super::special::{json as special_json, words};
use super::tables::{columns, rows, special_columns};
use crate::failure::Failure;
use crate::render::{Report, explained, place};

/// The report of a branch, and of the others that begin on it, if they were followed.
pub(super) fn of(
    system: &System,
    range: &ParameterRange,
    branch: &TwoSidedBranch,
    others: Option<&[SideBranch]>,
) -> Result<Report, Failure> {
    let (name, points, family) = (&range.name, &branch.points, branch.family);
    let orbits = points.len();
    let what = match orbits {
        1 => "1 periodic orbit".to_owned(),
        _ => format!("{orbits} periodic orbits"),
    };
    let what = format!("{what} over {}", range.words());
    let mut report = Report::of(system, what);
    report
        .field("parameter", range)
        .field("points", orbits)
        .field("family_dimension", family);
    if let Some(BranchOrbit { orbit, .. }) = points.get(branch.first) {
        let [at, period] = [orbit.parameter, orbit.period].map(readable);
        let phases = explained(system, &orbit.sequence);
        let phases = phases.map_or(String::new(), |phases| format!(", phases {phases}"));
        let stability = orbit.stability();
        report.note(format!(
            "begun at {name} = {at}: period {period}, {stability}{phases}"
        ));
    }
    if family > 0 {
        let family = family_words(family);
        report.note(format!(
            "it is {family}; at each value the one nearest to that before is followed"
        ));
    }
    for at in &branch.special {
        let (at, what) = (place(at.parameter, at.uncertainty), words(at, system));
        report.note(format!("at {name} = {at}: {what}"));
    }
    let special: Vec<Value> = branch
        .special
        .iter()
        .map(|at| special_json(at, system))
        .collect();
    report.field("special", special);

    report_ends(&mut report, system, name, branch);
    if let Some(others) = others {
        let objects = (1..).zip(others).map(|other| {
            let parent = match other.1.parent {
                0 => branch,
                number => &others[number - 1].branch,
            };
            let (note, object) = of_other(other, parent, system, name);
            report.note(note);
            object
        });
        let objects: Vec<Value> = objects.collect();
        report.field("branches", objects);
    }

    let is_numbered = others.is_some();
    let others = others.unwrap_or_default();
    let followed = others.iter().map(|other| &other.branch);
    let branches: Vec<&TwoSidedBranch> = std::iter::once(branch).chain(followed).collect();
    let numbered = || branches.iter().copied().enumerate();
    let points = numbered().flat_map(|(k, one)| one.points.iter().map(move |at| (k, at)));
    let points: Vec<(usize, &BranchOrbit)> = points.collect();
    report.table(columns(system, name, (is_numbered, &points)).csv("branch", &points)?);
    let rows = numbered().flat_map(|(k, one)| rows((k, one), others, system));
    report.table(special_columns(system, name, is_numbered).csv("special", rows)?);
    report.figure("continue", &figure::diagram(system, range, &branches));
    Ok(report)
}

/// Reports the ends of the branch in both directions.
fn report_ends(report: &mut Report, system: &System, name: &str, branch: &TwoSidedBranch) {
    let ends = branch
        .stops
        .each_ref()
        .map(|stop| EndDescription::of(stop, system, name));
    let last = [branch.points.first(), branch.points.last()];
    let mut objects = Vec::new();
    for ((last, end), way) in last.into_iter().zip(&ends).zip(["downwards", "upwards"]) {
        if let Some(BranchOrbit { orbit, .. }) = last {
            let (stability, at, words) = (orbit.stability(), readable(orbit.parameter), &end.words);
            report.note(format!(
                "begun {way}, {stability} at its last orbit ({name} = {at}), it ends {words}"
            ));
        }
        let mut object = json!({
            "parameter": last.map(|last| last.orbit.parameter),
            "stop": end.stop,
            "error": null,
            "flip": null,
            "hopf": null,
            "boundary_equilibrium": null,
            "two_fold": null,
            "homoclinic": null,
        });
        if let Some((key, value)) = &end.detail {
            object[key] = value.clone();
        }
        objects.push(object);
    }
    report.field("ends", objects);
}

/// A branch that begins at another branch, in words and as a JSON object.
fn of_other(
    (number, other): (usize, &SideBranch),
    parent: &TwoSidedBranch,
    system: &System,
    name: &str,
) -> (String, Value) {
    let SideBranch {
        from, to, branch, ..
    } = other;
    let place_of = |at: &SpecialPoint| place(at.parameter, at.uncertainty);
    let begin = parent.special.get(*from).map_or_else(String::new, |at| {
        let of = match other.parent {
            0 => String::new(),
            number => format!(" of branch {number}"),
        };
        format!(" from the {}{of} at {name} = {}", at.what, place_of(at))
    });
    let bubble = to.and_then(|to| parent.special.get(to));
    let bubble = bubble.map_or_else(String::new, |at| {
        let place = place_of(at);
        format!("; it is a bubble to the flip at {name} = {place}, where the same branch begins")
    });
    let [_, stop] = &branch.stops;
    let end = EndDescription::of(stop, system, name);
    let last = branch.points.last();
    let of_last = last.map_or_else(String::new, |BranchOrbit { orbit, .. }| {
        let [at, period] = [orbit.parameter, orbit.period].map(readable);
        let stability = orbit.stability();
        format!(", {stability} at its last orbit ({name} = {at}, period {period})")
    });
    let orbits = branch.points.len();
    let words = &end.words;
    let special: Vec<Value> = branch
        .special
        .iter()
        .map(|at| special_json(at, system))
        .collect();
    let mut object = json!({
        "branch": number,
        "parent": other.parent,
        "from": from,
        "to": to,
        "points": orbits,
        "parameter": last.map(|last| last.orbit.parameter),
        "special": special,
        "stop": end.stop,
    });
    if let Some((key, value)) = end.detail {
        object[key] = value;
    }
    let plural = if orbits == 1 { "" } else { "s" };
    let note =
        format!("branch {number}{begin}: {orbits} orbit{plural}{of_last}; it ends {words}{bubble}");
    (note, object)
}
