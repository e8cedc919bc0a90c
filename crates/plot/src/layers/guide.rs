//! Straight lines across the whole panel.

use super::{Layer, TEXT_SIZE};
use crate::color::{Color, GREY};
use crate::elements::Ink;
use crate::legend::Entry;
use crate::marks::Words;
use crate::pen::{Dash, Pen};
use crate::plot::{Drawn, Plot};
use plotters_backend::text_anchor::{HPos, VPos};

/// A horizontal or vertical line from border to border.
#[derive(Clone, Debug)]
pub struct Guide {
    horizontal: bool,
    value: f64,
    pen: Pen,
    label: Option<(String, f64)>,
    legend: String,
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
            pen: Pen {
                dash: Dash::Dashed,
                ..Pen::new(GREY, 0.8)
            },
            label: None,
            legend: String::new(),
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
    }

    /// A text in markup beside the line, at a fraction of its length: above a horizontal line, to
    /// the right of a vertical one.
    pub fn label(mut self, text: &str, fraction: f64) -> Self {
        self.label = Some((text.to_owned(), fraction));
        self
    }
}

impl Layer for Guide {
    fn draw(&self, plot: &Plot<'_, '_>) -> Drawn {
        let (x, y) = (plot.bounds.x, plot.bounds.y);
        let ends = if self.horizontal {
            [(x.0, self.value), (x.1, self.value)]
        } else {
            [(self.value, y.0), (self.value, y.1)]
        };
        plot.stroke(&ends, &self.pen)
    }

    fn annotate(&self, plot: &Plot<'_, '_>) -> Drawn {
        let Some((text, fraction)) = &self.label else {
            return Ok(());
        };
        let (fx, fy) = plot.frame.at(*fraction, *fraction);
        let (x, y) = plot.px((self.value, self.value));
        let (at, anchor) = if self.horizontal {
            ((fx, y - 4.0), (HPos::Center, VPos::Bottom))
        } else {
            ((x + 5.0, fy), (HPos::Left, VPos::Center))
        };
        plot.sheet
            .words(at, Words::new(text, TEXT_SIZE, anchor).halo())
    }

    fn legend(&self) -> Option<Entry> {
        Entry::new(&self.legend, Ink::Line(self.pen))
    }
}
