//! The area between two curves.

use super::Layer;
use crate::color::{Color, LIGHT_GREY};
use crate::elements::Ink;
use crate::legend::Entry;
use crate::plot::{Drawn, Plot};

/// A filled area, such as a stick zone whose ends oscillate.
#[derive(Clone, Debug)]
pub struct Region {
    outline: Vec<(f64, f64)>,
    fill: Color,
    legend: String,
}

impl Region {
    /// The area between two curves that run in the same direction.
    pub fn between(
        one: impl IntoIterator<Item = (f64, f64)>,
        other: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        let mut outline: Vec<(f64, f64)> = one.into_iter().collect();
        let mut back: Vec<(f64, f64)> = other.into_iter().collect();
        back.reverse();
        outline.append(&mut back);
        Self {
            outline,
            fill: LIGHT_GREY,
            legend: String::new(),
        }
    }

    setters! {
        /// Colour.
        fill: Color => fill;
        /// Text in the legend, in markup.
        legend: &str => legend;
    }
}

impl Layer for Region {
    fn draw(&self, plot: &Plot<'_, '_>) -> Drawn {
        plot.fill(&self.outline, self.fill)
    }

    fn legend(&self) -> Option<Entry> {
        Entry::new(&self.legend, Ink::Area(self.fill))
    }
}
