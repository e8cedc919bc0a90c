//! Fig. 10: the block and the bracket, first set of parameters, published as two-periodic.

use super::block_and_bracket::{BlockAndBracketFigure, Set};
use stickslip::models::Caption;

/// Fig. 10.
#[derive(Debug)]
pub struct Fig10;

impl BlockAndBracketFigure for Fig10 {
    const SET: Set = Set {
        figure: "fig10",
        caption: Caption::FIG10,
        shown: 40.0,
        title: "Fig. 10: periodic motion of the block and the bracket",
        description: "The block's and the bracket's phase planes each show one closed loop; the block's has a kink where \
            it touches the line of belt speed. Below, the running exponents: one tends to zero, two fall to the \
            same small negative value, the fourth is minus infinity.",
    };
    const TITLE: &'static str = "Periodic motion of the block and the bracket (Fig. 10)";
    const ABOUT: &'static str = "Panels (a), (b): phase planes of model 3, Eq. (27)-(28), for the first set of parameters, published \
        as two-periodic, with the signs that Newton demands and a normal force that cannot pull; the last 40 \
        time units of t = 3000 ... 12000. Panel (c): the running exponents over that time, from the \
        equations and from 45001 states sampled every 0.2. Table: published exponents against both. Numbers: \
        exponents, class of the motion with its evidence, stick, normal force; and when the equations as \
        printed diverge.";
}
