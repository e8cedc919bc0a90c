//! The special orbits between two on a branch, by their multipliers.

use super::corrector::OnBranch;
use super::line::Line;
use super::walk::Walk;
use super::{Special, SpecialPoint};
use crate::analysis::critical::{Critical, zero_between};
use crate::filippov::Switched;

impl<S: Switched<N, G>, const N: usize, const G: usize> Walk<'_, S, N, G> {
    /// Goes on from this orbit, and tells what is special between the last one and it, by the multipliers.
    pub(super) fn follow(&mut self, next: OnBranch<N, S::Mode>) {
        let behind = self.points.len();
        self.take(next);
        let line = self.line();
        let is_forced = self.settings.forced.is_some();
        let of = |orbit: &OnBranch<N, S::Mode>| orbit.branch.critical(is_forced);
        let (here, there) = (of(&self.before), of(&self.last));
        type Function = fn(&Critical) -> Option<f64>;
        let functions: [Function; 3] = [|c| Some(c.one), |c| Some(c.minus_one), |c| c.circle];
        let mut found = Vec::new();
        for (kind, function) in functions.into_iter().enumerate() {
            let (Some(a), Some(b)) = (function(&here), function(&there)) else {
                continue;
            };
            if a * b >= 0.0 {
                continue;
            }
            let at = |s: f64| self.on(&line, s);
            let value = |s: f64| at(s).and_then(|orbit| function(&of(&orbit)));
            let zero = zero_between((-line.length, a), (0.0, b), value);
            let Some(orbit) = zero.and_then(|zero| self.next_to(&line, zero)) else {
                continue;
            };
            let what = match kind {
                0 => self.fold_or_branch(&line, &orbit),
                1 => Special::Flip,
                _ => Special::NeimarkSacker {
                    angle: of(&orbit).angle,
                },
            };
            found.push((
                orbit.s,
                SpecialPoint {
                    parameter: orbit.circuit.anchor.x[N - 1],
                    what,
                    behind,
                    x: orbit.circuit.anchor.x,
                    period: orbit.circuit.period,
                },
            ));
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        self.special
            .extend(found.into_iter().map(|(_, point)| point));
    }

    /// The orbit at a place, or, where another branch meets this one and Newton's matrix is singular, next to it.
    fn next_to(&self, line: &Line<N, S::Mode>, s: f64) -> Option<OnBranch<N, S::Mode>> {
        const PARTS: [f64; 5] = [0.0, 1e-10, -1e-10, 1e-9, -1e-9];
        let mut places = PARTS.iter().map(|part| s + part * line.length);
        places.find_map(|place| self.on(line, place))
    }

    /// Whether the parameter turns back at an orbit between the last two.
    fn fold_or_branch(
        &self,
        line: &Line<N, S::Mode>,
        orbit: &OnBranch<N, S::Mode>,
    ) -> Special<N, S::Mode> {
        let parameter = |orbit: &OnBranch<N, S::Mode>| orbit.circuit.anchor.x[N - 1];
        let near = 1e-3 * line.length;
        let next_to = |s: f64, end: &OnBranch<N, S::Mode>| {
            parameter(self.on(line, s).as_ref().unwrap_or(end))
        };
        let before = next_to(orbit.s - near, &self.before);
        let behind = next_to(orbit.s + near, &self.last);
        let here = parameter(orbit);
        if (before - here) * (behind - here) < 0.0 {
            Special::BranchPoint
        } else {
            Special::Fold
        }
    }
}
