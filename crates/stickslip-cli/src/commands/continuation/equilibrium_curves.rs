//! Special equilibria in two parameters.

use serde_json::json;
use stickslip::analysis::{EquilibriumCurve, EquilibriumCurvePoint, EquilibriumCurveSpecial};
use stickslip::error::readable;
use stickslip_model::file::System;
use stickslip_model::study::{EquilibriaOfBranch, word_of_curve_stop};

use super::super::range::ParameterRange;
use super::branch::SecondParameter;
use super::curves::{CurveDrawing, described, diagram};
use super::equilibria::{object, words};
use crate::failure::Failure;
use crate::render::{Report, Table, place};

/// Reports the curves, and writes `curves.csv`, `curves-special.csv` and `curves.svg`.
pub(super) fn report(
    report: &mut Report,
    system: &System,
    (range, also): (&ParameterRange, &SecondParameter),
    branch: &EquilibriaOfBranch,
    curves: &[(usize, Option<EquilibriumCurve>)],
) -> Result<(), Failure> {
    let (name, other, states) = (&range.name, &also.range.name, system.states());
    let mut objects = Vec::new();
    for (number, curve) in curves {
        let at = &branch.special[*number];
        let what = words(at, system);
        let Some(curve) = curve else {
            report.note(format!("in {name} and {other}, {what}: no curve was found"));
            let mut object = object(at, system);
            object["points"] = json!(0);
            objects.push(object);
            continue;
        };
        let count = curve.points.len();
        let ends = [0, count - 1].map(|k| curve.points[k].parameters.map(readable));
        let [first, last] = [0, 1].map(|k| {
            let [q, p] = &ends[k];
            let end = described(curve.stops[k], ["equilibrium", "equilibria"]);
            format!("{other} = {q}, {name} = {p} {end}")
        });
        report.note(format!(
            "in {name} and {other}, {what}: {count} equilibria from {first} to {last}"
        ));
        for one in &curve.special {
            let [q, p] = [0, 1].map(|k| place(one.parameters[k], one.uncertainties[k]));
            report.note(format!("  at {other} = {q}, {name} = {p}: {}", one.what));
        }
        let special = curve.special.iter().map(|one| {
            json!({
                "what": one.what.to_string(),
                "parameters": one.parameters,
                "uncertainties": one.uncertainties,
                "behind": one.behind,
                "x": one.x.as_slice()[..states],
            })
        });
        let mut object = object(at, system);
        object["points"] = json!(count);
        object["stops"] = json!(curve.stops.map(word_of_curve_stop));
        object["special"] = special.collect();
        objects.push(object);
    }
    report.field("also", &also.range);
    report.field("curves", objects);
    let complete = || {
        let curves = curves.iter().enumerate();
        let curves = curves.filter_map(|(k, (_, curve))| Some((k, curve.as_ref()?)));
        curves.map(|(k, curve)| (k, curve.at.what.to_string(), curve))
    };
    let rows = complete().flat_map(|(k, what, curve)| {
        let points = curve.points.iter();
        points.map(move |point| (k, what.clone(), point))
    });
    let table = Table::new()
        .column("curve", |row: &(usize, String, &EquilibriumCurvePoint)| {
            row.0
        })
        .column("what", |row| row.1.clone())
        .column(other, |row| row.2.parameters[0])
        .column(name, |row| row.2.parameters[1])
        .column("frequency", |row| row.2.frequency)
        .state(system, "", |row| row.2.x.as_slice()[..states].to_vec());
    report.table(table.csv("curves", rows)?);
    let rows = complete().flat_map(|(k, what, curve)| {
        let special = curve.special.iter();
        special.map(move |one| (k, what.clone(), one))
    });
    let table = Table::new()
        .column(
            "curve",
            |row: &(usize, String, &EquilibriumCurveSpecial)| row.0,
        )
        .column("of", |row| row.1.clone())
        .column("behind", |row| row.2.behind)
        .column("what", |row| row.2.what.to_string())
        .column(other, |row| row.2.parameters[0])
        .column(name, |row| row.2.parameters[1])
        .column(&format!("uncertainty_{other}"), |row| {
            row.2.uncertainties[0]
        })
        .column(&format!("uncertainty_{name}"), |row| row.2.uncertainties[1])
        .state(system, "", |row| row.2.x.as_slice()[..states].to_vec());
    report.table(table.csv("curves-special", rows)?);
    let drawn = complete().map(|(_, what, curve)| CurveDrawing {
        what,
        places: curve.points.iter().map(|one| one.parameters).collect(),
        special: curve
            .special
            .iter()
            .map(|one| (one.what.to_string(), one.parameters))
            .collect(),
    });
    let drawn: Vec<CurveDrawing> = drawn.collect();
    report.figure(
        "curves",
        &diagram(system, range, also, ("equilibria", &drawn)),
    );
    Ok(())
}
