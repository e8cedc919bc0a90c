//! A panel: axes and layers.

use plotters_backend::text_anchor::{HPos, VPos};

use super::axis::Axis;
use super::color::BLACK;
use super::layers::Layer;
use super::legend::{self, Entry, Legend};
use super::marks::Words;
use super::metrics;
use super::pen::Pen;
use super::plot::{Drawn, Frame, Page, Plot, Sheet};
use super::polyline::{self, Bounds};
use super::rich;
use crate::error::PlotError;

// Lengths, px. They are chosen by eye at the nominal size.
const TICK_LENGTH: f64 = 4.5;
const MINOR_TICK_LENGTH: f64 = 2.5;
const TICK_GAP: f64 = 5.0;
const LABEL_GAP: f64 = 7.0;
const FRAME_WIDTH: f64 = 0.9;
/// Subscripts reach this far below the baseline, px.
const DESCENT: f64 = 5.0;

/// Space around the plot rectangle for numbers and labels, px.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Margins {
    pub(super) left: f64,
    pub(super) right: f64,
    pub(super) top: f64,
    pub(super) bottom: f64,
}

impl Axis {
    /// Height of the numbers of a lower axis, px.
    fn numbers(&self) -> f64 {
        if self.numbered {
            metrics::SMALL_TEXT + 2.0
        } else {
            0.0
        }
    }
}

/// A curve of a figure as numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct NumericCurve {
    /// Label of its panel, without brackets.
    pub panel: String,
    /// Name or legend, without markup.
    pub name: String,
    /// Labels of the two axes, without markup.
    pub axes: [String; 2],
    /// Values on the two axes, for each piece inside the panel.
    pub pieces: Vec<Vec<(f64, f64)>>,
}

/// Axes, layers, legend, label.
pub struct Panel {
    x: Axis,
    y: Axis,
    layers: Vec<Box<dyn Layer>>,
    legend: Legend,
    label: String,
    title: String,
}

impl Panel {
    /// An empty panel.
    pub fn new(x: Axis, y: Axis) -> Self {
        Self {
            x,
            y,
            layers: Vec::new(),
            legend: Legend::Hidden,
            label: String::new(),
            title: String::new(),
        }
    }

    setters! {
        /// Label above the upper left corner, such as `(a)`; set in bold.
        label: &str => label;
        /// Heading after the label, in markup.
        title: &str => title;
        /// Position of the legend. The caller knows which corner is free.
        legend: Legend => legend;
    }

    /// Adds a layer on top of those already there.
    pub fn add(&mut self, layer: impl Layer + 'static) -> &mut Self {
        self.layers.push(Box::new(layer));
        self
    }

    /// Adds a layer on top of those already there, in a chain of calls.
    pub fn with(mut self, layer: impl Layer + 'static) -> Self {
        self.add(layer);
        self
    }

    fn entries(&self) -> Vec<Entry> {
        self.layers.iter().filter_map(|l| l.legend()).collect()
    }

    /// The curves inside the axes, without points whose absence moves a line by less than a
    /// fraction of the axes.
    pub(super) fn curves(&self, tolerance: f64) -> Vec<NumericCurve> {
        let bounds = Bounds {
            x: (self.x.min, self.x.max),
            y: (self.y.min, self.y.max),
        };
        let scale = (
            1.0 / (self.x.max - self.x.min),
            1.0 / (self.y.max - self.y.min),
        );
        let values = |(x, y): (f64, f64)| ((self.x.value)(x), (self.y.value)(y));
        let pieces = |points: &[(f64, f64)]| {
            let pieces = polyline::clip_line(points, &bounds).into_iter();
            let thinned = pieces.map(|piece| polyline::simplify(&piece, scale, tolerance));
            thinned
                .map(|piece| piece.into_iter().map(values).collect())
                .collect()
        };
        let curves = self.layers.iter().filter_map(|layer| layer.curve());
        let numbered = (1..).zip(curves);
        let exported = numbered.map(|(number, (name, points)): (usize, _)| NumericCurve {
            panel: self.label.trim_matches(['(', ')']).to_owned(),
            name: match name {
                "" => format!("curve {number}"),
                _ => rich::plain(name),
            },
            axes: [&self.x, &self.y].map(|axis| rich::plain(&axis.label)),
            pieces: pieces(points),
        });
        exported.collect()
    }

    fn heading(&self) -> String {
        match (self.label.is_empty(), self.title.is_empty()) {
            (true, true) => String::new(),
            (false, true) => format!("**{}**", self.label),
            (true, false) => self.title.clone(),
            (false, false) => format!("**{}**  {}", self.label, self.title),
        }
    }

    /// Height of numbers and label below the plot rectangle, px.
    fn below(&self) -> f64 {
        let label = match self.x.label.as_str() {
            "" => 0.0,
            _ => metrics::LARGE_TEXT + DESCENT + 1.0,
        };
        TICK_GAP + self.x.numbers() + label
    }

