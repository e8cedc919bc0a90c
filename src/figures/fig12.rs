//! Fig. 12: the block and the bracket, third set of parameters, published as chaotic.

use super::block_and_bracket::{BlockAndBracketFigure, Set};
use crate::paper::claim_id::SpectrumFigure;
use stickslip::models::Caption;

/// Fig. 12.
#[derive(Debug)]
pub struct Fig12;

impl BlockAndBracketFigure for Fig12 {
    const SET: Set = Set {
        figure: SpectrumFigure::Fig12,
        caption: Caption::FIG12,
        shown: 300.0,
        title: "Fig. 12: chaotic motion of the block and the bracket",
        description: "The block's and the bracket's phase planes with the line of belt speed and the region without contact, and below them the running exponents beside the published ones.",
    };
    const TITLE: &'static str = "Chaotic motion of the block and the bracket (Fig. 12)";
    const ABOUT: &'static str = "Panels (a), (b): phase planes of model 3, Eq. (27)-(28), for the third set of \
        parameters, published as chaotic, with the signs that Newton demands and a normal force that cannot pull; \
        the end of the run. Panel (c): the running exponents over that time, from the equations and from the sampled \
        states. Table: published exponents against both; biased: identified by the data, and yet off the equations \
        by more than three standard errors and twice the neighbourhoods explain. Numbers: exponents, class of the \
        motion with its evidence, stick, normal force; and when the equations as printed diverge.";
}
