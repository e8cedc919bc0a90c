//! How well the phases of a periodic orbit are determined: next to one with a multiplier of 1, rounding leaves its state open.

use nalgebra::DMatrix;

use super::circuit::Circuit;
use super::locate::is_same;
use crate::analysis::anchor::Anchor;
use crate::filippov::{Options, Switched, run};
use crate::system::State;

/// A state that may be off by less than this part of the orbit's extent is as good as known.
pub(super) const LEAST: f64 = 1e-11;

/// One closes as well as the orbit if its gap is no larger than so many times what rounding leaves.
const CLOSED: f64 = 2.0;

/// Doublings of the smallest displacement: where the return map is curved, as next to a branch point, more closes than by the linear estimate, or less.
const DOUBLINGS: i32 = 32;

/// By how much an orbit may be off where it is determined worst, and its period.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slack<const N: usize> {
    x: State<N>,
    period: f64,
    /// What may be left of the gap.
    gap: f64,
}

impl<const N: usize> Slack<N> {
    /// From the matrix of Newton's iteration, of the states and, if it has one more column, the period; and what may be left of the orbit's gap.
    /// Directions that nothing depends on are left out, as Newton's step leaves them out.
    pub fn of(matrix: DMatrix<f64>, gap: f64) -> Option<Self> {
        let bound = matrix.nrows() as f64 * f64::EPSILON;
        let parts = matrix.svd(false, true);
        let bound = bound * parts.singular_values.max();
        let values = parts.singular_values.iter().enumerate();
        let (number, least) = values
            .filter(|(_, value)| **value > bound)
            .min_by(|a, b| a.1.total_cmp(b.1))?;
        let directions = parts.v_t?;
        let off = directions.row(number) * (gap / least);
        Some(Slack {
            x: State::from_fn(|i, _| off[i]),
            period: off.get(N).copied().unwrap_or(0.0),
            gap,
        })
    }
}

impl<const N: usize, K: Copy + PartialEq> Circuit<N, K> {
    /// Notes by how much the margins may be off, and whether the phases may be others, for an orbit that was followed from `start` and may be off so far.
    pub fn with_slack<S: Switched<N, G, Mode = K>, const G: usize>(
        mut self,
        system: &S,
        start: &Anchor<N, K>,
        slack: Option<Slack<N>>,
        options: &Options,
    ) -> Self {
        let least = LEAST * self.extent;
        let Some(slack) = slack.filter(|slack| slack.x.amax() > least) else {
            return self;
        };
        let sequence = self.sequence();
        let smallest = least / slack.x.amax();
        for sign in [1.0, -1.0] {
            let displaced = |part: f64| {
                let moved = start.moved(start.x + slack.x * part).settled(system);
                let period = self.period + slack.period * part;
                let t_end = moved.t + period;
                let end = run(system, moved.t, moved.x, t_end, options, &mut ()).ok()?;
                let gap = (end.x - moved.x).amax();
                (gap <= CLOSED * slack.gap).then_some((moved, period))
            };
            let parts = (0..DOUBLINGS).map(|k| sign * smallest * 2.0_f64.powi(k));
            let Some((moved, period)) = parts.map_while(displaced).last() else {
                continue;
            };
            let there = Circuit::follow(system, &moved, period, options);
            let same = there.ok().filter(|one| is_same(&one.sequence(), &sequence));
            let Some(there) = same else {
                self.is_certain = false;
                continue;
            };
            for margin in &mut self.margins {
                let off = there.margin(margin.key).map(|m| m.value - margin.value);
                margin.off = margin.off.max(off.map_or(0.0, f64::abs));
            }
        }
        self
    }
}
