//! Fig. 4: orbits of model 1 and the limit cycle they settle on.

mod compute;
mod draw;
mod numbers;

use super::FigureSpec;
use compute::compute;
pub use compute::{Cycle, Data};
use draw::draw;
#[cfg(feature = "report")]
pub(crate) use numbers::kind;
use numbers::numbers;

/// Fig. 4.
pub const FIG04: FigureSpec<Data> = FigureSpec {
    name: "fig04",
    title: "Orbits of the belt oscillator and its limit cycle (Fig. 4)",
    about: "Panel (a): phase plane of model 1, Eq. (3), for mu0 = 1/(3√3) and vp = 1: orbits from \
        the six tangent points and two further starts, the limit cycle, stick zones as grey bars, tangent points \
        numbered, visible ones filled. Panel (b): the kink where the cycle crosses the belt's speed near \
        the third tangent point. Numbers: tangent points and their kinds, the cycle's crossings, period, Floquet \
        multiplier and number of stick phases.",
    compute,
    numbers,
    draw,
};
