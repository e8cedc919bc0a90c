//! A panel's plot rectangle while it is being drawn: data coordinates on top of the page.

use super::axis::Axis;
use super::canvas::{Canvas, Drawn, Frame, Units, units};
use super::polyline::{self, Bounds, Point};
use super::style::{Color, Pen, Symbol};

/// Nobody sees a curve move by less than this, px, even enlarged a few times.
const TOLERANCE: f64 = 0.02;

/// Draws in the data coordinates of a panel.
pub(super) struct Plot<'p> {
    pub(super) canvas: &'p Canvas,
    pub(super) frame: Frame,
    pub(super) bounds: Bounds,
}

impl<'p> Plot<'p> {
    pub(super) fn new(canvas: &'p Canvas, frame: Frame, x: &Axis, y: &Axis) -> Self {
        Self {
            canvas,
            frame,
            bounds: Bounds {
                x: (x.min, x.max),
                y: (y.min, y.max),
            },
        }
    }

    /// px per data unit.
    fn scale(&self) -> Point {
        (
            self.frame.width() / (self.bounds.x.1 - self.bounds.x.0),
            self.frame.height() / (self.bounds.y.1 - self.bounds.y.0),
        )
    }

    /// Where a data point lies on the page, px.
    pub(super) fn px(&self, p: Point) -> Point {
        let (sx, sy) = self.scale();
        (
            self.frame.left + (p.0 - self.bounds.x.0) * sx,
            self.frame.bottom - (p.1 - self.bounds.y.0) * sy,
        )
    }

    /// The place of a data point, by parts of the sides of the frame. Places are rounded towards the
    /// lower left corner, but for a thousandth of a unit, within which a point is on a whole one.
    fn place(&self, points: &[Point]) -> Vec<Units> {
        const SLACK: f64 = 1e-3;
        let along = |v: f64, (low, high): (f64, f64), from: f64, to: f64| {
            let (from, to) = (units(from), units(to));
            let way = f64::from(to - from) * ((v - low) / (high - low));
            let whole = if to > from {
                (way + SLACK).floor()
            } else {
                (way - SLACK).ceil()
            };
            from + whole as i32
        };
        let frame = &self.frame;
        let place = |p: &Point| {
            (
                along(p.0, self.bounds.x, frame.left, frame.right),
                along(p.1, self.bounds.y, frame.bottom, frame.top),
            )
        };
        points.iter().map(place).collect()
    }

    /// A polyline in data units, cut at the frame.
    pub(super) fn stroke(&self, points: &[Point], pen: &Pen) -> Drawn {
        for piece in polyline::clip_line(points, &self.bounds) {
            let points = polyline::thin(&piece, self.scale(), TOLERANCE);
            self.canvas.path(&self.place(&points), pen)?;
        }
        Ok(())
    }

    /// A filled polygon in data units, cut at the frame.
    pub(super) fn fill(&self, points: &[Point], color: Color) -> Drawn {
        let cut = polyline::clip_area(points, &self.bounds);
        let corners = polyline::thin(&cut, self.scale(), TOLERANCE);
        self.canvas.area(&self.place(&corners), color)
    }

    /// Markers at those of the data points that lie inside the frame.
    pub(super) fn symbols(&self, points: &[Point], symbol: &Symbol) -> Drawn {
        let inside = points.iter().filter(|point| self.bounds.contains(**point));
        let inside: Vec<Point> = inside.copied().collect();
        let mut places = self.place(&inside).into_iter();
        places.try_for_each(|at| self.canvas.symbol(at, symbol))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::canvas::Naming;

    #[test]
    fn data_points_are_placed_towards_the_lower_left() {
        let naming = Naming {
            id: "",
            title: "",
            description: "",
        };
        let canvas = Canvas::new((12.0, 12.0), &naming).unwrap();
        let frame = Frame {
            left: 1.0,
            top: 1.0,
            right: 11.0,
            bottom: 11.0,
        };
        let unit = || Axis::new("", 0.0, 1.0);
        let plot = Plot::new(&canvas, frame, &unit(), &unit());
        // A side is a thousand units long.
        let points = [(0.0, 0.0), (0.5, 0.25), (0.0019, 0.0019), (1.0, 1.0)];
        let places = [(100, 1100), (600, 850), (101, 1099), (1100, 100)];
        assert_eq!(plot.place(&points), places);
    }
}
