//! Figures for a journal, drawn with plotters. No other crate depends on plotters, and this one
//! does not depend on what the figures show.
//!
//! A [`Figure`] is rows of [`Panel`]s. A panel has two [`Axis`]es and layers: [`Curve`],
//! [`Markers`], [`Guide`], [`Band`], [`Region`], [`Cells`], [`Note`], [`Dimension`], [`Inset`].
//! Sizes, widths and offsets are in px at the figure's nominal size. One px is 1/96 inch, and
//! 658 px are a journal's text width. Offsets are `(right, up)`. Everything else is in the data's
//! units. A [`Trace`] keeps what a picture shows of a curve that is too long to keep.
//!
//! Texts are written in a small markup. `*x*_1` sets an italic x with the subscript 1, `_{…}` and
//! `^{…}` put groups below and above the line, `**…**` is bold. A backslash takes the next
//! character literally. Greek letters and signs are typed as they are.
//!
//! ```
//! use plot::*;
//!
//! let mut panel = Panel::new(
//!     Axis::new("*z*, m", -1.5, 1.5).step(0.5),
//!     Axis::new("*σ*, m^2/s^4", -0.5, 1.0).step(0.5).minor(5),
//! )
//! .label("(a)")
//! .legend(Legend::UpperLeft);
//! panel.add(Band::x(-0.2, 0.2).legend("stick zone"));
//! panel.add(Guide::horizontal(0.0));
//! let curve = (0..=300).map(|i| f64::from(i) / 100.0 - 1.5).map(|z| (z, z * z - 0.04));
//! panel.add(Curve::new(curve).color(BLUE).dash(Dash::Dashed).legend("*μ*_0 = 0.2"));
//! panel.add(Markers::new([(-0.2, 0.0), (0.2, 0.0)]).open().label(0, "2", (-6.0, 6.0)));
//! panel.add(Note::new((0.8, -0.3), "tangent point").arrow((0.2, 0.0)));
//! panel.add(Dimension::new((-0.2, 0.6), (0.2, 0.6), "0.4 m"));
//! let description = "A parabola below zero between ±0.2.";
//! let svg = Figure::new("example", (400.0, 300.0), "A zone", description)
//!     .row(1.0, panel)
//!     .render()?;
//! # assert!(svg.starts_with("<svg"));
//! # Ok::<(), plot::PlotError>(())
//! ```

/// Methods that set a field each, for chains of calls.
macro_rules! setters {
    ($($(#[$doc:meta])* $name:ident: $type:ty => $($field:ident).+;)*) => {$(
        $(#[$doc])*
        pub fn $name(mut self, value: $type) -> Self {
            self.$($field).+ = value.into();
            self
        }
    )*};
}

mod arrow;
mod axis;
mod canvas;
mod color;
mod elements;
mod error;
mod figure;
mod layers;
mod legend;
mod marks;
mod math;
mod metrics;
mod panel;
mod pen;
mod plot;
mod polyline;
mod rich;
mod table;
mod trace;

pub use axis::{Axis, number};
pub use color::{
    BLACK, BLUE, Color, GREEN, GREY, LIGHT_GREY, LIGHT_ORANGE, MID_GREY, ORANGE, PURPLE, SKY,
    VERMILLION, WHITE,
};
pub use error::PlotError;
pub use figure::{Cell, Figure};
pub use layers::{Band, Cells, Curve, Dimension, Guide, Inset, Markers, Note, Position, Region};
pub use legend::Legend;
pub use marks::Shape;
pub use metrics::FACES;
pub use panel::{NumericCurve, Panel};
pub use pen::Dash;
pub use table::Table;
pub use trace::Trace;
