//! Markers and texts, as they are drawn at points.

use plotters_backend::text_anchor::{HPos, VPos};

use super::color::{BLACK, Color};

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
