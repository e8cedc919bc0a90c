//! Colours, lines, markers and texts: how things are drawn. The palette is Okabe and Ito's eight
//! colours, told apart by readers with any colour vision, and greys.

/// An opaque colour, red, green, blue in 0..=255.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Color(pub u8, pub u8, pub u8);

/// Text, axes, and the main curve.
pub const BLACK: Color = Color(0, 0, 0);
/// Paper.
pub const WHITE: Color = Color(255, 255, 255);
/// Okabe–Ito blue.
pub const BLUE: Color = Color(0, 114, 178);
/// Okabe–Ito vermillion.
pub const VERMILLION: Color = Color(213, 94, 0);
/// Okabe–Ito bluish green.
pub const GREEN: Color = Color(0, 158, 115);
/// Okabe–Ito reddish purple.
pub const PURPLE: Color = Color(204, 121, 167);
/// Okabe–Ito orange.
pub const ORANGE: Color = Color(230, 159, 0);
/// Okabe–Ito sky blue.
pub const SKY: Color = Color(86, 180, 233);
/// Guide lines and leader lines.
pub const GREY: Color = Color(115, 115, 115);
/// Bars that mark stick zones.
pub const MID_GREY: Color = Color(185, 185, 185);
/// Shading behind curves: stick zones and stick intervals.
pub const LIGHT_GREY: Color = Color(228, 228, 228);
/// A second shading, told from [`LIGHT_GREY`] by hue and lightness.
pub const LIGHT_ORANGE: Color = Color(252, 232, 196);
impl Color {
    /// `#rrggbb`, as SVG wants it.
    pub(super) fn hex(self) -> String {
        format!("#{:02x}{:02x}{:02x}", self.0, self.1, self.2)
    }

    /// The colour on white, two fifths of it: for a broad curve under others.
    pub fn pale(self) -> Self {
        let mixed = |part: u8| (255 - (255 - u16::from(part)) * 2 / 5) as u8;
        Self(mixed(self.0), mixed(self.1), mixed(self.2))
    }
}

/// Line style; told apart without colour.
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

/// Colour, width (px) and line style of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pen {
    /// Colour.
    pub color: Color,
    /// Width, px at the figure's nominal size.
    pub width: f64,
    /// Line style.
    pub dash: Dash,
}

impl Default for Pen {
    fn default() -> Self {
        Self {
            color: BLACK,
            width: 1.4,
            dash: Dash::Solid,
        }
    }
}

impl Pen {
    /// A solid pen.
    pub fn new(color: Color, width: f64) -> Self {
        Self {
            color,
            width,
            dash: Dash::Solid,
        }
    }

    /// The same pen with another line style.
    pub fn dash(mut self, dash: Dash) -> Self {
        self.dash = dash;
        self
    }

    /// Lengths of strokes and gaps, px; empty for a solid line. They grow with the width, so that a bold dotted
    /// line is still dotted.
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

/// Which point of a text's box, from left to right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum HPos {
    Left,
    Center,
    Right,
}

impl HPos {
    /// How far from the left, in parts of the width.
    pub(super) fn part(self) -> f64 {
        match self {
            HPos::Left => 0.0,
            HPos::Center => 0.5,
            HPos::Right => 1.0,
        }
    }
}

/// Which point of a text's box, from above.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum VPos {
    Top,
    Center,
    Bottom,
}

impl VPos {
    /// How far from above, in parts of the height.
    pub(super) fn part(self) -> f64 {
        match self {
            VPos::Top => 0.0,
            VPos::Center => 0.5,
            VPos::Bottom => 1.0,
        }
    }
}

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
