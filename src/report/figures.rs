//! The figures for the ledger: computed once, each with its table and its picture.

use super::exponent::Sign;
use crate::figures::block_and_bracket::{self, FIG10, FIG11, FIG12};
use crate::figures::fig04::{self, FIG04};
use crate::figures::fig06::FIG06;
use crate::figures::fig07::{self, FIG07};
use crate::figures::fig08::{self, FIG08};
use crate::figures::rows::Row;
use crate::figures::{FigureSpec, curves};
use crate::terminal::ProgramError;

/// A picture on the page, and the numbers behind it.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Name of the figure.
    pub figure: &'static str,
    /// One line on what it shows.
    pub title: &'static str,
    /// Description of the drawing and the reported numbers.
    pub about: &'static str,
    /// The picture.
    pub svg: String,
    /// The curves in it as CSV. Empty for the report's own pictures.
    pub curves: String,
    /// Rows. Empty for the report's own pictures, whose numbers are in the ledger.
    pub rows: Vec<Row>,
}

/// The figures' data for the ledger.
pub struct Computed {
    /// The paper's figures.
    pub pictures: Vec<Picture>,
    /// Fig. 4 in full.
    pub fig04: fig04::Data,
    /// Fig. 7 in full.
    pub fig07: fig07::Data,
    /// Fig. 8 in full.
    pub fig08: fig08::Data,
    /// Figs. 10, 11, 12 in full.
    pub bracket: [block_and_bracket::Data; 3],
}

/// Number of figures computed.
pub const FIGURES: usize = 7;

impl Picture {
    /// The picture of a figure.
    ///
    /// # Errors
    /// A failure to draw.
    pub fn of<D>(figure: &FigureSpec<D>, data: &D) -> Result<Picture, ProgramError> {
        let drawn = (figure.draw)(data)?;
        Ok(Picture {
            figure: figure.name,
            title: figure.title,
            about: figure.about,
            svg: drawn.render()?,
            curves: curves::table(&drawn),
            rows: (figure.numbers)(data),
        })
    }
}

/// Data and picture of a figure.
fn computed<D>(
    figure: &FigureSpec<D>,
    tick: &(dyn Fn() + Sync),
) -> Result<(D, Picture), ProgramError> {
    let data = figure.compute()?;
    let picture = Picture::of(figure, &data)?;
    tick();
    Ok((data, picture))
}

impl Computed {
    /// Computes all figures and calls `tick` after each.
    ///
    /// # Errors
    /// That of the first figure that fails.
    pub fn compute(tick: &(dyn Fn() + Sync)) -> Result<Computed, ProgramError> {
        let ((fig04, fig06), (fig07, fig08)) = rayon::join(
            || (computed(&FIG04, tick), computed(&FIG06, tick)),
            || (computed(&FIG07, tick), computed(&FIG08, tick)),
        );
        let (fig10, (fig11, fig12)) = rayon::join(
            || computed(&FIG10, tick),
            || rayon::join(|| computed(&FIG11, tick), || computed(&FIG12, tick)),
        );
        let ((fig04, fig06), (fig07, fig08)) = ((fig04?, fig06?), (fig07?, fig08?));
        let (fig10, fig11, fig12) = (fig10?, fig11?, fig12?);
        Ok(Computed {
            pictures: vec![
                fig04.1, fig06.1, fig07.1, fig08.1, fig10.1, fig11.1, fig12.1,
            ],
            fig04: fig04.0,
            fig07: fig07.0,
            fig08: fig08.0,
            bracket: [fig10.0, fig11.0, fig12.0],
        })
    }
}

/// Signs of a spectrum's exponents from the equations, the largest first.
pub fn signs(data: &block_and_bracket::Data) -> [Sign; 4] {
    let evidence = &data.exact.evidence;
    let grow = usize::from(evidence.positive);
    std::array::from_fn(|i| match i {
        _ if i < grow => Sign::Positive,
        _ if i < grow + evidence.zeros => Sign::Zero,
        _ => Sign::Negative,
    })
}
