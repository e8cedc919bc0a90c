//! Comparisons that a series depends on, and where their results change.

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

/// Smallest jump of a field that counts as a reversal, relative to its size. A continuous field
/// that is zero to rounding stays below it.
const TURN: f64 = 1e-3;

/// Where two compared numbers are equal (fractions of the step).
#[derive(Clone, Copy)]
pub(super) struct Kink {
    /// The series holds up to here: slightly before the equality, or slightly behind it if the
    /// numbers are equal from the start.
    pub(super) before: f64,
    /// Slightly behind the equality, where the next series sees the new result.
    pub(super) behind: f64,
}

impl<const N: usize, const G: usize> TaylorStepper<N, G> {
    /// The first change of a comparison in the step that the series depends on. Also returns
    /// whether two compared numbers are equal at the start and the result changes behind it.
    pub(super) fn first_kink(&self) -> (Option<Kink>, bool) {
        let piece = &self.piece;
        let (mut first, mut is_tie): (Option<Kink>, _) = (None, false);
        for c in &self.choices {
            let c = &c[..=piece.order];
            // Numbers that are equal throughout give the same result throughout.
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
            // The margin must be positive even if the step begins at time zero.
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

/// The event of a guard that is negative at `at`, behind a kink: it has jumped there.
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

/// Counts a step that ends at `at` because a comparison changes, if the field reverses there. The
/// slope of the series before and the field behind show this. Such a reversal is a transition at an
/// undeclared boundary, and it can pile up as others do.
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
