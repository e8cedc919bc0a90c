//! Lines and points.

use super::notes::anchor_of;
use super::{Layer, TEXT, in_legend};
use crate::canvas::Drawn;
use crate::legend::{Entry, Key};
use crate::plot::Plot;
use crate::style::{BLACK, Color, Dash, GREY, HPos, Pen, Shape, Symbol, VPos, WHITE, Words};

/// What lines have in common.
macro_rules! pen {
    ($($line:ty),*) => {$(
        impl $line {
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
        }
    )*};
}
pen!(Curve, Guide);
in_legend!(Curve, Guide, Markers);

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
}

impl Layer for Curve {
    fn draw(&self, plot: &Plot<'_>) -> Drawn {
        plot.stroke(&self.points, &self.pen)
    }

    fn legend(&self) -> Option<Entry> {
        self.legend
            .as_ref()
            .map(|text| Entry::new(text, Key::Line(self.pen)))
    }
}

/// A horizontal or vertical line from border to border.
#[derive(Clone, Debug)]
pub struct Guide {
    horizontal: bool,
    value: f64,
    pen: Pen,
    label: Option<(String, f64)>,
    legend: Option<String>,
}

impl Guide {
    /// A thin dashed grey line at this ordinate.
    pub fn horizontal(y: f64) -> Self {
        Self::new(true, y)
    }

    /// A thin dashed grey line at this abscissa.
    pub fn vertical(x: f64) -> Self {
        Self::new(false, x)
    }

    fn new(horizontal: bool, value: f64) -> Self {
        Self {
            horizontal,
            value,
            pen: Pen::new(GREY, 0.8).dash(Dash::Dashed),
            label: None,
            legend: None,
        }
    }

    /// A text in markup beside the line, at a fraction of its length: above a horizontal line, to the right
    /// of a vertical one.
    pub fn label(mut self, text: &str, fraction: f64) -> Self {
        self.label = Some((text.to_owned(), fraction));
        self
    }
}

impl Layer for Guide {
    fn draw(&self, plot: &Plot<'_>) -> Drawn {
        let (x, y) = (plot.bounds.x, plot.bounds.y);
        let ends = if self.horizontal {
            [(x.0, self.value), (x.1, self.value)]
        } else {
            [(self.value, y.0), (self.value, y.1)]
        };
        plot.stroke(&ends, &self.pen)
    }

    fn annotate(&self, plot: &Plot<'_>) -> Drawn {
        let Some((text, fraction)) = &self.label else {
            return Ok(());
        };
        let (fx, fy) = plot.frame.at(*fraction, *fraction);
        let (x, y) = plot.px((self.value, self.value));
        let words = Words::new(text, TEXT).halo();
        if self.horizontal {
            plot.canvas
                .words((fx, y - 4.0), words.anchor(HPos::Center, VPos::Bottom))
        } else {
            plot.canvas
                .words((x + 5.0, fy), words.anchor(HPos::Left, VPos::Center))
        }
    }

    fn legend(&self) -> Option<Entry> {
        self.legend
            .as_ref()
            .map(|text| Entry::new(text, Key::Line(self.pen)))
    }
}

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
}

impl Layer for Markers {
    fn draw(&self, plot: &Plot<'_>) -> Drawn {
        plot.symbols(&self.points, &self.symbol)
    }

    fn annotate(&self, plot: &Plot<'_>) -> Drawn {
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
            plot.canvas.words((x + dx, y - dy), words)?;
        }
        Ok(())
    }

    fn legend(&self) -> Option<Entry> {
        self.legend
            .as_ref()
            .map(|text| Entry::new(text, Key::Symbol(self.symbol)))
    }
}
