//! Fig. 12: the block and the bracket, third set of parameters, published as chaotic.

use super::block_and_bracket::{BlockAndBracketFigure, Set};
use stickslip::models::Caption;

/// Fig. 12.
#[derive(Debug)]
pub struct Fig12;

impl BlockAndBracketFigure for Fig12 {
    const SET: Set = Set {
        figure: "fig12",
        caption: Caption::FIG12,
        shown: 300.0,
        title: "Fig. 12: chaotic motion of the block and the bracket",
        description: "The block's and the bracket's phase planes show irregular loops; the bracket goes far into the \
            region where the contact is lost. Below, the running exponents: the first stays positive, the second \
            tends to zero, the third is negative, the fourth is minus infinity.",
    };
    const TITLE: &'static str = "Chaotic motion of the block and the bracket (Fig. 12)";
    const ABOUT: &'static str = "Panels (a), (b): phase planes of model 3, Eq. (27)-(28), for the third set of parameters, published \
        as chaotic, with the signs that Newton demands and a normal force that cannot pull; the last 300 \
        time units of t = 3000 ... 12000. Panel (c): the running exponents over that time, from the \
        equations and from 45001 states sampled every 0.2. Table: published exponents against both. Numbers: \
        exponents, class of the motion with its evidence, stick, normal force; and when the equations as \
        printed diverge.";
}
