//! The figure of a spectrum: convergence of the exponents, and directions in the data.

use crate::commands::figures::extremes;
use plot::*;
use stickslip::math;
use stickslip_series::{
    DataSpectrum, DimensionEvidence, Direction, Divergence, Running, Statistics, Status,
    SurrogateTest,
};

use super::findings::{Embedded, Findings, short};

const COLOURS: [Color; 6] = [BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY];
/// Height of a row of panels.
const ROW_HEIGHT: f64 = 420.0;
/// Fraction of the series after which the running means must lie within the vertical axis.
const SETTLED_FRACTION: f64 = 0.1;

/// The figure.
pub(super) fn figure(findings: &Findings, name: &str) -> Figure {
    let spectrum = &findings.spectrum;
    let title = format!("Lyapunov spectrum of {name}");
    let mut description = format!(
        "Left: running means of {} exponents over time. Right: singular values of neighbourhoods \
         over their radius, both logarithmic; {} of them grow in proportion to it.",
        spectrum.exponents.len(),
        spectrum.dimension
    );
    let mut rows: Vec<Vec<Panel>> = vec![vec![convergence(findings), sizes(spectrum)]];
    if let Some(embedded) = &findings.embedded {
        description += &format!(
            " Below: mutual information over the lag, with the delay {}; false neighbours and \
             Cao's averages over the number of delayed values, with the number {} chosen.",
            embedded.choice.embedding.delay, embedded.choice.embedding.dimension
        );
        rows.push(vec![delays(embedded), dimensions(embedded)]);
    }
    let mut checks = Vec::new();
    if let Some(curves) = &findings.divergence {
        description += " Mean logarithm of the distance of neighbours over time, with the straight \
            parts whose slopes are exponents.";
        checks.push(divergence_panel(curves));
    }
    if let Some(test) = &findings.surrogates {
        description += " First exponent and unpredicted part of the series and of surrogates.";
        checks.push(surrogates(test));
    }
    if !checks.is_empty() {
        rows.push(checks);
    }
    let height = ROW_HEIGHT * rows.len() as f64;
    let mut labels = ["(a)", "(b)", "(c)", "(d)", "(e)", "(f)"].into_iter();
    let mut figure = Figure::new("spectrum", (880.0, height), &title, &description);
    for row in rows {
        let cells = row
            .into_iter()
            .zip(labels.by_ref())
            .map(|(panel, label)| (1.0, panel.label(label).into()));
        figure = figure.columns(1.0, cells.collect());
    }
    figure
}

/// A panel with its legend below.
fn panel(title: &str, x: Axis, y: Axis) -> Panel {
    Panel::new(x, y).title(title).legend(Legend::Below)
}

/// Distances between neighbours over time.
fn divergence_panel(divergence: &Divergence) -> Panel {
    let curves = || std::iter::once(&divergence.rosenstein).chain(&divergence.kantz);
    let points = || curves().flat_map(|curve| &curve.points);
    let last = points()
        .map(|point| point.0)
        .fold(f64::MIN_POSITIVE, f64::max);
    let (low, high) = range(points().map(|point| point.1).chain([divergence.saturation]));
    let mut panel = panel(
        "divergence of neighbours",
        Axis::new("*t*", 0.0, last),
        Axis::new("mean ln distance", low, high),
    );
    for (i, curve) in curves().enumerate() {
        let name = match curve.radius {
            Some(radius) => format!("Kantz, radius {}", brief(radius)),
            None => "Rosenstein".into(),
        };
        let slope = match &curve.straight {
            Some(straight) => format!("{} ± {}", brief(straight.slope), brief(straight.stderr)),
            None => "no straight part".into(),
        };
        panel.add(
            Curve::new(curve.points.iter().copied())
                .color(COLOURS[i % COLOURS.len()])
                .legend(&format!("{name}: {slope}")),
        );
        let line = curve
            .straight
            .as_ref()
            .and_then(|straight| straight.line(&curve.points));
        if let Some(line) = line {
            panel.add(Curve::new(line).color(BLACK).width(2.5).dash(Dash::Dotted));
        }
    }
    panel.add(Guide::horizontal(divergence.saturation).legend("distance of any two points"));
    panel
}

