//! Points marked by symbols, with texts beside them.

use super::{Layer, TEXT_SIZE};
use crate::color::{BLACK, Color, WHITE};
use crate::elements::Ink;
use crate::legend::Entry;
use crate::marks::{Shape, Symbol, Words};
use crate::plot::{Drawn, Plot};

use super::note::anchor_of;

/// Symbols at data points.
#[derive(Clone, Debug)]
pub struct Markers {
    points: Vec<(f64, f64)>,
    symbol: Symbol,
    /// Texts beside points, each with the index of its point and its offset.
    labels: Vec<(usize, String, (f64, f64))>,
    legend: String,
}

impl Markers {
    /// Filled black circles, 7 px wide.
    pub fn new(points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self {
            points: points.into_iter().collect(),
            symbol: Symbol {
                shape: Shape::Circle,
                size: 7.0,
                fill: BLACK,
                edge: BLACK,
                edge_width: 1.2,
            },
            labels: Vec::new(),
            legend: String::new(),
        }
    }

    setters! {
        /// Outline.
        shape: Shape => symbol.shape;
        /// Diameter, px.
        size: f64 => symbol.size;
        /// Text in the legend, in markup.
        legend: &str => legend;
    }

    /// Colour of edge and inside.
    pub fn color(mut self, color: Color) -> Self {
        self.symbol.edge = color;
        self.symbol.fill = color;
        self
    }

    /// White inside; call after [`Markers::color`].
    pub fn open(mut self) -> Self {
        self.symbol.fill = WHITE;
        self
    }

    /// Adds a text in markup beside the point `index`, `(right, up)` px away from it. An index that
    /// does not exist has no effect.
    pub fn label(mut self, index: usize, text: &str, offset: (f64, f64)) -> Self {
        self.labels.push((index, text.to_owned(), offset));
        self
    }
}

impl Layer for Markers {
    fn draw(&self, plot: &Plot<'_, '_>) -> Drawn {
        plot.symbols(&self.points, &self.symbol)
    }

    fn annotate(&self, plot: &Plot<'_, '_>) -> Drawn {
        for (index, text, (right, up)) in &self.labels {
            let point = self.points.get(*index);
            if let Some(&point) = point.filter(|point| plot.bounds.contains(**point)) {
                let (x, y) = plot.px(point);
                let words = Words::new(text, TEXT_SIZE, anchor_of(*right, *up)).halo();
                plot.sheet.words((x + right, y - up), words)?;
            }
        }
        Ok(())
    }

    fn legend(&self) -> Option<Entry> {
        Entry::new(&self.legend, Ink::Symbol(self.symbol))
    }
}
