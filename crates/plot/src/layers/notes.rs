//! Texts, arrows and lengths, as in a technical drawing.

use super::{Layer, Place, TEXT};
use crate::PlotError;
use crate::canvas::{Canvas, Drawn, Frame};
use crate::metrics;
use crate::plot::Plot;
use crate::polyline::Point;
use crate::style::{BLACK, Color, GREY, HPos, Pen, VPos, Words};

/// Space between a text and its arrow, px.
const CLEARANCE: f64 = 3.0;

/// A text in markup at a place.
#[derive(Clone, Debug)]
pub struct Note {
    at: Place,
    text: String,
    offset: (f64, f64),
    size: f64,
    color: Color,
    target: Option<Place>,
    head: bool,
}

impl Note {
    /// A text centred at `at`.
    pub fn new(at: impl Into<Place>, text: &str) -> Self {
        Self {
            at: at.into(),
            text: text.to_owned(),
            offset: (0.0, 0.0),
            size: TEXT,
            color: BLACK,
            target: None,
            head: true,
        }
    }

    /// Moves the text by `(right, up)` px. It then stands on that side of the place, instead of being
    /// centred at it: to the right of it for an offset to the right, above it for an offset upwards.
    pub fn offset(mut self, right: f64, up: f64) -> Self {
        self.offset = (right, up);
        self
    }

    /// Font size, px.
    pub fn size(mut self, size: f64) -> Self {
        self.size = size;
        self
    }

    /// Colour of the text.
    pub fn color(mut self, color: Color) -> Self {
        self.color = color;
        self
    }

    /// Adds an arrow from the text to a place.
    pub fn arrow(mut self, target: impl Into<Place>) -> Self {
        self.target = Some(target.into());
        self.head = true;
        self
    }

    /// Adds a thin line without a head from the text to a place.
    pub fn leader(mut self, target: impl Into<Place>) -> Self {
        self.target = Some(target.into());
        self.head = false;
        self
    }

    /// Where the text is anchored on the page, and at which of its points.
    fn anchor(&self, plot: &Plot<'_>) -> (Point, (HPos, VPos)) {
        let ((x, y), (right, up)) = (self.at.px(plot), self.offset);
        ((x + right, y - up), anchor_of(right, up))
    }

    /// The box that the text fills on the page.
    fn layout(&self, plot: &Plot<'_>) -> Result<Frame, PlotError> {
        let ((x, y), (h, v)) = self.anchor(plot);
        let width = metrics::width(&self.text, self.size)?;
        let height = metrics::CAP_HEIGHT * self.size;
        let (left, top) = (x - h.part() * width, y - v.part() * height);
        Ok(Frame {
            left,
            top,
            right: left + width,
            bottom: top + height,
        })
    }
}

impl Layer for Note {
    fn draw(&self, plot: &Plot<'_>) -> Drawn {
        let Some(target) = self.target else {
            return Ok(());
        };
        let text = self.layout(plot)?;
        let target = target.px(plot);
        let centre = text.at(0.5, 0.5);
        let (dx, dy) = (target.0 - centre.0, target.1 - centre.1);
        // How far along the way from the centre to the target the line leaves the text's box.
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
            single(plot.canvas, start, target, &pen)
        } else {
            plot.canvas.stroke(&[start, target], &pen)
        }
    }

    fn annotate(&self, plot: &Plot<'_>) -> Drawn {
        let (at, (h, v)) = self.anchor(plot);
        let words = Words::new(&self.text, self.size)
            .color(self.color)
            .anchor(h, v)
            .halo();
        plot.canvas.words(at, words)
    }
}

