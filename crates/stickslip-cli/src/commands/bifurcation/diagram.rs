//! Results of both passes through the range, as tables and as a diagram.

use std::path::PathBuf;
use std::rc::Rc;

use plot::{BLUE, Figure, Guide, Legend, Markers, ORANGE, Panel, Shape};
use stickslip::analysis::{AttractorChange, AttractorKind, Exponent};
use stickslip::dynamics::{Phase, Vector};
use stickslip_model::file::System;
use stickslip_model::study::AtValue;

use super::{Bifurcation, DiagramBlock, Pass};
use crate::commands::exponent;
use crate::commands::sweeping::table;
use crate::commands::{attractors, figures};
use crate::failure::Failure;
use crate::render::Table;
use crate::sweep::Store;

/// Names of the two passes through the range.
pub(super) const DIRECTION_NAMES: [&str; 2] = ["up", "down"];

/// Points of one pass through the range, as parameter and value.
type PointsOfPass = Vec<(f64, f64)>;

/// Selects the points that a panel shows of one pass.
type Shown = fn(&OneDirection) -> &PointsOfPass;

/// An attractor at a value, and a motion of another class at the next value.
pub(super) struct Replacement {
    pub(super) values: (f64, f64),
    /// The attractor at the first value, in words.
    pub(super) lost: String,
    /// The motion at the second value, in words.
    pub(super) reached: String,
    /// The class of that motion.
    pub(super) class: String,
}

/// Neighbouring values of the parameter with the same motion.
pub(super) struct Span {
    /// The first and the last value, in the order of the pass.
    pub(super) values: (f64, f64),
    /// The class of the motion.
    pub(super) class: String,
    /// Error of the run at the first value, if it failed.
    pub(super) reason: Option<String>,
}

/// Content of the figure for one pass through the range.
#[derive(Default)]
pub(super) struct OneDirection {
    /// First state at the section points.
    section: PointsOfPass,
    /// Durations of stick.
    sticks: PointsOfPass,
    /// Largest exponents.
    exponents: PointsOfPass,
    /// Changes along the pass, and the values between which they occur.
    pub(super) changes: Vec<AttractorChange>,
    pub(super) spans: Vec<Span>,
    /// Periods of the periodic orbits, by value.
    periods: PointsOfPass,
    /// The last value and the attractor there in words, if the orbit reached one.
    last: Option<(f64, String)>,
    pub(super) replacements: Vec<Replacement>,
}

impl OneDirection {
    /// Whether the orbit at a value has twice the period of a flip. The period may vary with the
    /// parameter, and other loops make the ratio 1, 3 or 4.
    pub(super) fn is_doubled(&self, value: f64, flip: Option<f64>) -> bool {
        let here = self.periods.iter().find(|(at, _)| *at == value);
        here.zip(flip)
            .is_some_and(|((_, here), flip)| (here / flip - 2.0).abs() < 0.1)
    }

    fn add(&mut self, system: &System, at: &AtValue, until: f64) {
        let value = at.value;
        if let AttractorKind::Periodic { period, .. } = at.reached.kind {
            self.periods.push((value, period));
        }
        let points = at.reached.points.iter();
        self.section.extend(points.map(|point| (value, point.x[0])));
        let sticks = at.sticks().map(|phase| (value, phase.duration()));
        self.sticks.extend(sticks);
        if let Some(Exponent::Finite {
            value: exponent, ..
        }) = at.largest
        {
            self.exponents.push((value, exponent));
        }
        let class = system.class(&at.reached);
        let words = attractors::words(system, &at.reached, until);
        let is_attractor = at.reached.kind.is_attractor();
        let here = is_attractor.then(|| (value, words.clone()));
        let last = std::mem::replace(&mut self.last, here);
        match self.spans.last_mut() {
            Some(span) if span.class == class => span.values.1 = value,
            _ => {
                self.spans.push(Span {
                    values: (value, value),
                    class: class.clone(),
                    reason: attractors::reason(&at.reached),
                });
                self.replacements
                    .extend(last.map(|(before, lost)| Replacement {
                        values: (before, value),
                        lost,
                        reached: words,
                        class,
                    }));
            }
        }
    }
}