/// Four decimals, so that a legend has room.
fn brief(v: f64) -> String {
    if (1e-3..1e4).contains(&v.abs()) {
        number(v, 4)
    } else {
        short(v)
    }
}

/// The series compared with its surrogates.
fn surrogates(test: &SurrogateTest) -> Panel {
    let all = || std::iter::once(&test.series).chain(&test.surrogates);
    let x = range(all().map(|one| one.residual));
    let y = range(all().map(|one| one.exponent));
    let place = |one: &Statistics| (one.residual, one.exponent);
    panel(
        "surrogates",
        Axis::new("unpredicted part", x.0, x.1),
        Axis::new("first exponent", y.0, y.1),
    )
    .with(
        Markers::new(test.surrogates.iter().map(place))
            .color(GREY)
            .size(5.0)
            .legend(&format!("{} surrogates", test.surrogates.len())),
    )
    .with(
        Markers::new([place(&test.series)])
            .color(VERMILLION)
            .size(8.0)
            .legend(&format!("the series, *p* = {:.3}", test.p)),
    )
}

/// Mutual information over the lag.
fn delays(embedded: &Embedded) -> Panel {
    let choice = &embedded.choice;
    let information = choice.information.iter();
    let curve = || information.clone().map(|&(lag, nats)| (lag as f64, nats));
    let last = curve().map(|(lag, _)| lag).fold(1.0, f64::max);
    let (_, high) = range(curve().map(|(_, nats)| nats).chain([0.0]));
    let mut panel = panel(
        "choice of the delay",
        Axis::new("lag, points", 0.0, last),
        Axis::new("mutual information, nats", 0.0, high),
    );
    let delay = choice.embedding.delay as f64;
    if delay <= last {
        let text = format!(
            "delay {}: {}",
            choice.embedding.delay,
            choice.delay_reason.words()
        );
        panel.add(Guide::vertical(delay).color(VERMILLION).legend(&text));
    }
    panel.add(
        Curve::new(curve())
            .color(BLUE)
            .legend("average mutual information"),
    );
    panel
}

