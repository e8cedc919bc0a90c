//! Fig. 7: the transition function `σ`, its oscillating zeros, and their bifurcation with `μ₀`.

mod compute;
mod draw;
mod numbers;

use super::FigureSpec;
use compute::compute;
pub use compute::{Branches, Data, Oscillation, Transition};
use draw::draw;
use numbers::numbers;

/// Fig. 7.
pub const FIG07: FigureSpec<Data> = FigureSpec {
    name: "fig07",
    title: "Fig. 7: tangent points, their oscillation and bifurcation",
    about: "Draws (a) the transition function sigma(z) of Eq. (19) for mu0 = 0 and \
        mu0 = 2 sqrt(3)/9, (b) the six tangent points z_k + A sin(omega t) over two forcing periods with the \
        parameters of Fig. 8, (c) the tangent points against mu0 from 0 to 4 sqrt(3)/9. Reports the critical \
        points of Eq. (22) and the critical friction of Eq. (23) for k1 = 3, k2 = 12, found by a root search and held \
        against the printed formulas.",
    compute,
    numbers,
    draw,
};
