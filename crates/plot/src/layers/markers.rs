//! Points marked by symbols, with texts beside them.

use super::{Layer, TEXT};
use crate::color::{BLACK, Color, WHITE};
use crate::elements::{Shape, Symbol, Words};
use crate::legend::{Entry, Key};
use crate::plot::{Drawn, Plot};

use super::note::anchor_of;

/// Symbols at data points.
#[derive(Clone, Debug)]
pub struct Markers {
    points: Vec<(f64, f64)>,
    symbol: Symbol,
    labels: Vec<Beside>,
    legend: Option<String>,
}

#[derive(Clone, Debug)]
struct Beside {
    index: usize,
    text: String,
    offset: (f64, f64),
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
            legend: None,
        }
    }

    /// Outline.
    pub fn shape(mut self, shape: Shape) -> Self {
        self.symbol.shape = shape;
        self
    }

    /// Diameter, px.
    pub fn size(mut self, size: f64) -> Self {
        self.symbol.size = size;
        self
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

    /// A text in markup beside the point `index`, `(right, up)` px away from it. Of an index that does not
    /// exist nothing is drawn.
    pub fn label(mut self, index: usize, text: &str, offset: (f64, f64)) -> Self {
        self.labels.push(Beside {
            index,
            text: text.to_owned(),
            offset,
        });
        self
    }

    /// Text in the legend, in markup.
    pub fn legend(mut self, text: &str) -> Self {
        self.legend = Some(text.to_owned());
        self
    }
}

impl Layer for Markers {
    fn draw(&self, plot: &Plot<'_, '_>) -> Drawn {
        for point in &self.points {
            plot.symbol(*point, &self.symbol)?;
        }
        Ok(())
    }

    fn annotate(&self, plot: &Plot<'_, '_>) -> Drawn {
        for label in &self.labels {
            let Some(&point) = self.points.get(label.index) else {
                continue;
            };
            if !plot.bounds.contains(point) {
                continue;
            }
            let (x, y) = plot.px(point);
            let (dx, dy) = label.offset;
            let (h, v) = anchor_of(dx, dy);
            let words = Words::new(&label.text, TEXT).anchor(h, v).halo();
            plot.sheet.words((x + dx, y - dy), words)?;
        }
        Ok(())
    }

    fn legend(&self) -> Option<Entry> {
        self.legend
            .as_ref()
            .map(|text| Entry::new(text, Key::Symbol(self.symbol)))
    }
}
