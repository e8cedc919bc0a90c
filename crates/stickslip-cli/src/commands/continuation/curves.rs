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
                    let p = match point.uncertainty {
                        Some(uncertainty) => place(point.parameters[1], uncertainty),
                        None => p,
                    };
                    let end = described(stop, ["orbit", "orbits"]);
                    format!("{other} = {q}, {name} = {p} {end}")
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
        .column(&format!("uncertainty_{name}"), |row| row.2.uncertainty)
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
    let complete = curves
        .iter()
        .filter_map(|(at, curve)| Some((at, curve.as_ref()?)));
    let drawn: Vec<CurveDrawing> = complete
        .map(|(at, curve)| CurveDrawing {
            what: at.what.to_string(),
            places: curve.points.iter().map(|one| one.parameters).collect(),
            special: curve
                .special
                .iter()
                .map(|one| (one.what.to_string(), one.parameters))
                .collect(),
        })
        .collect();
    report.figure(
        "curves",
        &diagram(system, range, also, ("periodic orbits", &drawn)),
    );
    Ok(())
}

/// The drawn parts of a curve: the two parameters of its points, the second one first.
pub(super) struct CurveDrawing {
    pub(super) what: String,
    pub(super) places: Vec<[f64; 2]>,
    pub(super) special: Vec<(String, [f64; 2])>,
}

/// Words for the end of a curve of orbits or of equilibria.
pub(super) fn described(stop: CurveStop, [one, many]: [&str; 2]) -> String {
    match stop {
        CurveStop::Range => "(an end of a range)".to_owned(),
        CurveStop::Points => format!("(the largest number of {many})"),
        CurveStop::Closed => format!("(its first {one}: it is closed)"),
        CurveStop::Flip => "(a flip of the orbit of half the period)".to_owned(),
        CurveStop::Resonance => "(its pair of multipliers becomes real)".to_owned(),
        CurveStop::BogdanovTakens => "(its pair of eigenvalues becomes real)".to_owned(),
        CurveStop::AnotherChange => format!("(another change occurs at the same {one})"),
        CurveStop::NoConvergence => format!("(no further {one} was found)"),
    }
}

/// Plots the curves in the plane of both parameters.
pub(super) fn diagram(
    system: &System,
    range: &ParameterRange,
    also: &SecondParameter,
    (of, curves): (&str, &[CurveDrawing]),
) -> Figure {
    const COLORS: [plot::Color; 6] = [BLUE, VERMILLION, GREEN, PURPLE, ORANGE, BLACK];
    const SHAPES: [Shape; 5] = [
        Shape::Circle,
        Shape::Diamond,
        Shape::Up,
        Shape::Down,
        Shape::Square,
    ];
    let title = format!("{}: special {of} in two parameters", system.file.name);
    let description = format!(
        "Curves of special {of} of {}, over {} from {} to {} and {} from {} to {}, with marks at \
         their own special points.",
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
    let place = |[other, own]: [f64; 2]| (own, other);
    for (number, curve) in curves.iter().enumerate() {
        let points: Vec<_> = curve.places.iter().map(|at| place(*at)).collect();
        let line = Line::new(points).color(COLORS[number % COLORS.len()]);
        let legend = format!("curve {}: {}", number + 1, curve.what);
        panel.add(line.width(1.4).legend(&legend));
    }
    let special = || curves.iter().flat_map(|curve| &curve.special);
    let mut names: Vec<&str> = Vec::new();
    for (name, _) in special() {
        if !names.contains(&&**name) {
            names.push(name);
        }
    }
    for (number, name) in names.into_iter().enumerate() {
        let there = special().filter(|one| one.0 == name);
        let points: Vec<_> = there.map(|one| place(one.1)).collect();
        let markers = Markers::new(points).shape(SHAPES[number % SHAPES.len()]);
        panel.add(markers.color(BLACK).size(6.0).legend(name));
    }
    let panel = panel.legend(Legend::Below);
    Figure::new("curves", (640.0, 420.0), &title, &description).row(1.0, panel)
}
