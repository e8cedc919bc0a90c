//! The picture of Fig. 8.

use super::compute::Data;
use crate::figures::{belt_line, side_by_side};
use crate::numbers::extent;
use crate::paper::listing::{Crossing, Instant, PRINTED_STEP};
use crate::terminal::ProgramError;
use plot::*;
use stickslip::math;

/// Description of the picture for screen readers.
fn description(data: &Data) -> String {
    let printed = &data.as_printed.pattern;
    let exact = &data.exact.pattern;
    let list = |positions: Vec<String>| (times(positions.len()), positions.join(" and "));
    let rides = printed.pattern_sticks();
    let rides = rides.map(|stick| format!("{:.4}", stick.length()));
    let (ridden, rides) = list(rides.collect());
    let (deflected, left) = list(printed.deflections().iter().map(position).collect());
    let (crossed, there) = list(exact.pattern_crossings().map(position).collect());
    format!(
        "Left: the listing as printed. In the phase plane a closed trajectory of {} rides the line \
         of belt speed {ridden}, over {rides} metres, and crosses it without sticking {deflected} \
         on the left, at {left} metres, enlarged in a corner; below, its position against time \
         among the oscillating stick zones. Right: the stated model with the same parameters, \
         solved accurately. A closed orbit of {} crosses the line {crossed}, at {there} metres, \
         and {} sticks.",
        periods(printed.period),
        periods(exact.period),
        times(exact.pattern_sticks().count()),
    )
}

fn position(crossing: &Crossing) -> String {
    number(crossing.at.x1, 3)
}

fn times(count: usize) -> String {
    match count {
        0 => "never".into(),
        1 => "once".into(),
        2 => "twice".into(),
        more => format!("{more} times"),
    }
}

fn periods(count: usize) -> String {
    match count {
        1 => "1 forcing period".into(),
        more => format!("{more} forcing periods"),
    }
}

pub(super) fn draw(data: &Data) -> Result<Figure, ProgramError> {
    let printed_side = HalfFigure::of(data, &data.as_printed.trajectory, BLUE);
    let exact_side = HalfFigure::of(data, &data.exact.trajectory, VERMILLION);
    let power = number(math::log10(PRINTED_STEP), 0);
    let title = format!("listing as printed, *h* = 10^{{{power}}} s");
    let mut left = printed_side.plane("(a)", &title);
    add_stick_phases(&mut left, data);
    add_deflections(&mut left, &printed_side);
    left.add(start(data));
    let mut left_strip = printed_side.strip("(c)");
    add_durations(&mut left_strip, &printed_side);
    let outside = 100.0 * data.as_printed.outside_zones;
    let text = format!("{outside:.0} % of the stick time lies in no stick zone");
    left_strip.add(Note::new(Position::Fraction(0.5, 0.0), &text).offset(0.0, 6.0));
    let mut right = exact_side.plane("(b)", "stated model, exact");
    let belt = data.model.belt_speed;
    let crossings = data.exact.pattern.pattern_crossings();
    let crossings = crossings.map(|crossing| (crossing.at.x1, belt));
    right.add(Markers::new(crossings).open().legend("crossing"));
    let sticks = match data.exact.pattern.pattern_sticks().count() {
        0 => "no stick phase".to_owned(),
        1 => "1 stick phase".to_owned(),
        more => format!("{more} stick phases"),
    };
    right.add(Note::new((0.03, -0.03), &sticks));
    right.add(start(data));
    let right_strip = exact_side.strip("(d)");
    let title = "Fig. 8: stick–slip as printed, and the stated model solved exactly";
    let figure = Figure::new("fig08", (770.0, 680.0), title, &description(data));
    let strips = side_by_side(left_strip, right_strip);
    let figure = figure
        .columns(0.6, side_by_side(left, right))
        .columns(0.4, strips);
    Ok(figure)
}

/// The listing's start.
fn start(data: &Data) -> Markers {
    let start = Markers::new([data.as_printed.start]).shape(Shape::Square);
    start.size(6.0).color(GREEN).legend("start")
}

/// Points where the listing releases the body.
fn releases(points: Vec<(f64, f64)>) -> Markers {
    let points = Markers::new(points).shape(Shape::Diamond);
    points.size(7.0).color(PURPLE).legend("release")
}

/// Position of the durations in the lower panel (m).
const DURATIONS_AT: f64 = -1.4;

/// The stick phases against time, with their durations and releases.
fn add_durations(strip: &mut Panel, side: &HalfFigure<'_>) {
    let at = |instant: &Instant| (instant.t - side.origin, instant.x1);
    let sticks = &side.data.as_printed.stuck;
    for (i, stick) in sticks.iter().enumerate() {
        let ends = [at(&stick.entry), at(&stick.exit)];
        let thick = Curve::new(ends).color(ORANGE).width(3.4);
        let thick = thick.name(&format!("stick phase {}", i + 1));
        strip.add(if i == 0 { thick.legend("stick") } else { thick });
        let [from, to] = ends.map(|(t, _)| (t, DURATIONS_AT));
        strip.add(Dimension::new(
            from,
            to,
            &format!("{:.4} s", stick.duration()),
        ));
    }
    strip.add(releases(
        sticks.iter().map(|stick| at(&stick.exit)).collect(),
    ));
}

