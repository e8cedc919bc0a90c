//! The picture of the listing's approach to its limit.

use super::convergence::{Convergence, PRINTED_STEP, REACH, distances};
use crate::figures::{pair, with_ticks};
use crate::text::joined;
use plot::*;
use stickslip::math;

/// What the picture shows, for readers who cannot see it.
fn description(data: &Convergence) -> String {
    let bounds = data.approach.iter().map(|one| format!("{:.1}", one.bound));
    let (all, good) = (data.around.len(), data.steps_that_give_digits());
    format!(
        "Left: distance of the listing's two stick lengths and two stick durations from their limit against its step, both axes \
         logarithmic; the points scatter below and along lines of slope one, the bounds {} times h, of which the largest is drawn; the \
         printed step is left out of the bounds and marked, the steps around it are drawn smaller. Right: deviation from the published numbers, in units of their last printed \
         digit, for {all} steps within {} per cent of the printed one; at {good} of them all four lie within half a unit.",
        joined(bounds, ", "),
        100.0 * REACH
    )
}

/// What the four numbers are called, and how they are drawn.
const NAMES: [(&str, Color, Shape); 4] = [
    ("first stick length, m", BLUE, Shape::Circle),
    ("second stick length, m", VERMILLION, Shape::Square),
    ("first stick duration, s", GREEN, Shape::Up),
    ("second stick duration, s", PURPLE, Shape::Down),
];

/// Draws it.
///
/// # Errors
/// As [`Figure::render`].
pub fn draw(data: &Convergence, published: [f64; 4]) -> Result<String, PlotError> {
    let title = "The listing as printed for smaller and smaller steps";
    let figure = Figure::new("convergence", (760.0, 430.0), title, &description(data));
    let panels = pair(approach(data), around(data, published));
    figure.columns(1.0, panels).render()
}

/// Logarithm for an axis.
fn log((h, error): (f64, f64)) -> (f64, f64) {
    (math::log10(h), math::log10(error))
}

fn approach(data: &Convergence) -> Panel {
    let powers = |from: i32, to: i32| {
        let power = |k: i32| (f64::from(k), format!("10^{{{}}}", number(f64::from(k), 0)));
        (from..=to).map(power)
    };
    let mut panel = Panel::new(
        with_ticks(Axis::new("step *h*, s", -6.15, -2.85), powers(-6, -3)),
        with_ticks(
            Axis::new("distance from the limit", -7.0, -2.0),
            powers(-7, -2),
        ),
    )
    .label("(a)")
    .title("as printed, *h* → 0")
    .legend(Legend::Below);
    let points = |steps, i| distances(steps, &data.limit, i).into_iter().map(log);
    let largest = data.largest_bound();
    let line = [-6.15, -2.85].map(|h: f64| (h, h + math::log10(largest)));
    let bound = Curve::new(line).color(GREY).dash(Dash::Dashed);
    panel.add(bound.legend(&format!("the largest bound, {largest:.1} *h*")));
    let printed = Guide::vertical(math::log10(PRINTED_STEP)).color(GREY);
    panel.add(printed.width(0.6).legend("printed step, not in the fit"));
    for (i, (name, color, shape)) in NAMES.into_iter().enumerate() {
        let markers = |steps| Markers::new(points(steps, i)).shape(shape).color(color);
        panel.add(markers(&data.steps).size(6.0).legend(name));
        panel.add(markers(&data.around).size(2.5));
    }
    let small = format!("small: steps within {} % of it", 100.0 * REACH);
    panel.add(Markers::new([]).color(GREY).size(2.5).legend(&small));
    panel
}

fn around(data: &Convergence, published: [f64; 4]) -> Panel {
    let units = |at: &super::matrix::Cell, i: usize| {
        let x = 100.0 * (at.h / PRINTED_STEP - 1.0);
        Some((x, (at.numbers?[i] - published[i]) / 1e-4))
    };
    let of_step = |at| (0..4).filter_map(move |i| units(at, i));
    let all = data.around.iter().flat_map(of_step);
    let reach = all.fold(1.0, |reach: f64, (_, y)| reach.max(1.05 * y.abs()));
    let reach = reach.ceil();
    let mut panel = Panel::new(
        Axis::new("step against the printed one, %", -5.5, 5.5).step(1.0),
        Axis::new("off the published number, 10^{−4}", -reach, reach),
    )
    .label("(b)")
    .title("around *h* = 10^{−4} s")
    .legend(Legend::Below);
    panel.add(Band::y(-0.5, 0.5).legend("rounds to the printed digits"));
    panel.add(Guide::horizontal(0.0).color(GREY).width(0.6));
    let printed = Guide::vertical(0.0).color(GREY).width(0.6);
    panel.add(printed.dash(Dash::Dashed));
    for (i, (name, color, shape)) in NAMES.into_iter().enumerate() {
        let points: Vec<(f64, f64)> = data.around.iter().filter_map(|at| units(at, i)).collect();
        panel.add(Curve::new(points.iter().copied()).color(color).width(0.6));
        let markers = Markers::new(points).shape(shape).color(color);
        panel.add(markers.size(6.0).legend(name));
    }
    panel
}
