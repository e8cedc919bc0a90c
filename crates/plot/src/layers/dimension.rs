//! Lengths, as in a technical drawing.

use super::note::anchor_of;
use super::{Layer, TEXT};
use crate::arrow;
use crate::color::BLACK;
use crate::elements::Words;
use crate::pen::Pen;
use crate::plot::{Drawn, Plot};

/// A double-headed arrow between two points, with a text.
#[derive(Clone, Debug)]
pub struct Dimension {
    from: (f64, f64),
    to: (f64, f64),
    text: String,
    offset: (f64, f64),
    shift: f64,
}

impl Dimension {
    /// From point to point in data units, with a text in markup above the middle.
    pub fn new(from: (f64, f64), to: (f64, f64), text: &str) -> Self {
        Self {
            from,
            to,
            text: text.to_owned(),
            offset: (0.0, 4.0),
            shift: 0.0,
        }
    }

    /// Where the text stands relative to the middle of the arrow, `(right, up)` px.
    pub fn offset(mut self, right: f64, up: f64) -> Self {
        self.offset = (right, up);
        self
    }

    /// Moves the arrow by this many px to the left of its direction (upwards for one that points right) and
    /// draws thin lines from its ends to the points.
    pub fn shift(mut self, px: f64) -> Self {
        self.shift = px;
        self
    }

    /// Both ends on the page after the shift, px.
    fn ends(&self, plot: &Plot<'_, '_>) -> [(f64, f64); 2] {
        let (a, b) = (plot.px(self.from), plot.px(self.to));
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        let length = crate::math::hypot(dx, dy);
        if length == 0.0 {
            return [a, b];
        }
        let (sx, sy) = (self.shift * dy / length, -self.shift * dx / length);
        [(a.0 + sx, a.1 + sy), (b.0 + sx, b.1 + sy)]
    }
}

impl Layer for Dimension {
    fn draw(&self, plot: &Plot<'_, '_>) -> Drawn {
        let [a, b] = self.ends(plot);
        let pen = Pen::new(BLACK, 0.9);
        if self.shift != 0.0 {
            let thin = Pen::new(BLACK, 0.5);
            plot.sheet.stroke(&[plot.px(self.from), a], &thin)?;
            plot.sheet.stroke(&[plot.px(self.to), b], &thin)?;
        }
        arrow::double(&plot.sheet, a, b, &pen)
    }

    fn annotate(&self, plot: &Plot<'_, '_>) -> Drawn {
        let [a, b] = self.ends(plot);
        let (right, up) = self.offset;
        let (h, v) = anchor_of(right, up);
        let words = Words::new(&self.text, TEXT).anchor(h, v).halo();
        let middle = ((a.0 + b.0) / 2.0, (a.1 + b.1) / 2.0);
        plot.sheet.words((middle.0 + right, middle.1 - up), words)
    }
}
