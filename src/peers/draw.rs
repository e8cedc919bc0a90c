//! The work–precision figure.

use super::compare::front;
use super::problem::Problem;
use super::row::Row;
use crate::figures::FigureError;
use crate::numbers::extent;
use crate::text::{distinct, joined};
use plot::*;
use stickslip::math;

const LOOKS: [(Color, Dash, Shape); 8] = [
    (BLACK, Dash::Solid, Shape::Circle),
    (BLUE, Dash::Solid, Shape::Square),
    (VERMILLION, Dash::Solid, Shape::Up),
    (GREEN, Dash::Dashed, Shape::Diamond),
    (PURPLE, Dash::Solid, Shape::Down),
    (ORANGE, Dash::Dashed, Shape::Circle),
    (SKY, Dash::Solid, Shape::Square),
    (GREY, Dash::Dashed, Shape::Up),
];
const PANELS_IN_ROW: usize = 2;
const ROW: f64 = 290.0;
/// Room for the legend under the last row, px.
const LEGEND: f64 = 60.0;

/// The SVG: a panel for every problem, and one with the times of whole processes where they were
/// measured.
///
/// # Errors
/// Those of [`Figure::render`].
pub fn draw(rows: &[Row], problems: &[Problem]) -> Result<String, FigureError> {
    let names = distinct(rows.iter().map(|row| row.solver.as_str()));
    let mut panels: Vec<Panel> = Vec::new();
    for (i, problem) in problems.iter().enumerate() {
        let of = rows.iter().filter(|row| row.problem == problem.name);
        let panel = work_precision(&of.collect::<Vec<_>>(), &names);
        panels.push(panel.label(&letter(i)).title(problem.title));
    }
    let mut about_processes = "";
    if rows.iter().any(|row| row.process.is_some()) {
        panels.push(processes(rows, &names, problems).label(&letter(problems.len())));
        about_processes = " Last panel: time of a whole process, one line for each solver.";
    }
    if let Some(last) = panels.pop() {
        panels.push(with_legend(last, &names));
    }
    let lines = panels.len().div_ceil(PANELS_IN_ROW);
    let height = lines as f64 * ROW + LEGEND;
    let description = format!(
        "{} panels, one for each problem: largest error of the event times against the time of a run, both logarithmic, one \
         curve for each of {}. Down and to the left is better.{about_processes}",
        problems.len(),
        names.join(", ")
    );
    let mut figure = Figure::new("bench", (880.0, height), "Work and precision", &description);
    let mut panels = panels.into_iter();
    for line in 0..lines {
        let row: Vec<(f64, Cell)> = panels
            .by_ref()
            .take(PANELS_IN_ROW)
            .map(|panel| (1.0, panel.into()))
            .collect();
        let weight = if line + 1 == lines { ROW + LEGEND } else { ROW };
        figure = figure.columns(weight, row);
    }
    figure.render().map_err(Into::into)
}

/// The label of a panel.
fn letter(place: usize) -> String {
    format!("({})", char::from(b'a' + place as u8))
}

fn look(place: usize) -> (Color, Dash, Shape) {
    LOOKS[place % LOOKS.len()]
}

fn work_precision(rows: &[&Row], names: &[&str]) -> Panel {
    let fronts: Vec<Vec<(f64, f64)>> = names
        .iter()
        .map(|name| {
            let own = rows.iter().copied().filter(|row| row.solver == *name);
            let points = front(own).into_iter();
            points
                .map(|(time, error)| (math::log10(time), math::log10(error)))
                .collect()
        })
        .collect();
    let all = || fronts.iter().flatten();
    let mut panel = Panel::new(
        Axis::decades("time of a run, s", range(all().map(|p| p.0))),
        Axis::decades("error of event times", range(all().map(|p| p.1))),
    );
    // Ours last, on top.
    for (i, points) in fronts.iter().enumerate().rev() {
        let (color, dash, shape) = look(i);
        panel.add(Curve::new(points.clone()).color(color).dash(dash));
        panel.add(
            Markers::new(points.clone())
                .color(color)
                .shape(shape)
                .size(5.5),
        );
    }
    panel
}

/// A line for every solver; filled marks are of the first problem that was timed so, open ones of
/// the others.
fn processes(rows: &[Row], names: &[&str], problems: &[Problem]) -> Panel {
    let timed = |problem: &&'static str| {
        let mut rows = rows.iter();
        rows.any(|row| row.problem == *problem && row.process.is_some())
    };
    let of: Vec<&'static str> = problems
        .iter()
        .map(|problem| problem.name)
        .filter(timed)
        .collect();
    // What the marks mean: the letters of the problems' own panels.
    let letters = |of: &[&str]| {
        let places = problems.iter().enumerate();
        let places = places.filter(|(_, problem)| of.contains(&problem.name));
        joined(places.map(|(i, _)| letter(i)), ", ")
    };
    let title = match of.split_first() {
        Some((first, others)) if !others.is_empty() => format!(
            "whole process; filled: {}, open: {}",
            letters(&[first]),
            letters(others)
        ),
        _ => format!("whole process of {}", letters(&of)),
    };
    let times: Vec<Vec<(&str, f64)>> = names
        .iter()
        .map(|name| {
            let own = rows.iter().filter(|row| row.solver == *name);
            own.filter_map(|row| Some((row.problem, math::log10(row.process?))))
                .collect()
        })
        .collect();
    let lines: Vec<(f64, &str)> = names
        .iter()
        .enumerate()
        .map(|(i, name)| ((names.len() - i) as f64, *name))
        .collect();
    let mut panel = Panel::new(
        Axis::decades(
            "time to start, compile and run once, s",
            range(times.iter().flatten().map(|(_, time)| *time)),
        ),
        // The names say what they are; a label would lie over the longest.
        Axis::new("", 0.0, names.len() as f64 + 1.0).ticks(&lines),
    )
    .title(&title);
    for (i, times) in times.iter().enumerate() {
        let (color, _, shape) = look(i);
        let y = (names.len() - i) as f64;
        for filled in [true, false] {
            let own = times
                .iter()
                .filter(|(problem, _)| (of.first() == Some(problem)) == filled);
            let marks = Markers::new(own.map(|(_, t)| (*t, y)))
                .color(color)
                .shape(shape)
                .size(5.5);
            panel.add(if filled { marks } else { marks.open() });
        }
    }
    panel
}

/// The legend, which serves all panels, under one.
fn with_legend(panel: Panel, names: &[&str]) -> Panel {
    let mut panel = panel.legend(Legend::Below);
    for (i, name) in names.iter().enumerate() {
        let (color, dash, _) = look(i);
        panel.add(Curve::new([]).color(color).dash(dash).legend(name));
    }
    panel
}

/// The range of logarithms, with a margin; some decade if there are none.
fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    const MARGIN: f64 = 0.25;
    let (low, high) = extent(values);
    if low > high {
        (-1.0, 1.0)
    } else {
        (low - MARGIN, high + MARGIN)
    }
}
