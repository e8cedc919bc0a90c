//! A panel: axes and what is drawn between them.

use plotters_backend::text_anchor::{HPos, VPos};

use super::axis::Axis;
use super::color::BLACK;
use super::elements::Words;
use super::layers::{AnyLayer, Layer};
use super::legend::{self, Entry, Legend};
use super::metrics;
use super::pen::Pen;
use super::plot::{Drawn, Frame, Page, Plot, Sheet};
use crate::error::PlotError;

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
#[derive(Clone, Copy, Debug)]
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
        let mut bottom = TICK_GAP;
        if self.x.numbered {
            bottom += TICK_TEXT + 2.0;
        }
        if !self.x.label.is_empty() {
            bottom += AXIS_TEXT + DESCENT + 1.0;
        }
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
        self.draw_x_axis(&plot)?;
        self.draw_y_axis(&plot, cell.left)?;
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
        let words = Words::new(&heading, PANEL_TEXT).anchor(HPos::Left, VPos::Bottom);
        plot.sheet.words((frame.left, frame.top - 7.0), words)
    }

    fn draw_x_axis(&self, plot: &Plot<'_, '_>) -> Drawn {
        let pen = Pen::new(BLACK, FRAME_WIDTH);
        let bottom = plot.frame.bottom;
        for v in self.x.minor_ticks() {
            let (x, _) = plot.px((v, plot.bounds.y.0));
            plot.sheet
                .stroke(&[(x, bottom), (x, bottom - MINOR_TICK)], &pen)?;
        }
        for (v, text) in self.x.major() {
            let (x, _) = plot.px((v, plot.bounds.y.0));
            plot.sheet
                .stroke(&[(x, bottom), (x, bottom - TICK)], &pen)?;
            if self.x.numbered {
                let words = Words::new(&text, TICK_TEXT).anchor(HPos::Center, VPos::Top);
                plot.sheet.words((x, bottom + TICK_GAP + 1.0), words)?;
            }
        }
        if self.x.label.is_empty() {
            return Ok(());
        }
        let numbers = if self.x.numbered {
            TICK_TEXT + 2.0
        } else {
            0.0
        };
        let at = (
            (plot.frame.left + plot.frame.right) / 2.0,
            bottom + TICK_GAP + numbers + 3.0,
        );
        let words = Words::new(&self.x.label, AXIS_TEXT).anchor(HPos::Center, VPos::Top);
        plot.sheet.words(at, words)
    }

    fn draw_y_axis(&self, plot: &Plot<'_, '_>, cell_left: f64) -> Drawn {
        let pen = Pen::new(BLACK, FRAME_WIDTH);
        let left = plot.frame.left;
        for v in self.y.minor_ticks() {
            let (_, y) = plot.px((plot.bounds.x.0, v));
            plot.sheet
                .stroke(&[(left, y), (left + MINOR_TICK, y)], &pen)?;
        }
        for (v, text) in self.y.major() {
            let (_, y) = plot.px((plot.bounds.x.0, v));
            plot.sheet.stroke(&[(left, y), (left + TICK, y)], &pen)?;
            if self.y.numbered {
                let words = Words::new(&text, TICK_TEXT).anchor(HPos::Right, VPos::Center);
                plot.sheet.words((left - TICK_GAP, y), words)?;
            }
        }
        if self.y.label.is_empty() {
            return Ok(());
        }
        let at = (cell_left, (plot.frame.top + plot.frame.bottom) / 2.0);
        let words = Words::new(&self.y.label, AXIS_TEXT)
            .anchor(HPos::Center, VPos::Top)
            .upwards();
        plot.sheet.words(at, words)
    }

    fn draw_legend(&self, sheet: &Sheet<'_, '_>, frame: &Frame) -> Drawn {
        let entries = self.entries();
        match self.legend {
            Legend::Hidden => Ok(()),
            Legend::Below => {
                let mut top = frame.bottom + TICK_GAP;
                if self.x.numbered {
                    top += TICK_TEXT + 2.0;
                }
                if !self.x.label.is_empty() {
                    top += AXIS_TEXT + DESCENT + 1.0;
                }
                legend::draw_below(sheet, &entries, (frame.left, frame.right), top)
            }
            corner => legend::draw_inside(sheet, &entries, frame, corner),
        }
    }
}
