//! Elements that plotters lacks: dashed lines, markers with an edge, text with markup.

use plotters::element::{Drawable, PointCollection};
use plotters_backend::BackendCoord;

use super::canvas::{Canvas, Drawn, drawn};
use super::color::Color;
use super::marks::{Symbol, Words};
use super::pen::Pen;

/// Marks at points.
#[derive(Clone)]
pub(super) enum Ink {
    /// A polyline through them.
    Line(Pen),
    /// Several polylines, with the number of points of each.
    Lines(Pen, Vec<usize>),
    /// Rectangles that make one area; upper left and lower right corners in turn.
    Area(Color),
    /// A filled polygon with these corners.
    Polygon(Color),
    /// A filled rectangle between two corners, upper left and lower right.
    Rectangle(Color),
    /// A marker at each.
    Symbol(Symbol),
    /// A text at each.
    Words(Words),
}

/// A drawing, in the coordinates of its drawing area.
pub(super) struct Element<C> {
    pub(super) points: Vec<C>,
    pub(super) ink: Ink,
}

impl<'a, C> PointCollection<'a, C> for &'a Element<C> {
    type Point = &'a C;
    type IntoIter = &'a [C];
    fn point_iter(self) -> Self::IntoIter {
        &self.points
    }
}

impl<C> Drawable<Canvas<'_>> for Element<C> {
    fn draw<I: Iterator<Item = BackendCoord>>(
        &self,
        points: I,
        canvas: &mut Canvas<'_>,
        _: (u32, u32),
    ) -> Drawn {
        let points: Vec<BackendCoord> = points.collect();
        drawn(match &self.ink {
            Ink::Line(pen) => canvas.stroke(&points, &[points.len()], pen),
            Ink::Lines(pen, lengths) => canvas.stroke(&points, lengths, pen),
            Ink::Area(color) => canvas.tiles(&points, *color),
            Ink::Polygon(color) => canvas.polygon(&points, *color),
            Ink::Rectangle(color) => canvas.rect(&points, *color),
            Ink::Symbol(symbol) => points.iter().try_for_each(|at| canvas.symbol(*at, symbol)),
            Ink::Words(words) => points.iter().try_for_each(|at| canvas.words(*at, words)),
        })
    }
}
