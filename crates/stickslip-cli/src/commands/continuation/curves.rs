//! Special orbits in two parameters.

use plot::{
    BLACK, BLUE, Curve as Line, Figure, GREEN, Legend, Markers, ORANGE, PURPLE, Panel, Shape,
    VERMILLION,
};
use serde_json::json;
use stickslip::analysis::{Curve, CurvePoint, CurveSpecialPoint, CurveStop, SpecialPoint};
use stickslip::error::readable;
use stickslip_model::file::System;
use stickslip_model::study::word_of_curve_stop;

use super::super::figures;
use super::super::range::ParameterRange;
use super::branch::SecondParameter;
use super::special::{json as special_json, words as special_words};
use crate::failure::Failure;
use crate::render::{Report, Table, place};

/// Reports the curves, and writes `curves.csv`, `curves-special.csv` and `curves.svg`.
pub(super) fn report(
    report: &mut Report,
    system: &System,
    range: &ParameterRange,
    also: &SecondParameter,
    curves: &[(SpecialPoint, Option<Curve>)],
) -> Result<(), Failure> {
    let (name, other) = (&range.name, &also.range.name);
    let mut objects = Vec::new();
    for (at, curve) in curves {
        let what = special_words(at, system);
        let points = curve.as_ref().map_or(&[][..], |curve| &curve.points);
        report.note(match (curve, points.first(), points.last()) {
            (Some(curve), Some(first), Some(last)) => {
                let end = |point: &CurvePoint, stop: CurveStop| {
                    let [q, p] = point.parameters.map(readable);
                    format!("{other} = {q}, {name} = {p} {}", described(stop))
                };
                format!(
                    "in {name} and {other}, {what}: {} orbits from {} to {}",
                    points.len(),
                    end(first, curve.stops[0]),
                    end(last, curve.stops[1])
                )
            }
            _ => format!("in {name} and {other}, {what}: no curve was found"),
        });
        let special = curve.iter().flat_map(|curve| &curve.special);
        for one in special.clone() {
            let [q, p] = [0, 1].map(|k| place(one.parameters[k], one.uncertainties[k]));
            report.note(format!("  at {other} = {q}, {name} = {p}: {}", one.what));
        }
        let mut object = special_json(at, system);
        object["points"] = json!(points.len());
        object["stops"] = json!(
            curve
                .as_ref()
                .map(|curve| curve.stops.map(word_of_curve_stop))
        );
        let special = special.map(|one| {
            json!({
                "what": one.what.to_string(),
                "parameters": one.parameters,
                "uncertainties": one.uncertainties,
                "behind": one.behind,
                "period": one.period,
                "t": one.t,
                "x": one.x.as_slice()[..system.states()],
            })
        });
        object["special"] = special.collect();
        objects.push(object);
    }
    report.field("also", &also.range);
    report.field("curves", objects);
    let rows = curves.iter().enumerate();
    let rows = rows.flat_map(|(number, (at, curve))| {
        let what = at.what.to_string();
        let points = curve.iter().flat_map(|curve| &curve.points);
        points.map(move |point| (number, what.clone(), point))
    });
    let table = Table::new()
        .column("curve", |row: &(usize, String, &CurvePoint)| row.0)
        .column("what", |row| row.1.clone())
        .column(other, |row| row.2.parameters[0])
        .column(name, |row| row.2.parameters[1])
        .column("period", |row| row.2.period)
        .column("t", |row| row.2.t)
        .state(system, "", |row| {
            let states = system.states();
            row.2.x.as_slice()[..states].to_vec()
        });
    report.table(table.csv("curves", rows)?);
    let rows = curves.iter().enumerate().flat_map(|(number, (at, curve))| {
        let special = curve.iter().flat_map(|curve| &curve.special);
        special.map(move |one| (number, at.what.to_string(), one))
    });
    let table = Table::new()
        .column("curve", |row: &(usize, String, &CurveSpecialPoint)| row.0)
        .column("of", |row| row.1.clone())
        .column("behind", |row| row.2.behind)
        .column("what", |row| row.2.what.to_string())
        .column(other, |row| row.2.parameters[0])
        .column(name, |row| row.2.parameters[1])
        .column(&format!("uncertainty_{other}"), |row| {
            row.2.uncertainties[0]
        })
        .column(&format!("uncertainty_{name}"), |row| row.2.uncertainties[1])
        .column("period", |row| row.2.period)
        .column("t", |row| row.2.t)
        .state(system, "", |row| {
            let states = system.states();
            row.2.x.as_slice()[..states].to_vec()
        });
    report.table(table.csv("curves-special", rows)?);
    report.figure("curves", &diagram(system, range, also, curves));
    Ok(())
}

