//! The figure of a fit: data, model, residuals and sticks.

use plot::*;
use stickslip::Mode;
use stickslip_model::file::System;
use stickslip_model::study::fit::Fit;

use super::Wanted;
use crate::commands::figures::{axis, plain, symbol, time_label};

/// Height of the panel of a column, and of that of its residuals, px.
const HEIGHTS: [f64; 2] = [170.0, 90.0];

/// Most sticks that are drawn behind the data.
const MOST_STICKS: usize = 400;

/// Data, model and residuals of a record, with its sticks behind them.
pub(super) fn figure(
    system: &System,
    wanted: &Wanted,
    found: &Fit,
    record: usize,
    name: &str,
) -> Figure {
    let measured = &wanted.request.records[record];
    let times = &measured.times;
    let (from, to) = match (times.first(), times.last()) {
        (Some(from), Some(to)) if from < to => (*from, *to),
        _ => (0.0, 1.0),
    };
    let columns = found
        .columns
        .iter()
        .filter(|column| column.record == record);
    let columns: Vec<_> = columns.collect();
    let sticks = found.phases[record]
        .iter()
        .filter(|phase| phase.2.any_sticks());
    let sticks: Vec<(f64, f64)> = sticks
        .map(|phase| (phase.0.max(from), phase.1.min(to)))
        .filter(|(begin, end)| begin < end)
        .take(MOST_STICKS)
        .collect();
    let height = (HEIGHTS[0] + HEIGHTS[1] + 32.0) * columns.len() as f64 + 60.0;
    let title = format!("{}: fit to {}", system.file.name, plain(&measured.name));
    let description = format!(
        "{} columns of {} measured values, the fitted model and the residuals, from t = {from} to \
         {to}. It sticks {} times.",
        columns.len(),
        times.len(),
        sticks.len()
    );
    let mut figure = Figure::new(name, (720.0, height), &title, &description);
    for (k, column) in columns.iter().enumerate() {
        let data = &measured.columns[column.observable];
        let observable = &wanted.request.observables[column.observable];
        let points = |values: &[f64]| -> Vec<(f64, f64)> {
            let pairs = times.iter().copied().zip(values.iter().copied());
            pairs.filter(|point| point.1.is_finite()).collect()
        };
        let label = symbol(&observable.name);
        let values = data.iter().chain(&column.model).copied();
        let mut panel =
            Panel::new(Axis::new("", from, to).bare(), axis(&label, values)).legend(Legend::Below);
        let residuals = column.residuals.iter().copied();
        let is_last = k + 1 == columns.len();
        let time = match is_last {
            true => Axis::new(&time_label(system), from, to),
            false => Axis::new("", from, to).bare(),
        };
        let mut below = Panel::new(time, axis("residual", residuals.chain([0.0])));
        for &(begin, end) in &sticks {
            panel.add(Band::x(begin, end).fill(LIGHT_ORANGE));
            below.add(Band::x(begin, end).fill(LIGHT_ORANGE));
        }
        let size = if times.len() > 300 { 2.0 } else { 4.0 };
        panel.add(
            Markers::new(points(data))
                .size(size)
                .color(BLACK)
                .legend("measured"),
        );
        panel.add(
            Curve::new(points(&column.model))
                .color(BLUE)
                .width(1.4)
                .legend("fit"),
        );
        let of_column = found.seen.iter().filter(|one| one.record == record);
        let of_column = of_column.filter(|one| one.observable == column.observable);
        let lowest = (data.iter().chain(&column.model).copied()).fold(f64::INFINITY, f64::min);
        let seen = of_column.flat_map(|one| &one.data);
        let seen = seen
            .filter(|phase| phase.2 == Mode::Stick)
            .flat_map(|phase| {
                let (begin, end, _) = *phase;
                [(begin, lowest), (end, lowest), (f64::NAN, f64::NAN)]
            });
        let seen: Vec<(f64, f64)> = seen.collect();
        if !seen.is_empty() {
            let shown = Curve::new(seen).color(ORANGE).width(4.0);
            panel.add(shown.legend("sticks in the data"));
        }
        below.add(Guide::horizontal(0.0));
        below.add(
            Markers::new(points(&column.residuals))
                .size(size)
                .color(VERMILLION),
        );
        let last = if is_last { 44.0 } else { 0.0 };
        figure = figure.row(HEIGHTS[0], panel).row(HEIGHTS[1] + last, below);
    }
    figure
}
