//! The picture of Fig. 8.

use super::compute::Data;
use crate::figures::error::FigureError;
use plot::*;

const DESCRIPTION: &str = "Left: the listing as printed. In the phase plane a closed trajectory of two forcing periods rides \
    the line of belt speed twice, over 0.4697 and 0.1663 metres, and crosses it twice without sticking on the left; \
    below, its position against time among the oscillating stick zones. Right: the stated model with the \
    same parameters, solved accurately. A closed orbit of one forcing period crosses the line twice and never sticks.";

pub(super) fn draw(data: &Data) -> Result<String, FigureError> {
    let printed = &data.as_printed.trajectory;
    let exact = &data.exact.trajectory;
    let start = |trajectory: &[(f64, f64, f64)]| trajectory.first().map_or(0.0, |p| p.0);
    let printed_side = Side {
        data,
        trajectory: printed,
        origin: start(printed),
        crossings: data
            .as_printed
            .deflections
            .iter()
            .map(|crossing| crossing.at.x1)
            .collect(),
        colour: BLUE,
    };
    let exact_side = Side {
        data,
        trajectory: exact,
        origin: start(exact),
        crossings: vec![data.exact.left, data.exact.right],
        colour: VERMILLION,
    };
    let mut left = printed_side.plane("(a)", "listing as printed, *h* = 10^{−4} s", "deflection");
    add_stick_phases(&mut left, data);
    let mut left_strip = printed_side.strip("(c)");
    for stretch in &data.as_printed.stuck {
        let ends = stretch.map(|(t, x1)| (t - printed_side.origin, x1));
        left_strip.add(Curve::new(ends).color(ORANGE).width(3.4));
    }
    let outside = 100.0 * data.as_printed.outside_zones;
    let text = format!("{outside:.0} % of the stick time lies in no stick zone");
    left_strip.add(Note::new(Place::Fraction(0.5, 0.0), &text).offset(0.0, 6.0));
    let mut right = exact_side.plane("(b)", "stated model, exact", "crossing");
    right.add(Note::new((0.03, -0.03), "no stick phase"));
    let right_strip = exact_side.strip("(d)");
    Figure::new(
        "fig08",
        (880.0, 680.0),
        "Fig. 8: stick–slip as printed, and the stated model solved exactly",
        DESCRIPTION,
    )
    .columns(0.6, vec![(1.0, left.into()), (1.0, right.into())])
    .columns(
        0.4,
        vec![(1.0, left_strip.into()), (1.0, right_strip.into())],
    )
    .render()
    .map_err(Into::into)
}

/// The stick phases on the line of belt speed, with their lengths.
fn add_stick_phases(panel: &mut Panel, data: &Data) {
    let belt = data.model.belt_speed;
    for (i, stick) in data.as_printed.sticks.iter().enumerate() {
        let ends = [(stick.entry.x1, belt), (stick.exit.x1, belt)];
        let thick = Curve::new(ends).color(ORANGE).width(3.4);
        panel.add(if i == 0 {
            thick.legend("stick phase")
        } else {
            thick
        });
        let length = format!("{:.4} m", stick.length());
        panel.add(Dimension::new(ends[0], ends[1], &length).shift(30.0));
    }
}

/// One half of the figure.
struct Side<'a> {
    data: &'a Data,
    trajectory: &'a [(f64, f64, f64)],
    /// Time that the lower panel counts from.
    origin: f64,
    /// Positions at which the orbit crosses Σ.
    crossings: Vec<f64>,
    colour: Color,
}

impl Side<'_> {
    fn plane(&self, label: &str, title: &str, crossing: &str) -> Panel {
        let belt = self.data.model.belt_speed;
        let mut panel = Panel::new(
            Axis::new("*x*_1, m", -1.0, 1.0).step(0.5).minor(5),
            Axis::new("*x*_2, m/s", -2.0, 1.8).step(1.0).minor(5),
        )
        .label(label)
        .title(title)
        .legend(Legend::Below);
        let line = Guide::horizontal(belt).color(GREY).width(0.7);
        panel.add(line.dash(Dash::Dashed).legend("Σ: *x*_2 = *v*_p"));
        let reach = self.data.model.amplitude;
        // The outer zones' sweeps overlap this one's and would hide it.
        if let Some(&(lower, upper)) = self.data.zones.get(1) {
            let swept = Band::bar((lower - reach, upper + reach), belt, 9.0);
            panel.add(
                swept
                    .fill(LIGHT_GREY)
                    .legend("sweep of the middle stick zone"),
            );
        }
        let curve = self.trajectory.iter().map(|&(_, x1, x2)| (x1, x2));
        panel.add(Curve::new(curve).color(self.colour).width(1.4));
        let on_belt = self.crossings.iter().map(|&x1| (x1, belt));
        panel.add(Markers::new(on_belt).open().legend(crossing));
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
        for (i, &(lower, upper)) in self.data.zones.iter().enumerate() {
            let end = |z: f64| {
                let origin = self.origin;
                times
                    .iter()
                    .map(move |&t| (t, z + model.support(origin + t)))
                    .collect::<Vec<_>>()
            };
            let zone = Region::between(end(lower), end(upper)).fill(LIGHT_GREY);
            panel.add(if i == 0 {
                zone.legend("stick zones")
            } else {
                zone
            });
        }
        let curve = self
            .trajectory
            .iter()
            .map(|&(t, x1, _)| (t - self.origin, x1));
        panel.add(
            Curve::new(curve)
                .color(self.colour)
                .width(1.4)
                .legend("position of the block"),
        );
        panel
    }
}
