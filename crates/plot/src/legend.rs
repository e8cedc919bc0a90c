//! Legends.

use plotters_backend::text_anchor::{HPos, VPos};

use super::color::{Color, WHITE};
use super::elements::Ink;
use super::marks::Words;
use super::metrics;
use super::pen::Pen;
use super::plot::{Drawn, Frame, Sheet};
use crate::error::PlotError;

/// Position of a panel's legend.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Legend {
    /// No legend.
    #[default]
    Hidden,
    /// Inside, upper left corner.
    UpperLeft,
    /// Inside, at the upper border.
    UpperMiddle,
    /// Place under the panel, in as many columns as fit.
    Below,
}

/// A line of a legend: a text, preceded by a sample of the layer.
pub struct Entry {
    text: String,
    ink: Ink,
}

impl Entry {
    /// An entry; `None` without a text.
    pub(super) fn new(text: &str, ink: Ink) -> Option<Self> {
        let text = text.to_owned();
        (!text.is_empty()).then_some(Self { text, ink })
    }
}

/// Most lines of a legend below a panel, and inside: more would leave no room for the panel.
const MOST_LINES: usize = 12;
const MOST_LINES_INSIDE: usize = 6;

// Lengths, px. They are chosen by eye for small text.
const LINE_HEIGHT: f64 = 16.0;
const KEY_WIDTH: f64 = 27.0;
const KEY_GAP: f64 = 6.0;
const COLUMN_GAP: f64 = 18.0;
const PADDING: f64 = 5.0;
const INSET: f64 = 7.0;

/// Width of the widest entry, px.
fn widest(entries: &[Entry]) -> Result<f64, PlotError> {
    let widths = entries
        .iter()
        .map(|entry| metrics::width(&entry.text, metrics::SMALL_TEXT));
    let widths: Vec<f64> = widths.collect::<Result<_, _>>()?;
    Ok(KEY_WIDTH + KEY_GAP + widths.into_iter().fold(0.0, f64::max))
}

/// An entry that counts others.
fn counted(entries: usize) -> Entry {
    Entry {
        text: format!("and {entries} more"),
        ink: Ink::Line(Pen::new(WHITE, 0.0)),
    }
}

/// The entries that a legend of so many lines has room for, with number and width of its columns.
/// The rest is counted in the last entry.
fn arranged(
    mut entries: Vec<Entry>,
    available: f64,
    lines: usize,
) -> Result<(Vec<Entry>, usize, f64), PlotError> {
    let mut widest = widest(&entries)?;
    if entries.len() > lines {
        widest = widest.max(self::widest(&[counted(entries.len())])?);
    }
    let fit = ((available + COLUMN_GAP) / (widest + COLUMN_GAP)).floor() as usize;
    let fit = fit.clamp(1, entries.len().max(1));
    let room = fit * lines;
    if entries.len() > room {
        let rest = entries.split_off(room - 1);
        entries.push(counted(rest.len()));
    }
    // The entries are spread evenly over the lines: 4 entries make 2 + 2, not 3 + 1.
    let lines = entries.len().div_ceil(fit);
    let columns = entries.len().div_ceil(lines.max(1)).max(1);
    Ok((entries, columns, widest))
}

/// Height a legend below a panel takes, px.
pub(super) fn height_below(entries: Vec<Entry>, available: f64) -> Result<f64, PlotError> {
    if entries.is_empty() {
        return Ok(0.0);
    }
    let (entries, count, _) = arranged(entries, available, MOST_LINES)?;
    Ok(entries.len().div_ceil(count) as f64 * LINE_HEIGHT + PADDING)
}

/// Draws the legend under a panel: centred between `left` and `right`, from `top` down.
pub(super) fn draw_below(
    sheet: &Sheet<'_, '_>,
    entries: Vec<Entry>,
    (left, right): (f64, f64),
    top: f64,
) -> Drawn {
    if entries.is_empty() {
        return Ok(());
    }
    let (entries, count, width) = arranged(entries, right - left, MOST_LINES)?;
    let total = count as f64 * (width + COLUMN_GAP) - COLUMN_GAP;
    let start = left + ((right - left) - total) / 2.0;
    for (i, entry) in entries.iter().enumerate() {
        let (line, column) = (i / count, i % count);
        let x = start + column as f64 * (width + COLUMN_GAP);
        draw_entry(
            sheet,
            entry,
            x,
            top + PADDING + (line as f64 + 0.5) * LINE_HEIGHT,
        )?;
    }
    Ok(())
}

/// Draws the legend inside the plot rectangle.
pub(super) fn draw_inside(
    sheet: &Sheet<'_, '_>,
    entries: Vec<Entry>,
    plot: &Frame,
    place: Legend,
) -> Drawn {
    if entries.is_empty() {
        return Ok(());
    }
    let (entries, _, widest) = arranged(entries, 0.0, MOST_LINES_INSIDE)?;
    let width = widest + 2.0 * PADDING;
    let height = entries.len() as f64 * LINE_HEIGHT + PADDING;
    let left = match place {
        Legend::UpperLeft => plot.left + INSET,
        _ => (plot.left + plot.right - width) / 2.0,
    };
    let top = plot.top + INSET;
    let frame = Frame::new((left, top), (width, height));
    sheet.rect(&frame, WHITE)?;
    sheet.outline(&frame, &Pen::new(Color(190, 190, 190), 0.6))?;
    for (i, entry) in entries.iter().enumerate() {
        let y = top + PADDING / 2.0 + (i as f64 + 0.5) * LINE_HEIGHT;
        draw_entry(sheet, entry, left + PADDING, y)?;
    }
    Ok(())
}

fn draw_entry(sheet: &Sheet<'_, '_>, entry: &Entry, x: f64, y: f64) -> Drawn {
    match &entry.ink {
        Ink::Area(color) => {
            let swatch = Frame::between((x + 2.0, y - 4.5), (x + KEY_WIDTH - 2.0, y + 4.5));
            sheet.rect(&swatch, *color)?;
            sheet.outline(&swatch, &Pen::new(Color(150, 150, 150), 0.5))?;
        }
        Ink::Line(_) => sheet.draw(&[(x, y), (x + KEY_WIDTH, y)], entry.ink.clone())?,
        _ => sheet.draw(&[(x + KEY_WIDTH / 2.0, y)], entry.ink.clone())?,
    }
    let words = Words::new(&entry.text, metrics::SMALL_TEXT, (HPos::Left, VPos::Center));
    sheet.words((x + KEY_WIDTH + KEY_GAP, y), words)
}
