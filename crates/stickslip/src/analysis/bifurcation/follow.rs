//! Periodic orbits followed from one value of a sweep towards another, with the phase sequence of
//! the first.

use super::change::End;
use super::stability::NEXT_TO;
use super::{Family, WhatChanges};
use crate::analysis::attractors::is_same_cycle;
use crate::analysis::boundary_equilibrium::{Approach, Held, ends_in};
use crate::analysis::continuation::Special;
use crate::analysis::critical::{Critical, zero_between};
use crate::analysis::cycle::{
    AT_ONCE, Cycle, Function, Margin, MarginKind, Outline, Path, SequenceChange, Shooting, Zero,
    at_least, describe,
};
use crate::analysis::lagrange::weights;
use crate::dynamics::{Moment, Vector};
use crate::filippov::Options;

/// First step as a fraction of the interval, and the ratio of successive steps.
const FIRST: f64 = 1.0 / 64.0;
const GROWTH: f64 = 1.3;

/// Fraction of the interval to which the end of an orbit is located.
const RESOLUTION: f64 = 1e-10;

/// At an end of the orbit located to this fraction, a multiplier that approaches 1 like a square
/// root is about 1e-5 away from it.
const NEAR_ONE: f64 = 1e-3;

/// Distances beyond a change at which orbits are sought, as fractions of the interval.
const BEHIND: [f64; 4] = [1e-5, 1e-4, 1e-3, 1e-2];

/// The periodic orbits of a family, followed from the first.
pub(super) struct Following<'a> {
    family: &'a Family<'a>,
    /// The period, where the forcing prescribes it.
    forced: Option<f64>,
    /// Dimension of the families to which the orbits belong.
    free: usize,
    options: Options,
    first: OrbitAt,
}

/// An orbit at a parameter.
#[derive(Clone)]
struct OrbitAt {
    parameter: f64,
    cycle: Cycle,
}

/// The orbits with one sequence between two values of the parameter.
pub(super) struct FollowedOrbits {
    good: Vec<OrbitAt>,
    /// The last of these behind which none was computed.
    lost: Option<f64>,
    /// The change of phases at the end.
    pub change: Option<SequenceChange>,
}

/// The orbits on the line through some computed ones, by their parameter.
struct Between<'f, 'a> {
    following: &'f Following<'a>,
    known: &'f [OrbitAt],
}

impl Path for Between<'_, '_> {
    type Solution = Cycle;

    fn solution(&self, parameter: f64, options: &Options) -> Option<Cycle> {
        let found = self.following.by_line(self.known, parameter, options);
        found.map(|found| found.cycle)
    }

    fn options(&self) -> &Options {
        &self.following.options
    }

    fn parameter(&self, parameter: f64, _: &Cycle) -> f64 {
        parameter
    }

    fn pace(&self) -> f64 {
        1.0
    }
}

impl<'a> Following<'a> {
    /// Begins with the orbit reached at a value.
    pub fn begin(
        family: &'a Family<'a>,
        from: End<'_>,
        period: f64,
        forced: Option<f64>,
        options: &Options,
    ) -> Option<Self> {
        let system = &*family(from.0);
        // The cut is where a phase begins in which all contacts slip: stick forgets the past and
        // with it the error of the start. With a forcing, it is at the strobe.
        let mut phases = from.1.phases.iter();
        let slip = phases.find(|phase| forced.is_none() && !phase.mode.any_sticks());
        let begin = slip.map(|phase| (phase.t_start, &phase.x_start));
        let points = || from.1.points.first().map(|at| (at.t, &at.x));
        let (t, x) = begin.or_else(points)?;
        let start = Moment { t, x: x.clone() };
        let period = forced.unwrap_or(period);
        let outline = Outline::of_run(system, &start, period, options).ok()?;
        let cycle = Shooting::of(system, &outline, forced, options).nearest(&outline, None)?;
        Some(Following {
            family,
            forced,
            free: cycle.family,
            options: *options,
            first: OrbitAt {
                parameter: from.0,
                cycle,
            },
        })
    }

