//! The figures as the ledger needs them: computed once, each with its table and its picture.

use super::remark::Sign;
use crate::figures::block_and_bracket::{self, Fig10, Fig11, Fig12};
use crate::figures::fig04::Data as Fig04Data;
use crate::figures::fig07::Data as Fig07Data;
use crate::figures::fig08::Data as Fig08Data;
use crate::figures::rows::Row;
use crate::figures::{
    FigureError, FigureSpec, fig04::Fig04, fig06::Fig06, fig07::Fig07, fig08::Fig08,
};

/// One figure's table.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Name of the figure.
    pub figure: &'static str,
    /// One line on what it shows.
    pub title: &'static str,
    /// What is drawn and which numbers are reported.
    pub about: &'static str,
    /// The picture.
    pub svg: String,
    /// Its rows.
    pub rows: Vec<Row>,
}

/// What the ledger needs of the figures.
pub struct Computed {
    /// All tables.
    pub tables: Vec<Table>,
    /// Fig. 4 in full.
    pub fig04: Fig04Data,
    /// Fig. 7 in full.
    pub fig07: Fig07Data,
    /// Fig. 8 in full.
    pub fig08: Fig08Data,
    /// Figs. 10, 11, 12 in full.
    pub bracket: [block_and_bracket::Data; 3],
}

/// Figures computed.
pub const FIGURES: usize = 7;

fn table<F: FigureSpec>(tick: &(dyn Fn() + Sync)) -> Result<(F::Data, Table), FigureError> {
    let data = F::compute()?;
    let table = Table {
        figure: F::NAME,
        title: F::TITLE,
        about: F::ABOUT,
        svg: F::draw(&data)?,
        rows: F::numbers(&data),
    };
    tick();
    Ok((data, table))
}

impl Computed {
    /// Computes all figures and calls `tick` after each.
    ///
    /// # Errors
    /// [`FigureError`] of the first that fails.
    pub fn compute(tick: &(dyn Fn() + Sync)) -> Result<Computed, FigureError> {
        let ((fig04, fig06), (fig07, fig08)) = rayon::join(
            || (table::<Fig04>(tick), table::<Fig06>(tick)),
            || (table::<Fig07>(tick), table::<Fig08>(tick)),
        );
        let (fig10, (fig11, fig12)) = rayon::join(
            || table::<Fig10>(tick),
            || rayon::join(|| table::<Fig11>(tick), || table::<Fig12>(tick)),
        );
        let ((fig04, fig06), (fig07, fig08)) = ((fig04?, fig06?), (fig07?, fig08?));
        let (fig10, fig11, fig12) = (fig10?, fig11?, fig12?);
        Ok(Computed {
            tables: vec![
                fig04.1, fig06.1, fig07.1, fig08.1, fig10.1, fig11.1, fig12.1,
            ],
            fig04: fig04.0,
            fig07: fig07.0,
            fig08: fig08.0,
            bracket: [fig10.0, fig11.0, fig12.0],
        })
    }
}

/// Signs of a spectrum's exponents from the equations, the largest first: what grows, what stays,
/// what shrinks.
pub fn signs(data: &block_and_bracket::Data) -> [Sign; 4] {
    let evidence = &data.exact.evidence;
    let grow = usize::from(evidence.positive);
    std::array::from_fn(|i| match i {
        _ if i < grow => Sign::Positive,
        _ if i < grow + evidence.zeros => Sign::Zero,
        _ => Sign::Negative,
    })
}