    /// The space this panel needs around its plot rectangle in a cell of the given width.
    ///
    /// # Errors
    /// An axis without an interval; a damaged font.
    pub(super) fn margins(&self, cell_width: f64) -> Result<Margins, PlotError> {
        self.x.check()?;
        self.y.check()?;
        let mut left = TICK_GAP;
        if self.y.numbered {
            let mut widest: f64 = 0.0;
            for (_, text) in self.y.major() {
                widest = widest.max(metrics::width(&text, metrics::SMALL_TEXT)?);
            }
            left += widest;
        }
        if !self.y.label.is_empty() {
            left += LABEL_GAP + metrics::LARGE_TEXT + DESCENT - 2.0;
        }
        let mut right: f64 = 3.0;
        if let (true, Some((v, text))) = (self.x.numbered, self.x.major().last()) {
            let from_border = (self.x.max - v) / (self.x.max - self.x.min) * cell_width;
            right = right.max(metrics::width(text, metrics::SMALL_TEXT)? / 2.0 - from_border + 1.0);
        }
        let top = if self.heading().is_empty() {
            metrics::SMALL_TEXT / 2.0
        } else {
            metrics::LARGE_TEXT + 8.0
        };
        let mut bottom = self.below();
        if self.legend == Legend::Below {
            bottom += legend::height_below(self.entries(), cell_width - left - right)?;
        }
        Ok(Margins {
            left,
            right,
            top,
            bottom,
        })
    }

    /// Draws into a cell of the page, leaving these margins.
    pub(super) fn draw(&self, page: &Page<'_>, cell: &Frame, margins: &Margins) -> Drawn {
        let frame = Frame {
            left: cell.left + margins.left,
            top: cell.top + margins.top,
            right: cell.right - margins.right,
            bottom: cell.bottom - margins.bottom,
        };
        let plot = Plot::new(page, frame, &self.x, &self.y);
        for layer in &self.layers {
            layer.draw(&plot)?;
        }
        self.draw_axis(&plot, &self.x, None)?;
        self.draw_axis(&plot, &self.y, Some(cell.left))?;
        let pen = Pen::new(BLACK, FRAME_WIDTH);
        plot.sheet.outline(&frame, &pen)?;
        for layer in &self.layers {
            layer.annotate(&plot)?;
        }
        self.draw_legend(&plot.sheet, &frame)?;
        let heading = self.heading();
        if heading.is_empty() {
            return Ok(());
        }
        let words = Words::new(&heading, metrics::LARGE_TEXT, (HPos::Left, VPos::Bottom));
        plot.sheet.words((frame.left, frame.top - 7.0), words)
    }

    /// Ticks, numbers and label: below the plot rectangle, or left of it with the label from
    /// `label_left` on.
    fn draw_axis(&self, plot: &Plot<'_, '_>, axis: &Axis, label_left: Option<f64>) -> Drawn {
        let pen = Pen::new(BLACK, FRAME_WIDTH);
        let (frame, is_lower) = (&plot.frame, label_left.is_none());
        let tick = |v: f64, length: f64| {
            let (x, y) = plot.px((v, v));
            let ends = if is_lower {
                [(x, frame.bottom), (x, frame.bottom - length)]
            } else {
                [(frame.left, y), (frame.left + length, y)]
            };
            plot.sheet.stroke(&ends, &pen).map(|()| ends[0])
        };
        for v in axis.minor_ticks() {
            tick(v, MINOR_TICK_LENGTH)?;
        }
        for (v, text) in axis.major() {
            let (x, y) = tick(v, TICK_LENGTH)?;
            let (at, anchor) = if is_lower {
                ((x, y + TICK_GAP + 1.0), (HPos::Center, VPos::Top))
            } else {
                ((x - TICK_GAP, y), (HPos::Right, VPos::Center))
            };
            if axis.numbered {
                plot.sheet
                    .words(at, Words::new(&text, metrics::SMALL_TEXT, anchor))?;
            }
        }
        if axis.label.is_empty() {
            return Ok(());
        }
        let at = match label_left {
            Some(left) => (left, (frame.top + frame.bottom) / 2.0),
            None => (
                (frame.left + frame.right) / 2.0,
                frame.bottom + TICK_GAP + axis.numbers() + 3.0,
            ),
        };
        let words = Words {
            upwards: !is_lower,
            ..Words::new(&axis.label, metrics::LARGE_TEXT, (HPos::Center, VPos::Top))
        };
        plot.sheet.words(at, words)
    }

    fn draw_legend(&self, sheet: &Sheet<'_, '_>, frame: &Frame) -> Drawn {
        let entries = self.entries();
        match self.legend {
            Legend::Hidden => Ok(()),
            Legend::Below => {
                let top = frame.bottom + self.below();
                legend::draw_below(sheet, entries, (frame.left, frame.right), top)
            }
            corner => legend::draw_inside(sheet, entries, frame, corner),
        }
    }
}
