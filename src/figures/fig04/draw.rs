//! The picture of Fig. 4.

use super::compute::Data;
use crate::figures::belt_line;
use crate::terminal::ProgramError;
use crate::text::joined;
use plot::*;
use stickslip::Visibility;

/// Description of the picture for screen readers.
fn description(data: &Data) -> String {
    let sticks = match data.cycle.sticks {
        0 => "without sticking".to_owned(),
        count => format!("sticking {count} times"),
    };
    format!(
        "Phase plane of a block on a belt, position against velocity. Orbits from {} numbered \
         tangent points on the line of belt speed and from further starts, numbered on, wind onto \
         one limit cycle, which crosses that line {sticks}. Orbits {} stick first. Of the tangent \
         points, {}. An enlargement shows the cycle's kink where it crosses the line, at {:.3} \
         metres.",
        data.tangents.len(),
        joined(
            (1..)
                .zip(&data.sticks)
                .filter(|one| *one.1)
                .map(|one: (usize, _)| one.0),
            ", "
        ),
        data.kinds(),
        data.cycle.left
    )
}

pub(super) fn draw(data: &Data) -> Result<Figure, ProgramError> {
    let title = "Fig. 4: orbits of the belt oscillator and its limit cycle";
    let figure = Figure::new("fig04", (658.0, 640.0), title, &description(data));
    let figure = figure
        .row(0.64, orbits_panel(data))
        .row(0.36, kink_panel(data));
    Ok(figure)
}

const ZONE_THICKNESS: f64 = 9.0;

/// The limit cycle, broad and pale under the orbits, so that orbits on it are visible.
fn cycle(data: &Data) -> Curve {
    Curve::new(data.cycle.curve.iter().copied())
        .color(VERMILLION.pale())
        .width(6.0)
}

/// Stick zones as grey bars, with tangent points on them.
fn boundary(panel: &mut Panel, data: &Data) {
    let belt = data.model.belt_speed;
    panel.add(belt_line(belt));
    for (i, &zone) in data.zones.iter().enumerate() {
        let bar = Band::bar(zone, belt, ZONE_THICKNESS).fill(MID_GREY);
        panel.add(match i {
            0 => bar.legend("stick zones"),
            _ => bar,
        });
    }
    for (wanted, legend) in [
        (Visibility::Visible, "visible tangent point, a start"),
        (Visibility::Invisible, "invisible tangent point, a start"),
    ] {
        let chosen = (1..).zip(&data.tangents);
        let chosen = chosen.filter(|(_, tangent)| tangent.visibility == wanted);
        let chosen: Vec<(usize, f64)> = chosen.map(|(k, at)| (k, at.position)).collect();
        let points = chosen.iter().map(|&(_, x1)| (x1, belt));
        let mut markers = Markers::new(points).color(BLACK).legend(legend);
        if wanted == Visibility::Invisible {
            markers = markers.open();
        }
        for (index, (number, _)) in chosen.iter().enumerate() {
            markers = markers.label(index, &number.to_string(), label_offset(*number));
        }
        panel.add(markers);
    }
}

/// Offset of a tangent point's number, clear of the cycle. The cycle runs above the line at 1 and 2
/// and below it elsewhere.
fn label_offset(number: usize) -> (f64, f64) {
    (0.0, if number <= 2 { -9.0 } else { 9.0 })
}

/// The orbits; one of each kind has a legend.
fn orbits(data: &Data) -> Vec<Curve> {
    let mut listed = [false; 2];
    let mut curves = Vec::new();
    for (number, (orbit, &sticks)) in (1..).zip(data.orbits.iter().zip(&data.sticks)) {
        let curve = Curve::new(orbit.iter().copied()).width(1.0);
        let curve = curve.name(&format!("orbit {number}"));
        let (curve, legend) = match sticks {
            true => (curve.color(PURPLE).dash(Dash::Dashed), "orbits that stick"),
            false => (curve.color(BLUE), "orbits that never stick"),
        };
        curves.push(
            match std::mem::replace(&mut listed[usize::from(sticks)], true) {
                true => curve,
                false => curve.legend(legend),
            },
        );
    }
    curves
}

fn orbits_panel(data: &Data) -> Panel {
    let mut panel = Panel::new(
        Axis::new("*x*_1, m", -2.0, 2.0).step(0.5).minor(5),
        Axis::new("*x*_2, m/s", -1.6, 1.8).step(0.5).minor(5),
    )
    .label("(a)")
    .legend(Legend::Below);
    for tangent in &data.tangents {
        let line = Guide::vertical(tangent.position).color(GREY);
        panel.add(line.width(0.5).dash(Dash::Dashed));
    }
    panel.add(cycle(data).legend("limit cycle"));
    for curve in orbits(data) {
        panel.add(curve);
    }
    boundary(&mut panel, data);
    let further = data.tangents.len();
    let mut starts = Markers::new(data.starts[further..].iter().copied());
    for index in 0..data.starts.len() - further {
        let number = (further + index + 1).to_string();
        starts = starts.label(index, &number, (-9.0, 0.0));
    }
    let starts = starts.shape(Shape::Square).size(6.0).color(GREEN);
    panel.add(starts.legend("further starts"));
    panel
}

fn kink_panel(data: &Data) -> Panel {
    let belt = data.model.belt_speed;
    let cycle = &data.cycle;
    let mut panel = Panel::new(
        Axis::new("*x*_1, m", 0.15, 0.41).step(0.05).minor(5),
        Axis::new("*x*_2, m/s", belt - 0.06, belt + 0.06)
            .step(0.02)
            .minor(2),
    )
    .label("(b)");
    panel.add(self::cycle(data).name("limit cycle"));
    boundary(&mut panel, data);
    for curve in orbits(data).into_iter().take(data.tangents.len()) {
        panel.add(curve);
    }
    // On Σ the slope in the phase plane is the acceleration over the belt's speed.
    let [before, after] = cycle.kink.map(|acceleration| acceleration / belt);
    let at = (cycle.left, belt);
    let text = format!("kink: slope {before:.3} below Σ, {after:.3} above");
    panel.add(Note::new(at, &text).offset(26.0, -52.0).arrow(at));
    panel
}
