//! Areas.

use super::{Layer, frame_between, in_legend};
use crate::canvas::{Drawn, Frame};
use crate::legend::{Entry, Key};
use crate::plot::Plot;
use crate::style::{BLUE, Color, LIGHT_GREY};

in_legend!(Band, Cells, Region);

/// A shaded rectangle: between two abscissae, two ordinates, or both.
#[derive(Clone, Debug)]
pub struct Band {
    x: (f64, f64),
    y: (f64, f64),
    bar: Option<f64>,
    fill: Color,
    legend: Option<String>,
}

impl Band {
    /// From abscissa to abscissa over the whole height, such as the time of a stick phase.
    pub fn x(from: f64, to: f64) -> Self {
        Self::rect((from, to), (f64::NEG_INFINITY, f64::INFINITY))
    }

    /// From ordinate to ordinate over the whole width.
    pub fn y(from: f64, to: f64) -> Self {
        Self::rect((f64::NEG_INFINITY, f64::INFINITY), (from, to))
    }

    /// A rectangle in data units; an infinite end means the border of the panel.
    pub fn rect(x: (f64, f64), y: (f64, f64)) -> Self {
        Self {
            x,
            y,
            bar: None,
            fill: LIGHT_GREY,
            legend: None,
        }
    }

    /// A horizontal bar from abscissa to abscissa at an ordinate, `thickness` px high, such as a stick zone
    /// in the phase plane.
    pub fn bar(x: (f64, f64), y: f64, thickness: f64) -> Self {
        let mut band = Self::rect(x, (y, y));
        band.bar = Some(thickness);
        band
    }

    /// Colour of the shading.
    pub fn fill(mut self, color: Color) -> Self {
        self.fill = color;
        self
    }

    /// The corners inside the panel, lower left and upper right, or nothing.
    fn corners(&self, plot: &Plot<'_>) -> Option<[(f64, f64); 2]> {
        let half = match self.bar {
            Some(thickness) => {
                let per_px = (plot.bounds.y.1 - plot.bounds.y.0) / plot.frame.height();
                thickness / 2.0 * per_px
            }
            None => 0.0,
        };
        let x = (self.x.0.max(plot.bounds.x.0), self.x.1.min(plot.bounds.x.1));
        let y = (
            (self.y.0 - half).max(plot.bounds.y.0),
            (self.y.1 + half).min(plot.bounds.y.1),
        );
        (x.0 < x.1 && y.0 < y.1).then_some([(x.0, y.0), (x.1, y.1)])
    }
}

impl Layer for Band {
    fn draw(&self, plot: &Plot<'_>) -> Drawn {
        let Some([low, high]) = self.corners(plot) else {
            return Ok(());
        };
        let frame = frame_between(plot.px(low), plot.px(high));
        plot.canvas.rect(&frame, self.fill)
    }

    fn legend(&self) -> Option<Entry> {
        let text = self.legend.as_ref()?;
        Some(Entry::new(text, Key::Area(self.fill)))
    }
}

/// The cells of a grid that are set, in one colour. A picture of several kinds of cells is a layer for each kind.
#[derive(Clone, Debug)]
pub struct Cells {
    x: (f64, f64),
    y: (f64, f64),
    columns: usize,
    set: Vec<bool>,
    fill: Color,
    legend: Option<String>,
}

impl Cells {
    /// The cells of a grid over the ranges `x` and `y`, row by row from the lowest `y`, in each row from the lowest `x`. A last row that is
    /// not complete is left out.
    pub fn new(
        x: (f64, f64),
        y: (f64, f64),
        columns: usize,
        set: impl IntoIterator<Item = bool>,
    ) -> Self {
        Self {
            x,
            y,
            columns: columns.max(1),
            set: set.into_iter().collect(),
            fill: BLUE,
            legend: None,
        }
    }

    /// Colour.
    pub fn fill(mut self, color: Color) -> Self {
        self.fill = color;
        self
    }

