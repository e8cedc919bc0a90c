//! The picture of Figs. 10, 11 and 12.

use super::compute::{AsPrintedOutcome, Data};
use super::error_bars::{ErrorBar, Source, error_bars};
use super::numbers::{compare, quality};
use super::recorder::{END, START};
use crate::captions::{self, CaptionTable};
use crate::figures::{belt_line, side_by_side};
use crate::motion::Class;
use crate::numbers::extent;
use crate::paper::claim_id::ClaimId;
use crate::paper::models::Caption;
use crate::paper::published::Claims;
use crate::terminal::ProgramError;
use crate::text::joined;
use plot::*;
use stickslip::analysis::Exponent;
use stickslip::math;
use stickslip_series::Status;

const COLOURS: [Color; 4] = [BLUE, VERMILLION, GREEN, PURPLE];
/// Margin around a curve, as a fraction of its extent.
const MARGIN: f64 = 0.06;
/// Running exponents before this fraction of the time still oscillate; they may leave the panel.
const SETTLED_FRACTION: f64 = 0.12;
/// Width of the curves from data, px: broad and pale under the others.
const DATA_WIDTH: f64 = 5.0;
/// Widths of the curves from the equations, px. Each is narrower than the one it may cover.
const EQUATION_WIDTHS: [f64; 4] = [2.0, 1.4, 0.9, 0.8];
/// The axis of exponents is linear below this and logarithmic above.
const LINEAR_RANGE: f64 = 1e-3;

/// Place of the first column of error bars behind the end of the run, and the distance between two
/// columns, as fractions of the run.
const ERROR_BARS: (f64, f64) = (0.14, 0.12);
/// Distance between the bars of two exponents in a column, as a fraction of the run.
const BAR_STEP: f64 = 0.022;
/// Half the width of a cap of a bar, as a fraction of the run.
const CAP: f64 = 0.008;
/// Numbers of the columns, on the axis.
const COLUMN_NUMBERS: [&str; 4] = ["i", "ii", "iii", "iv"];

/// Description of the picture for screen readers.
fn description(data: &Data) -> String {
    let exact = &data.exact;
    let exponents = exact.spectrum.exponents.iter();
    let exponents = exponents.map(|exponent| four_decimals(exponent.value()));
    format!(
        "{} From the equations these come to {}; section points: {}; the motion is {}.",
        data.set.description,
        joined(exponents, ", "),
        section_points(exact.evidence.distinct, exact.evidence.returns),
        exact.class
    )
}

pub(super) fn draw(data: &Data) -> Result<Figure, ProgramError> {
    let (set, size) = (data.set, (860.0, 830.0));
    let below = vec![(0.8, running(data)?.into()), (1.2, table(data)?.into())];
    let figure = Figure::new(set.figure.name(), size, set.title, &description(data));
    let figure = figure.columns(0.47, side_by_side(block(data), bracket(data)));
    let figure = figure.columns(0.43, below).row(0.1, caption(&set.caption));
    Ok(figure)
}

/// An interval that holds all values, with a margin.
fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = extent(values.filter(|v| v.is_finite()));
    let margin = MARGIN * (high - low);
    (low - margin, high + margin)
}

fn width(data: &Data) -> f64 {
    match data.exact.class {
        Class::Periodic(_) => 1.4,
        _ => 0.5,
    }
}

/// The phase plane of a body, empty: `axes` are labels and ranges.
fn plane(label: &str, body: &str, axes: [(&str, (f64, f64)); 2], data: &Data) -> Panel {
    let [x, y] = axes.map(|(label, (low, high))| Axis::new(label, low, high).minor(5));
    let from = END - data.set.shown;
    let title = format!("{body}, corrected equations, *t* = {from} … {END}");
    let panel = Panel::new(x, y).label(label).title(&title);
    panel.legend(Legend::Below)
}

fn block(data: &Data) -> Panel {
    let belt = data.model.belt_speed;
    let curve = || data.curve.iter();
    let axes = [
        ("*x*_1", range(curve().map(|x| x[0]))),
        ("*x*_2", range(curve().map(|x| x[1]).chain([belt]))),
    ];
    let mut panel = plane("(a)", "block", axes, data);
    panel.add(belt_line(belt).legend("Σ: *x*_2 = *v*_p"));
    let points = curve().map(|x| (x[0], x[1]));
    let orbit = Curve::new(points).color(BLUE).width(width(data));
    panel.add(orbit.name("block"));
    if matches!(data.exact.class, Class::Periodic(_)) {
        let turning_points = data.section.iter().take(16).map(|x| (x[0], x[1]));
        panel.add(Markers::new(turning_points).open().legend("section point"));
    }
    panel
}

