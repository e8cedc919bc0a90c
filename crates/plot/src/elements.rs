//! The elements plotters lacks: dashed lines, markers with an edge, text with markup.

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

/// A marked-up text and how it is set.
#[derive(Clone)]
pub(super) struct Words {
    pub(super) markup: String,
    pub(super) size: f64,
    pub(super) color: Color,
    pub(super) h: HPos,
    pub(super) v: VPos,
    pub(super) upwards: bool,
    pub(super) halo: bool,
}

impl Words {
    /// Black, reading from left to right, its lower left corner at the point it is drawn at.
    pub(super) fn new(markup: &str, size: f64) -> Self {
        Self {
            markup: markup.to_owned(),
            size,
            color: BLACK,
            h: HPos::Left,
            v: VPos::Bottom,
            upwards: false,
            halo: false,
        }
    }

    pub(super) fn color(mut self, color: Color) -> Self {
        self.color = color;
        self
    }

    /// Which point of the text's box is put at the point it is drawn at.
    pub(super) fn anchor(mut self, h: HPos, v: VPos) -> Self {
        self.h = h;
        self.v = v;
        self
    }

    /// Turned by 90°, to be read from below.
    pub(super) fn upwards(mut self) -> Self {
        self.upwards = true;
        self
    }

    /// With a white rim, so that it can be read across lines.
    pub(super) fn halo(mut self) -> Self {
        self.halo = true;
        self
    }
}

/// A polyline in the coordinates of the area it is drawn on.
pub(super) struct Stroke<C> {
    pub(super) points: Vec<C>,
    pub(super) pen: Pen,
}

/// A marker at a point.
pub(super) struct Mark<C> {
    pub(super) at: C,
    pub(super) symbol: Symbol,
}

/// Rectangles that make one area; upper left and lower right corners in turn.
pub(super) struct Tiles<C> {
    pub(super) corners: Vec<C>,
    pub(super) color: Color,
}

/// A text at a point.
pub(super) struct Label<C> {
    pub(super) at: C,
    pub(super) words: Words,
}

impl<'a, C> PointCollection<'a, C> for &'a Stroke<C> {
    type Point = &'a C;
    type IntoIter = &'a [C];
    fn point_iter(self) -> Self::IntoIter {
        &self.points
    }
}

impl<'a, C> PointCollection<'a, C> for &'a Tiles<C> {
    type Point = &'a C;
    type IntoIter = &'a [C];
    fn point_iter(self) -> Self::IntoIter {
        &self.corners
    }
}

impl<'a, C> PointCollection<'a, C> for &'a Mark<C> {
    type Point = &'a C;
    type IntoIter = std::iter::Once<&'a C>;
    fn point_iter(self) -> Self::IntoIter {
        std::iter::once(&self.at)
    }
}

impl<'a, C> PointCollection<'a, C> for &'a Label<C> {
    type Point = &'a C;
    type IntoIter = std::iter::Once<&'a C>;
    fn point_iter(self) -> Self::IntoIter {
        std::iter::once(&self.at)
    }
}

impl<C> Drawable<Canvas<'_>> for Stroke<C> {
    fn draw<I: Iterator<Item = BackendCoord>>(
        &self,
        points: I,
        canvas: &mut Canvas<'_>,
        _: (u32, u32),
    ) -> Drawn {
        let points: Vec<BackendCoord> = points.collect();
        drawn(canvas.stroke(&points, &self.pen))
    }
}

impl<C> Drawable<Canvas<'_>> for Tiles<C> {
    fn draw<I: Iterator<Item = BackendCoord>>(
        &self,
        points: I,
        canvas: &mut Canvas<'_>,
        _: (u32, u32),
    ) -> Drawn {
        let points: Vec<BackendCoord> = points.collect();
        drawn(canvas.tiles(&points, self.color))
    }
}

impl<C> Drawable<Canvas<'_>> for Mark<C> {
    fn draw<I: Iterator<Item = BackendCoord>>(
        &self,
        points: I,
        canvas: &mut Canvas<'_>,
        _: (u32, u32),
    ) -> Drawn {
        for at in points {
            drawn(canvas.symbol(at, &self.symbol))?;
        }
        Ok(())
    }
}

impl<C> Drawable<Canvas<'_>> for Label<C> {
    fn draw<I: Iterator<Item = BackendCoord>>(
        &self,
        points: I,
        canvas: &mut Canvas<'_>,
        _: (u32, u32),
    ) -> Drawn {
        for at in points {
            drawn(canvas.words(at, &self.words))?;
        }
        Ok(())
    }
}
