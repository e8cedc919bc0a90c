//! PNG files from SVGs, with the embedded font only, so that they look the same everywhere.

/// An SVG cannot be turned into a PNG.
#[derive(Clone, Debug, thiserror::Error)]
pub enum PngError {
    /// The program was built without the feature `png`.
    #[error("this program was built without PNG output")]
    NotBuilt,
    /// The SVG cannot be read, or the image cannot be rendered.
    #[error("cannot render the SVG as PNG: {0}")]
    Rendering(String),
}

/// Pixels of the PNG per px of the figure.
#[cfg(feature = "png")]
const ZOOM: f32 = 2.0;

/// Renders an SVG at twice its nominal size.
///
/// # Errors
/// [`PngError::Rendering`]; [`PngError::NotBuilt`] in a program without the feature `png`.
#[cfg(feature = "png")]
pub fn png(svg: &str) -> Result<Vec<u8>, PngError> {
    use resvg::{tiny_skia, usvg};

    let mut options = usvg::Options::default();
    for (_, face) in &plot::FACES {
        options.fontdb_mut().load_font_data(face.to_vec());
    }
    let tree =
        usvg::Tree::from_str(svg, &options).map_err(|e| PngError::Rendering(e.to_string()))?;
    let size = tree.size();
    let (width, height) = (size.width() * ZOOM, size.height() * ZOOM);
    let mut pixmap = tiny_skia::Pixmap::new(width.round() as u32, height.round() as u32)
        .ok_or_else(|| PngError::Rendering(format!("no room for {width} x {height} pixels")))?;
    let zoom = tiny_skia::Transform::from_scale(ZOOM, ZOOM);
    resvg::render(&tree, zoom, &mut pixmap.as_mut());
    pixmap
        .encode_png()
        .map_err(|e| PngError::Rendering(e.to_string()))
}

/// Reports that this program cannot write PNG files.
///
/// # Errors
/// Always [`PngError::NotBuilt`].
#[cfg(not(feature = "png"))]
pub fn png(_svg: &str) -> Result<Vec<u8>, PngError> {
    Err(PngError::NotBuilt)
}

#[cfg(all(test, feature = "png"))]
mod tests {
    use super::*;

    #[test]
    fn a_png_comes_out() {
        let svg =
            r#"<svg xmlns="http://www.w3.org/2000/svg" width="4" height="4"><text>a</text></svg>"#;
        assert!(png(svg).unwrap().starts_with(b"\x89PNG"));
    }

    #[test]
    fn nonsense_is_refused() {
        assert!(matches!(png("<svg"), Err(PngError::Rendering(_))));
    }
}
