//! How wide a text will be, from the metrics of the embedded font.
//!
//! The SVG names the font by family and leaves the setting to the viewer. Liberation Sans has the widths of
//! Arial, which nearly every viewer has, so the boxes computed here fit there too.

use std::sync::LazyLock;

use ab_glyph::{Font, FontRef, ScaleFont};

use super::PlotError;
use super::rich::{self, Run};

/// Font families for the SVG, best first.
pub(super) const CSS_FAMILY: &str = "Liberation Sans, Arial, Helvetica, sans-serif";

/// The font files of the embedded faces: upright, italic, bold.
pub static FACES: [&[u8]; 3] = [
    include_bytes!("../assets/fonts/LiberationSans-Regular.ttf"),
    include_bytes!("../assets/fonts/LiberationSans-Italic.ttf"),
    include_bytes!("../assets/fonts/LiberationSans-Bold.ttf"),
];

/// Height of capitals and digits in font sizes (from the font: 1409 of 2048 units).
pub(super) const CAP_HEIGHT: f64 = 0.688;

/// The font library scales by ascender minus descender, not by the em: (1854 + 434) of 2048 units.
const LINE_PER_EM: f64 = 1.1171875;

/// Measured at this size, in whole px, and scaled down.
const MEASURED_AT: f64 = 1000.0;

static FONTS: LazyLock<Option<[FontRef<'static>; 3]>> = LazyLock::new(|| {
    let [upright, italic, bold] = FACES.map(|face| FontRef::try_from_slice(face).ok());
    Some([upright?, italic?, bold?])
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
    let Some(fonts) = &*FONTS else {
        return Err(PlotError::Draw("the embedded font is damaged".into()));
    };
    let face = match (run.bold, run.italic) {
        (true, _) => &fonts[2],
        (false, true) => &fonts[1],
        (false, false) => &fonts[0],
    };
    let font = face.as_scaled((MEASURED_AT * LINE_PER_EM) as f32);
    let (mut wide, mut before) = (0.0_f32, None);
    for glyph in run.text.chars().map(|c| font.glyph_id(c)) {
        wide += font.h_advance(glyph);
        if let Some(before) = before.replace(glyph) {
            wide += font.kern(before, glyph);
        }
    }
    Ok(f64::from(wide.trunc()) / MEASURED_AT * size * run.level.scale())
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