/// False neighbours and Cao's averages over the number of delayed values.
fn dimensions(embedded: &Embedded) -> Panel {
    let choice = &embedded.choice;
    let last = choice.dimensions.len().max(2) as f64;
    let all = choice.dimensions.iter().map(|one| one.e2);
    let e2 = all.filter(|v| v.is_finite()).fold(1.0, f64::max);
    let mut panel = panel(
        "choice of the dimension",
        Axis::new("delayed values of a column", 0.5, last + 0.5).step(1.0),
        Axis::new("part that is false; Cao's ratio", 0.0, (1.08 * e2).max(1.2)),
    );
    let text = format!(
        "dimension {}: {}",
        choice.embedding.dimension,
        choice.dimension_reason.words()
    );
    let chosen = choice.embedding.dimension as f64;
    panel.add(Guide::vertical(chosen).color(GREY).legend(&text));
    type Curves = [(&'static str, Color, fn(&DimensionEvidence) -> f64); 3];
    let curves: Curves = [
        ("false nearest neighbours", BLUE, |one| one.false_neighbours),
        ("Cao's E1", VERMILLION, |one| one.e1),
        ("Cao's E2", GREEN, |one| one.e2),
    ];
    for (name, colour, value) in curves {
        let points: Vec<(f64, f64)> = choice
            .dimensions
            .iter()
            .map(|one| (one.dimension as f64, value(one)))
            .filter(|point| point.1.is_finite())
            .collect();
        panel.add(Curve::new(points.clone()).color(colour).legend(name));
        panel.add(Markers::new(points).color(colour).size(5.0));
    }
    panel
}

fn convergence(findings: &Findings) -> Panel {
    let spectrum = &findings.spectrum;
    let end = spectrum.convergence.last().map_or(1.0, |row| row.t);
    let shown = |i: usize| spectrum.exponents[i].status != Status::Annihilated;
    // An unidentified exponent may have any value. The axis is chosen from the others, if there are
    // any.
    let scales = |i: usize| match spectrum.dimension {
        0 => shown(i),
        _ => spectrum.exponents[i].status != Status::Unidentified && shown(i),
    };
    let settled = spectrum.convergence.iter();
    let settled = settled
        .filter(|row| row.t >= SETTLED_FRACTION * end)
        .flat_map(|row| row.exponents.iter().enumerate())
        .filter(|(i, _)| scales(*i));
    let (low, high) = range(settled.map(|(_, v)| *v).chain([0.0]));
    let mut panel = panel(
        "exponents",
        Axis::new("*t*", 0.0, end),
        Axis::new("running mean, per unit of time", low, high),
    );
    panel.add(Guide::horizontal(0.0));
    for (i, exponent) in spectrum.exponents.iter().enumerate() {
        let value = number(exponent.value, 4);
        let (dash, text) = match exponent.status {
            _ if findings.is_spurious(i) => (Dash::Dashed, format!("({value}) spurious")),
            Status::Ok => (Dash::Solid, value),
            Status::Unidentified if exponent.value.is_nan() => {
                (Dash::Dashed, "unidentified".into())
            }
            Status::Unidentified => (Dash::Dashed, format!("({value}) unidentified")),
            Status::Annihilated => (Dash::Dotted, "−∞ annihilated".into()),
            other => (Dash::Solid, format!("{value} {}", other.word())),
        };
        let points = || spectrum.convergence.iter().filter(|_| shown(i));
        let is_seen = |row: &Running| (low..=high).contains(&row.exponents[i]);
        let outside = if exponent.value.is_finite() && !points().any(is_seen) {
            ", outside the axis"
        } else {
            ""
        };
        panel.add(
            Curve::new(points().map(|row| (row.t, row.exponents[i])))
                .color(COLOURS[i % COLOURS.len()])
                .dash(dash)
                .legend(&format!("*λ*_{{{}}} = {text}{outside}", i + 1)),
        );
    }
    panel
}

fn sizes(spectrum: &DataSpectrum) -> Panel {
    let logarithm = |v: f64| if v > 0.0 { math::log10(v) } else { f64::NAN };
    let points = |direction: &Direction| -> Vec<(f64, f64)> {
        let sizes = direction.sizes.iter();
        sizes.map(|&(r, s)| (logarithm(r), logarithm(s))).collect()
    };
    let all: Vec<(f64, f64)> = spectrum.directions.iter().flat_map(points).collect();
    let x = range(all.iter().map(|p| p.0));
    let y = range(all.iter().map(|p| p.1));
    let mut panel = panel(
        "directions of the neighbourhoods",
        Axis::decades("radius", x),
        Axis::decades("singular value / √*n*", y),
    );
    for (i, direction) in spectrum.directions.iter().enumerate() {
        let colour = COLOURS[i % COLOURS.len()];
        let slope = if direction.slope.is_nan() {
            String::new()
        } else {
            format!(", slope {}", number(direction.slope, 2))
        };
        let dash = if i < spectrum.dimension {
            Dash::Solid
        } else {
            Dash::Dashed
        };
        let text = format!("*s*_{{{}}}: {}{slope}", i + 1, direction.kind.word());
        let points = points(direction);
        let curve = Curve::new(points.clone()).color(colour).dash(dash);
        panel.add(curve.legend(&text));
        let finite = points
            .into_iter()
            .filter(|p| p.0.is_finite() && p.1.is_finite());
        panel.add(Markers::new(finite).color(colour).size(5.0));
    }
    panel
}

/// The range of the finite values, with a margin; a default interval if there are none.
fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = extremes(values);
    if low > high {
        return (-1.0, 1.0);
    }
    let margin = (0.06 * (high - low))
        .max(1e-3 * low.abs().max(high.abs()))
        .max(1e-6);
    (low - margin, high + margin)
}