    /// The orbit at a parameter near an outline.
    fn solve(&self, parameter: f64, guess: &Outline, options: &Options) -> Option<OrbitAt> {
        let system = &*(self.family)(parameter);
        let shooting = Shooting {
            extent: self.first.cycle.extent,
            family: self.free,
            ..Shooting::of(system, guess, self.forced, options)
        };
        let cycle = shooting.solve(guess, None)?;
        Some(OrbitAt { parameter, cycle })
    }

    /// The orbit extrapolated to a parameter from the last two.
    fn expected(good: &[OrbitAt], parameter: f64) -> Option<Outline> {
        let two = good.last()?;
        let own = two.cycle.outline.unknowns();
        let Some(slope) = slope(good) else {
            return Some(two.cycle.outline.clone());
        };
        let moved = own + slope * (parameter - two.parameter);
        Some(two.cycle.outline.with(&moved))
    }

    fn by_line(&self, good: &[OrbitAt], parameter: f64, options: &Options) -> Option<OrbitAt> {
        let guess = Following::expected(good, parameter)?;
        let is_possible = guess.segments.iter().all(|one| one.duration >= 0.0);
        is_possible
            .then(|| self.solve(parameter, &guess, options))
            .flatten()
    }

    /// Follows the orbit towards another value until its phases change or it is lost.
    pub fn follow(&self, to: f64) -> FollowedOrbits {
        let from = self.first.parameter;
        let mut way = FollowedOrbits {
            good: vec![self.first.clone()],
            lost: None,
            change: None,
        };
        let resolution = RESOLUTION * (to - from).abs();
        // Small steps ensure that this orbit is followed, not a neighbouring one.
        let mut step = FIRST * (to - from);
        while let Some(last) = way.good.last() {
            let at = last.parameter;
            if at == to {
                break;
            }
            let goes_on = (to - at) / step > 1.0;
            let mut next = if goes_on { at + step } else { to };
            if let Some(place) = vanishing(&way.good, next) {
                let change = self.vanishes(&way.good, place);
                let is_ahead = |change: &SequenceChange| {
                    let part = (change.parameter - from) / (to - from);
                    // The value of the sweep may lie exactly on it.
                    (-NEXT_TO..=1.0 + NEXT_TO).contains(&part)
                };
                way.change = change.filter(is_ahead);
                if way.change.is_some() {
                    break;
                }
                next = at + 0.5 * (place - at);
            }
            match self.by_line(&way.good, next, &self.options) {
                Some(found) => match self.passed(&way.good, &found, (to - from).abs()) {
                    Ok(Some(change)) => {
                        way.change = Some(change);
                        break;
                    }
                    Ok(None) => {
                        way.good.push(found);
                        step *= GROWTH;
                        continue;
                    }
                    Err(()) => {}
                },
                None => way.lost = Some(next),
            }
            step = 0.3 * (next - at);
            if step.abs() < resolution {
                way.lost = Some(next);
                break;
            }
        }
        if way.good.last().is_some_and(|last| last.parameter == to) || way.change.is_some() {
            way.lost = None;
        }
        match way.lost {
            Some(lost) => way.change = self.ends_in(&way.good, lost),
            None if way.change.is_none() => {
                let at_end = || self.ends_in(&way.good, to + resolution * (to - from).signum());
                way.change = self.hit(&way.good).or_else(at_end);
            }
            None => {}
        }
        way
    }

