//! Shaded intervals and rectangles.

use super::Layer;
use crate::color::{Color, LIGHT_GREY};
use crate::elements::Ink;
use crate::legend::Entry;
use crate::plot::{Drawn, Frame, Plot};

/// A shaded rectangle: between two abscissae, two ordinates, or both.
#[derive(Clone, Debug)]
pub struct Band {
    x: (f64, f64),
    y: (f64, f64),
    /// Height of a bar, px.
    thickness: f64,
    fill: Color,
    legend: String,
}

impl Band {
    /// A band from abscissa to abscissa over the whole height, such as the time of a stick phase.
    pub fn x(from: f64, to: f64) -> Self {
        Self::rect((from, to), (f64::NEG_INFINITY, f64::INFINITY))
    }

    /// A band from ordinate to ordinate over the whole width.
    pub fn y(from: f64, to: f64) -> Self {
        Self::rect((f64::NEG_INFINITY, f64::INFINITY), (from, to))
    }

    /// A rectangle in data units; an infinite end means the border of the panel.
    pub fn rect(x: (f64, f64), y: (f64, f64)) -> Self {
        Self {
            x,
            y,
            thickness: 0.0,
            fill: LIGHT_GREY,
            legend: String::new(),
        }
    }

    /// A horizontal bar from abscissa to abscissa at an ordinate, `thickness` px high, such as a
    /// stick zone in the phase plane.
    pub fn bar(x: (f64, f64), y: f64, thickness: f64) -> Self {
        let mut band = Self::rect(x, (y, y));
        band.thickness = thickness;
        band
    }

    setters! {
        /// Colour of the shading.
        fill: Color => fill;
        /// Text in the legend, in markup.
        legend: &str => legend;
    }
}

impl Layer for Band {
    fn draw(&self, plot: &Plot<'_, '_>) -> Drawn {
        let bounds = &plot.bounds;
        let per_px = (bounds.y.1 - bounds.y.0) / plot.frame.height();
        let half = self.thickness / 2.0 * per_px;
        let x = (self.x.0.max(bounds.x.0), self.x.1.min(bounds.x.1));
        let y = (
            (self.y.0 - half).max(bounds.y.0),
            (self.y.1 + half).min(bounds.y.1),
        );
        if !(x.0 < x.1 && y.0 < y.1) {
            return Ok(());
        }
        let frame = Frame::between(plot.px((x.0, y.0)), plot.px((x.1, y.1)));
        plot.sheet.rect(&frame, self.fill)
    }

    fn legend(&self) -> Option<Entry> {
        Entry::new(&self.legend, Ink::Area(self.fill))
    }
}
