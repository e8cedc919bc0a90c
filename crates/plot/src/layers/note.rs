//! A text in a panel, with or without an arrow.

use plotters_backend::text_anchor::{HPos, VPos};

use super::{Layer, Position, TEXT_SIZE};
use crate::arrow;
use crate::color::{BLACK, GREY};
use crate::error::PlotError;
use crate::marks::Words;
use crate::metrics;
use crate::pen::Pen;
use crate::plot::{Drawn, Frame, Plot};
use crate::polyline::Point;

/// Space between a text and its arrow, px.
const CLEARANCE: f64 = 3.0;

/// A text in markup at a place.
#[derive(Clone, Debug)]
pub struct Note {
    at: Position,
    text: String,
    offset: (f64, f64),
    target: Option<Position>,
    head: bool,
}

impl Note {
    /// A text centred at `at`.
    pub fn new(at: impl Into<Position>, text: &str) -> Self {
        Self {
            at: at.into(),
            text: text.to_owned(),
            offset: (0.0, 0.0),
            target: None,
            head: true,
        }
    }

    /// Moves the text by `(right, up)` px. It then stands on that side of the place instead of
    /// being centred there. An offset to the right puts it to the right, one upwards puts it above.
    pub fn offset(mut self, right: f64, up: f64) -> Self {
        self.offset = (right, up);
        self
    }

    /// Adds an arrow from the text to a place.
    pub fn arrow(mut self, target: impl Into<Position>) -> Self {
        self.target = Some(target.into());
        self
    }

    /// Adds a thin line without a head from the text to a place.
    pub fn leader(mut self, target: impl Into<Position>) -> Self {
        self.head = false;
        self.arrow(target)
    }

    /// Position of the text on the page.
    fn anchored(&self, plot: &Plot<'_, '_>) -> Point {
        let (x, y) = self.at.px(plot);
        (x + self.offset.0, y - self.offset.1)
    }

    /// The box of the text on the page.
    fn frame(&self, plot: &Plot<'_, '_>) -> Result<Frame, PlotError> {
        let (x, y) = self.anchored(plot);
        let width = metrics::width(&self.text, TEXT_SIZE)?;
        let height = metrics::CAP_HEIGHT * TEXT_SIZE;
        let (h, v) = anchor_of(self.offset.0, self.offset.1);
        let left = match h {
            HPos::Left => x,
            HPos::Center => x - width / 2.0,
            HPos::Right => x - width,
        };
        let top = match v {
            VPos::Top => y,
            VPos::Center => y - height / 2.0,
            VPos::Bottom => y - height,
        };
        Ok(Frame::new((left, top), (width, height)))
    }
}

impl Layer for Note {
    fn draw(&self, plot: &Plot<'_, '_>) -> Drawn {
        let Some(target) = self.target else {
            return Ok(());
        };
        let text = self.frame(plot)?;
        let target = target.px(plot);
        let centre = text.at(0.5, 0.5);
        let (dx, dy) = (target.0 - centre.0, target.1 - centre.1);
        // Fraction of the way from the centre to the target at which the line leaves the box.
        let half = (
            text.width() / 2.0 + CLEARANCE,
            text.height() / 2.0 + CLEARANCE,
        );
        let leaves = (half.0 / dx.abs()).min(half.1 / dy.abs());
        if leaves >= 1.0 {
            return Ok(());
        }
        let start = (centre.0 + leaves * dx, centre.1 + leaves * dy);
        let pen = Pen::new(if self.head { BLACK } else { GREY }, 0.8);
        if self.head {
            arrow::single(&plot.sheet, start, target, &pen)
        } else {
            plot.sheet.stroke(&[start, target], &pen)
        }
    }

    fn annotate(&self, plot: &Plot<'_, '_>) -> Drawn {
        let anchor = anchor_of(self.offset.0, self.offset.1);
        let words = Words::new(&self.text, TEXT_SIZE, anchor).halo();
        plot.sheet.words(self.anchored(plot), words)
    }
}

/// A text moved to one side of a point is anchored at the side that faces the point.
pub(super) fn anchor_of(right: f64, up: f64) -> (HPos, VPos) {
    /// Offsets up to this, px, only adjust a centred text.
    const CENTRED_OFFSET: f64 = 2.0;
    let h = if right > CENTRED_OFFSET {
        HPos::Left
    } else if right < -CENTRED_OFFSET {
        HPos::Right
    } else {
        HPos::Center
    };
    let v = if up > CENTRED_OFFSET {
        VPos::Bottom
    } else if up < -CENTRED_OFFSET {
        VPos::Top
    } else {
        VPos::Center
    };
    (h, v)
}
