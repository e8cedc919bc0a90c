//! The work–precision figure.

use std::error::Error;

use plot::*;
use stickslip::math;

use super::problems::descriptions;

const LINE_STYLES: [(Color, Dash, Shape); 9] = [
    (BLACK, Dash::Solid, Shape::Circle),
    (BLUE, Dash::Solid, Shape::Square),
    (VERMILLION, Dash::Solid, Shape::Up),
    (GREEN, Dash::Dashed, Shape::Diamond),
    (PURPLE, Dash::Solid, Shape::Down),
    (ORANGE, Dash::Dashed, Shape::Circle),
    (SKY, Dash::Solid, Shape::Square),
    (GREY, Dash::Dashed, Shape::Up),
    (BLACK, Dash::Dashed, Shape::Diamond),
];
const PANELS_IN_ROW: usize = 2;
/// Height of a row, px. Panels are a little wider than high.
const ROW_HEIGHT: f64 = 290.0;
/// Height of the legend under the last row, px.
const LEGEND_HEIGHT: f64 = 60.0;

/// Errors below this count as equal: the rounding of the times themselves.
const LEAST_ERROR: f64 = 1e-16;

/// Content of the figure for a row of the table.
struct Row {
    solver: String,
    problem: String,
    error: Option<f64>,
    /// Median time of a run (s).
    time: Option<f64>,
    /// Time of a whole process (s).
    process: Option<f64>,
}

/// The rows of a table.
///
/// # Errors
/// A column that is missing; a cell that is no number.
fn read(table: &str) -> Result<Vec<Row>, Box<dyn Error>> {
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    let header = reader.headers()?.clone();
    let columns = ["solver", "problem", "error", "median_s", "process_s"].map(|name| {
        let column = header.iter().position(|one| one == name);
        column.ok_or_else(|| format!("the table has no column {name}"))
    });
    let [solver, problem, error, time, process] = columns;
    let (solver, problem, error, time, process) = (solver?, problem?, error?, time?, process?);
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record?;
        let number = |column: usize| match &record[column] {
            "" => Ok(None),
            cell => cell
                .parse()
                .map(Some)
                .map_err(|_| format!("'{cell}' is no number")),
        };
        rows.push(Row {
            solver: record[solver].into(),
            problem: record[problem].into(),
            error: number(error)?,
            time: number(time)?,
            process: number(process)?,
        });
    }
    Ok(rows)
}

/// The Pareto front of some rows, as (time, error): points at which neither can be improved without
/// the other.
fn front<'a>(rows: impl Iterator<Item = &'a Row>) -> Vec<(f64, f64)> {
    let mut points: Vec<(f64, f64)> = rows
        .filter_map(|row| Some((row.time?, row.error?.max(LEAST_ERROR))))
        .collect();
    points.sort_by(|one, other| one.0.total_cmp(&other.0));
    let mut front: Vec<(f64, f64)> = Vec::new();
    for point in points {
        if front.last().is_none_or(|last| point.1 < last.1) {
            front.push(point);
        }
    }
    front
}

/// The problems of a table in order, with their titles in markup.
fn titles(rows: &[Row]) -> Result<Vec<(&str, String)>, Box<dyn Error>> {
    let all = descriptions()?;
    let title = |name| {
        all.get(name)
            .and_then(|one| one["title"].as_str())
            .map(str::to_owned)
    };
    let names = distinct(rows.iter().map(|row| row.problem.as_str()));
    let titled = names.into_iter().map(|name| {
        Ok((
            name,
            title(name).ok_or_else(|| format!("'{name}' is none of the problems"))?,
        ))
    });
    titled.collect()
}

/// Each distinct item once, in order of first occurrence.
fn distinct<'a>(items: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut all = Vec::new();
    for item in items {
        if !all.contains(&item) {
            all.push(item);
        }
    }
    all
}

/// The SVG of a table: a panel for every problem, and one with the times of whole processes if they
/// were measured.
///
/// # Errors
/// A table that cannot be read; those of [`Figure::render`].
pub fn draw(table: &str) -> Result<String, Box<dyn Error>> {
    let rows = &read(table)?[..];
    let problems = titles(rows)?;
    let names = distinct(rows.iter().map(|row| row.solver.as_str()));
    let mut panels: Vec<Panel> = Vec::new();
    for (i, (name, title)) in problems.iter().enumerate() {
        let of = rows.iter().filter(|row| row.problem == *name);
        let panel = work_precision(&of.collect::<Vec<_>>(), &names);
        panels.push(panel.label(&letter(i)).title(title));
    }
    let mut about_processes = "";
    if rows.iter().any(|row| row.process.is_some()) {
        panels.push(processes(rows, &names, &problems).label(&letter(problems.len())));
        about_processes = " Last panel: time of a whole process, one line for each solver.";
    }
    if let Some(last) = panels.pop() {
        panels.push(with_legend(last, &names));
    }
    let lines = panels.len().div_ceil(PANELS_IN_ROW);
    let height = lines as f64 * ROW_HEIGHT + LEGEND_HEIGHT;
    let (count, solvers) = (problems.len(), names.join(", "));
    let description = format!(
        "{count} panels, one for each problem: largest error of the event times against the time \
         of a run, both logarithmic, one curve for each of {solvers}. Down and to the left is \
         better.{about_processes}"
    );
    let mut figure = Figure::new("bench", (880.0, height), "Work and precision", &description);
    let mut panels = panels.into_iter().map(|panel| (1.0, panel.into()));
    for line in 0..lines {
        let row: Vec<(f64, Cell)> = panels.by_ref().take(PANELS_IN_ROW).collect();
        let weight = if line + 1 == lines {
            ROW_HEIGHT + LEGEND_HEIGHT
        } else {
            ROW_HEIGHT
        };
        figure = figure.columns(weight, row);
    }
    Ok(figure.render()?)
}