fn bracket(data: &Data) -> Panel {
    let curve = || data.curve.iter();
    let (low, high) = range(curve().map(|x| x[2]));
    let axes = [
        ("*x*_3", (low, high)),
        ("*x*_4", range(curve().map(|x| x[3]))),
    ];
    let mut panel = plane("(b)", "bracket", axes, data);
    // The border is vertical only if the bracket's velocity does not act on the contact.
    let lift = 1.0 / data.model.unloading;
    if data.model.unloading_rate == 0.0 && lift > low && lift < high {
        let lifted = Band::x(lift, high).fill(LIGHT_GREY);
        panel.add(lifted.legend("no contact, *N* = 0"));
    }
    let points = curve().map(|x| (x[2], x[3]));
    let orbit = Curve::new(points).color(VERMILLION).width(width(data));
    panel.add(orbit.name("bracket"));
    panel
}

/// The numbers of the caption under its heading, and their interpretation.
fn caption(caption: &Caption) -> Table {
    let first = ["*ξ*_1", "*ξ*_2", "*ξ*_3", "*ξ*_4", "*ξ*_5"];
    let named = |last: [&str; 4]| first.into_iter().chain(last).map(str::to_owned).collect();
    let row = |what: &str, numbers: Vec<String>, start: String| {
        [vec![what.to_owned()], numbers, vec![start]].concat()
    };
    let printed = caption.numbers.map(|value| number(value, 3)).to_vec();
    let start = caption.start.map(|value| number(value, 1)).join(", ");
    let headed = named(["*ξ*_6", "*ξ*_7", "*δ*", "*v*_p"]);
    let taken = named(["*μ*_0", "*ξ*_6", "*δ*", "*v*_p"]);
    let states = "*x*_1 … *x*_4".to_owned();
    Table::new(row("**(e)** caption", headed, "start".to_owned()))
        .row(row("as printed", printed, start))
        .row(row("taken for", taken, states))
}

/// An exponent on an axis that is linear near zero and logarithmic elsewhere.
fn scaled(exponent: f64) -> f64 {
    math::log10(1.0 + exponent.abs() / LINEAR_RANGE).copysign(exponent)
}

/// The exponent at a place on that axis.
fn unscaled(place: f64) -> f64 {
    (LINEAR_RANGE * (math::pow(10.0, place.abs()) - 1.0)).copysign(place)
}

