//! Cells of a grid, such as the starts that lead to one attractor.

use super::Layer;
use crate::color::{BLUE, Color};
use crate::elements::Ink;
use crate::legend::Entry;
use crate::plot::{Drawn, Frame, Plot};

/// The cells of a grid that are set, in one colour. A picture of several kinds of cells is a layer
/// for each kind.
#[derive(Clone, Debug)]
pub struct Cells {
    x: (f64, f64),
    y: (f64, f64),
    columns: usize,
    set: Vec<bool>,
    fill: Color,
    legend: String,
}

impl Cells {
    /// The cells of a grid over the ranges `x` and `y`, row by row from the lowest `y`, in each row
    /// from the lowest `x`. A last row that is not complete is left out.
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
            legend: String::new(),
        }
    }

    setters! {
        /// Colour.
        fill: Color => fill;
        /// Text in the legend, in markup.
        legend: &str => legend;
    }

    /// Rectangles that cover the set cells, as ranges of columns and of rows: neighbours in a row
    /// together, and equal ones above one another.
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
    fn draw(&self, plot: &Plot<'_, '_>) -> Drawn {
        let rows = self.set.len() / self.columns;
        let part = |(low, high): (f64, f64), k: usize, of: usize| {
            low + (high - low) * k as f64 / of as f64
        };
        let frame = &plot.frame;
        let mut tiles = Vec::new();
        for [columns, rows_of] in self.rectangles() {
            let corner = |column, row| {
                let x = part(self.x, column, self.columns);
                plot.px((x, part(self.y, row, rows)))
            };
            let found = Frame::between(corner(columns.0, rows_of.0), corner(columns.1, rows_of.1));
            let cut = Frame {
                left: found.left.max(frame.left),
                top: found.top.max(frame.top),
                right: found.right.min(frame.right),
                bottom: found.bottom.min(frame.bottom),
            };
            if cut.left < cut.right && cut.top < cut.bottom {
                tiles.extend(cut.corners());
            }
        }
        plot.sheet.draw(&tiles, Ink::Area(self.fill))
    }

    fn legend(&self) -> Option<Entry> {
        Entry::new(&self.legend, Ink::Area(self.fill))
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