impl Bifurcation {
    /// Reads the blocks in order and writes the tables of section points and of sticks.
    pub(super) fn read(
        &self,
        system: &System,
        store: &Store,
        [points, sticks_path]: &[PathBuf; 2],
    ) -> Result<[OneDirection; 2], Failure> {
        let mut directions = [OneDirection::default(), OneDirection::default()];
        let parameter = self.parameter.name.as_str();
        // A value without section points has one entry without a state.
        type Point = (usize, Rc<AtValue>, Option<usize>);
        let columns = Table::new()
            .column("way", |&(way, ..): &Point| DIRECTION_NAMES[way])
            .column(parameter, |(_, at, _)| at.value);
        let columns = attractors::columns(system, columns, |(_, at, _)| &at.reached);
        let columns = exponent::columns(columns, self.duration, |(_, at, _)| at.largest);
        let columns = columns.state(system, "", |(_, at, point)| {
            point.map(|point| at.reached.points[point].x.clone())
        });
        let columns = columns.column("reason", |(_, at, _)| {
            attractors::reason(&at.reached).or_else(|| at.unmeasured.clone())
        });
        table(store, points, &columns, |block, part: DiagramBlock| {
            let number = usize::from(self.pass(block) != Pass::Up);
            let way = &mut directions[number];
            way.changes.extend(part.changes);
            let mut rows = Vec::new();
            for at in part.found.into_iter().map(Rc::new) {
                way.add(system, &at, self.until);
                let points = (0..at.reached.points.len()).map(Some);
                let none = at.reached.points.is_empty().then_some(None);
                rows.extend(points.chain(none).map(|point| (number, at.clone(), point)));
            }
            Ok(rows)
        })?;

        for way in &mut directions {
            way.changes = AttractorChange::merged(std::mem::take(&mut way.changes));
        }

        type Stick = (usize, f64, Phase);
        let lengths = |(.., phase): &Stick| -> Vector { phase.displacement() };
        let columns = Table::new()
            .column("way", |&(way, ..): &Stick| DIRECTION_NAMES[way])
            .column(parameter, |&(_, value, _)| value)
            .column("duration", |(.., phase)| phase.duration())
            .state(system, "_length", lengths);
        table(store, sticks_path, &columns, |block, part: DiagramBlock| {
            let number = usize::from(self.pass(block) != Pass::Up);
            let all = part.found.iter().flat_map(|at| {
                at.sticks()
                    .map(move |phase| (number, at.value, phase.clone()))
            });
            Ok(all.collect())
        })?;
        Ok(directions)
    }

    /// The diagram: section, sticks and exponent over the parameter.
    pub(super) fn figure(&self, [up, down]: &[OneDirection; 2], system: &System) -> Figure {
        let range = &self.parameter;
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
            .filter(|(_, of)| !(of(up).is_empty() && of(down).is_empty()))
            .collect();
        let title = format!("{}: bifurcation diagram", system.file.name);
        let description = format!(
            "Attractors of {} over {} from {} to {}, followed up and down: {} at the points of the \
             section, durations of stick, and the largest Lyapunov exponent; lines where changes \
             were located.",
            system.file.name, range.name, range.low, range.high, first.name
        );
        // Points at the ends of the range stay inside the frame.
        let room = 0.015 * (range.high - range.low);
        let (low, high) = (range.low - room, range.high + room);
        let height = 90.0 + 170.0 * rows.len() as f64;
        let mut figure = Figure::new("bifurcation", (640.0, height), &title, &description);
        let last = rows.len().saturating_sub(1);
        for (k, (label, of)) in rows.into_iter().enumerate() {
            let x = figures::parameter_axis(system, &range.name, (low, high), k == last);
            let values = of(up).iter().chain(of(down)).map(|point| point.1);
            let mut panel = Panel::new(x, figures::axis(&label, values));
            if label.contains('λ') {
                panel.add(Guide::horizontal(0.0));
            }
            for change in up.changes.iter().chain(&down.changes) {
                if let Some(value) = change.what.parameter() {
                    panel.add(Guide::vertical(value));
                }
            }
            // The upward pass has open squares around the points of the downward one, so that both
            // are visible where they agree.
            let up = Markers::new(of(up).iter().copied());
            panel.add(
                up.shape(Shape::Square)
                    .color(BLUE)
                    .open()
                    .size(4.2)
                    .legend("up"),
            );
            let down = Markers::new(of(down).iter().copied());
            panel.add(down.color(ORANGE).size(2.0).legend("down"));
            if k == last {
                panel = panel.legend(Legend::Below);
            }
            // Below the last panel are the numbers of the axis and the legend.
            figure = figure.row(if k == last { 1.3 } else { 1.0 }, panel);
        }
        figure
    }
}
