//! Comparisons that a series relies on, and where they come out otherwise.

use super::TaylorStepper;
use crate::error::{Error, Point};
use crate::filippov::event::Event;
use crate::filippov::flow::Flow;
use crate::filippov::options::Options;
use crate::filippov::pile_up::Burst;
use crate::filippov::uncertainty::uncertainty;
use crate::ode::{Timed, power_series};
use crate::system::State;
use crate::taylor::roots::first_zero;

/// By how much of its size a field jumps at least that turns round: what is continuous and zero to
/// rounding does not.
const TURN: f64 = 1e-3;

/// Where in a step two that are compared are equal, by parts of it.
#[derive(Clone, Copy)]
pub(super) struct Kink {
    /// Up to there the series holds: a little before, or a little behind where the two are equal
    /// from the start.
    pub(super) before: f64,
    /// A little behind: there the next one sees how they come out.
    pub(super) behind: f64,
}

impl<const N: usize, const G: usize> TaylorStepper<N, G> {
    /// The first comparison in the step that the series relies on and that comes out otherwise
    /// behind. And whether two are equal at the start and come out otherwise behind it.
    pub(super) fn first_kink(&self) -> (Option<Kink>, bool) {
        let piece = &self.piece;
        let (mut first, mut is_tie): (Option<Kink>, _) = (None, false);
        for c in &self.choices {
            let c = &c[..=piece.order];
            // Two that are equal throughout come out the same throughout.
            let Some(start) = c.iter().position(|&c| c != 0.0) else {
                continue;
            };
            let c_left = &c[start..];
            let s = if c_left[0] <= 0.0 {
                0.0
            } else {
                match first_zero(c_left) {
                    Some(s) => s,
                    None => continue,
                }
            };
            let size: f64 = c.iter().map(|c| c.abs()).sum();
            let mut behind = s;
            // At least something, where the step begins at time zero.
            let mut more = 4.0 * f64::EPSILON * (s + (piece.t / piece.h).abs()).max(1.0);
            if s == 0.0 {
                is_tie = true;
                more = more.max(self.past_tie / piece.h);
            }
            while behind < 1.0 && power_series(c, behind).0 >= -8.0 * f64::EPSILON * size {
                behind = s + more;
                more *= 2.0;
            }
            if behind < first.map_or(1.0, |first| first.behind) {
                let before = if s == 0.0 {
                    behind
                } else {
                    f64::max(0.0, s - (behind - s))
                };
                first = Some(Kink { before, behind });
            }
        }
        (first, is_tie)
    }
}

/// The event of a guard that lies below zero at `at`, behind a kink: it has jumped there.
#[cold]
pub(super) fn jumped<F: Flow<N>, const N: usize>(
    flow: &F,
    at: &Timed<N>,
    options: &Options,
) -> Option<Event<N>> {
    F::GUARDS.iter().find_map(|&guard| {
        let value: f64 = flow.guard_at(guard, at.t, &at.x);
        let blur = uncertainty(flow, guard, at, &options.tolerance());
        (-value > blur.by_tolerance + blur.by_rounding).then(|| Event {
            guard,
            at: *at,
            is_touch: false,
            residual: -value,
        })
    })
}

/// Counts a step to `at` that has ended where a comparison comes out otherwise, if the field turns
/// round there: the series' slope there and the one behind tell. It is a transition at a boundary
/// that the solver is not told of, and piles up as others do.
#[cold]
pub(super) fn note_turn<const N: usize>(
    turns: &mut Burst,
    at: &Timed<N>,
    [before, behind]: [&State<N>; 2],
    options: &Options,
) -> Result<(), Error> {
    let size = f64::max(before.amax(), behind.amax());
    let turns_round =
        |i: usize| before[i] * behind[i] < 0.0 && (before[i] - behind[i]).abs() > TURN * size;
    if !(0..N).any(turns_round) {
        return Ok(());
    }
    let (count, span) = turns.note(at.t, options);
    if count < options.pile_up_count {
        return Ok(());
    }
    Err(Error::BranchPileUp {
        count,
        span,
        t: at.t,
        x: Point::from(&at.x),
    })
}
