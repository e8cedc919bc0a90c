//! Layers of a panel. They are drawn in the order of their addition. Their texts come last, above
//! all lines.

mod band;
mod cells;
mod curve;
mod dimension;
mod guide;
mod inset;
mod markers;
mod note;
mod region;

pub use band::Band;
pub use cells::Cells;
pub use curve::Curve;
pub use dimension::Dimension;
pub use guide::Guide;
pub use inset::Inset;
pub use markers::Markers;
pub use note::Note;
pub use region::Region;

use super::legend::Entry;
use super::plot::{Drawn, Plot};
use super::polyline::Point;

/// Font size of texts inside a panel, px.
pub(super) const TEXT_SIZE: f64 = 11.5;

/// A layer of a panel. Only this crate defines layers, because [`Plot`] is private.
pub trait Layer {
    /// Draws lines and areas.
    fn draw(&self, plot: &Plot<'_, '_>) -> Drawn;

    /// Draws texts, after the lines and areas of all layers.
    fn annotate(&self, _plot: &Plot<'_, '_>) -> Drawn {
        Ok(())
    }

    /// The entry of the layer in the legend.
    fn legend(&self) -> Option<Entry> {
        None
    }

    /// Name, in markup, and points of a layer that is a curve.
    fn curve(&self) -> Option<(&str, &[Point])> {
        None
    }
}

/// A place in a panel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Position {
    /// Data units.
    Data(f64, f64),
    /// Fractions of the plot rectangle: (0, 0) is its lower left corner, (1, 1) its upper right
    /// one.
    Fraction(f64, f64),
}

impl From<(f64, f64)> for Position {
    fn from((x, y): (f64, f64)) -> Self {
        Position::Data(x, y)
    }
}

impl Position {
    fn px(self, plot: &Plot<'_, '_>) -> Point {
        match self {
            Position::Data(x, y) => plot.px((x, y)),
            Position::Fraction(fx, fy) => plot.frame.at(fx, fy),
        }
    }
}
