//! Lengths, as in a technical drawing.

use plotters_backend::text_anchor::{HPos, VPos};

use super::{Layer, TEXT_SIZE};
use crate::arrow;
use crate::color::BLACK;
use crate::marks::Words;
use crate::pen::Pen;
use crate::plot::{Drawn, Plot};

/// Distance of the text above the arrow, px.
const TEXT_DISTANCE: f64 = 4.0;

/// A double-headed arrow between two points, with a text.
#[derive(Clone, Debug)]
pub struct Dimension {
    from: (f64, f64),
    to: (f64, f64),
    text: String,
    shift: f64,
}

impl Dimension {
    /// A dimension from point to point in data units, with a text in markup above the middle.
    pub fn new(from: (f64, f64), to: (f64, f64), text: &str) -> Self {
        Self {
            from,
            to,
            text: text.to_owned(),
            shift: 0.0,
        }
    }

    setters! {
        /// Moves the arrow by this many px to the left of its direction: upwards for one that
        /// points right. Thin lines connect its ends to the points.
        shift: f64 => shift;
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
        let words = Words::new(&self.text, TEXT_SIZE, (HPos::Center, VPos::Bottom)).halo();
        let above = ((a.0 + b.0) / 2.0, (a.1 + b.1) / 2.0 - TEXT_DISTANCE);
        plot.sheet.words(above, words)
    }
}