/// The stick phases on the line of belt speed, with their lengths and releases.
fn add_stick_phases(panel: &mut Panel, data: &Data) {
    let belt = data.model.belt_speed;
    for (i, stick) in data.as_printed.pattern.pattern_sticks().enumerate() {
        let ends = [(stick.entry.x1, belt), (stick.exit.x1, belt)];
        let thick = Curve::new(ends).color(ORANGE).width(3.4);
        let thick = thick.name(&format!("stick phase {}", i + 1));
        panel.add(match i {
            0 => thick.legend("stick phase"),
            _ => thick,
        });
        let length = format!("{:.4} m", stick.length());
        panel.add(Dimension::new(ends[0], ends[1], &length).shift(30.0));
    }
    let sticks = data.as_printed.pattern.pattern_sticks();
    panel.add(releases(
        sticks.map(|stick| (stick.exit.x1, belt)).collect(),
    ));
}

/// The deflections, which are too close together for the panel's scale. They are drawn small, and
/// enlarged in a corner.
fn add_deflections(panel: &mut Panel, side: &HalfFigure<'_>) {
    let belt = side.data.model.belt_speed;
    let deflections = side.data.as_printed.pattern.deflections();
    let points = || deflections.iter().map(|crossing| (crossing.at.x1, belt));
    panel.add(Markers::new(points()).size(4.0).open());
    let positions = || deflections.iter().map(|crossing| crossing.at.x1);
    let (least, most) = extent(positions());
    if most < least {
        return;
    }
    let (middle, reach) = (0.5 * (least + most), (0.5 * (most - least)).max(0.005));
    let (from, to) = (middle - 3.0 * reach, middle + 3.0 * reach);
    let ticks = positions().map(|x1| (x1, number(x1, 3)));
    let mut detail = Panel::new(
        Axis::new("", from, to).ticks(ticks),
        Axis::new("", belt - 0.1, belt + 0.1).ticks::<&str>([]),
    );
    detail.add(belt_line(belt));
    let curve = side.trajectory.iter().map(|&(_, x1, x2)| (x1, x2));
    detail.add(Curve::new(curve).color(side.colour).width(1.4));
    detail.add(Markers::new(points()).open());
    panel.add(Inset::new((0.03, 0.72), (0.42, 0.98), detail));
    // The legend shows the symbol once, in the large size.
    let symbol = Markers::new([]).open();
    panel.add(symbol.legend("deflection, enlarged in the corner"));
}

/// One half of the figure.
struct HalfFigure<'a> {
    data: &'a Data,
    trajectory: &'a [(f64, f64, f64)],
    /// Origin of the lower panel's time axis.
    origin: f64,
    colour: Color,
}

impl<'a> HalfFigure<'a> {
    fn of(data: &'a Data, trajectory: &'a [(f64, f64, f64)], colour: Color) -> Self {
        HalfFigure {
            data,
            trajectory,
            origin: trajectory.first().map_or(0.0, |p| p.0),
            colour,
        }
    }

    fn plane(&self, label: &str, title: &str) -> Panel {
        let belt = self.data.model.belt_speed;
        let mut panel = Panel::new(
            Axis::new("*x*_1, m", -1.0, 1.0).step(0.5).minor(5),
            Axis::new("*x*_2, m/s", -2.0, 2.6).step(1.0).minor(5),
        )
        .label(label)
        .title(title)
        .legend(Legend::Below);
        panel.add(belt_line(belt).legend("Σ: *x*_2 = *v*_p"));
        let reach = self.data.model.amplitude;
        // The sweeps of the outer zones overlap this one and would hide it.
        if let Some(&(lower, upper)) = self.data.zones.get(1) {
            let swept = Band::bar((lower - reach, upper + reach), belt, 9.0).fill(LIGHT_GREY);
            panel.add(swept.legend("sweep of the middle stick zone"));
        }
        let curve = self.trajectory.iter().map(|&(_, x1, x2)| (x1, x2));
        let curve = Curve::new(curve).color(self.colour).width(1.4);
        panel.add(curve.name("trajectory"));
        panel
    }

    fn strip(&self, label: &str) -> Panel {
        let model = &self.data.model;
        let span = 2.0 * model.period();
        let mut panel = Panel::new(
            Axis::new("*t* − *t*_0, s", 0.0, span).step(0.5).minor(5),
            Axis::new("*x*_1, m", -2.0, 1.6).step(1.0).minor(2),
        )
        .label(label)
        .legend(Legend::Below);
        let times: Vec<f64> = (0..=400).map(|k| span * f64::from(k) / 400.0).collect();
        let over_time = |z: f64| -> Vec<(f64, f64)> {
            let at = |&t: &f64| (t, z + model.support(self.origin + t));
            times.iter().map(at).collect()
        };
        for (i, &(lower, upper)) in self.data.zones.iter().enumerate() {
            let zone = Region::between(over_time(lower), over_time(upper)).fill(LIGHT_GREY);
            panel.add(match i {
                0 => zone.legend("stick zones"),
                _ => zone,
            });
        }
        let curve = self.trajectory.iter();
        let curve = curve.map(|&(t, x1, _)| (t - self.origin, x1));
        let curve = Curve::new(curve).color(self.colour).width(1.4);
        panel.add(curve.legend("position of the block"));
        panel
    }
}
