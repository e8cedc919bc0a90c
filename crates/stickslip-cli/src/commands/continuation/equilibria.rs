//! A branch of equilibria, in both directions.

use plot::{BLACK, Figure, Legend, Markers, Panel, Shape};
use serde_json::{Value, json};
use stickslip::analysis::{
    EquilibriumBifurcation, EquilibriumPoint, SpecialEquilibrium, Stability, Stop,
};
use stickslip::error::readable;
use stickslip_model::file::System;
use stickslip_model::study::{EquilibriaOfBranch, boundary_of, frequency_of};

use super::super::figures;
use super::super::range::ParameterRange;
use super::ends::EndDescription;
use super::figure::curve;
use crate::failure::Failure;
use crate::render::{Report, Table, place};

/// Reports the branch, downwards and upwards.
pub(super) fn report(
    system: &System,
    range: &ParameterRange,
    branch: &EquilibriaOfBranch,
) -> Result<Report, Failure> {
    let name = &range.name;
    let EquilibriaOfBranch {
        points,
        special,
        first,
        stops,
        ..
    } = branch;
    let count = points.len();
    let what = match count {
        1 => "1 equilibrium".to_owned(),
        _ => format!("{count} equilibria"),
    };
    let what = format!("{what} over {}", range.words());
    let mut report = Report::of(system, what);
    report.field("parameter", range).field("points", count);
    if let Some(at) = points.get(*first) {
        let (value, stability) = (readable(at.parameter), at.stability());
        let begun = format!("begun at {name} = {value}: {stability}");
        report.note(match system.contacts() {
            0 => begun,
            _ => {
                let phases = system.sequence(&[at.mode]);
                format!("{begun}, mode {phases}  (- below, + above, S stick)")
            }
        });
    }
    for at in special {
        let value = place(at.parameter, at.uncertainty);
        report.note(format!("at {name} = {value}: {}", words(at, system)));
    }
    let objects: Vec<Value> = special.iter().map(|at| object(at, system)).collect();
    report.field("special", objects);
    let ends = [
        (points.first(), special.first()),
        (points.last(), special.last()),
    ];
    let ends: Vec<Value> = ends
        .into_iter()
        .zip(stops)
        .zip(["downwards", "upwards"])
        .map(|(((last, special), stop), way)| {
            let words = words_of_end((stop, special), system, name);
            let stop = EndDescription::of(stop, system, name).stop;
            let parameter = last.map(|last| last.parameter);
            let at = parameter.map_or_else(String::new, readable);
            report.note(format!("begun {way}, it ends at {name} = {at}, {words}"));
            json!({ "parameter": parameter, "stop": stop })
        })
        .collect();
    report.field("ends", ends);
    report.table(columns(system, name, points).csv("equilibria", points)?);
    report.table(special_columns(system, name).csv("equilibria-special", special)?);
    report.figure("equilibria", &diagram(system, range, points, special));
    Ok(report)
}

/// The end of a branch in words that follow "it ends", with the special equilibrium next to it.
fn words_of_end(
    (stop, special): (&Stop, Option<&SpecialEquilibrium>),
    system: &System,
    name: &str,
) -> String {
    let what = special.map(|at| (&at.what, place(at.parameter, at.uncertainty)));
    match (stop, what) {
        (
            Stop::BoundaryEquilibrium { .. },
            Some((EquilibriumBifurcation::Boundary { contact, .. }, at)),
        ) => format!(
            "where it reaches {}: {name} = {at}",
            system.surface(*contact)
        ),
        (Stop::Points, _) => "after the largest number of equilibria (--points)".to_owned(),
        (Stop::NoConvergence, _) => {
            "where no further equilibrium was found; a shorter --step may help".to_owned()
        }
        _ => EndDescription::of(stop, system, name).words,
    }
}

/// A special equilibrium in words.
pub(super) fn words(at: &SpecialEquilibrium, system: &System) -> String {
    match at.what {
        EquilibriumBifurcation::Hopf { frequency } => {
            format!("Hopf bifurcation, frequency {}", readable(frequency))
        }
        EquilibriumBifurcation::Boundary { contact, turns, .. } => {
            let (_, [before, after]) = boundary_of(at, system);
            let surface = system.surface(contact);
            let what = match (&*after, turns) {
                ("", _) => "no equilibrium was found beyond".to_owned(),
                (_, true) => format!("nonsmooth fold, between modes {before} and {after}"),
                (_, false) => format!("persistence, between modes {before} and {after}"),
            };
            format!("boundary equilibrium at {surface}, {what}")
        }
        EquilibriumBifurcation::Unresolved { before, after } => format!(
            "{}: {after} eigenvalues have a positive real part instead of {before}, and no \
             bifurcation that explains it was resolved",
            at.what
        ),
        ref other => other.to_string(),
    }
}