    /// The change at the last orbit: if a margin is zero to the tolerances, the orbit has the
    /// phases of both sides.
    fn hit(&self, good: &[OrbitAt]) -> Option<SequenceChange> {
        let [.., before, last] = good else {
            return None;
        };
        let is_open = |margin: &&Margin| {
            margin.key.kind != MarginKind::Duration && !margin.is_resolved(&self.options)
        };
        let margin = last.cycle.margins.iter().find(is_open)?;
        let earlier = before.cycle.margin_like(margin)?.value;
        let slope = (margin.value - earlier) / (last.parameter - before.parameter);
        let way = margin.value / slope;
        let system = &*(self.family)(last.parameter);
        let width = (last.parameter - good.first()?.parameter).abs();
        let uncertainty = at_least((last.parameter, way.abs()), width, width);
        let place = (last.parameter - way, uncertainty);
        let sides = [last.cycle.outline.modes(), Vec::new()];
        Some(describe(system, (&last.cycle, margin), place, sides))
    }

    fn is_violated(&self, margin: &Margin) -> bool {
        margin.is_violated(&self.options)
    }

    /// The first change of phases between the last orbit and another; `Err` where that is too far
    /// away to decide.
    fn passed(
        &self,
        good: &[OrbitAt],
        next: &OrbitAt,
        range: f64,
    ) -> Result<Option<SequenceChange>, ()> {
        let last = good.last().ok_or(())?;
        let both = [last.clone(), next.clone()];
        let ends = both.each_ref().map(|one| (one.parameter, &one.cycle));
        let found = self.between(&both).passed(ends[0], ends[1], range)?;
        Ok(found.map(|(zero, margin)| self.described(last, &zero, &margin, next.parameter)))
    }

