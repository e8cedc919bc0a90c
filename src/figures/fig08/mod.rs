//! Fig. 8: the stick–slip trajectory as the listing prints it, and what the stated model does.

mod compute;
mod draw;
mod numbers;

pub use compute::{AsPrinted, Data, Exact, FOLLOWED, REACH, Shares};

use super::FigureError;
use super::FigureSpec;
use super::rows::Row;

/// Fig. 8.
#[derive(Debug)]
pub struct Fig08;

impl FigureSpec for Fig08 {
    const NAME: &'static str = "fig08";
    const TITLE: &'static str =
        "Stick–slip of the forced oscillator: as printed, and exact (Fig. 8)";
    const ABOUT: &'static str = "Left: the Appendix's listing run as printed, at its own step: its settled trajectory with its stick phases and \
        deflections. Right: the stated model, Eq. (17), with the same parameters, solved accurately, from the listing's \
        start. Below each, position against time with the oscillating stick zones. Numbers: stick lengths and durations as printed and for the listing's limit (slip three times \
        too fast, exit tested at one end), the exact orbit's crossings and slip durations, and where a grid of \
        starts ends up.";
    type Data = Data;

    fn compute() -> Result<Data, FigureError> {
        compute::compute()
    }

    fn numbers(data: &Data) -> Vec<Row> {
        numbers::numbers(data)
    }

    fn draw(data: &Data) -> Result<String, FigureError> {
        draw::draw(data)
    }
}
