//! Comparisons that a series depends on, and where their results change.

use super::TaylorStepper;
use crate::error::{Error, Point};
use crate::filippov::flow::Flow;
use crate::filippov::guard::Event;
use crate::filippov::options::Options;
use crate::filippov::uncertainty::uncertainty;
use crate::ode::{Timed, power_series};
use crate::system::State;
use crate::taylor::roots::first_zero;

/// Smallest jump of a field that counts as a reversal, relative to its size. Chosen far above the
/// rounding by which a continuous field changes its sign.
const REVERSAL: f64 = 1e-3;

/// Roundings of time and state within which the field reverses again where it holds the orbit.
/// Chosen: a tied comparison is passed by up to sixteen, and what only turns fast is far from it.
const HELD_ROUNDINGS: f64 = 1e3;

/// Part of the way to a kink after which the field may have its new result by rounding. Chosen: a
/// millionth of a step is far above the rounding of what is compared.
const CERTAIN_PART: f64 = 1.0 - 1e-6;

/// Time at which two compared numbers are equal (fractions of the step).
#[derive(Clone, Copy)]
pub(super) struct BranchTie {
    /// The series holds up to here: slightly before the equality, or slightly after it if the
    /// numbers are equal from the start.
    pub(super) before: f64,
    /// The field has the old result for certain up to here.
    pub(super) certain: f64,
    /// Slightly after the equality, where the next series sees the new result.
    pub(super) after: f64,
}

impl<const N: usize, const G: usize> TaylorStepper<N, G> {
    /// The first change of a comparison in the step that the series depends on, or at the end of
    /// the run up to rounding. Also returns whether two compared numbers are equal at the start and
    /// the result changes after it.
    pub(super) fn first_kink(&self) -> (Option<BranchTie>, bool) {
        let step_series = &self.step_series;
        let (mut first, mut at_end, mut is_tie): (Option<BranchTie>, _, _) = (None, None, false);
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
                    None if self.is_last => 1.0,
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
                let (before, certain) = if s == 0.0 {
                    (after, 0.0)
                } else {
                    let before = f64::max(0.0, s - (after - s));
                    (before, before * CERTAIN_PART)
                };
                first = Some(BranchTie {
                    before,
                    certain,
                    after,
                });
            } else if self.is_last
                && first.is_none()
                && power_series(c, 1.0).0 <= 8.0 * f64::EPSILON * size
            {
                at_end = Some(BranchTie {
                    before: 1.0,
                    certain: CERTAIN_PART,
                    after: 1.0,
                });
            }
        }
        (first.or(at_end), is_tie)
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

/// Reversals of the field where comparisons change, in a row between which only rounding moves the
/// orbit.
#[derive(Clone, Copy)]
pub(super) struct Reversals {
    count: usize,
    /// Times of the first and of the last.
    first: f64,
    last: f64,
}

impl Reversals {
    pub(super) const NONE: Self = Reversals {
        count: 0,
        first: 0.0,
        last: f64::NEG_INFINITY,
    };

    /// Records a step of length `h` that ends at `at` because a comparison changes, if the field
    /// reverses there. The slope of the series before and the field after it show this. Such a
    /// reversal is a transition at an undeclared boundary, which may hold the orbit.
    #[cold]
    pub(super) fn record<const N: usize>(
        &mut self,
        at: &Timed<N>,
        [before, after]: [&State<N>; 2],
        h: f64,
        options: &Options,
    ) -> Result<(), Error> {
        let size = f64::max(before.amax(), after.amax());
        let reverses = |i: &usize| {
            before[*i] * after[*i] < 0.0 && (before[*i] - after[*i]).abs() > REVERSAL * size
        };
        // Steps in which a component that reverses moves by its own size.
        let steps = |i: usize| (at.x[i] / after[i]).abs();
        let Some(longest) = (0..N).filter(reverses).map(steps).reduce(f64::max) else {
            return Ok(());
        };
        let rounding = f64::EPSILON * (at.t.abs() + h * longest.max(1.0));
        if at.t - self.last > HELD_ROUNDINGS * rounding {
            (self.count, self.first) = (0, at.t);
        }
        (self.count, self.last) = (self.count + 1, at.t);
        if self.count < options.pile_up_count {
            return Ok(());
        }
        Err(Error::BranchPileUp {
            count: self.count,
            span: at.t - self.first,
            t: at.t,
            x: Point::from(&at.x),
        })
    }
}