    fn between<'f>(&'f self, known: &'f [OrbitAt]) -> Between<'f, 'a> {
        let following = self;
        Between { following, known }
    }

    /// The change at a zero of a margin, with the phases of the orbit that the system itself takes
    /// next to it.
    fn described(&self, last: &OrbitAt, zero: &Zero, margin: &Margin, next: f64) -> SequenceChange {
        let at = &OrbitAt {
            parameter: zero.parameter,
            cycle: zero.solution.clone(),
        };
        let way = next - last.parameter;
        let modes = last.cycle.outline.modes();
        let places = BEHIND.into_iter().flat_map(|part| [part, -part]);
        let after = places.into_iter().find_map(|part| {
            let parameter = at.parameter + part * way;
            let beyond = at.parameter + part.abs() * way;
            let both = [last.clone(), at.clone()];
            let beyond = self.by_line(&both, beyond, &self.options)?;
            let system = &*(self.family)(beyond.parameter);
            let (start, period) = (&beyond.cycle.anchor, beyond.cycle.period);
            let outline = Outline::of_run(system, start, period, &self.options).ok()?;
            let found = self.solve(parameter, &outline, &self.options)?;
            let is_valid = !found.cycle.margins.iter().any(|one| self.is_violated(one));
            let other = found.cycle.outline.modes();
            let is_other = !is_same_cycle(&other, &modes);
            (is_valid && is_other).then_some(other)
        });
        let system = &*(self.family)(at.parameter);
        let sides = [modes, after.unwrap_or_default()];
        let place = (at.parameter, uncertainty(zero, way));
        describe(system, (&at.cycle, margin), place, sides)
    }

    /// The change at which the durations of segments vanish, extrapolated to a place.
    fn vanishes(&self, good: &[OrbitAt], place: f64) -> Option<SequenceChange> {
        let last = good.last()?;
        let way = place - last.parameter;
        let numbers = vanishing_by(good, last.parameter + AT_ONCE * way);
        let numbers: Vec<usize> = numbers.into_iter().map(|(k, _)| k).collect();
        let first = numbers.first()?;
        let several = (numbers.len() > 1).then(|| self.vanishes_without(last, &numbers, way));
        several
            .flatten()
            .or_else(|| self.vanishes_without(last, &[*first], way))
            .or_else(|| self.coincides(good, *first, way))
    }

    /// The change at which two contacts switch in the same instant. The segment between them has a
    /// positive duration on either side, in one order of the two and in the other.
    fn coincides(&self, good: &[OrbitAt], number: usize, way: f64) -> Option<SequenceChange> {
        let last = good.last()?;
        let orbit = |parameter: f64, options: &Options| {
            let guess = Following::expected(good, parameter)?;
            // Symmetric orbits have several.
            let sign = guess.segments[number].duration.signum();
            let durations = guess.segments.iter().map(|one| one.duration).enumerate();
            let mut negative = durations.filter(|(_, duration)| *duration < 0.0);
            let other = negative.try_fold(guess.clone(), |guess, (number, duration)| {
                guess.swapped(number, -duration)
            });
            let found = self.solve(parameter, &other?, options)?;
            let lasts = found.cycle.outline.segments[number].duration;
            Some((found, sign * lasts))
        };
        let beyond = last.parameter + 2.0 * way;
        let (other, at_beyond) = orbit(beyond, &self.options)?;
        let here = last.cycle.outline.segments[number].duration;
        let lasts = |parameter: f64| Some(orbit(parameter, &self.options)?.1);
        let ends = ((last.parameter, here), (beyond, at_beyond));
        let parameter = zero_between(ends.0, ends.1, lasts)?;
        let (at, left) = orbit(parameter, &self.options)?;
        let (_, finer) = orbit(parameter, &self.options.finer())?;
        let slope = (at_beyond - here) / (beyond - last.parameter);
        let off = left.abs() + 2.0 * (finer - left).abs();
        let is_meant =
            |margin: &&Margin| margin.key.kind == MarginKind::Duration && margin.key.part == number;
        let margin = at.cycle.margins.iter().find(is_meant)?;
        let system = &*(self.family)(parameter);
        let sides = [last, &other].map(|one| one.cycle.outline.modes());
        let uncertainty = at_least((parameter, (off / slope).abs()), way.abs(), way.abs());
        let place = (parameter, uncertainty);
        Some(describe(system, (&at.cycle, margin), place, sides))
    }

    /// The change at which the orbits end with none behind it: a margin goes to zero like a square
    /// root of the parameter.
    fn ends_in(&self, good: &[OrbitAt], lost: f64) -> Option<SequenceChange> {
        const NEAR: f64 = 10.0;
        let last = good.last()?;
        let bracket = (lost - last.parameter).abs();
        let zero = |margin: &Margin| {
            let square =
                |one: &OrbitAt| one.cycle.margin_like(margin).map(|at| at.value * at.value);
            let own = square(last)?;
            let apart = |one: &&OrbitAt| square(one).is_some_and(|other| other >= 2.0 * own);
            let apart = good.iter().rev().find(apart)?;
            let way = own * (last.parameter - apart.parameter) / (square(apart)? - own);
            (way.abs() <= NEAR * bracket).then_some(way)
        };
        let arrivals = last.cycle.margins.iter();
        let arrivals = arrivals.filter(|margin| margin.key.kind == MarginKind::Arrival);
        let ways = arrivals.filter_map(|margin| Some((margin, zero(margin)?)));
        let (margin, way) = ways.min_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
        let guess = &last.cycle.outline;
        let finer = self.solve(last.parameter, guess, &self.options.finer());
        let by_tolerance = finer.and_then(|finer| {
            let value = finer.cycle.margin_like(margin)?.value;
            // The distance in the parameter is quadratic in the margin.
            Some(4.0 * (value / margin.value - 1.0).abs() * way.abs())
        });
        let system = &*(self.family)(last.parameter);
        let uncertainty = bracket.max(way.abs()) + by_tolerance.unwrap_or(0.0);
        let sides = [last.cycle.outline.modes(), Vec::new()];
        let place = (last.parameter + way, uncertainty);
        Some(describe(system, (&last.cycle, margin), place, sides))
    }

    fn vanishes_without(
        &self,
        last: &OrbitAt,
        numbers: &[usize],
        way: f64,
    ) -> Option<SequenceChange> {
        let OrbitAt { parameter, cycle } = last;
        let simple = cycle.outline.without(numbers, &cycle.begins)?;
        let one = self.solve(*parameter, &simple, &self.options)?;
        let margin = one.cycle.margin_about(cycle, numbers)?.clone();
        let value = |one: &Cycle| Some(one.margin_like(&margin)?.value);
        let begin = (*parameter, value(&one.cycle)?);
        let next = self.solve(parameter + 0.01 * way, &one.cycle.outline, &self.options)?;
        let both = [one, next];
        let path = self.between(&both);
        let [a, b] = path.bracket(begin, way, &value)?;
        let zero = path.zero([a, b], &value)?;
        let margin = zero.solution.margin_like(&margin)?;
        let is_valid = |other: &Margin| other.key == margin.key || !self.is_violated(other);
        if !zero.solution.margins.iter().all(is_valid) {
            return None;
        }
        let system = &*(self.family)(zero.parameter);
        let sides = [cycle.outline.modes(), simple.modes()];
        let place = (zero.parameter, uncertainty(&zero, b.0 - a.0));
        Some(describe(system, (&zero.solution, margin), place, sides))
    }

    /// Where the orbits end in an equilibrium of one of several modes on the way to another value,
    /// if anywhere.
    pub fn boundary_equilibrium(&self, way: &FollowedOrbits, to: f64) -> Option<WhatChanges> {
        let goes_on = way.lost.is_none() && way.change.is_none();
        if goes_on || self.forced.is_some() {
            return None;
        }
        let approach = |one: &OrbitAt| Approach::of(one.parameter, &one.cycle);
        let orbits: Vec<Approach> = way.good.iter().map(approach).collect();
        let held = |parameter: f64, mode, x: &Vector| {
            Held::near(&*(self.family)(parameter), mode, x, x.len())
        };
        let first = &self.first;
        let states = first.cycle.sizes.len();
        let (parameter, x) = ends_in(&orbits, first.cycle.extent, states, held)?;
        let part = (parameter - first.parameter) / (to - first.parameter);
        let is_on_way = part > 0.0 && part <= 1.0 + NEXT_TO;
        is_on_way.then_some(WhatChanges::BoundaryEquilibrium { parameter, x })
    }

    /// The first multiplier to reach the unit circle on the way, or the fold in which the orbit
    /// ends.
    pub fn multiplier(&self, way: &FollowedOrbits) -> Option<WhatChanges> {
        let of = |cycle: &Cycle| Critical::of(&cycle.monodromy, self.free);
        let one = |cycle: &Cycle| Some(of(cycle).one);
        let minus_one = |cycle: &Cycle| Some(of(cycle).minus_one);
        let circle = |cycle: &Cycle| of(cycle).circle;
        let functions: [&Function<'_>; 3] = [&one, &minus_one, &circle];
        for both in way.good.windows(2) {
            let [before, behind] = both else { continue };
            let gaps = [before, behind].map(|one| of(&one.cycle).gap_to_one());
            // Near a fold rounding decides the sign.
            let is_noise = gaps[0].max(gaps[1]) < NEAR_ONE;
            for (kind, function) in functions.into_iter().enumerate() {
                let ends = [before, behind].map(|one| function(&one.cycle));
                let [Some(a), Some(b)] = ends else { continue };
                if a * b >= 0.0 || kind == 0 && is_noise {
                    continue;
                }
                let ends = [(before.parameter, a), (behind.parameter, b)];
                let Some(zero) = self.between(both).zero(ends, function) else {
                    continue;
                };
                let what = match kind {
                    0 => Special::BranchPoint,
                    1 => Special::Flip,
                    _ => Special::NeimarkSacker {
                        angle: of(&zero.solution).angle,
                    },
                };
                let place = (
                    zero.parameter,
                    uncertainty(&zero, behind.parameter - before.parameter),
                );
                return Some(changed(&zero.solution, place, what));
            }
        }
        let (last, lost) = (way.good.last()?, way.lost?);
        if of(&last.cycle).gap_to_one() >= NEAR_ONE {
            return None;
        }
        // There the square of the function goes to zero linearly in the parameter.
        let square = |one: &OrbitAt| of(&one.cycle).one * of(&one.cycle).one;
        let own = square(last);
        // Nearer to it, an orbit closes within the tolerance although none exists.
        const LEAST: f64 = 1e-10;
        const APART: f64 = 4.0;
        const NODES: usize = 4;
        let mut nodes: Vec<(f64, &OrbitAt)> = Vec::new();
        for one in way.good.iter().rev() {
            let value = square(one);
            let is_apart = nodes.last().is_none_or(|(near, _)| value >= APART * near);
            if value >= own.max(LEAST) && is_apart && nodes.len() < NODES {
                nodes.push((value, one));
            }
        }
        let at_zero = |nodes: &[(f64, &OrbitAt)]| -> f64 {
            let values: Vec<f64> = nodes.iter().map(|node| node.0).collect();
            let weighted = weights(&values, 0.0).into_iter().zip(nodes);
            weighted
                .map(|(weight, node)| weight * node.1.parameter)
                .sum()
        };
        let (value, nearest) = *nodes.first()?;
        let (farthest, other) = *nodes.last()?;
        let parameter = at_zero(&nodes);
        let lacks = match nodes.len() {
            0..NODES => (lost - nearest.parameter).abs(),
            _ => {
                let fewer = [&nodes[..NODES - 1], &nodes[1..]].map(at_zero);
                fewer.iter().map(|one| (parameter - one).abs()).sum()
            }
        };
        const SAFE: f64 = 2.0;
        let slope = (nearest.parameter - other.parameter) / (value - farthest);
        let guess = &nearest.cycle.outline;
        let finer = self.solve(nearest.parameter, guess, &self.options.finer());
        let by_tolerance = finer.map_or(f64::NAN, |finer| ((square(&finer) - value) * slope).abs());
        let off = lacks + SAFE * by_tolerance;
        let bracket = (lost - nearest.parameter).abs();
        let uncertainty = at_least(
            (parameter, off),
            bracket,
            (lost - self.first.parameter).abs(),
        );
        Some(changed(
            &last.cycle,
            (parameter, uncertainty),
            Special::Fold,
        ))
    }
}

