//! A panel's plot rectangle during drawing: data coordinates on the page.

use std::collections::HashSet;
use std::fmt;

use plotters::coord::Shift;
use plotters::coord::cartesian::Cartesian2d;
use plotters::coord::types::RangedCoordf64;
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind};

use super::axis::Axis;
use super::canvas::{Canvas, units};
use super::color::Color;
use super::elements::{Element, Ink};
use super::marks::{Symbol, Words};
use super::pen::Pen;
use super::polyline::{self, Bounds, Point};
use super::trace::Trace;
use crate::error::PlotError;

/// Displacement of a curve, px, that is invisible even when enlarged a few times.
pub(super) const INVISIBLE: f64 = 0.02;

/// Most points of a curve; of a longer one only what it shows is kept.
const MOST_POINTS: usize = 100_000;

/// Most pieces of a line with an element for each.
const MOST_ELEMENTS: usize = 64;

/// Most markers of a layer. Of more of them one is drawn for each cell of a grid.
const MOST_MARKERS: usize = 4000;

/// The outcome of drawing.
pub type Drawn = Result<(), PlotError>;
pub(super) type Page<'a> = DrawingArea<Canvas<'a>, Shift>;

impl From<DrawingAreaErrorKind<fmt::Error>> for PlotError {
    fn from(error: DrawingAreaErrorKind<fmt::Error>) -> Self {
        PlotError::Draw(error.to_string())
    }
}

/// A rectangle on the page, px from the upper left corner of the figure.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) right: f64,
    pub(super) bottom: f64,
}

impl Frame {
    /// A plot area by its upper left corner.
    pub(super) fn new((left, top): Point, (width, height): Point) -> Self {
        Self {
            left,
            top,
            right: left + width,
            bottom: top + height,
        }
    }

    /// The rectangle between two opposite corners.
    pub(super) fn between(a: Point, b: Point) -> Self {
        Self {
            left: a.0.min(b.0),
            top: a.1.min(b.1),
            right: a.0.max(b.0),
            bottom: a.1.max(b.1),
        }
    }

    pub(super) fn width(&self) -> f64 {
        self.right - self.left
    }

    pub(super) fn height(&self) -> f64 {
        self.bottom - self.top
    }

    /// Upper left and lower right.
    pub(super) fn corners(&self) -> [Point; 2] {
        [(self.left, self.top), (self.right, self.bottom)]
    }

    /// The point at fractions of width (from the left) and height (from below).
    pub(super) fn at(&self, fx: f64, fy: f64) -> Point {
        (
            self.left + fx * self.width(),
            self.bottom - fy * self.height(),
        )
    }
}

/// Draws on the page, in px.
pub(super) struct Sheet<'p, 'a> {
    pub(super) page: &'p Page<'a>,
}

impl Sheet<'_, '_> {
    pub(super) fn draw(&self, points: &[Point], ink: Ink) -> Drawn {
        let points = points.iter().map(backend).collect();
        Ok(self.page.draw(&Element { points, ink })?)
    }

    pub(super) fn stroke(&self, points: &[Point], pen: &Pen) -> Drawn {
        self.draw(points, Ink::Line(*pen))
    }

    pub(super) fn words(&self, at: Point, words: Words) -> Drawn {
        self.draw(&[at], Ink::Words(words))
    }

    pub(super) fn fill(&self, points: &[Point], color: Color) -> Drawn {
        self.draw(points, Ink::Polygon(color))
    }

    pub(super) fn rect(&self, frame: &Frame, color: Color) -> Drawn {
        self.draw(&frame.corners(), Ink::Rectangle(color))
    }

    pub(super) fn outline(&self, frame: &Frame, pen: &Pen) -> Drawn {
        let [(left, top), (right, bottom)] = frame.corners();
        let around = [(left, top), (right, top), (right, bottom), (left, bottom)];
        // The first side is repeated, so that the start of the outline also has a joint.
        self.stroke(&[&around[..], &around[..2]].concat(), pen)
    }
}

