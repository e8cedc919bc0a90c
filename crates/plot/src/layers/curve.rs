//! A line through data points.

use super::Layer;
use crate::color::Color;
use crate::elements::Ink;
use crate::legend::Entry;
use crate::pen::{Dash, Pen};
use crate::plot::{Drawn, Plot};

/// A polyline in data units. Points that are not finite leave a gap; what lies outside the axes is
/// cut off.
#[derive(Clone, Debug)]
pub struct Curve {
    points: Vec<(f64, f64)>,
    pen: Pen,
    legend: String,
    name: String,
}

impl Curve {
    /// A solid black curve.
    pub fn new(points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self {
            points: points.into_iter().collect(),
            pen: Pen::default(),
            legend: String::new(),
            name: String::new(),
        }
    }

    setters! {
        /// Colour.
        color: Color => pen.color;
        /// Width, px.
        width: f64 => pen.width;
        /// Line style.
        dash: Dash => pen.dash;
        /// Text in the legend, in markup.
        legend: &str => legend;
        /// Name in the table of curves; without one the legend serves.
        name: &str => name;
    }

    /// Round ends, so that a piece without length is a dot.
    pub fn round(mut self) -> Self {
        self.pen.is_round = true;
        self
    }
}

impl Layer for Curve {
    fn curve(&self) -> Option<(&str, &[(f64, f64)])> {
        let name = if self.name.is_empty() {
            &self.legend
        } else {
            &self.name
        };
        Some((name, &self.points))
    }

    fn draw(&self, plot: &Plot<'_, '_>) -> Drawn {
        plot.stroke(&self.points, &self.pen)
    }

    fn legend(&self) -> Option<Entry> {
        Entry::new(&self.legend, Ink::Line(self.pen))
    }
}
