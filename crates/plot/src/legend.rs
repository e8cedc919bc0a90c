//! Legends.

use super::canvas::{Canvas, Drawn, Frame, place};
use super::style::{Color, HPos, Pen, Symbol, VPos, WHITE, Words};
use super::{PlotError, metrics};

/// Where a panel's legend stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Legend {
    /// None is drawn.
    #[default]
    Hidden,
    /// Inside, upper left corner.
    UpperLeft,
    /// Inside, at the upper border.
    UpperMiddle,
    /// Inside, upper right corner.
    UpperRight,
    /// Inside, lower left corner.
    LowerLeft,
    /// Inside, at the lower border.
    LowerMiddle,
    /// Inside, lower right corner.
    LowerRight,
    /// Under the panel, in as many columns as fit.
    Below,
}

/// What stands before the text.
#[derive(Clone, Copy, Debug)]
pub(super) enum Key {
    Line(Pen),
    Symbol(Symbol),
    Area(Color),
}

/// One line of a legend.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    text: String,
    key: Key,
}

impl Entry {
    pub(super) fn new(text: &str, key: Key) -> Self {
        Self {
            text: text.to_owned(),
            key,
        }
    }
}

const SIZE: f64 = 11.0;
const LINE: f64 = 16.0;
const KEY: f64 = 27.0;
const KEY_GAP: f64 = 6.0;
const COLUMN_GAP: f64 = 18.0;
const PADDING: f64 = 5.0;
const INSET: f64 = 7.0;

/// A legend below a panel, laid out for its width.
struct Columns {
    count: usize,
    width: f64,
}

/// Width of the widest entry, px.
fn widest(entries: &[Entry]) -> Result<f64, PlotError> {
    let mut widths = entries
        .iter()
        .map(|entry| metrics::width(&entry.text, SIZE));
    widths.try_fold(0.0, |most: f64, width| Ok(most.max(KEY + KEY_GAP + width?)))
}

fn columns(entries: &[Entry], available: f64) -> Result<Columns, PlotError> {
    let widest = widest(entries)?;
    let fit = ((available + COLUMN_GAP) / (widest + COLUMN_GAP)).floor() as usize;
    let fit = fit.clamp(1, entries.len().max(1));
    // As many lines as that takes, but spread evenly over them: 4 entries make 2 + 2, not 3 + 1.
    let lines = entries.len().div_ceil(fit);
    Ok(Columns {
        count: entries.len().div_ceil(lines.max(1)).max(1),
        width: widest,
    })
}

/// Height a legend below a panel takes, px.
pub(super) fn height_below(entries: &[Entry], available: f64) -> Result<f64, PlotError> {
    if entries.is_empty() {
        return Ok(0.0);
    }
    let columns = columns(entries, available)?;
    Ok(entries.len().div_ceil(columns.count) as f64 * LINE + PADDING)
}

/// Draws the legend under a panel: centred between `left` and `right`, from `top` down.
pub(super) fn draw_below(
    canvas: &Canvas,
    entries: &[Entry],
    (left, right): (f64, f64),
    top: f64,
) -> Drawn {
    if entries.is_empty() {
        return Ok(());
    }
    let Columns { count, width } = columns(entries, right - left)?;
    let total = count as f64 * (width + COLUMN_GAP) - COLUMN_GAP;
    let start = left + ((right - left) - total) / 2.0;
    for (i, entry) in entries.iter().enumerate() {
        let (line, column) = (i / count, i % count);
        let x = start + column as f64 * (width + COLUMN_GAP);
        draw_entry(canvas, entry, x, top + PADDING + (line as f64 + 0.5) * LINE)?;
    }
    Ok(())
}

/// Draws the legend inside the plot rectangle.
pub(super) fn draw_inside(
    canvas: &Canvas,
    entries: &[Entry],
    plot: &Frame,
    corner: Legend,
) -> Drawn {
    if entries.is_empty() {
        return Ok(());
    }
    let width = widest(entries)? + 2.0 * PADDING;
    let height = entries.len() as f64 * LINE + PADDING;
    let left = match corner {
        Legend::UpperLeft | Legend::LowerLeft => plot.left + INSET,
        Legend::UpperMiddle | Legend::LowerMiddle => (plot.left + plot.right - width) / 2.0,
        _ => plot.right - INSET - width,
    };
    let top = match corner {
        Legend::UpperLeft | Legend::UpperMiddle | Legend::UpperRight => plot.top + INSET,
        _ => plot.bottom - INSET - height,
    };
    let frame = Frame {
        left,
        top,
        right: left + width,
        bottom: top + height,
    };
    canvas.rect(&frame, WHITE)?;
    canvas.outline(&frame, &Pen::new(Color(190, 190, 190), 0.6))?;
    for (i, entry) in entries.iter().enumerate() {
        let y = top + PADDING / 2.0 + (i as f64 + 0.5) * LINE;
        draw_entry(canvas, entry, left + PADDING, y)?;
    }
    Ok(())
}

fn draw_entry(canvas: &Canvas, entry: &Entry, x: f64, y: f64) -> Drawn {
    match &entry.key {
        Key::Line(pen) => canvas.stroke(&[(x, y), (x + KEY, y)], pen)?,
        Key::Symbol(symbol) => canvas.symbol(place((x + KEY / 2.0, y)), symbol)?,
        Key::Area(color) => {
            let swatch = Frame {
                left: x + 2.0,
                top: y - 4.5,
                right: x + KEY - 2.0,
                bottom: y + 4.5,
            };
            canvas.rect(&swatch, *color)?;
            canvas.outline(&swatch, &Pen::new(Color(150, 150, 150), 0.5))?;
        }
    }
    let words = Words::new(&entry.text, SIZE).anchor(HPos::Left, VPos::Center);
    canvas.words((x + KEY + KEY_GAP, y), words)
}
