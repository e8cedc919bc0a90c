//! Shaded intervals and rectangles.

use super::Layer;
use crate::color::{Color, LIGHT_GREY};
use crate::legend::{Entry, Key};
use crate::pen::Pen;
use crate::plot::{Drawn, Plot};

/// A shaded rectangle: between two abscissae, two ordinates, or both.
#[derive(Clone, Debug)]
pub struct Band {
    x: (f64, f64),
    y: (f64, f64),
    bar: Option<f64>,
    fill: Option<Color>,
    outline: Option<Pen>,
    legend: Option<String>,
}

impl Band {
    /// From abscissa to abscissa over the whole height, such as the time of a stick phase.
    pub fn x(from: f64, to: f64) -> Self {
        Self::rect((from, to), (f64::NEG_INFINITY, f64::INFINITY))
    }

    /// From ordinate to ordinate over the whole width.
    pub fn y(from: f64, to: f64) -> Self {
        Self::rect((f64::NEG_INFINITY, f64::INFINITY), (from, to))
    }

    /// A rectangle in data units; an infinite end means the border of the panel.
    pub fn rect(x: (f64, f64), y: (f64, f64)) -> Self {
        Self {
            x,
            y,
            bar: None,
            fill: Some(LIGHT_GREY),
            outline: None,
            legend: None,
        }
    }

    /// A horizontal bar from abscissa to abscissa at an ordinate, `thickness` px high, such as a stick zone
    /// in the phase plane.
    pub fn bar(x: (f64, f64), y: f64, thickness: f64) -> Self {
        let mut band = Self::rect(x, (y, y));
        band.bar = Some(thickness);
        band
    }

    /// Colour of the shading.
    pub fn fill(mut self, color: Color) -> Self {
        self.fill = Some(color);
        self
    }

    /// A line around it, and no shading, such as for the part of a panel an inset enlarges.
    pub fn outline(mut self, color: Color, width: f64) -> Self {
        self.outline = Some(Pen::new(color, width));
        self.fill = None;
        self
    }

    /// Text in the legend, in markup.
    pub fn legend(mut self, text: &str) -> Self {
        self.legend = Some(text.to_owned());
        self
    }

    /// The corners inside the panel, lower left and upper right, or nothing.
    fn corners(&self, plot: &Plot<'_, '_>) -> Option<[(f64, f64); 2]> {
        let half = match self.bar {
            Some(thickness) => {
                let per_px = (plot.bounds.y.1 - plot.bounds.y.0) / plot.frame.height();
                thickness / 2.0 * per_px
            }
            None => 0.0,
        };
        let x = (self.x.0.max(plot.bounds.x.0), self.x.1.min(plot.bounds.x.1));
        let y = (
            (self.y.0 - half).max(plot.bounds.y.0),
            (self.y.1 + half).min(plot.bounds.y.1),
        );
        (x.0 < x.1 && y.0 < y.1).then_some([(x.0, y.0), (x.1, y.1)])
    }
}

impl Layer for Band {
    fn draw(&self, plot: &Plot<'_, '_>) -> Drawn {
        let Some([low, high]) = self.corners(plot) else {
            return Ok(());
        };
        let frame = super::frame_between(plot.px(low), plot.px(high));
        if let Some(color) = self.fill {
            plot.sheet.rect(&frame, color)?;
        }
        if let Some(pen) = &self.outline {
            plot.sheet.outline(&frame, pen)?;
        }
        Ok(())
    }

    fn legend(&self) -> Option<Entry> {
        let text = self.legend.as_ref()?;
        let key = match (self.fill, self.outline) {
            (Some(color), _) => Key::Area(color),
            (None, Some(pen)) => Key::Line(pen),
            (None, None) => return None,
        };
        Some(Entry::new(text, key))
    }
}
