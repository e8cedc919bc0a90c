//! Fig. 11: the block and the bracket, second set of parameters, published as quasi-periodic.

use super::block_and_bracket::{BlockAndBracketFigure, Set};
use stickslip::models::Caption;

/// Fig. 11.
#[derive(Debug)]
pub struct Fig11;

impl BlockAndBracketFigure for Fig11 {
    const SET: Set = Set {
        figure: "fig11",
        caption: Caption::FIG11,
        shown: 300.0,
        title: "Fig. 11: quasi-periodic motion of the block and the bracket",
        description: "The block's and the bracket's phase planes each show a band that the orbit fills without closing. \
            Below, the running exponents: two tend to zero, the third to a small negative value, the fourth is \
            minus infinity.",
    };
    const TITLE: &'static str = "Quasi-periodic motion of the block and the bracket (Fig. 11)";
    const ABOUT: &'static str = "Panels (a), (b): phase planes of model 3, Eq. (27)-(28), for the second set of parameters, published \
        as quasi-periodic, with the signs that Newton demands and a normal force that cannot pull; the last \
        300 time units of t = 3000 ... 12000. Panel (c): the running exponents over that time, from the \
        equations and from 45001 states sampled every 0.2. Table: published exponents against both. Numbers: \
        exponents, class of the motion with its evidence, stick, normal force; and when the equations as \
        printed diverge.";
}
