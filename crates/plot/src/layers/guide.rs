//! Straight lines across the whole panel.

use super::{Layer, TEXT};
use crate::color::{Color, GREY};
use crate::elements::Words;
use crate::legend::{Entry, Key};
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

    /// A text in markup beside the line, at a fraction of its length: above a horizontal line, to the right
    /// of a vertical one.
    pub fn label(mut self, text: &str, fraction: f64) -> Self {
        self.label = Some((text.to_owned(), fraction));
        self
    }

    /// Text in the legend, in markup.
    pub fn legend(mut self, text: &str) -> Self {
        self.legend = Some(text.to_owned());
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
        let words = Words::new(text, TEXT).halo();
        if self.horizontal {
            plot.sheet
                .words((fx, y - 4.0), words.anchor(HPos::Center, VPos::Bottom))
        } else {
            plot.sheet
                .words((x + 5.0, fy), words.anchor(HPos::Left, VPos::Center))
        }
    }

    fn legend(&self) -> Option<Entry> {
        self.legend
            .as_ref()
            .map(|text| Entry::new(text, Key::Line(self.pen)))
    }
}
