//! The pictures of the listing's convergence and of the scan over parameters.

use super::convergence::{Convergence, NEIGHBOUR_RANGE, distances};
use super::figures::Picture;
use super::scan::{ParameterPoint, ParameterScan, Scan, StartClass};
use crate::figures::side_by_side;
use crate::numbers::largest;
use crate::paper::listing::PRINTED_STEP;
use crate::paper::published::LAST_DIGIT;
use crate::text::joined;
use plot::*;
use stickslip::math;

/// Description of the picture for screen readers.
fn about_convergence(data: &Convergence) -> String {
    let bounds = data.approach.iter().map(|one| format!("{:.1}", one.bound));
    let (all, good) = (data.around.len(), data.steps_that_give_digits());
    format!(
        "Above: distance of the listing's two stick lengths (left) and two stick durations (right) \
         from their limit against its step, all axes logarithmic; the points scatter below and \
         along lines of slope one, the bounds {} times h, of which the larger of each pair is \
         drawn; the printed step is left out of the bounds and marked, the steps around it are \
         drawn smaller. Below: deviation from the published numbers, in units of their last \
         printed digit, for {all} steps within {} per cent of the printed one; at {good} of them \
         all four lie within half a unit.",
        joined(bounds, ", "),
        100.0 * NEIGHBOUR_RANGE
    )
}

