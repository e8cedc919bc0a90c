//! What Figs. 10, 11 and 12 share: the block and the bracket with the parameters of one caption,
//! its exponents from the equations and from data, and the class of its motion.

mod against_equations;
mod compute;
mod draw;
mod numbers;
mod watch;

pub use against_equations::{Comparison, compare};
#[cfg(all(test, feature = "report"))]
pub(crate) use compute::best_common;
pub use compute::{Data, Literal, Measured, by_rk4_and_henon, compute};

use draw::draw;
pub use numbers::DIVERGES;
use numbers::numbers;

use super::FigureError;
use super::FigureSpec;
use super::rows::Row;
use crate::paper::claim_id::SpectrumFigure;
use stickslip::models::Caption;

/// What one of the three figures differs in.
#[derive(Clone, Copy, Debug)]
pub struct Set {
    /// Which of the three.
    pub figure: SpectrumFigure,
    /// Its parameters.
    pub caption: Caption,
    /// Length of the orbit drawn, at the end of the run.
    pub shown: f64,
    /// [`FigureSpec::TITLE`] and [`FigureSpec::ABOUT`].
    pub heading: &'static str,
    /// See `heading`.
    pub about: &'static str,
    /// Title for readers who cannot see the picture.
    pub title: &'static str,
    /// What the picture shows, for them.
    pub description: &'static str,
}

/// One of Figs. 10, 11 and 12.
pub trait BlockAndBracketFigure {
    /// What it differs in from the others.
    const SET: Set;
}

/// What is computed, in words: which set of parameters, and what the paper publishes it as.
macro_rules! about {
    ($set:literal, $published:literal) => {
        concat!(
            "Panels (a), (b): phase planes of model 3, Eq. (27)-(28), for the ",
            $set,
            " set of parameters, published as ",
            $published,
            ", with the signs that Newton demands and a normal force that cannot pull; the end of the run. Panel (c): the running \
             exponents over that time, from the equations and from the sampled states. Table: published exponents against both; biased: \
             identified by the data, and yet off the equations by more than three standard errors and twice the neighbourhoods explain. \
             Numbers: exponents, class of the motion with its evidence, stick, normal force; and when the equations as printed diverge."
        )
    };
}

/// Fig. 10.
#[derive(Debug)]
pub struct Fig10;

impl BlockAndBracketFigure for Fig10 {
    const SET: Set = Set {
        figure: SpectrumFigure::Fig10,
        caption: Caption::FIG10,
        shown: 40.0,
        heading: "Periodic motion of the block and the bracket (Fig. 10)",
        about: about!("first", "two-periodic"),
        title: "Fig. 10: periodic motion of the block and the bracket",
        description: "The block's and the bracket's phase planes with the line of belt speed, and below them the running exponents beside the published ones.",
    };
}

/// Fig. 11.
#[derive(Debug)]
pub struct Fig11;

impl BlockAndBracketFigure for Fig11 {
    const SET: Set = Set {
        figure: SpectrumFigure::Fig11,
        caption: Caption::FIG11,
        shown: 300.0,
        heading: "Quasi-periodic motion of the block and the bracket (Fig. 11)",
        about: about!("second", "quasi-periodic"),
        title: "Fig. 11: quasi-periodic motion of the block and the bracket",
        ..Fig10::SET
    };
}

/// Fig. 12.
#[derive(Debug)]
pub struct Fig12;

impl BlockAndBracketFigure for Fig12 {
    const SET: Set = Set {
        figure: SpectrumFigure::Fig12,
        caption: Caption::FIG12,
        shown: 300.0,
        heading: "Chaotic motion of the block and the bracket (Fig. 12)",
        about: about!("third", "chaotic"),
        title: "Fig. 12: chaotic motion of the block and the bracket",
        description: "The block's and the bracket's phase planes with the line of belt speed and the region without contact, and below them the running exponents beside the published ones.",
    };
}

impl<F: BlockAndBracketFigure> FigureSpec for F {
    const NAME: &'static str = F::SET.figure.name();
    const TITLE: &'static str = F::SET.heading;
    const ABOUT: &'static str = F::SET.about;
    type Data = Data;

    fn compute() -> Result<Data, FigureError> {
        compute(&F::SET)
    }

    fn numbers(data: &Data) -> Vec<Row> {
        numbers(&F::SET, data)
    }

    fn draw(data: &Data) -> Result<String, FigureError> {
        draw(&F::SET, data)
    }
}
