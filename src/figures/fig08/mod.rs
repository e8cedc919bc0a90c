//! Fig. 8: the stick–slip trajectory as the listing prints it, and what the stated model does.

mod compute;
mod draw;
mod numbers;

use super::FigureSpec;
use compute::compute;
#[cfg(feature = "report")]
pub(crate) use compute::starts;
pub use compute::{AsPrinted, Data, Exact, FOLLOWED, REACH, Shares};
use draw::draw;
use numbers::numbers;

/// Fig. 8.
pub const FIG08: FigureSpec<Data> = FigureSpec {
    name: "fig08",
    title: "Stick–slip of the forced oscillator: as printed, and exact (Fig. 8)",
    about: "Left: the Appendix's listing run as printed, at its own step: its settled trajectory with its stick phases and \
        deflections. Right: the stated model, Eq. (17), with the same parameters, solved accurately, from the listing's \
        start. Below each, position against time with the oscillating stick zones. Numbers: stick lengths and durations as printed and for the listing's limit (slip three times \
        too fast, exit tested at one end), the exact orbit's crossings and slip durations, and where a grid of \
        starts ends up.",
    compute,
    numbers,
    draw,
};