/// The label of a panel.
fn letter(index: usize) -> String {
    format!("({})", char::from(b'a' + index as u8))
}

fn line_style(index: usize) -> (Color, Dash, Shape) {
    LINE_STYLES[index % LINE_STYLES.len()]
}

fn work_precision(rows: &[&Row], names: &[&str]) -> Panel {
    let log = |(time, error)| (math::log10(time), math::log10(error));
    let front = |name: &&str| -> Vec<(f64, f64)> {
        let own = rows.iter().copied().filter(|row| row.solver == *name);
        front(own).into_iter().map(log).collect()
    };
    let fronts: Vec<_> = names.iter().map(front).collect();
    let all = || fronts.iter().flatten();
    let mut panel = Panel::new(
        Axis::decades("time of a run, s", range(all().map(|p| p.0))),
        Axis::decades("error of event times", range(all().map(|p| p.1))),
    );
    // Our solvers last, on top.
    for (i, points) in fronts.into_iter().enumerate().rev() {
        let (color, dash, shape) = line_style(i);
        panel.add(Curve::new(points.clone()).color(color).dash(dash));
        panel.add(Markers::new(points).color(color).shape(shape).size(5.5));
    }
    panel
}

/// A line for every solver. Filled markers belong to the first problem timed this way, open ones to
/// the others.
fn processes(rows: &[Row], names: &[&str], problems: &[(&str, String)]) -> Panel {
    let timed = |name: &str| {
        let mut rows = rows.iter();
        rows.any(|row| row.problem == name && row.process.is_some())
    };
    let of = problems.iter().enumerate().filter(|(_, one)| timed(one.0));
    // The legend names the markers by the letters of the problems' panels.
    let letters: Vec<String> = of.clone().map(|(i, _)| letter(i)).collect();
    let title = match &letters[..] {
        [first, others @ ..] if !others.is_empty() => {
            format!(
                "whole process; filled: {first}, open: {}",
                others.join(", ")
            )
        }
        all => format!("whole process of {}", all.join(", ")),
    };
    let first = of.map(|(_, one)| one.0).next();
    let times = |name: &&str| -> Vec<(&str, f64)> {
        let own = rows.iter().filter(|row| row.solver == *name);
        own.filter_map(|row| Some((row.problem.as_str(), math::log10(row.process?))))
            .collect()
    };
    let times: Vec<_> = names.iter().map(times).collect();
    let line = |i: usize| (names.len() - i) as f64;
    let lines = names.iter().enumerate().map(|(i, name)| (line(i), *name));
    let shown = range(times.iter().flatten().map(|(_, time)| *time));
    let mut panel = Panel::new(
        Axis::decades("time to start, compile and run once, s", shown),
        // The solver names identify the lines. An axis label would overlap the longest.
        Axis::new("", 0.0, line(0) + 1.0).ticks(lines),
    )
    .title(&title);
    for (i, times) in times.iter().enumerate() {
        let (color, _, shape) = line_style(i);
        for filled in [true, false] {
            let own = times.iter().filter(|one| (first == Some(one.0)) == filled);
            let marks = Markers::new(own.map(|(_, t)| (*t, line(i))));
            let marks = marks.color(color).shape(shape).size(5.5);
            panel.add(if filled { marks } else { marks.open() });
        }
    }
    panel
}

/// Adds the legend of all panels to one of them.
fn with_legend(panel: Panel, names: &[&str]) -> Panel {
    let mut panel = panel.legend(Legend::Below);
    for (i, name) in names.iter().enumerate() {
        let (color, dash, _) = line_style(i);
        panel.add(Curve::new([]).color(color).dash(dash).legend(name));
    }
    panel
}

/// The range of logarithms, with a margin; an arbitrary decade if there are no values.
fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    const MARGIN: f64 = 0.25;
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    let (low, high) = values.fold(none, |(low, high), one| (low.min(one), high.max(one)));
    if low > high {
        (-1.0, 1.0)
    } else {
        (low - MARGIN, high + MARGIN)
    }
}
