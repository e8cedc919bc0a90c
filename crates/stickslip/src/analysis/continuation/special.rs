//! The special orbits between two on a branch, by their multipliers.

use super::corrector::OnBranch;
use super::critical::{Critical, zero_between};
use super::line::Line;
use super::walk::Walk;
use super::{Special, SpecialPoint};
use crate::filippov::Switched;

/// Two neighbouring orbits, with their places on the line through the last two of the branch.
pub(super) struct Between<const N: usize, K> {
    a: OnBranch<N, K>,
    b: OnBranch<N, K>,
    /// Behind how many points of the branch what lies between them is.
    behind: usize,
    /// Whether they are the last of the branch and the next.
    is_next: bool,
}

impl<const N: usize, K: Copy> Between<N, K> {
    /// The last orbit, from which the line begins, and the next.
    pub fn next(last: &OnBranch<N, K>, next: &OnBranch<N, K>, behind: usize) -> Self {
        let mut a = last.clone();
        a.s = 0.0;
        Between {
            a,
            b: next.clone(),
            behind,
            is_next: true,
        }
    }

    /// The last two orbits, the line beginning from the second one.
    pub fn last(before: OnBranch<N, K>, last: &OnBranch<N, K>, behind: usize) -> Self {
        let mut b = last.clone();
        b.s = 0.0;
        Between {
            a: before,
            b,
            behind,
            is_next: false,
        }
    }
}

impl<S: Switched<N, G>, const N: usize, const G: usize> Walk<'_, S, N, G> {
    /// What is special between two orbits, by the multipliers.
    pub(super) fn note_critical(&mut self, line: &Line<N>, mut between: Between<N, S::Mode>) {
        let is_forced = self.settings.forced.is_some();
        if !between.is_next {
            between.a.s = -line.length;
        }
        let Between {
            a: one,
            b: two,
            behind,
            is_next,
        } = between;
        let of = |orbit: &OnBranch<N, S::Mode>| Critical::of(&orbit.branch, is_forced);
        let (here, there) = (of(&one), of(&two));
        let turns = is_next && {
            let change = |a: &OnBranch<N, _>, b: &OnBranch<N, _>| {
                b.circuit.anchor.x[N - 1] - a.circuit.anchor.x[N - 1]
            };
            change(&self.before, &one) * change(&one, &two) < 0.0
        };
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
            let at = |s: f64| self.on(line, s);
            let value = |s: f64| at(s).and_then(|orbit| function(&of(&orbit)));
            let Some(orbit) = zero_between((one.s, a), (two.s, b), value).and_then(at) else {
                continue;
            };
            let what = match kind {
                0 if turns => Special::Fold,
                0 => self.fold_or_branch(line, two.s - one.s, &orbit),
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

    /// Whether the parameter turns back at an orbit between two that are so far apart on the line.
    fn fold_or_branch(
        &self,
        line: &Line<N>,
        length: f64,
        orbit: &OnBranch<N, S::Mode>,
    ) -> Special<N, S::Mode> {
        let near = 1e-3 * length;
        let parameter = |s: f64| {
            let found = self.on(line, s);
            found.map(|found| found.circuit.anchor.x[N - 1])
        };
        let here = orbit.circuit.anchor.x[N - 1];
        match (parameter(orbit.s - near), parameter(orbit.s + near)) {
            (Some(before), Some(behind)) if (before - here) * (behind - here) < 0.0 => {
                Special::BranchPoint
            }
            _ => Special::Fold,
        }
    }
}
