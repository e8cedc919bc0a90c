//! The picture of the scan over parameters.

use super::scan::{Class, Line, Point, Scan};
use crate::figures::with_ticks;
use plot::*;
use stickslip::math;

/// What the picture shows, for readers who cannot see it.
fn description(scan: &Scan) -> String {
    let sticking = scan.printed().map_or(0, |point| {
        point.counts[Class::StickSlip as usize] + point.counts[Class::StickSlipTwo as usize]
    });
    format!(
        "One strip for each of {} parameters, multiplied by a factor from one half to two. At each factor a column shows in which parts the \
         starts escape, settle on slip only, on stick–slip, on stick–slip of period two, or on nothing periodic. At the printed values, the \
         middle, {sticking} of {} starts lead to stick–slip; stick–slip of period two is marked by triangles.",
        scan.lines.len(),
        scan.starts
    )
}

/// Height of a strip; the rest is space between strips.
const HEIGHT: f64 = 0.8;

/// How a class is drawn and called.
fn look(class: Class) -> (Color, &'static str) {
    match class {
        Class::Escape => (LIGHT_GREY, "escapes"),
        Class::SlipOnly => (SKY, "slip only"),
        Class::StickSlip => (ORANGE, "stick–slip, period not two"),
        Class::StickSlipTwo => (VERMILLION, "stick–slip of period two"),
        Class::Unsettled => (GREY, "nothing repeats"),
    }
}

/// Draws it.
///
/// # Errors
/// As [`Figure::render`].
pub fn draw(scan: &Scan) -> Result<String, PlotError> {
    let rows = scan.lines.len();
    // The first parameter on top.
    let base = |k: usize| (rows - 1 - k) as f64;
    let factors = [0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.2, 1.4, 1.6, 1.8, 2.0];
    let ticks = factors.map(|factor| (position(factor), number(factor, 1)));
    let names = scan.lines.iter().enumerate();
    let names = names.map(|(k, line)| (base(k) + 0.5 * HEIGHT, line.symbol));
    let names: Vec<(f64, &str)> = names.collect();
    let half = half_column(scan);
    let (low, high) = (-1.0 - 2.0 * half, 1.0 + 2.0 * half);
    let factor = Axis::new("factor on the printed value", low, high);
    let mut panel = Panel::new(
        with_ticks(factor, ticks),
        Axis::new("", -0.25, rows as f64).ticks(&names),
    )
    .title("Where the starts lead in the stated model (height of a colour: part of the starts)")
    .legend(Legend::Below);
    let mut listed = [false; 5];
    for (k, line) in scan.lines.iter().enumerate() {
        for band in strip(line, base(k), half, &mut listed) {
            panel.add(band);
        }
    }
    let printed = Guide::vertical(0.0).color(BLACK).width(0.8);
    panel.add(printed.dash(Dash::Dashed));
    let two = scan.lines.iter().enumerate().flat_map(|(k, line)| {
        let has = |point: &&Point| point.counts[Class::StickSlipTwo as usize] > 0;
        let points = line.points.iter().filter(has);
        points.map(move |point| (position(point.factor), base(k) + 0.15))
    });
    let two: Vec<(f64, f64)> = two.collect();
    if !two.is_empty() {
        let two = Markers::new(two).shape(Shape::Up).color(VERMILLION);
        panel.add(two.size(6.0).legend("a motion of period two exists"));
    }
    let title = "Where starts lead as each parameter of Fig. 8 is changed";
    let figure = Figure::new("scan", (700.0, 560.0), title, &description(scan));
    figure.row(1.0, panel).render()
}

/// Abscissa of a factor: logarithm to the base of two.
fn position(factor: f64) -> f64 {
    math::ln(factor) / math::ln(2.0)
}

/// Half the width of a column.
fn half_column(scan: &Scan) -> f64 {
    let line = scan.lines.first();
    let columns = line.map_or(2, |line| line.points.len().max(2));
    1.0 / (columns - 1) as f64
}

/// The rectangles of one strip, each class listed in the legend once.
fn strip(line: &Line, base: f64, half: f64, listed: &mut [bool; 5]) -> Vec<Band> {
    let mut bands = Vec::new();
    for point in &line.points {
        let all = point.counts.iter().sum::<usize>().max(1) as f64;
        let middle = position(point.factor);
        let mut bottom = base;
        for (class, count) in Class::ALL.into_iter().zip(point.counts) {
            if count == 0 {
                continue;
            }
            let top = bottom + HEIGHT * count as f64 / all;
            let (color, name) = look(class);
            let mut band = Band::rect((middle - half, middle + half), (bottom, top)).fill(color);
            if !std::mem::replace(&mut listed[class as usize], true) {
                band = band.legend(name);
            }
            bands.push(band);
            bottom = top;
        }
    }
    bands
}