/// Two of the four numbers that have one unit.
struct NumberPair {
    unit: &'static str,
    /// Names of the numbers in the title.
    title: &'static str,
    /// Indices in the four numbers, with names, colours and markers.
    members: [(usize, &'static str, Color, Shape); 2],
}

const PAIRS: [NumberPair; 2] = [
    NumberPair {
        unit: "m",
        title: "stick lengths",
        members: [
            (0, "first length", BLUE, Shape::Circle),
            (1, "second length", VERMILLION, Shape::Square),
        ],
    },
    NumberPair {
        unit: "s",
        title: "stick durations",
        members: [
            (2, "first duration", GREEN, Shape::Up),
            (3, "second duration", PURPLE, Shape::Down),
        ],
    },
];

/// Draws the listing's convergence to its limit.
///
/// # Errors
/// As [`Figure::render`].
pub fn convergence(data: &Convergence, published: [f64; 4]) -> Result<Picture, PlotError> {
    let (name, title) = (
        "convergence",
        "The listing as printed for smaller and smaller steps",
    );
    let [lengths, durations] = PAIRS;
    let above = side_by_side(
        approach(data, &lengths, "(a)"),
        approach(data, &durations, "(b)"),
    );
    let below = side_by_side(
        around(data, &lengths, published, "(c)"),
        around(data, &durations, published, "(d)"),
    );
    let figure = Figure::new(name, (760.0, 760.0), title, &about_convergence(data));
    let figure = figure.columns(0.52, above).columns(0.48, below);
    Ok(Picture {
        figure: name,
        title,
        about: "Above: the four numbers of Fig. 8 approach what the event-exact solver gives with \
            the two defects that do not vanish with the step. Below: how far they are from the \
            published ones at steps near the printed one, in units of the last printed digit.",
        svg: figure.render()?,
        curves: String::new(),
        rows: Vec::new(),
    })
}

/// Logarithms for the axes.
fn log((h, error): (f64, f64)) -> (f64, f64) {
    (math::log10(h), math::log10(error))
}

fn approach(data: &Convergence, pair: &NumberPair, label: &str) -> Panel {
    let mut panel = Panel::new(
        Axis::decades("step *h*, s", (-6.15, -2.85)),
        Axis::decades(
            &format!("distance from the limit, {}", pair.unit),
            (-7.0, -2.0),
        ),
    )
    .label(label)
    .title(&format!("{}, *h* → 0", pair.title))
    .legend(Legend::Below);
    let points = |steps, i| distances(steps, &data.limit, i).into_iter().map(log);
    let largest = largest(pair.members.iter().map(|one| data.approach[one.0].bound));
    let line = [-6.15, -2.85].map(|h: f64| (h, h + math::log10(largest)));
    let bound = Curve::new(line).color(GREY).dash(Dash::Dashed);
    panel.add(bound.legend(&format!("larger bound, {largest:.1} *h*")));
    let printed = Guide::vertical(math::log10(PRINTED_STEP)).color(GREY);
    panel.add(printed.width(0.6).legend("printed step"));
    for (i, name, color, shape) in pair.members {
        let markers = |steps| Markers::new(points(steps, i)).shape(shape).color(color);
        panel.add(markers(&data.steps).size(6.0).legend(name));
        panel.add(markers(&data.around).size(2.5));
    }
    let small = format!("small: within {} % of it", 100.0 * NEIGHBOUR_RANGE);
    panel.add(Markers::new([]).color(GREY).size(2.5).legend(&small));
    panel
}

fn around(data: &Convergence, pair: &NumberPair, published: [f64; 4], label: &str) -> Panel {
    let units = |at: &super::matrix::ComparedRun, i: usize| {
        let x = 100.0 * (at.h / PRINTED_STEP - 1.0);
        Some((x, (at.numbers?[i] - published[i]) / LAST_DIGIT))
    };
    // All four numbers share the range.
    let of_step = |at| (0..4).filter_map(move |i| units(at, i));
    let all = data.around.iter().flat_map(of_step);
    let reach = all.fold(1.0, |reach: f64, (_, y)| reach.max(1.05 * y.abs()));
    let reach = reach.ceil();
    let off = format!("off the published number, 10^{{−4}} {}", pair.unit);
    let mut panel = Panel::new(
        Axis::new("step against the printed one, %", -5.5, 5.5).step(1.0),
        Axis::new(&off, -reach, reach),
    )
    .label(label)
    .title(&format!("{} around *h* = 10^{{−4}} s", pair.title))
    .legend(Legend::Below);
    panel.add(Band::y(-0.5, 0.5).legend("rounds to the printed digits"));
    panel.add(Guide::horizontal(0.0).color(GREY).width(0.6));
    let printed = Guide::vertical(0.0).color(GREY).width(0.6);
    panel.add(printed.dash(Dash::Dashed));
    for (i, name, color, shape) in pair.members {
        let points: Vec<(f64, f64)> = data.around.iter().filter_map(|at| units(at, i)).collect();
        panel.add(Curve::new(points.iter().copied()).color(color).width(0.6));
        let markers = Markers::new(points).shape(shape).color(color);
        panel.add(markers.size(6.0).legend(name));
    }
    panel
}

/// Description of the picture for screen readers.
fn about_scan(scan: &Scan) -> String {
    let sticking = scan.printed().map_or(0, ParameterPoint::sticking);
    format!(
        "One strip for each of {} parameters, multiplied by a factor from one half to two. At each \
         factor a column shows in which parts the starts escape, settle on slip only, on \
         stick–slip, on stick–slip of period two, or on nothing periodic. At the printed values, \
         the middle, {sticking} of {} starts lead to stick–slip; stick–slip of period two is \
         marked by triangles.",
        scan.lines.len(),
        scan.starts
    )
}

/// Height of a strip, the rest being space between strips.
const STRIP_HEIGHT: f64 = 0.8;

/// Colour and name of a class.
fn class_style(class: StartClass) -> (Color, &'static str) {
    match class {
        StartClass::Escape => (LIGHT_GREY, "escapes"),
        StartClass::SlipOnly => (SKY, "slip only"),
        StartClass::StickSlip => (ORANGE, "stick–slip, period not two"),
        StartClass::StickSlipTwo => (VERMILLION, "stick–slip of period two"),
        StartClass::Unsettled => (GREY, "nothing repeats"),
    }
}

/// Draws the scan over parameters.
///
/// # Errors
/// As [`Figure::render`].
pub fn scan(scan: &Scan) -> Result<Picture, PlotError> {
    let rows = scan.lines.len();
    // The first parameter on top.
    let base = |k: usize| (rows - 1 - k) as f64;
    let factors = [0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.2, 1.4, 1.6, 1.8, 2.0];
    let ticks = factors.map(|factor| (position(factor), number(factor, 1)));
    let names = scan.lines.iter().enumerate();
    let names = names.map(|(k, line)| (base(k) + 0.5 * STRIP_HEIGHT, line.symbol));
    let half = half_column(scan);
    let (low, high) = (-1.0 - 2.0 * half, 1.0 + 2.0 * half);
    let factor = Axis::new("factor on the printed value", low, high);
    let mut panel = Panel::new(
        factor.ticks(ticks),
        Axis::new("", -0.25, rows as f64).ticks(names),
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
        let has = |point: &&ParameterPoint| point.counts[StartClass::StickSlipTwo as usize] > 0;
        let points = line.points.iter().filter(has);
        points.map(move |point| (position(point.factor), base(k) + 0.15))
    });
    let two: Vec<(f64, f64)> = two.collect();
    if !two.is_empty() {
        let two = Markers::new(two).shape(Shape::Up).color(VERMILLION);
        panel.add(two.size(6.0).legend("a motion of period two exists"));
    }
    let title = "Where starts lead as each parameter of Fig. 8 is changed";
    let figure = Figure::new("scan", (700.0, 560.0), title, &about_scan(scan));
    Ok(Picture {
        figure: "scan",
        title,
        about: "Each parameter of the stated model in turn from half to twice its printed value, \
            the others as printed; solved accurately from the same starts each.",
        svg: figure.row(1.0, panel).render()?,
        curves: String::new(),
        rows: Vec::new(),
    })
}

/// Abscissa of a factor: logarithm to base two.
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
fn strip(line: &ParameterScan, base: f64, half: f64, listed: &mut [bool; 5]) -> Vec<Band> {
    let mut bands = Vec::new();
    for point in &line.points {
        let all = point.counts.iter().sum::<usize>().max(1) as f64;
        let middle = position(point.factor);
        let mut bottom = base;
        for (class, count) in StartClass::ALL.into_iter().zip(point.counts) {
            if count == 0 {
                continue;
            }
            let top = bottom + STRIP_HEIGHT * count as f64 / all;
            let (color, name) = class_style(class);
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
