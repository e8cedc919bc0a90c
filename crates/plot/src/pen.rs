//! Pens: colour, width and style of lines.

use super::color::{BLACK, Color};

/// Line style, which distinguishes lines without colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Dash {
    /// ————
    #[default]
    Solid,
    /// – – –
    Dashed,
    /// · · ·
    Dotted,
    /// – · –
    DashDot,
}

/// Colour, width (px at the figure's nominal size) and line style of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pen {
    pub(super) color: Color,
    pub(super) width: f64,
    pub(super) dash: Dash,
    /// Whether lines have round ends, so that one without length is a dot.
    pub(super) is_round: bool,
}

impl Default for Pen {
    fn default() -> Self {
        Self::new(BLACK, 1.4)
    }
}

impl Pen {
    /// A solid pen.
    pub(super) fn new(color: Color, width: f64) -> Self {
        Self {
            color,
            width,
            dash: Dash::Solid,
            is_round: false,
        }
    }

    /// Lengths of strokes and gaps, px; empty for a solid line. They grow with the width, so that a
    /// bold dotted line is still dotted.
    pub(super) fn pattern(&self) -> Vec<f64> {
        let w = self.width.max(1.0);
        match self.dash {
            Dash::Solid => vec![],
            Dash::Dashed => vec![4.5 * w, 2.6 * w],
            Dash::Dotted => vec![1.1 * w, 1.7 * w],
            Dash::DashDot => vec![5.5 * w, 1.9 * w, 1.1 * w, 1.9 * w],
        }
    }
}
