//! The picture of Figs. 10, 11 and 12.

use super::compute::{AsPrintedOutcome, Data};
use super::numbers::{compare, quality};
use super::recorder::{END, START};
use crate::figures::{belt_line, side_by_side};
use crate::numbers::extent;
use crate::paper::claim_id::ClaimId;
use crate::paper::models::Caption;
use crate::paper::published::Claims;
use crate::terminal::ProgramError;
use crate::text::joined;
use plot::*;
use stickslip::analysis::Exponent;
use stickslip::analysis::motion::Class;
use stickslip::math;
use stickslip_series::Status;

const COLOURS: [Color; 4] = [BLUE, VERMILLION, GREEN, PURPLE];
/// Margin around a curve, as a fraction of its extent.
const MARGIN: f64 = 0.06;
/// Running exponents before this fraction of the time still oscillate; they may leave the panel.
const SETTLED_FRACTION: f64 = 0.12;
/// Widths of the curves from data, px. They are broad under the curves from the equations, and each
/// is narrower than the one it may cover.
const DATA_WIDTHS: [f64; 4] = [6.0, 4.0, 3.0, 2.0];
/// Neighbouring exponents may coincide; one of two is dashed and on top.
const DASHES: [Dash; 4] = [Dash::Solid, Dash::Dashed, Dash::Solid, Dash::Dashed];
/// The axis of exponents is linear below this and logarithmic above.
const LINEAR_RANGE: f64 = 1e-3;

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

pub(super) fn draw(data: &Data) -> Result<String, ProgramError> {
    let (set, size) = (data.set, (770.0, 800.0));
    let below = vec![(0.9, running(data)?.into()), (1.1, table(data)?.into())];
    let figure = Figure::new(set.figure.name(), size, set.title, &description(data));
    let figure = figure.columns(0.47, side_by_side(block(data), bracket(data)));
    let figure = figure.columns(0.43, below).row(0.1, caption(&set.caption));
    Ok(figure.render()?)
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
    panel.add(Curve::new(points).color(BLUE).width(width(data)));
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
    panel.add(Curve::new(points).color(VERMILLION).width(width(data)));
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
    let shown = settled.chain(settled_data).chain(published).chain([0.0]);
    let (low, high) = range(shown.map(scaled));
    let ticks = [-1.0, -0.1, -0.01, -0.001, 0.0, 0.001, 0.01, 0.1, 1.0].map(|exponent: f64| {
        let decimals = if exponent == 0.0 { 0 } else { 3 };
        (scaled(exponent), number(exponent, decimals))
    });
    let ticks = ticks
        .into_iter()
        .filter(|(at, _)| (low..=high).contains(at));
    let mut panel = Panel::new(
        Axis::new("*t* − 3000", 0.0, end).step(3000.0).minor(3),
        Axis::new("*λ*, running means", low, high).ticks(ticks),
    )
    .label("(c)")
    .title(&format!("exponents{}", annihilated(data)))
    .legend(Legend::Below);
    panel.add(Guide::horizontal(0.0).color(GREY).width(0.6));
    // Broad and pale, under the equations' curves: where both agree, both remain visible.
    for &i in &reliable {
        let points = by_data().map(|at| (at.t, scaled(at.exponents[i])));
        let broad = Curve::new(points)
            .color(COLOURS[i].pale())
            .width(DATA_WIDTHS[i]);
        panel.add(broad.legend(&format!("*λ*_{}, data", i + 1)));
    }
    for (i, value) in published.into_iter().enumerate() {
        let ends = [0.0, end].map(|t| (t, scaled(value)));
        let line = Curve::new(ends).color(COLOURS[i]).dash(Dash::Dotted);
        panel.add(line.width(1.2).legend(&format!("*λ*_{}, published", i + 1)));
    }
    // The dashed curves last, on top.
    for i in [0, 2, 1, 3] {
        if data.exact.spectrum.exponents[i] == Exponent::Annihilated {
            continue;
        }
        let points = convergence().map(|at| (at.elapsed, scaled(at.exponents[i])));
        let curve = Curve::new(points).color(COLOURS[i]).dash(DASHES[i]);
        panel.add(curve.legend(&format!("*λ*_{}, equations", i + 1)));
    }
    Ok(panel)
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

/// The indices of the exponents from data, by size; unidentified ones come last.
fn by_size(data: &Data) -> Vec<usize> {
    let exponents = &data.from_data.exponents;
    let is_unidentified = |i: usize| exponents[i].status == Status::Unidentified;
    let mut order: Vec<usize> = (0..exponents.len()).collect();
    order.sort_by(|&one, &other| {
        let by_value = exponents[other].value.total_cmp(&exponents[one].value);
        let by_status = is_unidentified(one).cmp(&is_unidentified(other));
        by_status.then(by_value)
    });
    order
}

/// The number of distinct section points, in words.
fn section_points(distinct: usize, returns: usize) -> String {
    match distinct {
        1 => format!("one, met {returns} times"),
        all if all == returns => format!("{returns}, all different"),
        _ => format!("{distinct}, met {returns} times in all"),
    }
}

fn table(data: &Data) -> Result<Table, ProgramError> {
    let claims = Claims::committed()?;
    let published = |id: ClaimId| claims.of(id).published.clone();
    let mut table = Table::new(["", "published", "from equations", "from data"])
        .title("**(d)**  per unit of *t*; in brackets: unidentified, last");
    let comparisons = compare(&data.from_data, &data.exact.spectrum.exponents);
    let order = by_size(data);
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
        let by_data = order.get(i).map_or_else(String::new, |&i| {
            let e = &data.from_data.exponents[i];
            let value = four_decimals(e.value);
            match e.status {
                Status::Unidentified => format!("({value})"),
                _ => match quality(&data.from_data, i, &comparisons) {
                    "ok" | "annihilated" => value,
                    word => format!("{value} {word}"),
                },
            }
        });
        table = table.row([format!("*λ*_{}", i + 1), printed, equations, by_data]);
    }
    let exact = &data.exact;
    let literal = match &data.literal {
        AsPrintedOutcome::Diverges(t) => format!("beyond 1000 at *t* = {}", number(*t, 1)),
        AsPrintedOutcome::Bounded(measured) => measured.class.to_string(),
    };
    let points = section_points(exact.evidence.distinct, exact.evidence.returns);
    let stick = number(100.0 * exact.spectrum.stick_fraction, 2);
    let force = number(exact.least_force, 3);
    let class = published(data.set.figure.class());
    let none = String::new();
    let rows = [
        ("class", class, exact.class.to_string()),
        ("section points", none.clone(), points),
        ("stick, % of time", none.clone(), stick),
        ("least *N*/*mg*, not clipped", none.clone(), force),
        (
            "off the belt, % of time",
            none.clone(),
            number(100.0 * data.lifted_share(), 1),
        ),
        ("signs as printed", none.clone(), literal),
    ];
    let cells = |(name, published, value): (&str, String, String)| {
        [name.to_owned(), published, value, none.clone()]
    };
    Ok(rows.into_iter().map(cells).fold(table, Table::row))
}
