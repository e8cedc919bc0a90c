//! Shared by Figs. 10, 11 and 12: the block and the bracket with the parameters of one caption. The
//! figures show its exponents from the equations and from data, and the class of its motion.

mod compute;
mod draw;
mod error_bars;
mod numbers;
mod recorder;

pub(crate) use compute::DIVERGED;
#[cfg(test)]
pub(crate) use compute::best_common_settings;
pub use compute::{
    AsPrintedOutcome, BoundedMotion, Data, FigureSet, SETS, TOLERANCE, by_rk4_and_henon, class,
};

use super::FigureSpec;
use compute::compute;
use draw::draw;
use numbers::numbers;
pub use numbers::{DIVERGES, ExponentComparison, compare};
pub(crate) use recorder::{DT, START};

/// A figure with its description: the set of parameters, and the class that the paper publishes.
macro_rules! figure {
    ($index:literal, $title:literal, $set:literal, $published:literal) => {
        FigureSpec {
            name: SETS[$index].figure.name(),
            title: $title,
            about: concat!(
                "Panels (a), (b): phase planes of model 3, Eq. (27)-(28), for the ",
                $set,
                " set of parameters, published as ",
                $published,
                ", with the signs that Newton demands and a normal force that cannot pull; the end \
                 of the run. Panel (c): the running exponents over that time, from the equations \
                 and from the sampled states, and error bars: statistical, by the rounding of the \
                 captions, by step and tolerance, by unstated settings. Table: published exponents \
                 against both; biased: identified by the data, but further from the equations than \
                 three standard errors and the change with doubled neighbourhoods. Numbers: \
                 exponents, class of the motion with its evidence, stick, normal force; and when \
                 the equations as printed diverge."
            ),
            compute: || compute(&SETS[$index]),
            numbers,
            draw,
        }
    };
}

/// Fig. 10.
pub const FIG10: FigureSpec<Data> = figure!(
    0,
    "Periodic motion of the block and the bracket (Fig. 10)",
    "first",
    "two-periodic"
);
/// Fig. 11.
pub const FIG11: FigureSpec<Data> = figure!(
    1,
    "Quasi-periodic motion of the block and the bracket (Fig. 11)",
    "second",
    "quasi-periodic"
);
/// Fig. 12.
pub const FIG12: FigureSpec<Data> = figure!(
    2,
    "Chaotic motion of the block and the bracket (Fig. 12)",
    "third",
    "chaotic"
);
