//! A small panel inside a panel.

use super::Layer;
use crate::color::WHITE;
use crate::panel::Panel;
use crate::plot::{Drawn, Frame, Plot};

/// A panel drawn over a part of another, on white, such as an enlarged detail.
pub struct Inset {
    from: (f64, f64),
    to: (f64, f64),
    panel: Panel,
}

impl Inset {
    /// `panel`, including its labels, between two corners in fractions of the outer plot rectangle,
    /// from (0, 0) lower left to (1, 1) upper right.
    pub fn new(from: (f64, f64), to: (f64, f64), panel: Panel) -> Self {
        Self { from, to, panel }
    }
}

impl Layer for Inset {
    fn draw(&self, _: &Plot<'_, '_>) -> Drawn {
        Ok(())
    }

    /// The inset is drawn with the texts, so that no curve of the outer panel covers it.
    fn annotate(&self, plot: &Plot<'_, '_>) -> Drawn {
        let cell = Frame::between(
            plot.frame.at(self.from.0, self.from.1),
            plot.frame.at(self.to.0, self.to.1),
        );
        plot.sheet.rect(&cell, WHITE)?;
        let margins = self.panel.margins(cell.width())?;
        self.panel.draw(plot.sheet.page, &cell, &margins)
    }
}
