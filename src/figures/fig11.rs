//! Fig. 11: the block and the bracket, second set of parameters, published as quasi-periodic.

use super::block_and_bracket::{Data, Set, compute, draw, numbers};
use super::error::FigureError;
use super::rows::Row;
use super::spec::FigureSpec;
use crate::models::Caption;

/// Fig. 11.
#[derive(Debug)]
pub struct Fig11;

const SET: Set = Set {
    figure: Fig11::NAME,
    caption: Caption::FIG11,
    shown: 300.0,
    title: "Fig. 11: quasi-periodic motion of the block and the bracket",
    description: "The block's and the bracket's phase planes each show a band that the orbit fills without closing. \
        Below, the running exponents: two tend to zero, the third to a small negative value, the fourth is \
        minus infinity.",
};

impl FigureSpec for Fig11 {
    const NAME: &'static str = "fig11";
    const TITLE: &'static str = "Quasi-periodic motion of the block and the bracket (Fig. 11)";
    const ABOUT: &'static str = "Panels (a), (b): phase planes of model 3, Eq. (27)-(28), for the second set of parameters, published \
        as quasi-periodic, with the signs that Newton demands and a normal force that cannot pull; the last \
        300 time units of t = 3000 ... 12000. Panel (c): the running exponents over that time, from the \
        equations and from 45001 states sampled every 0.2. Table: published exponents against both. Numbers: \
        exponents, class of the motion with its evidence, stick, normal force; and when the equations as \
        printed diverge.";
    type Data = Data;

    fn compute() -> Result<Data, FigureError> {
        compute(&SET)
    }

    fn numbers(data: &Data) -> Vec<Row> {
        numbers(&SET, data)
    }

    fn draw(data: &Data) -> Result<String, FigureError> {
        draw(&SET, data)
    }
}