/// Draws in the data coordinates of a panel.
pub struct Plot<'p, 'a> {
    pub(super) sheet: Sheet<'p, 'a>,
    pub(super) frame: Frame,
    pub(super) bounds: Bounds,
    data: DrawingArea<Canvas<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>,
}

impl<'p, 'a> Plot<'p, 'a> {
    pub(super) fn new(page: &'p Page<'a>, frame: Frame, x: &Axis, y: &Axis) -> Self {
        let mapping = Cartesian2d::new(
            x.min..x.max,
            y.min..y.max,
            (
                units(frame.left)..units(frame.right),
                units(frame.bottom)..units(frame.top),
            ),
        );
        Self {
            sheet: Sheet { page },
            frame,
            bounds: Bounds {
                x: (x.min, x.max),
                y: (y.min, y.max),
            },
            data: page.apply_coord_spec(mapping),
        }
    }

    /// px per data unit.
    fn scale(&self) -> Point {
        (
            self.frame.width() / (self.bounds.x.1 - self.bounds.x.0),
            self.frame.height() / (self.bounds.y.1 - self.bounds.y.0),
        )
    }

    /// Position of a data point on the page, px.
    pub(super) fn px(&self, p: Point) -> Point {
        let (sx, sy) = self.scale();
        (
            self.frame.left + (p.0 - self.bounds.x.0) * sx,
            self.frame.bottom - (p.1 - self.bounds.y.0) * sy,
        )
    }

    /// A polyline in data units, cut at the frame.
    pub(super) fn stroke(&self, points: &[Point], pen: &Pen) -> Drawn {
        let mut pieces = polyline::clip_line(points, &self.bounds);
        let mut pen = *pen;
        if points.len() > MOST_POINTS {
            let size = (self.frame.width(), self.frame.height());
            let mut trace = Trace::new(size, pen.width, MOST_POINTS);
            for piece in pieces {
                piece.into_iter().for_each(|point| trace.push(point));
                trace.lift();
            }
            pieces = polyline::clip_line(&trace.points(), &self.bounds);
            // A thinned line ends in the middle of others: a round end is a corner there.
            pen.is_round = true;
        }
        let thin = |piece: &Vec<Point>| polyline::simplify(piece, self.scale(), INVISIBLE);
        let mut pieces: Vec<Vec<Point>> = pieces.iter().map(thin).collect();
        if pieces.len() > MOST_ELEMENTS {
            let lengths = pieces.iter().map(Vec::len).collect();
            let (points, ink) = (pieces.concat(), Ink::Lines(pen, lengths));
            return Ok(self.data.draw(&Element { points, ink })?);
        }
        pieces.drain(..).try_for_each(|points| {
            let ink = Ink::Line(pen);
            Ok(self.data.draw(&Element { points, ink })?)
        })
    }

    /// A filled polygon in data units, cut at the frame.
    pub(super) fn fill(&self, points: &[Point], color: Color) -> Drawn {
        let cut = polyline::clip_area(points, &self.bounds);
        let (points, ink) = (
            polyline::simplify(&cut, self.scale(), INVISIBLE),
            Ink::Polygon(color),
        );
        Ok(self.data.draw(&Element { points, ink })?)
    }

    /// Markers at those of the data points that lie inside the frame.
    pub(super) fn symbols(&self, points: &[Point], symbol: &Symbol) -> Drawn {
        let inside = points.iter().filter(|at| self.bounds.contains(**at));
        let (mut points, ink): (Vec<Point>, _) = (inside.copied().collect(), Ink::Symbol(*symbol));
        let mut cell = 0.125;
        while points.len() > MOST_MARKERS {
            cell *= 2.0;
            let mut taken = HashSet::new();
            points.retain(|&at| {
                let (x, y) = self.px(at);
                taken.insert(((x / cell) as i64, (y / cell) as i64))
            });
        }
        Ok(self.data.draw(&Element { points, ink })?)
    }
}

fn backend(p: &Point) -> (i32, i32) {
    (units(p.0), units(p.1))
}
