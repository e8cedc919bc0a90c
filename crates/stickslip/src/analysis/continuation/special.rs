//! The special orbits between two on a branch, by their multipliers.

use super::line::{Line, bordered};
use super::walk::{Vanishing, Walk};
use super::{Special, SpecialPoint, Stop, critical, parameter_of};
use crate::analysis::critical::zero_between;
use crate::analysis::cycle::{Cycle, Function, Path, Shooting, Zero, at_least};
use crate::analysis::lagrange::weights;

impl Walk<'_> {
    /// Continues to this orbit on the line, and records the special ones between the last one and
    /// it, by the multipliers. The reason is returned if the branch ends before this orbit.
    pub(super) fn follow(
        &mut self,
        line: &Line,
        next: Cycle,
        onward: Option<Line>,
    ) -> Option<Stop> {
        // A fold and a branch point are one if they are this close, as a part of the step.
        const SAME_PLACE: f64 = 0.1;
        let behind = self.branch.points.len();
        let shooting = self.shooting;
        let of = |cycle: &Cycle| critical(cycle, &shooting);
        let length = line.place(&next);
        let (units, across) = (self.branch.units, line.across());
        let heading = |cycle: &Cycle| Some(line.goes_on(&shooting, units, cycle)?.heading());
        // Zero where another branch meets this one (Keller 1977).
        let parts = |cycle: &Cycle| Some(bordered(cycle, across).determinant());
        let minus_one = |cycle: &Cycle| Some(of(cycle).minus_one);
        let circle = |cycle: &Cycle| of(cycle).circle;
        let functions: [&Function<'_>; 4] = [&heading, &parts, &minus_one, &circle];
        let mut found = Vec::new();
        // In a family there are always several tangents, and these are neither folds nor branch
        // points. At a flip of the half, the branch turns and meets that of the half run through
        // twice.
        let flip = self.flip_of_half(line, &next);
        let first = if shooting.family > 0 || flip.is_some() {
            2
        } else {
            0
        };
        for (kind, function) in functions.into_iter().enumerate().skip(first) {
            let (Some(a), Some(b)) = (function(&self.branch.last), function(&next)) else {
                continue;
            };
            if a * b >= 0.0 {
                continue;
            }
            let Some(zero) = self.zero(line, [(0.0, a), (length, b)], function) else {
                continue;
            };
            // A zero that the neighbouring orbits do not resolve is none: the tangent is
            // undetermined there.
            let off = |one: &Cycle| (parameter_of(one) - zero.parameter).abs();
            let is_resolved = zero.uncertainty < off(&self.branch.last).max(off(&next));
            if kind == 0 && !is_resolved {
                continue;
            }
            let what = match kind {
                0 => Special::Fold,
                1 => Special::BranchPoint,
                2 => Special::Flip,
                _ => Special::NeimarkSacker {
                    angle: of(&zero.solution).angle,
                },
            };
            found.push((zero, what));
        }
        found.sort_by(|a, b| a.0.s.total_cmp(&b.0.s));
        let place = |kind: &Special| found.iter().position(|(_, what)| what == kind);
        let meets = [Special::Fold, Special::BranchPoint].each_ref().map(place);
        if meets != [None, None] && self.is_back(&next) {
            let first = self.branch.first.clone();
            self.take(first);
            return Some(Stop::Closed);
        }
        // A branch that leaves another one to one side turns there.
        if let [Some(fold), Some(point)] = meets
            && (found[fold].0.s - found[point].0.s).abs() <= SAME_PLACE * length
        {
            let is_better = found[fold].0.uncertainty < found[point].0.uncertainty;
            let (kept, other) = if is_better {
                (fold, point)
            } else {
                (point, fold)
            };
            found[kept].1 = Special::BranchPoint;
            found.remove(other);
        }
        if let Some(flip) = &flip {
            found.retain(|(zero, _)| zero.s < flip.s);
        }
        for (zero, what) in found {
            let point = SpecialPoint {
                parameter: zero.parameter,
                uncertainty: self.at_least(zero.parameter, zero.uncertainty),
                what,
                behind,
                x: zero.solution.anchor.x.clone(),
                period: zero.solution.period,
            };
            self.note_special(point, zero.solution, Vanishing::Multiplier(line.clone()));
        }
        if let Some(flip) = flip {
            return Some(Stop::Flip {
                parameter: flip.parameter,
                uncertainty: self.at_least(flip.parameter, flip.uncertainty),
            });
        }
        self.take(next);
        self.branch.line = onward;
        None
    }

    /// Where both halves become the same orbit, between the last orbit and another one on a line:
    /// their difference passes through zero.
    fn flip_of_half(&self, line: &Line, next: &Cycle) -> Option<Zero> {
        // Part of the difference that is left at the nearest orbit that can be computed.
        const LEFT: f64 = 0.2;
        let last = &self.branch.last;
        let [before, behind] = [last.halves()?, next.halves()?];
        let is_resolved = before.amax() > last.closes_to && behind.amax() > next.closes_to;
        if before.len() != behind.len() {
            return None;
        }
        let way = behind.normalize();
        let part = |one: &Cycle| Some(one.halves()?.dot(&way));
        let (a, b) = (part(last)?, part(next)?);
        if !is_resolved || a >= 0.0 {
            return None;
        }
        let zero = self.zero(line, [(0.0, a), (line.place(next), b)], &part)?;
        let left = zero.solution.halves()?.norm();
        (left <= LEFT * before.norm().max(behind.norm())).then_some(zero)
    }

    /// Whether the branch passes its first orbit between the last one and another one.
    fn is_back(&self, next: &Cycle) -> bool {
        // Distance by which a straight line between them may miss it, as a part of its length: the
        // branch bends little in a step.
        const MISSED: f64 = 0.1;
        let off = [&self.branch.last, next].map(|one| self.away(one));
        let [Some(before), Some(behind)] = off else {
            return false;
        };
        let way = &behind - &before;
        let part = -before.dot(&way) / way.norm_squared();
        let missed = (&before + &way * part).norm();
        self.branch.points.len() > 3 && (0.0..=1.0).contains(&part) && missed <= MISSED * way.norm()
    }

    /// Where a function vanishes on a line, between two places at which it has different signs. Its
    /// parameter is that of the orbit there, or follows from orbits around it where these determine
    /// it better: next to a multiplier of 1, the closing error exceeds rounding.
    pub(super) fn zero(
        &self,
        line: &Line,
        [a, b]: [(f64, f64); 2],
        function: &Function<'_>,
    ) -> Option<Zero> {
        const GOOD: f64 = 100.0;
        let found = line.orbits(&self.shooting).zero([a, b], function);
        let good = GOOD * self.shooting.options.rtol * self.branch.units.width;
        if found.as_ref().is_some_and(|zero| zero.uncertainty <= good) {
            return found;
        }
        let secant = a.0 - a.1 * (b.0 - a.0) / (b.1 - a.1);
        let rough = found.as_ref().map_or(secant, |zero| zero.s);
        let other = self.interpolated(line, b.0 - a.0, rough, function);
        let (Some(found), Some(other)) = (&found, &other) else {
            return found.or(other);
        };
        let is_better = other.uncertainty < found.uncertainty || found.uncertainty.is_nan();
        let best = if is_better { other } else { found };
        Some(Zero {
            parameter: best.parameter,
            uncertainty: best.uncertainty,
            solution: found.solution.clone(),
            ..*found
        })
    }

    /// Where a function vanishes near a place, by a polynomial through orbits around it. Where
    /// another branch meets this one, Newton's matrix is singular, and no orbit can be computed
    /// next to it.
    fn interpolated(
        &self,
        line: &Line,
        length: f64,
        rough: f64,
        function: &Function<'_>,
    ) -> Option<Zero> {
        // Spacing, as a fraction of the distance between the last two orbits, and number on each
        // side.
        const APART: f64 = 0.05;
        const EACH_WAY: i32 = 4;
        const FEWEST: usize = 5;
        let node = |s: f64, shooting: &Shooting<'_>| {
            let cycle = line.on(shooting, s)?;
            let value = function(&cycle)?;
            Some(Node { s, value, cycle })
        };
        let places = (-EACH_WAY..=EACH_WAY).filter(|k| *k != 0);
        let places = places.map(|k| rough + APART * length * f64::from(k));
        let nodes: Vec<Node> = places.filter_map(|s| node(s, &self.shooting)).collect();
        let all: Vec<&Node> = nodes.iter().collect();
        if nodes.len() < FEWEST {
            return None;
        }
        let (s, parameter) = zero_of_polynomial(&all)?;
        // Without the farthest node, the polynomial's error shows; without the nearest, the
        // rounding error.
        let mut sizes: Vec<f64> = nodes.iter().map(|one| one.value.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let apart: Vec<&Node> = all
            .iter()
            .copied()
            .filter(|one| one.value.abs() > sizes[1])
            .collect();
        let fewer = [&all[1..nodes.len() - 1], &apart].map(zero_of_polynomial);
        let off =
            |other: Option<(f64, f64)>| other.map_or(f64::NAN, |(_, p)| (parameter - p).abs());
        // The tolerances have the largest effect at the nearest node. Next to a multiplier of 1,
        // errors that differ between orbits amplify it.
        const SAFE: f64 = 8.0;
        let finer = Shooting {
            options: &self.shooting.options.finer(),
            ..self.shooting
        };
        let (first, last) = (nodes.first()?, nodes.last()?);
        let nearest = nodes.iter().find(|one| one.value.abs() == sizes[0])?;
        let by_tolerance = node(nearest.s, &finer).map_or(f64::NAN, |finer| {
            let way = parameter_of(&last.cycle) - parameter_of(&first.cycle);
            let along = (finer.value - nearest.value) * way / (last.value - first.value);
            SAFE * (along.abs() + (parameter_of(&finer.cycle) - parameter_of(&nearest.cycle)).abs())
        });
        Some(Zero {
            s,
            parameter,
            solution: nearest.cycle.clone(),
            uncertainty: off(fewer[0]) + off(fewer[1]) + by_tolerance,
        })
    }

    /// An uncertainty, at least what Newton's iteration leaves of a parameter's last digits. Where
    /// none is known, the place lies in the last step.
    pub(super) fn at_least(&self, parameter: f64, uncertainty: f64) -> f64 {
        let step = (self.parameter() - parameter_of(&self.branch.before)).abs();
        at_least((parameter, uncertainty), step, self.branch.units.width)
    }
}

/// An orbit on a line, and the value of a function there.
struct Node {
    s: f64,
    value: f64,
    cycle: Cycle,
}

/// Where the interpolating polynomial of a function vanishes between two of its nodes, and the
/// parameter there.
fn zero_of_polynomial(nodes: &[&Node]) -> Option<(f64, f64)> {
    let places: Vec<f64> = nodes.iter().map(|node| node.s).collect();
    let at = |s: f64, of: fn(&Node) -> f64| -> f64 {
        let terms = weights(&places, s).into_iter().zip(nodes);
        terms.map(|(weight, node)| weight * of(node)).sum()
    };
    let mut pairs = nodes.windows(2);
    let ends = pairs.find(|two| two[0].value * two[1].value < 0.0)?;
    let [a, b] = [ends[0], ends[1]].map(|node| (node.s, node.value));
    let s = zero_between(a, b, |s| Some(at(s, |node| node.value)))?;
    Some((s, at(s, |node| parameter_of(&node.cycle))))
}
