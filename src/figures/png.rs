//! PNG files from the SVGs, with the embedded font only, so that they look the same everywhere.

use super::error::FigureError;

/// Pixels of the PNG per px of the figure.
#[cfg(feature = "png")]
const ZOOM: f32 = 2.0;

/// Renders an SVG at twice its nominal size.
///
/// # Errors
/// [`FigureError::Png`] if the SVG cannot be read or encoded; [`FigureError::PngNotBuilt`] in a program without the
/// feature `png`.
#[cfg(feature = "png")]
pub fn from_svg(svg: &str) -> Result<Vec<u8>, FigureError> {
    use resvg::{tiny_skia, usvg};

    let mut options = usvg::Options::default();
    for (_, face) in &plot::FACES {
        options.fontdb_mut().load_font_data(face.to_vec());
    }
    let tree = usvg::Tree::from_str(svg, &options).map_err(|e| FigureError::Png(e.to_string()))?;
    let size = tree.size();
    let (width, height) = (size.width() * ZOOM, size.height() * ZOOM);
    let mut pixmap = tiny_skia::Pixmap::new(width.round() as u32, height.round() as u32)
        .ok_or_else(|| FigureError::Png(format!("no room for {width} x {height} pixels")))?;
    let zoom = tiny_skia::Transform::from_scale(ZOOM, ZOOM);
    resvg::render(&tree, zoom, &mut pixmap.as_mut());
    pixmap
        .encode_png()
        .map_err(|e| FigureError::Png(e.to_string()))
}

/// Says that this program cannot make PNG files.
///
/// # Errors
/// Always [`FigureError::PngNotBuilt`].
#[cfg(not(feature = "png"))]
pub fn from_svg(_svg: &str) -> Result<Vec<u8>, FigureError> {
    Err(FigureError::PngNotBuilt)
}

#[cfg(all(test, feature = "png"))]
mod tests {
    use super::*;

    #[test]
    fn a_png_comes_out() {
        let svg =
            r#"<svg xmlns="http://www.w3.org/2000/svg" width="4" height="4"><text>a</text></svg>"#;
        assert!(from_svg(svg).unwrap().starts_with(b"\x89PNG"));
    }

    #[test]
    fn nonsense_is_refused() {
        assert!(matches!(from_svg("<svg"), Err(FigureError::Png(_))));
    }
}
