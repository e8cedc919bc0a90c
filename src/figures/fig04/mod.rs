//! Fig. 4: orbits of model 1 and the limit cycle they settle on.

mod compute;
mod draw;
mod numbers;

pub use compute::{Cycle, Data, Tangent};

use super::FigureError;
use super::FigureSpec;
use super::rows::Row;

/// Fig. 4.
#[derive(Debug)]
pub struct Fig04;

impl FigureSpec for Fig04 {
    const NAME: &'static str = "fig04";
    const TITLE: &'static str = "Orbits of the belt oscillator and its limit cycle (Fig. 4)";
    const ABOUT: &'static str = "Panel (a): phase plane of model 1, Eq. (3), for mu0 = 1/(3√3) and vp = 1: orbits from \
        the six tangent points and two further starts, the limit cycle, stick zones as grey bars, tangent points \
        numbered, visible ones filled. Panel (b): the kink where the cycle crosses the belt's speed near \
        the third tangent point. Numbers: tangent points and their kinds, the cycle's crossings, period, Floquet \
        multiplier and number of stick phases.";
    type Data = Data;

    fn compute() -> Result<Data, FigureError> {
        compute::compute().map_err(Self::failed)
    }

    fn numbers(data: &Data) -> Vec<Row> {
        numbers::numbers(data)
    }

    fn draw(data: &Data) -> Result<String, FigureError> {
        draw::draw(data)
    }
}