fn changed(at: &Cycle, (parameter, uncertainty): (f64, f64), what: Special) -> WhatChanges {
    WhatChanges::Multiplier {
        parameter,
        uncertainty,
        what,
        x: at.anchor.x.clone(),
        period: at.period,
    }
}

/// Uncertainty of the parameter at a zero located in an interval of this width. Where another
/// branch meets this one no orbit can be computed, so the zero lies in the interval.
fn uncertainty(zero: &Zero, width: f64) -> f64 {
    at_least((zero.parameter, zero.uncertainty), width.abs(), width.abs())
}

/// Derivative of the unknowns by the parameter, from the last two orbits.
fn slope(good: &[OrbitAt]) -> Option<Vector> {
    let [.., one, two] = good else { return None };
    let way = two.cycle.outline.unknowns() - one.cycle.outline.unknowns();
    Some(way / (two.parameter - one.parameter))
}

/// The first place up to another at which the duration of a segment would vanish.
fn vanishing(good: &[OrbitAt], by: f64) -> Option<f64> {
    vanishing_by(good, by).first().map(|(_, place)| *place)
}

/// The segments whose durations would vanish up to a place, ordered by where they vanish, and that
/// place.
fn vanishing_by(good: &[OrbitAt], by: f64) -> Vec<(usize, f64)> {
    let (Some(last), Some(slope)) = (good.last(), slope(good)) else {
        return Vec::new();
    };
    let from = last.parameter;
    let places = last.cycle.outline.vanishing(&slope, by - from);
    let places = places.into_iter();
    places.map(|(k, way)| (k, from + way)).collect()
}
