//! The page: rows of panels.

use plotters::drawing::IntoDrawingArea;

use super::canvas::{Canvas, Naming};
use super::panel::{Margins, Panel};
use super::plot::Frame;
use super::table::Table;
use crate::figures::error::FigureError;

/// White border of the page, px.
const BORDER: f64 = 8.0;
/// Space between neighbouring cells, px.
const GAP: f64 = 14.0;
/// Smallest plot rectangle that still shows something, px.
const SMALLEST: f64 = 24.0;

/// What stands in a cell of the page.
pub enum Cell {
    /// Axes and curves.
    Panel(Panel),
    /// Text.
    Table(Table),
}

impl From<Panel> for Cell {
    fn from(panel: Panel) -> Self {
        Cell::Panel(panel)
    }
}

impl From<Table> for Cell {
    fn from(table: Table) -> Self {
        Cell::Table(table)
    }
}

impl Cell {
    fn margins(&self, width: f64) -> Result<Margins, FigureError> {
        match self {
            Cell::Panel(panel) => panel.margins(width),
            Cell::Table(_) => Ok(Margins {
                left: 0.0,
                right: 0.0,
                top: 0.0,
                bottom: 0.0,
            }),
        }
    }
}

struct Row {
    weight: f64,
    cells: Vec<(f64, Cell)>,
}

/// A figure of one or more panels.
pub struct Figure {
    id: String,
    title: String,
    description: String,
    size: (f64, f64),
    rows: Vec<Row>,
}

/// Where a cell of the page lies and which margins it keeps.
struct Placed<'f> {
    frame: Frame,
    margins: Margins,
    cell: &'f Cell,
}

impl Figure {
    /// An empty figure. `id` is unique among figures (`fig06`); `width` and `height` in px. `title` and
    /// `description` are for readers who cannot see the picture and say what it shows.
    pub fn new(id: &str, (width, height): (f64, f64), title: &str, description: &str) -> Self {
        Self {
            id: id.to_owned(),
            title: title.to_owned(),
            description: description.to_owned(),
            size: (width, height),
            rows: Vec::new(),
        }
    }

    /// Adds a row with one cell. `weight` is its share of the height.
    pub fn row(self, weight: f64, cell: impl Into<Cell>) -> Self {
        self.columns(weight, vec![(1.0, cell.into())])
    }

    /// Adds a row of several cells, each with its share of the width.
    pub fn columns(mut self, weight: f64, cells: Vec<(f64, Cell)>) -> Self {
        self.rows.push(Row { weight, cells });
        self
    }

    /// The SVG.
    ///
    /// # Errors
    /// An axis without an interval, a figure too small for its labels.
    pub fn render(&self) -> Result<String, FigureError> {
        let placed = self.layout()?;
        let mut svg = String::new();
        let naming = Naming {
            id: &self.id,
            title: &self.title,
            description: &self.description,
        };
        let (width, height) = self.size;
        let canvas = Canvas::new(&mut svg, width, height, &naming)
            .map_err(|error| FigureError::Draw(error.to_string()))?;
        let page = canvas.into_drawing_area();
        for place in &placed {
            match place.cell {
                Cell::Panel(panel) => panel.draw(&page, &place.frame, &place.margins)?,
                Cell::Table(table) => table.draw(&page, &place.frame)?,
            }
        }
        page.present()?;
        drop(page);
        Ok(svg)
    }

    /// Divides the page. Panels under one another get the same margins, so that their frames line up.
    fn layout(&self) -> Result<Vec<Placed<'_>>, FigureError> {
        let (width, height) = self.size;
        let weights: f64 = self.rows.iter().map(|row| row.weight).sum();
        let gaps = GAP * self.rows.len().saturating_sub(1) as f64;
        let room = height - 2.0 * BORDER - gaps;
        let mut rows: Vec<Vec<Placed<'_>>> = Vec::new();
        let mut top = BORDER;
        for row in &self.rows {
            let bottom = top + room * row.weight / weights;
            rows.push(place_row(row, width, top, bottom)?);
            top = bottom + GAP;
        }
        line_up(&mut rows);
        let placed: Vec<Placed<'_>> = rows.into_iter().flatten().collect();
        for place in &placed {
            let width = place.frame.width() - place.margins.left - place.margins.right;
            let height = place.frame.height() - place.margins.top - place.margins.bottom;
            if !(width >= SMALLEST && height >= SMALLEST) {
                return Err(FigureError::NoRoom {
                    figure: self.id.clone(),
                    width,
                    height,
                });
            }
        }
        Ok(placed)
    }
}

fn place_row(
    row: &Row,
    page_width: f64,
    top: f64,
    bottom: f64,
) -> Result<Vec<Placed<'_>>, FigureError> {
    let weights: f64 = row.cells.iter().map(|(weight, _)| weight).sum();
    let room = page_width - 2.0 * BORDER - GAP * row.cells.len().saturating_sub(1) as f64;
    let mut left = BORDER;
    let mut placed = Vec::new();
    for (weight, cell) in &row.cells {
        let right = left + room * weight / weights;
        placed.push(Placed {
            frame: Frame {
                left,
                top,
                right,
                bottom,
            },
            margins: cell.margins(right - left)?,
            cell,
        });
        left = right + GAP;
    }
    // Frames beside one another begin and end at the same height.
    let above = placed.iter().map(|p| p.margins.top).fold(0.0, f64::max);
    let below = placed.iter().map(|p| p.margins.bottom).fold(0.0, f64::max);
    for place in &mut placed {
        if matches!(place.cell, Cell::Panel(_)) {
            place.margins.top = above;
            place.margins.bottom = below;
        }
    }
    Ok(placed)
}

/// Gives panels whose cells begin (or end) at the same abscissa the same left (or right) margin.
fn line_up(rows: &mut [Vec<Placed<'_>>]) {
    let cells: Vec<(f64, f64, Margins)> = rows
        .iter()
        .flatten()
        .filter(|p| matches!(p.cell, Cell::Panel(_)))
        .map(|p| (p.frame.left, p.frame.right, p.margins))
        .collect();
    for place in rows.iter_mut().flatten() {
        if matches!(place.cell, Cell::Table(_)) {
            continue;
        }
        for (left, right, margins) in &cells {
            if (left - place.frame.left).abs() < 0.5 {
                place.margins.left = place.margins.left.max(margins.left);
            }
            if (right - place.frame.right).abs() < 0.5 {
                place.margins.right = place.margins.right.max(margins.right);
            }
        }
    }
}
