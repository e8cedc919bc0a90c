//! The area between two curves.

use super::Layer;
use crate::color::{Color, LIGHT_GREY};
use crate::legend::{Entry, Key};
use crate::plot::{Drawn, Plot};

/// A filled area, such as a stick zone whose ends oscillate.
#[derive(Clone, Debug)]
pub struct Region {
    outline: Vec<(f64, f64)>,
    fill: Color,
    legend: Option<String>,
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
            legend: None,
        }
    }

    /// Colour.
    pub fn fill(mut self, color: Color) -> Self {
        self.fill = color;
        self
    }

    /// Text in the legend, in markup.
    pub fn legend(mut self, text: &str) -> Self {
        self.legend = Some(text.to_owned());
        self
    }
}

impl Layer for Region {
    fn draw(&self, plot: &Plot<'_, '_>) -> Drawn {
        plot.fill(&self.outline, self.fill)
    }

    fn legend(&self) -> Option<Entry> {
        self.legend
            .as_ref()
            .map(|text| Entry::new(text, Key::Area(self.fill)))
    }
}