pub(super) fn object(at: &SpecialEquilibrium, system: &System) -> Value {
    let boundary = match at.what {
        EquilibriumBifurcation::Boundary { turns, .. } => {
            let (contact, [before, after]) = boundary_of(at, system);
            json!({ "contact": contact, "before": before, "after": after, "turns": turns })
        }
        _ => Value::Null,
    };
    json!({
        "parameter": at.parameter,
        "uncertainty": at.uncertainty,
        "what": at.what.to_string(),
        "behind": at.behind,
        "x": at.x.as_slice()[..system.states()],
        "frequency": frequency_of(at),
        "boundary": boundary,
    })
}

fn columns<'a>(
    system: &'a System,
    parameter: &str,
    points: &[EquilibriumPoint],
) -> Table<'a, &'a EquilibriumPoint> {
    let states = system.states();
    let most = points.iter().map(|at| at.eigenvalues.len()).max();
    let numbers = 1..=most.unwrap_or(0);
    let parts = numbers.flat_map(|k| ["re", "im"].map(|part| format!("eigenvalue{k}_{part}")));
    Table::new()
        .column(parameter, |at: &&EquilibriumPoint| at.parameter)
        .column("stability", |at| at.stability().to_string())
        .column("mode", move |at| system.sequence(&[at.mode]))
        .state(system, "", move |at| at.x.as_slice()[..states].to_vec())
        .many("eigenvalues", parts.collect(), |at| -> Vec<f64> {
            let values = at.eigenvalues.iter();
            values.flat_map(|one| [one.re, one.im]).collect()
        })
}

/// Table of special equilibria, each with the number of rows before it in the table of all.
fn special_columns<'a>(system: &'a System, parameter: &str) -> Table<'a, &'a SpecialEquilibrium> {
    let states = system.states();
    let modes = |k: usize| move |at: &&SpecialEquilibrium| boundary_of(at, system).1[k].clone();
    Table::new()
        .column("behind", |at: &&SpecialEquilibrium| at.behind)
        .column(parameter, |at| at.parameter)
        .column("what", |at| at.what.to_string())
        .column("contact", |at| boundary_of(at, system).0)
        .column("frequency", |at| frequency_of(at))
        .column("uncertainty", |at| at.uncertainty)
        .column("before", modes(0))
        .column("after", modes(1))
        .state(system, "", move |at| at.x.as_slice()[..states].to_vec())
}

/// Plots the first state over the parameter.
fn diagram(
    system: &System,
    range: &ParameterRange,
    points: &[EquilibriumPoint],
    special: &[SpecialEquilibrium],
) -> Figure {
    let first = &system.file.states[0];
    let label = figures::with_unit(&first.name, &first.unit);
    let place = |x: &[f64], parameter: f64| (parameter, x[0]);
    let places = points.iter().map(|at| place(at.x.as_slice(), at.parameter));
    let places: Vec<(f64, f64)> = places.collect();
    let x = figures::parameter_axis(system, &range.name, (range.low, range.high), true);
    let mut panel = Panel::new(x, figures::axis(&label, places.iter().map(|at| at.1)));
    let mut in_legend: Vec<Stability> = Vec::new();
    let mut begin = 0;
    for run in points.chunk_by(|a, b| a.stability() == b.stability()) {
        let end = begin + run.len();
        // The line begins at the last point of the run before, without a gap.
        let line = places[begin.saturating_sub(1)..end].to_vec();
        begin = end;
        let stability = run[0].stability();
        panel.add(curve(line, stability, Some(&mut in_legend)));
    }
    let kinds = [
        ("fold", Shape::Circle),
        ("branch point", Shape::Up),
        ("Hopf", Shape::Diamond),
        ("boundary equilibrium", Shape::Down),
        ("unresolved crossing", Shape::Square),
    ];
    for (kind, shape) in kinds {
        let there = special.iter().filter(|at| at.what.to_string() == kind);
        let there: Vec<_> = there
            .map(|at| place(at.x.as_slice(), at.parameter))
            .collect();
        if !there.is_empty() {
            let markers = Markers::new(there).shape(shape).color(BLACK).open();
            panel.add(markers.size(7.0).legend(kind));
        }
    }
    let title = format!("{}: branch of equilibria", system.file.name);
    let description = format!(
        "Equilibria of {} over {} from {} to {}: the state {}; whole lines where stable, dotted \
         where neutral, dashed where unstable; marks at bifurcations.",
        system.file.name, range.name, range.low, range.high, first.name
    );
    Figure::new("equilibria", (640.0, 300.0), &title, &description)
        .row(1.0, panel.legend(Legend::Below))
}