/// Words for the end of a curve.
fn described(stop: CurveStop) -> &'static str {
    match stop {
        CurveStop::Range => "(an end of a range)",
        CurveStop::Points => "(the largest number of orbits)",
        CurveStop::Closed => "(its first orbit: it is closed)",
        CurveStop::Flip => "(a flip of the orbit of half the period)",
        CurveStop::Resonance => "(its pair of multipliers becomes real)",
        CurveStop::AnotherChange => "(another change occurs at the same orbit)",
        CurveStop::NoConvergence => "(no further orbit was found)",
    }
}

/// Plots the curves in the plane of both parameters.
fn diagram(
    system: &System,
    range: &ParameterRange,
    also: &SecondParameter,
    curves: &[(SpecialPoint, Option<Curve>)],
) -> Figure {
    const COLORS: [plot::Color; 6] = [BLUE, VERMILLION, GREEN, PURPLE, ORANGE, BLACK];
    const SHAPES: [Shape; 5] = [
        Shape::Circle,
        Shape::Diamond,
        Shape::Up,
        Shape::Down,
        Shape::Square,
    ];
    let title = format!(
        "{}: special periodic orbits in two parameters",
        system.file.name
    );
    let description = format!(
        "Curves of special periodic orbits of {}, over {} from {} to {} and {} from {} to {}, with \
         marks at their own special points.",
        system.file.name,
        range.name,
        range.low,
        range.high,
        also.range.name,
        also.range.low,
        also.range.high
    );
    let axis = |range: &ParameterRange| {
        figures::parameter_axis(system, &range.name, (range.low, range.high), true)
    };
    let mut panel = Panel::new(axis(range), axis(&also.range));
    let complete = curves
        .iter()
        .filter_map(|(at, curve)| Some((at, curve.as_ref()?)));
    for (number, (at, curve)) in complete.enumerate() {
        let points = curve.points.iter().map(|point| {
            let [other, own] = point.parameters;
            (own, other)
        });
        let what = at.what.to_string();
        let line = Line::new(points.collect::<Vec<_>>()).color(COLORS[number % COLORS.len()]);
        panel.add(line.width(1.4).legend(&format!("{} {what}", number + 1)));
    }
    let special = || {
        let curves = curves.iter().filter_map(|(_, curve)| curve.as_ref());
        curves.flat_map(|curve| &curve.special)
    };
    let mut names: Vec<String> = Vec::new();
    for one in special() {
        let name = one.what.to_string();
        if !names.contains(&name) {
            names.push(name);
        }
    }
    for (number, name) in names.iter().enumerate() {
        let there = special().filter(|one| one.what.to_string() == *name);
        let points = there.map(|one| (one.parameters[1], one.parameters[0]));
        let shape = SHAPES[number % SHAPES.len()];
        let markers = Markers::new(points.collect::<Vec<_>>()).shape(shape);
        panel.add(markers.color(BLACK).size(6.0).legend(name));
    }
    let panel = panel.legend(Legend::Below);
    Figure::new("curves", (640.0, 420.0), &title, &description).row(1.0, panel)
}
