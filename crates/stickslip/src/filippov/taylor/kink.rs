//! Comparisons that a series depends on, and where their results change.

use super::TaylorStepper;
use crate::error::{Error, Point};
use crate::filippov::flow::Flow;
use crate::filippov::guard::Event;
use crate::filippov::options::Options;
use crate::filippov::pile_up::Burst;
use crate::filippov::uncertainty::uncertainty;
use crate::ode::{Timed, power_series};
use crate::system::State;
use crate::taylor::roots::first_zero;

/// Smallest jump of a field that counts as a reversal, relative to its size. Chosen far above the
/// rounding by which a continuous field changes its sign.
const REVERSAL: f64 = 1e-3;

/// Where two compared numbers are equal (fractions of the step).
#[derive(Clone, Copy)]
pub(super) struct Kink {
    /// The series holds up to here: slightly before the equality, or slightly after it if the
    /// numbers are equal from the start.
    pub(super) before: f64,
    /// Slightly after the equality, where the next series sees the new result.
    pub(super) after: f64,
}

impl<const N: usize, const G: usize> TaylorStepper<N, G> {
    /// The first change of a comparison in the step that the series depends on. Also returns
    /// whether two compared numbers are equal at the start and the result changes after it.
    pub(super) fn first_kink(&self) -> (Option<Kink>, bool) {
        let step_series = &self.step_series;
        let (mut first, mut is_tie): (Option<Kink>, _) = (None, false);
        for c in &self.choices {
            let c = &c[..=step_series.order];
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
            let mut after = s;
            // The margin must be positive even if the step begins at time zero.
            let mut more =
                4.0 * f64::EPSILON * (s + (step_series.t / step_series.h).abs()).max(1.0);
            if s == 0.0 {
                is_tie = true;
                more = more.max(self.tie_step / step_series.h);
            }
            while after < 1.0 && power_series(c, after).0 >= -8.0 * f64::EPSILON * size {
                after = s + more;
                more *= 2.0;
            }
            if after < first.map_or(1.0, |first| first.after) {
                let before = if s == 0.0 {
                    after
                } else {
                    f64::max(0.0, s - (after - s))
                };
                first = Some(Kink { before, after });
            }
        }
        (first, is_tie)
    }
}

/// The event of a guard that is negative at `at`, after a kink: it has jumped there.
#[cold]
pub(super) fn guard_jump<F: Flow<N>, const N: usize>(
    flow: &F,
    at: &Timed<N>,
    options: &Options,
) -> Option<Event<N>> {
    flow.guards().iter().find_map(|&guard| {
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
/// slope of the series before and the field after it show this. Such a reversal is a transition at
/// an undeclared boundary, and it can pile up as others do.
#[cold]
pub(super) fn record_reversal<const N: usize>(
    reversals: &mut Burst,
    at: &Timed<N>,
    [before, after]: [&State<N>; 2],
    options: &Options,
) -> Result<(), Error> {
    let size = f64::max(before.amax(), after.amax());
    let reverses =
        |i: usize| before[i] * after[i] < 0.0 && (before[i] - after[i]).abs() > REVERSAL * size;
    if !(0..N).any(reverses) {
        return Ok(());
    }
    let (count, span) = reversals.record(at.t, options);
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
