//! Widths of texts, from the metrics of the embedded font.
//!
//! The SVG names the font by family and leaves the setting to the viewer. Liberation Sans has the
//! widths of Arial, which nearly every viewer has, so the boxes computed here fit there too.

use std::sync::LazyLock;

use plotters::style::{FontDesc, FontFamily, FontStyle, register_font};

use super::rich::{self, Run};
use crate::error::PlotError;

/// Name of the embedded font.
const FAMILY: &str = "Liberation Sans";

/// Font families for the SVG, best first.
pub(super) const CSS_FAMILY: &str = "Liberation Sans, Arial, Helvetica, sans-serif";

/// The embedded faces, each with its font file: upright, italic, bold.
pub static FACES: [(FontStyle, &[u8]); 3] = [
    (
        FontStyle::Normal,
        include_bytes!("../assets/fonts/LiberationSans-Regular.ttf"),
    ),
    (
        FontStyle::Italic,
        include_bytes!("../assets/fonts/LiberationSans-Italic.ttf"),
    ),
    (
        FontStyle::Bold,
        include_bytes!("../assets/fonts/LiberationSans-Bold.ttf"),
    ),
];

/// Font size of numbers at axes, legends and tables, px. Chosen by eye.
pub(super) const SMALL_TEXT: f64 = 11.0;

/// Font size of axis and panel labels, px.
pub(super) const LARGE_TEXT: f64 = 12.5;

/// Height of capitals and digits in font sizes (from the font: 1409 of 2048 units).
pub(super) const CAP_HEIGHT: f64 = 0.688;

/// The font library scales by ascender minus descender, not by the em: (1854 + 434) of 2048 units.
const LINE_PER_EM: f64 = 1.1171875;

/// Measured at this size and scaled down, because plotters returns whole pixels.
const MEASURED_SIZE: f64 = 1000.0;

/// Registration happens once per process; the registry is global to plotters.
static REGISTERED: LazyLock<bool> = LazyLock::new(|| {
    FACES
        .iter()
        .all(|(style, bytes)| register_font(FAMILY, *style, bytes).is_ok())
});

/// Width in px of a marked-up text at font size `size` px.
///
/// # Errors
/// [`PlotError::Draw`] if the embedded font cannot be read.
pub(super) fn width(markup: &str, size: f64) -> Result<f64, PlotError> {
    rich::parse(markup)
        .iter()
        .map(|run| run_width(run, size))
        .sum()
}

/// Width in px of a run at the font size `size` px of the text on the line.
///
/// # Errors
/// As of [`width`].
pub(super) fn run_width(run: &Run, size: f64) -> Result<f64, PlotError> {
    if !*REGISTERED {
        return Err(PlotError::Draw("the embedded font is damaged".into()));
    }
    let style = match (run.bold, run.italic) {
        (true, _) => FontStyle::Bold,
        (false, true) => FontStyle::Italic,
        (false, false) => FontStyle::Normal,
    };
    let font = FontDesc::new(FontFamily::Name(FAMILY), MEASURED_SIZE * LINE_PER_EM, style);
    let ((left, _), (right, _)) = font
        .layout_box(&run.text)
        .map_err(|error| PlotError::Draw(error.to_string()))?;
    Ok(f64::from(right - left) / MEASURED_SIZE * size * run.level.scale())
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn widths_are_those_of_the_font() {
        // Advance widths in the font file: digit 1139, space 569, capital M 1706 of 2048 units.
        assert_relative_eq!(width("0", 2048.0).unwrap(), 1139.0, max_relative = 2e-3);
        assert_relative_eq!(width("00", 2048.0).unwrap(), 2278.0, max_relative = 2e-3);
        assert_relative_eq!(width("M", 2048.0).unwrap(), 1706.0, max_relative = 2e-3);
    }

    #[test]
    fn subscripts_are_narrower() {
        let plain = width("01", 100.0).unwrap();
        let sub = width("0_1", 100.0).unwrap();
        assert_relative_eq!(sub, plain * (1.0 + 0.72) / 2.0, max_relative = 2e-3);
    }
}
