//! The diagram: section, sticks and exponent over the parameter.

use plot::{BLUE, Figure, Guide, Legend, Markers, ORANGE, Panel, Shape};

use super::super::figures;
use super::found::{Found, Way};
use super::request::Bifurcation;
use crate::output::OutputError;
use stickslip_kernels::file::System;

/// Points of one way through the range, as parameter and value.
type Points = Vec<(f64, f64)>;

/// The points that a panel shows of a way.
type Shown = fn(&Way) -> &Points;

pub(super) fn diagram(
    found: &Found,
    diagram: &Bifurcation,
    system: &System,
) -> Result<String, OutputError> {
    let range = &diagram.parameter;
    let first = &system.file.states[0];
    let rows: [(String, Shown); 3] = [
        (figures::with_unit(&first.name, &first.unit), |way| {
            &way.section
        }),
        (figures::in_time(system, "stick", ""), |way| &way.sticks),
        (figures::in_time(system, "*λ*_1", "^{−1}"), |way| {
            &way.exponents
        }),
    ];
    // A panel without a point would be an empty frame.
    let rows: Vec<_> = rows
        .into_iter()
        .filter(|(_, of)| !(of(&found.up).is_empty() && of(&found.down).is_empty()))
        .collect();
    let title = format!("{}: bifurcation diagram", system.file.name);
    let description = format!(
        "Attractors of {} over {} from {} to {}, followed up and down: {} at the points of the section, durations of stick, and the largest \
         Lyapunov exponent; lines where changes were located.",
        system.file.name, range.name, range.low, range.high, first.name
    );
    // Points at the ends of the range stay inside the frame.
    let room = 0.015 * (range.high - range.low);
    let (low, high) = (range.low - room, range.high + room);
    let height = 90.0 + 170.0 * rows.len() as f64;
    let mut figure = Figure::new("bifurcation", (640.0, height), &title, &description);
    let last = rows.len().saturating_sub(1);
    for (k, (label, of)) in rows.into_iter().enumerate() {
        let x = if k == last {
            plot::Axis::new(&figures::parameter_label(system, &range.name), low, high)
        } else {
            plot::Axis::new("", low, high).bare()
        };
        let values = of(&found.up)
            .iter()
            .chain(of(&found.down))
            .map(|point| point.1);
        let mut panel = Panel::new(x, figures::axis(&label, values));
        if label.contains('λ') {
            panel.add(Guide::horizontal(0.0));
        }
        for value in found.located() {
            panel.add(Guide::vertical(value));
        }
        // Up is an open square around the point of down, so that both are seen where they agree.
        let up = Markers::new(of(&found.up).iter().copied());
        panel.add(
            up.shape(Shape::Square)
                .color(BLUE)
                .open()
                .size(4.2)
                .legend("up"),
        );
        let down = Markers::new(of(&found.down).iter().copied());
        panel.add(down.color(ORANGE).size(2.0).legend("down"));
        if k == last {
            panel = panel.legend(Legend::Below);
        }
        // The last one has the numbers of the axis and the legend below.
        figure = figure.row(if k == last { 1.3 } else { 1.0 }, panel);
    }
    Ok(figure.render()?)
}
