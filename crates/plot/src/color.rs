//! The palette: the eight colours of Okabe and Ito, which readers with any colour vision can
//! distinguish, and greys.

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
/// A second shading, which differs from [`LIGHT_GREY`] in hue and lightness.
pub const LIGHT_ORANGE: Color = Color(252, 232, 196);

impl Color {
    /// The colour as `#rrggbb`, for SVG.
    pub(super) fn hex(self) -> String {
        format!("#{:02x}{:02x}{:02x}", self.0, self.1, self.2)
    }

    /// Two fifths of the colour on white, for a broad curve under others.
    pub fn pale(self) -> Self {
        let mixed = |part: u8| (255 - (255 - u16::from(part)) * 2 / 5) as u8;
        Self(mixed(self.0), mixed(self.1), mixed(self.2))
    }
}
