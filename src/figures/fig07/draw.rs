//! The picture of Fig. 7.

use super::compute::{Branches, Data, SigmaGraph, TangentPointMotion, Z_MAX};
use crate::figures::side_by_side;
use crate::terminal::ProgramError;
use plot::{
    Axis, BLACK, BLUE, Band, Color, Curve, Dash, Figure, GREY, Guide, LIGHT_GREY, Legend, MID_GREY,
    Markers, Note, Panel, Region, VERMILLION,
};

/// Tangent points with odd numbers bound their zone from above, those with even numbers from below.
const EDGES: [(Color, Dash); 2] = [(BLUE, Dash::Solid), (VERMILLION, Dash::Dashed)];

/// The picture.
pub(super) fn draw(data: &Data) -> Result<Figure, ProgramError> {
    let title = "Tangent points: transition function, oscillation, bifurcation";
    let description = "Panel a: the transition function σ against z. Without friction it touches \
        the axis from above at z = −1, 0 and 1; with μ0 = 2√3/9 it is negative between ±2/√3 and \
        touches the axis from below at ±1/√3. Panel b: six tangent points move up and down \
        together over two forcing periods; the strips between the first and second, third and \
        fourth, fifth and sixth are the stick zones. Panel c: tangent points against μ0: six \
        branches start in pairs at z = 1, 0 and −1, the inner four meet in pairs at μ0 = 2√3/9 and \
        ±1/√3, and two branches go on beyond it.";
    let figure = Figure::new("fig07", (680.0, 590.0), title, description);
    let above = side_by_side(transition(data), oscillation(&data.oscillation));
    let figure = figure.columns(1.0, above).row(1.08, branches(data));
    Ok(figure)
}

fn transition(data: &Data) -> Panel {
    let sigma = Axis::new("*σ*(*z*, *μ*_0), m^2/s^4", -0.2, 0.4);
    let mut panel = Panel::new(
        Axis::new("*z*, m", -Z_MAX, Z_MAX).step(0.5).minor(5),
        sigma.step(0.1).minor(2),
    )
    .label("(a)")
    .legend(Legend::UpperMiddle);
    for zone in &data.with_critical.zones {
        let bar = Band::bar(*zone, 0.0, 7.0).fill(MID_GREY);
        panel.add(bar.legend("stick zone, *μ*_0 = 2√3/9"));
    }
    panel.add(Guide::horizontal(0.0).dash(Dash::Dotted));
    let graph = |of: &SigmaGraph| Curve::new(of.graph.iter().copied());
    let zeros = |of: &SigmaGraph| Markers::new(of.zeros.iter().map(|zero| (zero.z, 0.0)));
    let without_friction = graph(&data.without_friction).color(BLUE).dash(Dash::Dashed);
    panel.add(without_friction.legend("*μ*_0 = 0"));
    let critical = graph(&data.with_critical).color(VERMILLION);
    panel.add(critical.legend("*μ*_0 = 2√3/9"));
    panel.add(zeros(&data.without_friction).color(BLUE).open());
    panel.add(zeros(&data.with_critical).color(VERMILLION).open());
    panel
}

fn oscillation(data: &TangentPointMotion) -> Panel {
    let (period, amplitude) = (data.model.period(), data.model.amplitude);
    let end = data.times.last().copied().unwrap_or(period);
    let mut panel = Panel::new(
        Axis::new("*t*, s", 0.0, end).step(0.5).minor(5),
        Axis::new("*x*_1, m", -1.9, 1.9).step(0.5).minor(5),
    )
    .label("(b)");
    let curve = |positions: &[f64]| -> Vec<(f64, f64)> {
        let times = data.times.iter().copied();
        times.zip(positions.iter().copied()).collect()
    };
    for zone in data.positions.chunks_exact(2) {
        panel.add(Region::between(curve(&zone[0]), curve(&zone[1])).fill(LIGHT_GREY));
    }
    panel.add(Guide::vertical(period).label("*t* = 2π/*ω*", 0.06));
    panel.add(Note::new((0.25 * period, amplitude), "stick"));
    for (k, positions) in data.positions.iter().enumerate() {
        let (color, dash) = EDGES[k % 2];
        let name = format!("tangent point {}", k + 1);
        let line = Curve::new(curve(positions)).color(color).dash(dash);
        panel.add(line.name(&name));
        // Beside the maximum of the second period, outside the zone.
        let crest = (1.25 * period, data.points[k] + amplitude);
        let up = if k % 2 == 0 { 5.0 } else { -5.0 };
        panel.add(Note::new(crest, &format!("{}", k + 1)).offset(0.0, up));
    }
    panel
}

fn branches(data: &Data) -> Panel {
    let root = 3f64.sqrt();
    let Branches { below, above, .. } = &data.branches;
    let mut panel = Panel::new(
        Axis::new("*μ*_0, N", 0.0, 4.0 * root / 9.0).ticks([
            (0.0, "0"),
            (root / 9.0, "√3/9"),
            (2.0 * root / 9.0, "2√3/9"),
            (root / 3.0, "√3/3"),
            (4.0 * root / 9.0, "4√3/9"),
        ]),
        Axis::new("*z*, m", -1.5, 1.5).step(0.5).minor(5),
    )
    .label("(c)");
    for zone in below.chunks_exact(2).chain(above.chunks_exact(2)) {
        let [upper, lower] = [0, 1].map(|k: usize| zone[k].iter().copied());
        panel.add(Region::between(upper, lower).fill(LIGHT_GREY));
    }
    panel.add(Guide::vertical(data.critical).color(GREY));
    // Both lists begin with an upper end and have even length, so that the colours alternate across
    // them.
    for (k, branch) in below.iter().chain(above).enumerate() {
        let (color, dash) = EDGES[k % 2];
        let curve = Curve::new(branch.iter().copied()).color(color);
        let name = match k {
            _ if k < below.len() => format!("tangent point {}, below critical", k + 1),
            _ => format!("tangent point {}, above critical", k + 1 - below.len()),
        };
        panel.add(curve.dash(dash).width(1.6).name(&name));
    }
    let drawn = &data.oscillation;
    let six = drawn.points.iter().map(|z| (drawn.model.mu0, *z));
    let mut six = Markers::new(six).color(BLACK).open();
    for k in 0..6 {
        let up = if k % 2 == 0 { 7.0 } else { -7.0 };
        six = six.label(k, &format!("{}", k + 1), (0.0, up));
    }
    panel.add(six);
    let near = 1.0 / root;
    panel.add(Markers::new([(data.critical, near), (data.critical, -near)]).color(BLACK));
    let meet = Note::new((0.5, near), "two tangent points meet");
    panel.add(
        meet.offset(6.0, -12.0)
            .leader((data.critical + 0.004, near)),
    );
    panel.add(Note::new((data.critical, 1.34), "critical *μ*_0").offset(6.0, 0.0));
    panel.add(Note::new((0.58, 0.0), "stick"));
    panel.add(Note::new((0.125, 0.55), "slip only"));
    panel.add(Note::new((0.125, -0.55), "slip only"));
    panel
}
