//! The picture of a spectrum: how the exponents converge, and which directions the data have.

use crate::figures::FigureError;
use plot::*;
use stickslip::analysis::data_spectrum::{DataSpectrum, Direction, Status};
use stickslip::math;

const COLOURS: [Color; 6] = [BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY];
/// Part of the series after which the vertical axis must hold the running means.
const SETTLED: f64 = 0.1;

/// The SVG.
///
/// # Errors
/// Those of [`Figure::render`].
pub fn draw(spectrum: &DataSpectrum, name: &str) -> Result<String, FigureError> {
    let title = format!("Lyapunov spectrum of {name}");
    let description = format!(
        "Left: running means of {} exponents over time. Right: singular values of neighbourhoods over their radius, both \
         logarithmic; {} of them grow in proportion to it.",
        spectrum.exponents.len(),
        spectrum.dimension
    );
    Figure::new("spectrum", (880.0, 420.0), &title, &description)
        .columns(
            1.0,
            vec![
                (1.0, convergence(spectrum).into()),
                (1.0, sizes(spectrum).into()),
            ],
        )
        .render()
        .map_err(Into::into)
}

fn convergence(spectrum: &DataSpectrum) -> Panel {
    let end = spectrum.convergence.last().map_or(1.0, |row| row.t);
    let shown = |i: usize| spectrum.exponents[i].status != Status::Annihilated;
    // An unidentified exponent may be anywhere; the axis is for those that mean something, if there are any.
    let scales = |i: usize| match spectrum.dimension {
        0 => shown(i),
        _ => spectrum.exponents[i].status != Status::Unidentified && shown(i),
    };
    let settled = spectrum
        .convergence
        .iter()
        .filter(|row| row.t >= SETTLED * end)
        .flat_map(|row| row.exponents.iter().enumerate())
        .filter(|(i, _)| scales(*i))
        .map(|(_, v)| *v);
    let (low, high) = range(settled.chain([0.0]));
    let mut panel = Panel::new(
        Axis::new("*t*", 0.0, end),
        Axis::new("running mean, per unit of time", low, high),
    )
    .label("(a)")
    .title("exponents")
    .legend(Legend::Below);
    panel.add(Guide::horizontal(0.0));
    for (i, exponent) in spectrum.exponents.iter().enumerate() {
        let (dash, text) = match exponent.status {
            Status::Ok => (Dash::Solid, number(exponent.value, 4)),
            Status::Unidentified if exponent.value.is_nan() => {
                (Dash::Dashed, "unidentified".into())
            }
            Status::Unidentified => (
                Dash::Dashed,
                format!("({}) unidentified", number(exponent.value, 4)),
            ),
            Status::Unstable | Status::Starved | Status::Unpredictable => (
                Dash::Solid,
                format!("{} {}", number(exponent.value, 4), exponent.status.word()),
            ),
            Status::Annihilated => (Dash::Dotted, "−∞ annihilated".into()),
        };
        let points = spectrum.convergence.iter().filter(|_| shown(i));
        panel.add(
            Curve::new(points.map(|row| (row.t, row.exponents[i])))
                .color(COLOURS[i % COLOURS.len()])
                .dash(dash)
                .legend(&format!("*λ*_{{{}}} = {text}", i + 1)),
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
    let mut panel = Panel::new(
        Axis::decades("radius", x),
        Axis::decades("singular value / √*n*", y),
    )
    .label("(b)")
    .title("directions of the neighbourhoods")
    .legend(Legend::Below);
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
        panel.add(
            Curve::new(points.clone())
                .color(colour)
                .dash(dash)
                .legend(&text),
        );
        let finite = points
            .into_iter()
            .filter(|p| p.0.is_finite() && p.1.is_finite());
        panel.add(Markers::new(finite).color(colour).size(5.0));
    }
    panel
}

/// The range of the finite values, widened by a margin; some interval if there is none.
fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(v), high.max(v))
        });
    if low > high {
        return (-1.0, 1.0);
    }
    let margin = (0.06 * (high - low))
        .max(1e-3 * low.abs().max(high.abs()))
        .max(1e-6);
    (low - margin, high + margin)
}
