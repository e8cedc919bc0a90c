//! What a panel can show. Layers are drawn in the order they are added; their texts come last, above all
//! lines.

mod areas;
mod lines;
mod notes;

pub use areas::{Band, Cells, Region};
pub use lines::{Curve, Guide, Markers};
pub use notes::{Dimension, Note};

use super::canvas::{Drawn, Frame};
use super::legend::Entry;
use super::panel::Panel;
use super::plot::Plot;
use super::polyline::Point;
use super::style::WHITE;

/// Font size of texts inside a panel, px.
pub(super) const TEXT: f64 = 11.5;

/// One thing in a panel.
pub(super) trait Layer {
    /// Lines and areas.
    fn draw(&self, plot: &Plot<'_>) -> Drawn;

    /// Texts; drawn after the lines and areas of all layers.
    fn annotate(&self, _plot: &Plot<'_>) -> Drawn {
        Ok(())
    }

    /// The line this layer wants in the legend.
    fn legend(&self) -> Option<Entry> {
        None
    }
}

/// Anything that can be added to a panel.
pub struct AnyLayer(pub(super) Box<dyn Layer>);

macro_rules! any_layer {
    ($($layer:ty),*) => {$(
        impl From<$layer> for AnyLayer {
            fn from(layer: $layer) -> Self {
                Self(Box::new(layer))
            }
        }
    )*};
}
any_layer!(
    Band, Cells, Curve, Dimension, Guide, Inset, Markers, Note, Region
);

/// Gives layers a line in the legend.
macro_rules! in_legend {
    ($($layer:ty),*) => {$(
        impl $layer {
            /// Text in the legend, in markup.
            pub fn legend(mut self, text: &str) -> Self {
                self.legend = Some(text.to_owned());
                self
            }
        }
    )*};
}
use in_legend;

/// A place in a panel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// In data units.
    Data(f64, f64),
    /// In fractions of the plot rectangle: (0, 0) is its lower left corner, (1, 1) its upper right one.
    Fraction(f64, f64),
}

impl From<(f64, f64)> for Place {
    fn from((x, y): (f64, f64)) -> Self {
        Place::Data(x, y)
    }
}

impl Place {
    fn px(self, plot: &Plot<'_>) -> Point {
        match self {
            Place::Data(x, y) => plot.px((x, y)),
            Place::Fraction(fx, fy) => plot.frame.at(fx, fy),
        }
    }
}

/// The frame between two corners given as places.
fn frame_between(a: Point, b: Point) -> Frame {
    Frame {
        left: a.0.min(b.0),
        top: a.1.min(b.1),
        right: a.0.max(b.0),
        bottom: a.1.max(b.1),
    }
}

/// A panel drawn over a part of another, on white, such as an enlarged detail.
pub struct Inset {
    from: (f64, f64),
    to: (f64, f64),
    panel: Panel,
}

impl Inset {
    /// `panel`, including its labels, between two corners in fractions of the outer plot rectangle, from
    /// (0, 0) lower left to (1, 1) upper right.
    pub fn new(from: (f64, f64), to: (f64, f64), panel: Panel) -> Self {
        Self { from, to, panel }
    }
}

impl Layer for Inset {
    fn draw(&self, _: &Plot<'_>) -> Drawn {
        Ok(())
    }

    /// All of it is drawn with the texts, so that no curve of the outer panel runs through it.
    fn annotate(&self, plot: &Plot<'_>) -> Drawn {
        let cell = frame_between(
            plot.frame.at(self.from.0, self.from.1),
            plot.frame.at(self.to.0, self.to.1),
        );
        plot.canvas.rect(&cell, WHITE)?;
        let margins = self.panel.margins(cell.width())?;
        self.panel.draw(plot.canvas, &cell, &margins)
    }
}
