//! The special orbits between two on a branch, by their multipliers.

use super::corrector::OnBranch;
use super::line::Line;
use super::walk::Walk;
use super::{Special, SpecialPoint};
use crate::analysis::critical::{Critical, zero_between};
use crate::filippov::Switched;
use crate::system::State;

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
            let value = |s: f64| self.on(&line, s).and_then(|orbit| function(&of(&orbit)));
            let zero = zero_between((-line.length, a), (0.0, b), value);
            let by_polynomial =
                |rough: f64| self.interpolated(&line, rough, |orbit| function(&of(orbit)));
            let place = zero
                .and_then(|zero| self.next_to(&line, zero))
                .map(|orbit| Place::of(&orbit))
                .or_else(|| by_polynomial(-line.length * b / (b - a)));
            let Some(mut place) = place else {
                continue;
            };
            let what = match kind {
                0 => self.fold_or_branch(&line, &place),
                1 => Special::Flip,
                _ => Special::NeimarkSacker {
                    angle: self
                        .next_to(&line, place.s)
                        .map_or(there.angle, |orbit| of(&orbit).angle),
                },
            };
            // Next to it orbits are worse than about it.
            if what == Special::BranchPoint
                && let Some(better) = by_polynomial(place.s)
            {
                place = better;
            }
            found.push((
                place.s,
                SpecialPoint {
                    parameter: place.x[N - 1],
                    what,
                    behind,
                    x: place.x,
                    period: place.period,
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

    /// Where a function of the multipliers is zero near a place, by a polynomial through orbits about it: where another branch meets this one Newton's matrix
    /// is singular, and no orbit is found next to it.
    fn interpolated(
        &self,
        line: &Line<N, S::Mode>,
        rough: f64,
        function: impl Fn(&OnBranch<N, S::Mode>) -> Option<f64>,
    ) -> Option<Place<N>> {
        // So far apart, in parts of the distance between the last two orbits, and so many each way.
        const APART: f64 = 0.15;
        const EACH_WAY: i32 = 4;
        const FEWEST: usize = 5;
        let wanted = self.last.circuit.sequence();
        let mut nodes: Vec<(f64, f64, Place<N>)> = Vec::new();
        for k in (-EACH_WAY..=EACH_WAY).filter(|k| *k != 0) {
            let s = rough + APART * line.length * f64::from(k);
            let found = self.on(line, s);
            if let Some(orbit) = found.filter(|one| one.circuit.sequence() == wanted)
                && let Some(value) = function(&orbit)
            {
                nodes.push((s, value, Place::of(&orbit)));
            }
        }
        let is_between = nodes.windows(2).any(|two| two[0].1 * two[1].1 < 0.0);
        if nodes.len() < FEWEST || !is_between {
            return None;
        }
        // Lagrange's formula.
        let weights = |s: f64| -> Vec<f64> {
            let weight = |(k, node): (usize, &(f64, f64, Place<N>))| {
                let others = nodes.iter().enumerate().filter(|(other, _)| *other != k);
                others
                    .map(|(_, other)| (s - other.0) / (node.0 - other.0))
                    .product()
            };
            nodes.iter().enumerate().map(weight).collect()
        };
        let value = |s: f64| {
            let terms = weights(s).into_iter().zip(&nodes);
            terms.map(|(weight, node)| weight * node.1).sum::<f64>()
        };
        let ends = nodes.windows(2).find(|two| two[0].1 * two[1].1 < 0.0)?;
        let [a, b] = [&ends[0], &ends[1]].map(|node| (node.0, node.1));
        let s = zero_between(a, b, |s| Some(value(s)))?;
        let weights = weights(s);
        let weighted = || weights.iter().zip(&nodes);
        let x = weighted().fold(State::<N>::zeros(), |sum, (weight, node)| {
            sum + node.2.x * *weight
        });
        let period = weighted()
            .map(|(weight, node)| weight * node.2.period)
            .sum();
        Some(Place { s, x, period })
    }

    /// Whether the parameter turns back at a place between the last two orbits.
    fn fold_or_branch(&self, line: &Line<N, S::Mode>, at: &Place<N>) -> Special<N, S::Mode> {
        // Not next to it: there another branch may be.
        let away = 0.5 * line.length;
        let parameter = |s: f64, end: &OnBranch<N, S::Mode>| {
            let found = self.on(line, s);
            let orbit = found.filter(|one| one.circuit.sequence() == end.circuit.sequence());
            orbit.as_ref().unwrap_or(end).circuit.anchor.x[N - 1]
        };
        let before = parameter(at.s - away, &self.before);
        let behind = parameter(at.s + away, &self.last);
        let here = at.x[N - 1];
        if (before - here) * (behind - here) < 0.0 {
            Special::BranchPoint
        } else {
            Special::Fold
        }
    }
}

/// A place on the branch.
struct Place<const N: usize> {
    s: f64,
    /// A state on the orbit there.
    x: State<N>,
    period: f64,
}

impl<const N: usize> Place<N> {
    fn of<K>(orbit: &OnBranch<N, K>) -> Self {
        Place {
            s: orbit.s,
            x: orbit.circuit.anchor.x,
            period: orbit.circuit.period,
        }
    }
}