fn running(data: &Data) -> Result<Panel, ProgramError> {
    let claims = Claims::committed()?;
    let published = data.set.figure.exponents().map(|id| claims.value(id));
    let convergence = || data.exact.spectrum.convergence.iter();
    let by_data = || data.from_data.convergence.iter();
    let of_data = data.from_data.exponents.iter().take(4).enumerate();
    let reliable = of_data.filter(|(_, exponent)| exponent.status == Status::Ok);
    let reliable: Vec<usize> = reliable.map(|(i, _)| i).collect();
    let end = END - START;
    let settled = convergence().filter(|at| at.elapsed > SETTLED_FRACTION * end);
    let settled = settled.flat_map(|at| at.exponents.iter().copied());
    let settled_data = by_data().filter(|at| at.t > SETTLED_FRACTION * end);
    let settled_data = settled_data.flat_map(|at| reliable.iter().map(|&i| at.exponents[i]));
    let bars = error_bars(data)?;
    let ends = bars.iter().flat_map(|bar| [bar.least, bar.largest]);
    let shown = settled.chain(settled_data).chain(published).chain(ends);
    let (low, high) = range(shown.chain([0.0]).map(scaled));
    let ticks = [-1.0, -0.1, -0.01, -0.001, 0.0, 0.001, 0.01, 0.1, 1.0].map(|exponent: f64| {
        let decimals = if exponent == 0.0 { 0 } else { 3 };
        (scaled(exponent), number(exponent, decimals))
    });
    let ticks = ticks
        .into_iter()
        .filter(|(at, _)| (low..=high).contains(at));
    let (first, step) = ERROR_BARS;
    let column = |source: Source| end * (1.0 + first + step * source as u8 as f64);
    let times = (0..=3).map(|k| f64::from(k) * end / 3.0);
    let times = times.map(|t| (t, number(t, 0)));
    let columns = Source::ALL.into_iter().zip(COLUMN_NUMBERS);
    let columns = columns.map(|(source, name)| (column(source), name.to_owned()));
    let right = column(Source::Settings) + end * first;
    let mut panel = Panel::new(
        Axis::new("*t* − 3000", 0.0, right).ticks(times.chain(columns)),
        Axis::new("*λ* (linear to 10^{−3}, then logarithmic)", low, high)
            .ticks(ticks)
            .value(unscaled),
    )
    .label("(c)")
    .title(&format!(
        "running exponents, error bars{}",
        annihilated(data)
    ))
    .legend(Legend::Below);
    panel.add(Guide::horizontal(0.0).color(GREY).width(0.6));
    // One style for each source, one colour for each exponent.
    for &i in &reliable {
        let points = by_data().map(|at| (at.t, scaled(at.exponents[i])));
        let broad = Curve::new(points).color(COLOURS[i].pale());
        panel.add(
            broad
                .width(DATA_WIDTH)
                .legend(&format!("*λ*_{}, data", i + 1)),
        );
    }
    for i in 0..4 {
        if data.exact.spectrum.exponents[i] == Exponent::Annihilated {
            continue;
        }
        let points = convergence().map(|at| (at.elapsed, scaled(at.exponents[i])));
        let curve = Curve::new(points)
            .color(COLOURS[i])
            .width(EQUATION_WIDTHS[i]);
        panel.add(curve.legend(&format!("*λ*_{}, equations", i + 1)));
    }
    for (i, value) in published.into_iter().enumerate() {
        let ends = [0.0, right].map(|t| (t, scaled(value)));
        let line = Curve::new(ends).color(COLOURS[i]).dash(Dash::Dotted);
        panel.add(line.width(1.6).legend(&format!("*λ*_{}, published", i + 1)));
    }
    panel.add(Guide::vertical(end).color(GREY).width(0.6));
    for bar in &bars {
        let at = column(bar.source) + BAR_STEP * end * (bar.index as f64 - 1.5);
        let name = format!("λ{}, {}", bar.index + 1, bar.source.name());
        let curve = Curve::new(whiskers(bar, at, CAP * end, low));
        panel.add(curve.color(COLOURS[bar.index]).width(1.4).name(&name));
    }
    Ok(panel)
}

/// The line of a bar with its caps. An end of −∞ is at the bottom of the panel.
fn whiskers(bar: &ErrorBar, at: f64, cap: f64, bottom: f64) -> [(f64, f64); 6] {
    let [least, largest] = [bar.least, bar.largest].map(|end| scaled(end).max(bottom));
    [
        (at - cap, least),
        (at + cap, least),
        (at, least),
        (at, largest),
        (at - cap, largest),
        (at + cap, largest),
    ]
}

/// Exponents of −∞ by the equations, which the running means cannot show.
fn annihilated(data: &Data) -> String {
    let exponents = data.exact.spectrum.exponents.iter().enumerate();
    exponents
        .filter(|(_, exponent)| **exponent == Exponent::Annihilated)
        .map(|(i, _)| format!("; *λ*_{} = −∞", i + 1))
        .collect()
}

/// Four decimals, as published.
fn four_decimals(value: f64) -> String {
    if value == f64::NEG_INFINITY {
        "−∞".into()
    } else if value.is_nan() {
        "–".into()
    } else {
        number(value, 4)
    }
}

/// The number of distinct section points, in words.
fn section_points(distinct: usize, returns: usize) -> String {
    match distinct {
        1 => format!("one, met {returns} times"),
        all if all == returns => format!("{returns}, all different"),
        _ => format!("{distinct}, met {returns} times in all"),
    }
}

/// The range of an exponent over captions within their rounding.
fn over_captions(table: &CaptionTable, figure: usize, k: usize) -> String {
    let none = || four_decimals(f64::NEG_INFINITY);
    table.budget(figure, k).map_or_else(none, |budget| {
        let ends = [budget.least, budget.largest].map(four_decimals);
        ends.join(" … ")
    })
}

