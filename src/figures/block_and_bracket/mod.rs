//! What Figs. 10, 11 and 12 share: the block and the bracket with the parameters of one caption, its exponents from the
//! equations and from data, and the class of its motion.

mod against_equations;
mod best_common;
mod compute;
mod draw;
mod figure;
mod numbers;
mod watch;

pub use against_equations::{Comparison, compare};
pub(crate) use best_common::best_common;
pub use compute::{Data, Literal, Measured, by_rk4_and_henon, compute};
pub use figure::BlockAndBracketFigure;

use draw::draw;
pub use numbers::DIVERGES;
use numbers::numbers;

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
    /// Title for readers who cannot see the picture.
    pub title: &'static str,
    /// What the picture shows, for them.
    pub description: &'static str,
}