    /// Rectangles that cover the set cells, as ranges of columns and of rows: neighbours in a row together, and equal ones above one another.
    fn rectangles(&self) -> Vec<[(usize, usize); 2]> {
        let mut done: Vec<[(usize, usize); 2]> = Vec::new();
        // Indices of those that end at the row before.
        let mut open: Vec<usize> = Vec::new();
        for (row, cells) in self.set.chunks_exact(self.columns).enumerate() {
            let mut next = Vec::new();
            let mut column = 0;
            for run in cells.chunk_by(|one, other| one == other) {
                let range = (column, column + run.len());
                column = range.1;
                if !run[0] {
                    continue;
                }
                let below = open.iter().copied().find(|&index| done[index][0] == range);
                let index = below.unwrap_or_else(|| {
                    done.push([range, (row, row)]);
                    done.len() - 1
                });
                done[index][1].1 = row + 1;
                next.push(index);
            }
            open = next;
        }
        done
    }
}

impl Layer for Cells {
    fn draw(&self, plot: &Plot<'_>) -> Drawn {
        let rows = self.set.len() / self.columns;
        let part = |(low, high): (f64, f64), k: usize, of: usize| {
            low + (high - low) * k as f64 / of as f64
        };
        let frame = &plot.frame;
        let mut frames = Vec::new();
        for [columns, rows_of] in self.rectangles() {
            let corner = |column, row| {
                let x = part(self.x, column, self.columns);
                plot.px((x, part(self.y, row, rows)))
            };
            let found = frame_between(corner(columns.0, rows_of.0), corner(columns.1, rows_of.1));
            let cut = Frame {
                left: found.left.max(frame.left),
                top: found.top.max(frame.top),
                right: found.right.min(frame.right),
                bottom: found.bottom.min(frame.bottom),
            };
            if cut.left < cut.right && cut.top < cut.bottom {
                frames.push(cut);
            }
        }
        plot.canvas.rects(&frames, self.fill)
    }

    fn legend(&self) -> Option<Entry> {
        let text = self.legend.as_ref()?;
        Some(Entry::new(text, Key::Area(self.fill)))
    }
}

/// A filled area, such as a stick zone whose ends oscillate.
#[derive(Clone, Debug)]
pub struct Region {
    outline: Vec<(f64, f64)>,
    fill: Color,
    legend: Option<String>,
}

impl Region {
    /// The area between two curves that run in the same direction.
    pub fn between(
        one: impl IntoIterator<Item = (f64, f64)>,
        other: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        let mut outline: Vec<(f64, f64)> = one.into_iter().collect();
        let mut back: Vec<(f64, f64)> = other.into_iter().collect();
        back.reverse();
        outline.append(&mut back);
        Self {
            outline,
            fill: LIGHT_GREY,
            legend: None,
        }
    }

    /// Colour.
    pub fn fill(mut self, color: Color) -> Self {
        self.fill = color;
        self
    }
}

impl Layer for Region {
    fn draw(&self, plot: &Plot<'_>) -> Drawn {
        plot.fill(&self.outline, self.fill)
    }

    fn legend(&self) -> Option<Entry> {
        self.legend
            .as_ref()
            .map(|text| Entry::new(text, Key::Area(self.fill)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rectangles_cover_the_set_cells_and_no_others() {
        // Any pattern: the low bits of a quadratic sequence.
        let (columns, rows) = (9, 7);
        let set: Vec<bool> = (0..columns * rows)
            .map(|k| (k * k + k / 5) % 3 == 0)
            .collect();
        let cells = Cells::new((0.0, 1.0), (0.0, 1.0), columns, set.clone());
        let mut covered = vec![0; columns * rows];
        for [of_columns, of_rows] in cells.rectangles() {
            for row in of_rows.0..of_rows.1 {
                for column in of_columns.0..of_columns.1 {
                    covered[row * columns + column] += 1;
                }
            }
        }
        let wanted: Vec<i32> = set.into_iter().map(i32::from).collect();
        assert_eq!(covered, wanted);
    }

    #[test]
    fn a_block_is_one_rectangle() {
        let set = (0..5 * 4).map(|k| (1..3).contains(&(k % 5)) && k > 5);
        let cells = Cells::new((0.0, 1.0), (0.0, 1.0), 5, set);
        assert_eq!(cells.rectangles(), [[(1, 3), (1, 4)]]);
    }
}
