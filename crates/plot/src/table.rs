//! A short table of text in the place of a panel.

use plotters_backend::text_anchor::{HPos, VPos};

use super::color::BLACK;
use super::marks::Words;
use super::metrics;
use super::pen::Pen;
use super::plot::{Drawn, Frame, Page, Sheet};
use crate::error::PlotError;

// Lengths, px. They are chosen by eye at the nominal size.
const LINE_HEIGHT: f64 = 17.0;
const COLUMN_GAP: f64 = 16.0;
const TITLE_HEIGHT: f64 = 22.0;

/// Rows of marked-up text under a header; the first column is set to the left, the others to the
/// right.
#[derive(Clone, Debug)]
pub struct Table {
    title: String,
    rows: Vec<Vec<String>>,
    notes: Vec<String>,
}

impl Table {
    /// A table with its header.
    pub fn new<S: Into<String>>(header: impl IntoIterator<Item = S>) -> Self {
        Self {
            title: String::new(),
            rows: vec![header.into_iter().map(Into::into).collect()],
            notes: Vec::new(),
        }
    }

    setters! {
        /// A heading, in markup.
        title: &str => title;
    }

    /// Adds a row.
    pub fn row<S: Into<String>>(mut self, cells: impl IntoIterator<Item = S>) -> Self {
        self.rows.push(cells.into_iter().map(Into::into).collect());
        self
    }

    /// Adds a line under the table, in markup. It is not broken: make it no longer than a row.
    pub fn note(mut self, line: &str) -> Self {
        self.notes.push(line.to_owned());
        self
    }

    fn widths(&self) -> Result<Vec<f64>, PlotError> {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let mut widths = vec![0.0_f64; columns];
        for row in &self.rows {
            for (cell, width) in row.iter().zip(&mut widths) {
                *width = width.max(metrics::width(cell, metrics::SMALL_TEXT)?);
            }
        }
        Ok(widths)
    }

    /// Draws the table in the upper part of a cell, centred.
    pub(super) fn draw(&self, page: &Page<'_>, cell: &Frame) -> Drawn {
        let sheet = Sheet { page };
        let widths = self.widths()?;
        let total = widths.iter().sum::<f64>() + COLUMN_GAP * widths.len().saturating_sub(1) as f64;
        let left = cell.left + (cell.width() - total) / 2.0;
        let right = left + total;
        let mut top = cell.top;
        if !self.title.is_empty() {
            let words = Words::new(
                &self.title,
                metrics::SMALL_TEXT + 1.0,
                (HPos::Left, VPos::Top),
            );
            sheet.words((left, top), words)?;
            top += TITLE_HEIGHT;
        }
        let rule =
            |y: f64, width: f64| sheet.stroke(&[(left, y), (right, y)], &Pen::new(BLACK, width));
        rule(top, 1.1)?;
        for (i, row) in self.rows.iter().enumerate() {
            let middle = top + (i as f64 + 0.5) * LINE_HEIGHT + 0.5;
            let mut x = left;
            for (column, (cell, width)) in row.iter().zip(&widths).enumerate() {
                let (at, h) = if column == 0 {
                    (x, HPos::Left)
                } else {
                    (x + width, HPos::Right)
                };
                sheet.words(
                    (at, middle),
                    Words::new(cell, metrics::SMALL_TEXT, (h, VPos::Center)),
                )?;
                x += width + COLUMN_GAP;
            }
        }
        rule(top + LINE_HEIGHT, 0.6)?;
        let bottom = top + self.rows.len() as f64 * LINE_HEIGHT + 1.0;
        for (i, note) in self.notes.iter().enumerate() {
            let middle = bottom + (i as f64 + 0.5) * LINE_HEIGHT + 2.0;
            let words = Words::new(note, metrics::SMALL_TEXT, (HPos::Left, VPos::Center));
            sheet.words((left, middle), words)?;
        }
        rule(bottom, 1.1)
    }
}
