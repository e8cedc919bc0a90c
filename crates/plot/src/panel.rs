//! A panel: axes and what is drawn between them.

use super::PlotError;
use super::axis::Axis;
use super::canvas::{Canvas, Drawn, Frame};
use super::layers::{AnyLayer, Layer};
use super::legend::{self, Entry, Legend};
use super::metrics;
use super::plot::Plot;
use super::style::{BLACK, HPos, Pen, VPos, Words};

const TICK_TEXT: f64 = 11.0;
const AXIS_TEXT: f64 = 12.5;
const PANEL_TEXT: f64 = 12.5;
const TICK: f64 = 4.5;
const MINOR_TICK: f64 = 2.5;
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

    /// Label above the upper left corner, such as `(a)`; set in bold.
    pub fn label(mut self, label: &str) -> Self {
        self.label = label.to_owned();
        self
    }

    /// Heading after the label, in markup.
    pub fn title(mut self, title: &str) -> Self {
        self.title = title.to_owned();
        self
    }

    /// Where the legend stands. The caller knows which corner is free.
    pub fn legend(mut self, place: Legend) -> Self {
        self.legend = place;
        self
    }

    /// Adds a layer on top of those already there.
    pub fn add(&mut self, layer: impl Into<AnyLayer>) -> &mut Self {
        self.layers.push(layer.into().0);
        self
    }

    /// Adds a layer on top of those already there, in a chain of calls.
    pub fn with(mut self, layer: impl Into<AnyLayer>) -> Self {
        self.add(layer);
        self
    }

    fn entries(&self) -> Vec<Entry> {
        self.layers.iter().filter_map(|l| l.legend()).collect()
    }

    fn heading(&self) -> String {
        match (self.label.is_empty(), self.title.is_empty()) {
            (true, true) => String::new(),
            (false, true) => format!("**{}**", self.label),
            (true, false) => self.title.clone(),
            (false, false) => format!("**{}**  {}", self.label, self.title),
        }
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
                widest = widest.max(metrics::width(&text, TICK_TEXT)?);
            }
            left += widest;
        }
        if !self.y.label.is_empty() {
            left += LABEL_GAP + AXIS_TEXT + DESCENT - 2.0;
        }
        let mut right: f64 = 3.0;
        if let (true, Some((v, text))) = (self.x.numbered, self.x.major().last()) {
            let from_border = (self.x.max - v) / (self.x.max - self.x.min) * cell_width;
            right = right.max(metrics::width(text, TICK_TEXT)? / 2.0 - from_border + 1.0);
        }
        let top = if self.heading().is_empty() {
            TICK_TEXT / 2.0
        } else {
            PANEL_TEXT + 8.0
        };
        let mut bottom = self.under();
        if self.legend == Legend::Below {
            bottom += legend::height_below(&self.entries(), cell_width - left - right)?;
        }
        Ok(Margins {
            left,
            right,
            top,
            bottom,
        })
    }

    /// Draws into a cell of the page, leaving these margins.
    pub(super) fn draw(&self, canvas: &Canvas, cell: &Frame, margins: &Margins) -> Drawn {
        let frame = Frame {
            left: cell.left + margins.left,
            top: cell.top + margins.top,
            right: cell.right - margins.right,
            bottom: cell.bottom - margins.bottom,
        };
        let plot = Plot::new(canvas, frame, &self.x, &self.y);
        for layer in &self.layers {
            layer.draw(&plot)?;
        }
        self.draw_axis(&plot, &self.x, None)?;
        self.draw_axis(&plot, &self.y, Some(cell.left))?;
        let pen = Pen::new(BLACK, FRAME_WIDTH);
        plot.canvas.outline(&frame, &pen)?;
        for layer in &self.layers {
            layer.annotate(&plot)?;
        }
        self.draw_legend(plot.canvas, &frame)?;
        let heading = self.heading();
        if heading.is_empty() {
            return Ok(());
        }
        let words = Words::new(&heading, PANEL_TEXT).anchor(HPos::Left, VPos::Bottom);
        plot.canvas.words((frame.left, frame.top - 7.0), words)
    }

    /// Height under the plot rectangle that numbers and label of its lower axis take.
    fn under(&self) -> f64 {
        let numbers = if self.x.numbered {
            TICK_TEXT + 2.0
        } else {
            0.0
        };
        let label = if self.x.label.is_empty() {
            0.0
        } else {
            AXIS_TEXT + DESCENT + 1.0
        };
        TICK_GAP + numbers + label
    }

    /// The lower axis, or the left one of a cell that begins at this abscissa.
    fn draw_axis(&self, plot: &Plot<'_>, axis: &Axis, cell_left: Option<f64>) -> Drawn {
        let pen = Pen::new(BLACK, FRAME_WIDTH);
        let Frame { left, bottom, .. } = plot.frame;
        // Where on the axis a value is, and so far into the panel.
        let at = |v: f64, inside: f64| match cell_left {
            None => (plot.px((v, plot.bounds.y.0)).0, bottom - inside),
            Some(_) => (left + inside, plot.px((plot.bounds.x.0, v)).1),
        };
        let tick = |v: f64, length: f64| plot.canvas.stroke(&[at(v, 0.0), at(v, length)], &pen);
        for v in axis.minor_ticks() {
            tick(v, MINOR_TICK)?;
        }
        for (v, text) in axis.major() {
            tick(v, TICK)?;
            if axis.numbered {
                let (gap, h, v_pos) = match cell_left {
                    None => (TICK_GAP + 1.0, HPos::Center, VPos::Top),
                    Some(_) => (TICK_GAP, HPos::Right, VPos::Center),
                };
                let words = Words::new(&text, TICK_TEXT).anchor(h, v_pos);
                plot.canvas.words(at(v, -gap), words)?;
            }
        }
        if axis.label.is_empty() {
            return Ok(());
        }
        let words = Words::new(&axis.label, AXIS_TEXT).anchor(HPos::Center, VPos::Top);
        match cell_left {
            None => {
                let numbers = if axis.numbered { TICK_TEXT + 2.0 } else { 0.0 };
                let y = bottom + TICK_GAP + numbers + 3.0;
                plot.canvas
                    .words(((left + plot.frame.right) / 2.0, y), words)
            }
            Some(cell_left) => {
                let y = (plot.frame.top + bottom) / 2.0;
                plot.canvas.words((cell_left, y), words.upwards())
            }
        }
    }

    fn draw_legend(&self, canvas: &Canvas, frame: &Frame) -> Drawn {
        let entries = self.entries();
        match self.legend {
            Legend::Hidden => Ok(()),
            Legend::Below => {
                let top = frame.bottom + self.under();
                legend::draw_below(canvas, &entries, (frame.left, frame.right), top)
            }
            corner => legend::draw_inside(canvas, &entries, frame, corner),
        }
    }
}