/// The most frequent class of the captions within their rounding, with its share. A torus is only
/// what no locking was seen of.
fn class_over_captions(table: &CaptionTable, figure: usize) -> String {
    let classes = table.classes(figure);
    let all: usize = classes.iter().map(|(_, count)| count).sum();
    match classes.first() {
        Some((Class::QuasiPeriodic, count)) => format!("not locked: {count} of {all}"),
        Some((class, count)) => format!("{class}: {count} of {all}"),
        None => String::new(),
    }
}

/// Meaning of the ranges over the captions, a line each.
fn on_captions(table: &CaptionTable, figure: usize, class: Class) -> Vec<String> {
    let mut lines = vec![format!(
        "Captions: {} draws, each over {} units of *t*.",
        captions::DRAWS,
        number(captions::DURATION, 0)
    )];
    if class == Class::Chaotic {
        lines.push("Their ranges are scatter of a chaotic orbit over that time.".into());
    } else if let Some(zero) = table.zero_by_theorem(figure) {
        lines.push(format!(
            "The range of *λ*_{} is scatter: a flow has a zero exponent.",
            zero + 1
        ));
    }
    if let Some(slowest) = table.slowest_unseen(figure) {
        lines.push(format!(
            "Locking slower than {} is not seen.",
            four_decimals(slowest)
        ));
    }
    lines
}

/// Meaning of the columns of error bars.
const ON_ERROR_BARS: &str = "Bars in (c): i standard error, ii captions ± 0.0005, \
    iii step and tolerance, iv settings of the estimator.";

fn table(data: &Data) -> Result<Table, ProgramError> {
    let claims = Claims::committed()?;
    let captions = captions::committed()?;
    let figure = data.set.figure as usize;
    let published = |id: ClaimId| claims.of(id).published.clone();
    let header = ["", "published", "equations", "captions ± 0.0005", "data"];
    let mut table =
        Table::new(header).title("**(d)**  per unit of *t*; in brackets: unidentified, last");
    let comparisons = compare(&data.from_data, &data.exact.spectrum.exponents);
    for i in 0..4 {
        let printed = published(data.set.figure.exponents()[i]).replace('-', "−");
        let exponent = &data.exact.spectrum.exponents[i];
        let equations = match exponent.std_error() {
            Some(error) => format!(
                "{} ± {}",
                four_decimals(exponent.value()),
                four_decimals(error)
            ),
            None => four_decimals(exponent.value()),
        };
        let by_data = data
            .from_data
            .exponents
            .get(i)
            .map_or_else(String::new, |e| {
                let value = four_decimals(e.value);
                match e.status {
                    Status::Unidentified => format!("({value})"),
                    _ => match quality(&data.from_data, i, &comparisons) {
                        "ok" | "annihilated" => value,
                        word => format!("{value} {word}"),
                    },
                }
            });
        let name = format!("*λ*_{}", i + 1);
        let over_captions = over_captions(captions, figure, i);
        table = table.row([name, printed, equations, over_captions, by_data]);
    }
    let exact = &data.exact;
    let literal = match &data.literal {
        AsPrintedOutcome::Diverges(t) => format!("beyond 1000 at *t* = {}", number(*t, 1)),
        AsPrintedOutcome::Bounded(measured) => measured.class.to_string(),
    };
    let points = section_points(exact.evidence.distinct, exact.evidence.returns);
    let percent = |share: f64| number(100.0 * share, 2);
    let class = published(data.set.figure.class());
    let row = |name: &str, value: String| [name.to_owned(), String::new(), value];
    let rows = [
        row("section points", points),
        row("stick, % of time", percent(exact.spectrum.stick_fraction)),
        row("off the belt, % of time", percent(exact.lifted_fraction)),
        row("least *N*/*mg*, not clipped", number(exact.least_force, 3)),
        row("losses of contact", exact.contact_losses.to_string()),
        row("signs as printed", literal),
    ];
    let of_class = exact.class.to_string();
    let table = table.row([
        "class".to_owned(),
        class,
        of_class,
        class_over_captions(captions, figure),
    ]);
    let table = rows.into_iter().fold(table, Table::row);
    let mut notes = vec![ON_ERROR_BARS.to_owned()];
    notes.extend(on_captions(captions, figure, exact.class));
    Ok(notes.iter().fold(table, |table, line| table.note(line)))
}
