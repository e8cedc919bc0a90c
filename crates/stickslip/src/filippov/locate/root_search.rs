//! A safeguarded root search on re-integrated steps.

use super::DenseGuard;
use crate::filippov::flow::Flow;
use crate::filippov::guard::{Probe, StepGuard, turning_point};
use crate::filippov::scan::Bracket;

/// Result of the search.
pub(super) enum SearchResult<const N: usize> {
    Zero(Probe<N>),
    Turn(Probe<N>),
}

impl<F: Flow<N>, const N: usize> DenseGuard<'_, F, N> {
    /// Newton's iteration on re-integrated steps, held in a bracket by bisection. If the guard
    /// jumps through zero, the result lies after the jump.
    pub(super) fn search(&self, bracket: Bracket, estimate: f64, rounding: f64) -> SearchResult<N> {
        let (mut a, mut b) = (bracket.a, bracket.b);
        let end = self.probe(b);
        if end.guard > 0.0 {
            let turn = turning_point(self, estimate);
            if turn.guard > 0.0 {
                return SearchResult::Turn(turn);
            }
            if turn.s <= a || turn.s > b.max(1.0) {
                // The turning point belongs to another dip than the bracket's.
                return SearchResult::Turn(turn);
            }
            b = turn.s;
        }
        let mut s = estimate.clamp(a, b);
        let mut here = self.probe(s);
        for _ in 0..200 {
            if here.guard == 0.0 {
                break;
            }
            if here.guard > 0.0 {
                a = s;
            } else {
                b = s;
            }
            let newton = s - here.guard / (here.rate * self.origin.h);
            let next = if newton > a && newton < b {
                newton
            } else {
                0.5 * (a + b)
            };
            if next == s || next <= a || next >= b {
                break;
            }
            let there = self.probe(next);
            let stalled = (next - s).abs() <= 2.0 * f64::EPSILON * s.abs()
                && there.guard.abs() >= here.guard.abs();
            (s, here) = (next, there);
            if stalled {
                // Across a jump, the two places are on its two sides.
                if here.guard > 0.0 {
                    a = s;
                }
                break;
            }
        }
        if here.guard > rounding && b - a <= 4.0 * f64::EPSILON * b + f64::MIN_POSITIVE {
            here = self.probe(b);
        }
        SearchResult::Zero(here)
    }
}
