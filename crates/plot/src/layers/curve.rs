//! A line through data points.

use super::Layer;
use crate::color::Color;
use crate::legend::{Entry, Key};
use crate::pen::{Dash, Pen};
use crate::plot::{Drawn, Plot};

/// A polyline in data units. Points that are not finite leave a gap; what lies outside the axes is cut off.
#[derive(Clone, Debug)]
pub struct Curve {
    points: Vec<(f64, f64)>,
    pen: Pen,
    legend: Option<String>,
}

impl Curve {
    /// A solid black curve.
    pub fn new(points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self {
            points: points.into_iter().collect(),
            pen: Pen::default(),
            legend: None,
        }
    }

    /// Colour.
    pub fn color(mut self, color: Color) -> Self {
        self.pen.color = color;
        self
    }

    /// Width, px.
    pub fn width(mut self, width: f64) -> Self {
        self.pen.width = width;
        self
    }

    /// Line style.
    pub fn dash(mut self, dash: Dash) -> Self {
        self.pen.dash = dash;
        self
    }

    /// Text in the legend, in markup.
    pub fn legend(mut self, text: &str) -> Self {
        self.legend = Some(text.to_owned());
        self
    }
}

impl Layer for Curve {
    fn draw(&self, plot: &Plot<'_, '_>) -> Drawn {
        plot.stroke(&self.points, &self.pen)
    }

    fn legend(&self) -> Option<Entry> {
        self.legend
            .as_ref()
            .map(|text| Entry::new(text, Key::Line(self.pen)))
    }
}
