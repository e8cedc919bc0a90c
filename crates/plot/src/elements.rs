//! Elements that plotters lacks: dashed lines, markers with an edge, text with markup.

use plotters::element::{Drawable, PointCollection};
use plotters_backend::BackendCoord;
use plotters_backend::text_anchor::{HPos, VPos};

use super::canvas::{Canvas, Drawn, drawn};
use super::color::{BLACK, Color};
use super::pen::Pen;

/// Outline of a marker.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shape {
    /// ○
    #[default]
    Circle,
    /// □
    Square,
    /// ◇
    Diamond,
    /// △
    Up,
    /// ▽
    Down,
    /// ×
    Cross,
}

/// A marker: shape, size (px), colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Symbol {
    pub(super) shape: Shape,
    pub(super) size: f64,
    pub(super) fill: Color,
    pub(super) edge: Color,
    pub(super) edge_width: f64,
}

/// A marked-up text with its style.
#[derive(Clone)]
pub(super) struct Words {
    pub(super) markup: String,
    pub(super) size: f64,
    pub(super) color: Color,
    /// The point of the text's box that lies at the position of the text.
    pub(super) anchor: (HPos, VPos),
    /// Whether it is rotated by 90°, to be read upwards.
    pub(super) upwards: bool,
    /// Whether it has a white rim, so that it is legible on lines.
    pub(super) halo: bool,
}

impl Words {
    /// A black text from left to right.
    pub(super) fn new(markup: &str, size: f64, anchor: (HPos, VPos)) -> Self {
        Self {
            markup: markup.to_owned(),
            size,
            color: BLACK,
            anchor,
            upwards: false,
            halo: false,
        }
    }

    pub(super) fn halo(mut self) -> Self {
        self.halo = true;
        self
    }
}

/// The form in which points are drawn.
#[derive(Clone)]
pub(super) enum Ink {
    /// A polyline through them.
    Line(Pen),
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
            Ink::Line(pen) => canvas.stroke(&points, pen),
            Ink::Area(color) => canvas.tiles(&points, *color),
            Ink::Polygon(color) => canvas.polygon(&points, *color),
            Ink::Rectangle(color) => canvas.rect(&points, *color),
            Ink::Symbol(symbol) => points.iter().try_for_each(|at| canvas.symbol(*at, symbol)),
            Ink::Words(words) => points.iter().try_for_each(|at| canvas.words(*at, words)),
        })
    }
}