/// A text moved to one side of a point is anchored at the side that faces the point.
pub(super) fn anchor_of(right: f64, up: f64) -> (HPos, VPos) {
    const CENTRED: f64 = 2.0;
    let h = if right > CENTRED {
        HPos::Left
    } else if right < -CENTRED {
        HPos::Right
    } else {
        HPos::Center
    };
    let v = if up > CENTRED {
        VPos::Bottom
    } else if up < -CENTRED {
        VPos::Top
    } else {
        VPos::Center
    };
    (h, v)
}

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
    fn ends(&self, plot: &Plot<'_>) -> [(f64, f64); 2] {
        let (a, b) = (plot.px(self.from), plot.px(self.to));
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        let length = libm::hypot(dx, dy);
        if length == 0.0 {
            return [a, b];
        }
        let (sx, sy) = (self.shift * dy / length, -self.shift * dx / length);
        [(a.0 + sx, a.1 + sy), (b.0 + sx, b.1 + sy)]
    }
}

impl Layer for Dimension {
    fn draw(&self, plot: &Plot<'_>) -> Drawn {
        let [a, b] = self.ends(plot);
        let pen = Pen::new(BLACK, 0.9);
        if self.shift != 0.0 {
            let thin = Pen::new(BLACK, 0.5);
            plot.canvas.stroke(&[plot.px(self.from), a], &thin)?;
            plot.canvas.stroke(&[plot.px(self.to), b], &thin)?;
        }
        double(plot.canvas, a, b, &pen)
    }

    fn annotate(&self, plot: &Plot<'_>) -> Drawn {
        let [a, b] = self.ends(plot);
        let (right, up) = self.offset;
        let (h, v) = anchor_of(right, up);
        let words = Words::new(&self.text, TEXT).anchor(h, v).halo();
        let middle = ((a.0 + b.0) / 2.0, (a.1 + b.1) / 2.0);
        plot.canvas.words((middle.0 + right, middle.1 - up), words)
    }
}

/// Length and half width of an arrow head, px.
const HEAD: (f64, f64) = (6.5, 2.4);

/// A line from `from` to `to` with a head at `to`.
fn single(canvas: &Canvas, from: Point, to: Point, pen: &Pen) -> Drawn {
    let Some(neck) = neck(from, to) else {
        return Ok(());
    };
    canvas.stroke(&[from, neck], pen)?;
    head(canvas, neck, to, pen)
}

/// A line with heads at both ends. Where there is no room for two heads, they point at each other from
/// outside.
fn double(canvas: &Canvas, a: Point, b: Point, pen: &Pen) -> Drawn {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let length = libm::hypot(dx, dy);
    if length == 0.0 {
        return Ok(());
    }
    let (ux, uy) = (dx / length, dy / length);
    if length < 2.6 * HEAD.0 {
        let out = 2.2 * HEAD.0;
        single(canvas, (a.0 - out * ux, a.1 - out * uy), a, pen)?;
        return single(canvas, (b.0 + out * ux, b.1 + out * uy), b, pen);
    }
    let near_a = (a.0 + HEAD.0 * ux, a.1 + HEAD.0 * uy);
    let near_b = (b.0 - HEAD.0 * ux, b.1 - HEAD.0 * uy);
    canvas.stroke(&[near_a, near_b], pen)?;
    head(canvas, near_a, a, pen)?;
    head(canvas, near_b, b, pen)
}

/// Where the line ends and the head begins.
fn neck(from: Point, to: Point) -> Option<Point> {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let length = libm::hypot(dx, dy);
    (length > 0.0).then(|| {
        let s = HEAD.0.min(length) / length;
        (to.0 - s * dx, to.1 - s * dy)
    })
}

fn head(canvas: &Canvas, neck: Point, tip: Point, pen: &Pen) -> Drawn {
    let (dx, dy) = (tip.0 - neck.0, tip.1 - neck.1);
    let half = HEAD.1 / libm::hypot(dx, dy);
    let corners = [
        tip,
        (neck.0 - half * dy, neck.1 + half * dx),
        (neck.0 + half * dy, neck.1 - half * dx),
    ];
    canvas.fill(&corners, pen.color)
}
