//! Where between two values of a parameter an attractor changes.

use std::cell::RefCell;

use super::stability::{NEXT_TO, loss_of_stability};
use super::{Family, Reached, WhatChanges};
use crate::analysis::anchor::Anchor;
use crate::analysis::attractors::{Kind, is_same_cycle};
use crate::analysis::boundary_equilibrium::{Held, ends_in};
use crate::analysis::continuation::Special;
use crate::analysis::periodic::shoot;
use crate::analysis::sequence::circuit::Circuit;
use crate::analysis::sequence::locate::{self, Known, is_same, least};
use crate::analysis::sequence::{
    Orbits, Place, SequenceBifurcation, SequenceChange, circuit_from, describe,
};
use crate::dynamics::{Modes, Moment, Vector};
use crate::filippov::Options;

/// Part of the interval to which a change is located.
const RESOLUTION: f64 = 1e-10;

/// First step on the way, as a part of it, and by how much each is longer than the one before.
const FIRST: f64 = 1.0 / 64.0;
const GROWTH: f64 = 1.3;

/// A change is taken from the side with more phases where its uncertainty is less than this part of that from the other one.
const NEARER: f64 = 0.1;

/// How much shorter the first step is where the orbit was lost without a change.
const SHORTER: f64 = 0.1;

/// Part of the first step within which the orbit is lost again where it ends.
const STUCK: f64 = 1e-3;

/// A value of the parameter and what was found there.
type End<'a> = (f64, &'a Reached);

/// What becomes of the attractor between two values: where it ends, and, if that is another place and not the same change, where the other one begins.
pub(super) fn locate<'a>(
    family: &'a Family<'a>,
    ends: [End<'_>; 2],
    forcing: Option<f64>,
    options: &Options,
) -> Vec<WhatChanges> {
    let [one, other] = ends;
    let first = Seen::from(family, (one, other), forcing, options);
    let second = Seen::from(family, (other, one), forcing, options).turned_round();
    let width = other.0 - one.0;
    let are_two = match (first.place(), second.place()) {
        (Some(a), Some(b)) => (a - b).abs() > NEXT_TO * width.abs(),
        _ => false,
    };
    let phases = ends.map(|end| end.1);
    if are_two && !first.joins(phases) && !second.joins(phases) {
        return [first, second].into_iter().filter_map(Seen::best).collect();
    }
    let named = if first.joins(phases) || !second.joins(phases) {
        first.named.or(second.named)
    } else {
        second.named
    };
    let others = first
        .smooth
        .or(second.smooth)
        .or(first.unnamed)
        .or(second.unnamed);
    vec![named.or(others).unwrap_or(WhatChanges::Unlocated)]
}

/// What is seen of a change from one of its sides.
struct Seen {
    /// By an event function that vanishes, or the loss of an equilibrium.
    named: Option<WhatChanges>,
    /// By a multiplier.
    smooth: Option<WhatChanges>,
    /// By other phases only.
    unnamed: Option<WhatChanges>,
}

impl Seen {
    fn from<'a>(
        family: &'a Family<'a>,
        (from, to): (End<'_>, End<'_>),
        forcing: Option<f64>,
        options: &Options,
    ) -> Self {
        let mut seen = Seen {
            named: None,
            smooth: None,
            unnamed: None,
        };
        let (returns, period) = match from.1.kind {
            Kind::Periodic { returns, period } => (returns, period),
            Kind::Equilibrium => {
                seen.named = loss_of_stability(family, from, to.0);
                return seen;
            }
            _ => return seen,
        };
        let shooting = Shooting {
            family,
            // The forcing's own period is known better.
            forced: forcing.map(|one| one * returns as f64),
            options: *options,
        };
        let Some(way) = shooting.follow(from, period, to.0) else {
            return seen;
        };
        // Next to it a graze would be named: all of the orbit comes to the boundary.
        seen.named = shooting.boundary_equilibrium(&way, to.0);
        if seen.named.is_some() {
            return seen;
        }
        match shooting.change(&way) {
            Some(found) if found.bifurcation != SequenceBifurcation::Unnamed => {
                seen.named = Some(WhatChanges::Sequence(found));
            }
            found => {
                // Where nothing else was found either, the orbit was lost, and that is no change.
                let other = found.filter(|one| !one.after.is_empty());
                seen.unnamed = other.map(WhatChanges::Sequence);
                seen.smooth = shooting.multiplier(&way);
            }
        }
        seen
    }

    /// The same, of which what was before is behind.
    fn turned_round(mut self) -> Self {
        for what in [&mut self.named, &mut self.unnamed] {
            if let Some(WhatChanges::Sequence(change)) = what {
                std::mem::swap(&mut change.before, &mut change.after);
            }
        }
        self
    }

    /// A place at which an orbit begins or ends: of a change of its phases, or a fold.
    fn place(&self) -> Option<f64> {
        match (&self.named, &self.smooth) {
            (Some(WhatChanges::Sequence(change)), _) => Some(change.parameter),
            (
                None,
                Some(WhatChanges::Multiplier {
                    parameter,
                    what: Special::Fold,
                    ..
                }),
            ) => Some(*parameter),
            _ => None,
        }
    }

    /// Whether it is a change of the phases of one attractor into those of the other, or what has no such sides.
    fn joins(&self, ends: [&Reached; 2]) -> bool {
        match &self.named {
            Some(WhatChanges::Sequence(change)) => {
                let sides = [&change.before, &change.after];
                sides.into_iter().zip(ends).all(|(modes, end)| {
                    let phases: Vec<Modes> = end.phases.iter().map(|phase| phase.mode).collect();
                    is_same_cycle(modes, &phases)
                })
            }
            Some(_) => true,
            None => false,
        }
    }

    fn best(self) -> Option<WhatChanges> {
        self.named.or(self.smooth)
    }
}

/// Periodic orbits of a family by shooting.
pub(super) struct Shooting<'a> {
    pub(super) family: &'a Family<'a>,
    /// The period, where it is that of the forcing.
    pub(super) forced: Option<f64>,
    pub(super) options: Options,
}

/// An orbit followed from one value towards another, as far as its phases stay the same.
pub(super) struct Way {
    pub(super) good: Vec<Known<()>>,
    /// Where it has other phases, or is not found, next to the last of these; none where it goes on all the way.
    pub(super) bad: Option<f64>,
    /// With other phases.
    behind: Option<Known<()>>,
    resolution: f64,
}

impl Shooting<'_> {
    /// The same with a tenth of the tolerances.
    pub(super) fn finer(&self) -> Self {
        Shooting {
            options: self.options.finer(),
            ..*self
        }
    }

    /// Follows the orbit on the way to another value.
    fn follow(&self, from: End<'_>, period: f64, to: f64) -> Option<Way> {
        let start = self.start(from.1)?;
        let rough = circuit_from(&*(self.family)(from.0), &start, period, &self.options)?;
        let first = self.orbit(from.0, &rough.anchor, rough.period)?;
        let mut good = vec![first];
        let behind: RefCell<Option<Known<()>>> = RefCell::new(None);
        let mut solve = |s: f64, good: &[Known<()>]| {
            let found = self.by_line(s, good);
            let first = good.first()?;
            let is_other = |one: &Known<()>| {
                !is_same(&one.circuit.sequence(), &first.circuit.sequence())
                    && first.is_as_certain(one)
            };
            if let Some(other) = found.as_ref().filter(|one| is_other(one)) {
                behind.replace(Some(other.clone()));
            }
            found
        };
        // In small steps, so that it is this orbit that is followed and not another one near by.
        let mut first_step = FIRST * (to - from.0);
        let resolution = RESOLUTION * (to - from.0).abs();
        let bad = loop {
            let begun_at = good.last()?.s;
            behind.replace(None);
            let mut step = first_step;
            let stopped = loop {
                let last = good.last()?;
                let at = last.s;
                if at == to {
                    break None;
                }
                let goes_on = (to - at) / step > 1.0;
                let next = if goes_on { at + step } else { to };
                match solve(next, &good) {
                    Some(found) if last.goes_on_in(&found) => good.push(found),
                    _ => break Some(next),
                }
                step *= GROWTH;
            };
            let Some(stopped) = stopped else { break None };
            let bad = locate::locate(&mut good, stopped, resolution, &mut solve);
            let last = good.last()?;
            let is_change = least(&last.circuit).is_some_and(|margin| margin.vanishes());
            let advanced = (last.s - begun_at).abs();
            // Where no event function vanishes the orbit may only have been missed by too long a step.
            if is_change || advanced < STUCK * first_step.abs() || first_step.abs() < resolution {
                break Some(bad);
            }
            first_step *= SHORTER;
        };
        Some(Way {
            good,
            bad,
            behind: behind.into_inner(),
            resolution,
        })
    }

    /// Where its phases change, if they do.
    fn change(&self, way: &Way) -> Option<SequenceChange> {
        let (bad, last) = (way.bad?, way.good.last()?);
        let system = (self.family)(last.s);
        let after = way.behind.as_ref().map(|other| other.circuit.modes());
        let after = after.unwrap_or_default();
        let place = Place::in_parameter(&way.good, bad)?;
        let about = About {
            shooting: self,
            good: &way.good,
        };
        let here = describe(&*system, &way.good, after, place, &about);
        // From the side with fewer phases all event functions are smooth, and a graze is no root.
        let simple = way
            .behind
            .as_ref()
            .filter(|one| one.circuit.parts.len() < last.circuit.parts.len());
        let there = simple.and_then(|simple| self.back_from(last, simple, way.resolution));
        // An unstable orbit there may be lost further away than this one here.
        let is_nearer = |one: &SequenceChange, other: &SequenceChange| {
            one.bifurcation == other.bifurcation && one.uncertainty < NEARER * other.uncertainty
        };
        match (there, here) {
            (Some(there), Some(here)) if is_nearer(&here, &there) => Some(here),
            (Some(there), _) => Some(there),
            (None, here) => here,
        }
    }

    /// Where it ends in an equilibrium of one of several modes on the way to another value, if it
    /// does.
    fn boundary_equilibrium(&self, way: &Way, to: f64) -> Option<WhatChanges> {
        let first = way.good.first()?;
        if way.bad.is_none() || self.forced.is_some() {
            return None;
        }
        let orbits: Vec<_> = way.good.iter().collect();
        let held = |parameter: f64, mode, x: &Vector| {
            Held::near(&*(self.family)(parameter), mode, x, x.len())
        };
        let states = first.circuit.sizes.len();
        let widest = first.circuit.extent;
        let (parameter, x) = ends_in(&orbits, widest, states, |one| one.s, held)?;
        let part = (parameter - first.s) / (to - first.s);
        let is_on_way = part > 0.0 && part <= 1.0 + NEXT_TO;
        is_on_way.then_some(WhatChanges::BoundaryEquilibrium { parameter, x })
    }

    /// A state of the orbit: where a phase begins in which all contacts slip, for stick forgets what came before, and with it by how much the
    /// start is off; where there is none, or with a forcing, where the section or the strobe sees it.
    fn start(&self, reached: &Reached) -> Option<Moment> {
        let mut phases = reached.phases.iter();
        let slip = phases.find(|phase| self.forced.is_none() && !phase.mode.any_sticks());
        let begin = slip.map(|phase| (phase.t_start, &phase.x_start));
        let (t, x) = begin.or_else(|| reached.points.first().map(|at| (at.t, &at.x)))?;
        Some(Moment { t, x: x.clone() })
    }

    /// The change as it is seen from an orbit with fewer phases on the other side of it, or beside it where the branch turns back.
    fn back_from(
        &self,
        edge: &Known<()>,
        simple: &Known<()>,
        resolution: f64,
    ) -> Option<SequenceChange> {
        let way = edge.s - simple.s;
        let way = way.abs().max(1e4 * resolution) * way.signum();
        [0.3 * way, -0.3 * way].into_iter().find_map(|step| {
            let solve = |s: f64, good: &[_]| self.by_line(s, good);
            let (good, bad) = locate::approach(simple.clone(), step, resolution, solve)?;
            let last = good.last()?;
            let place = Place::in_parameter(&good, bad)?;
            let after = last.circuit.modes();
            let about = About {
                shooting: self,
                good: &good,
            };
            let system = (self.family)(last.s);
            let mut found = describe(&*system, &good, after, place, &about)?;
            (found.before, found.after) = (edge.circuit.modes(), found.before);
            (found.bifurcation != SequenceBifurcation::Unnamed).then_some(found)
        })
    }

    /// The orbit at a parameter by those known.
    fn by_line(&self, parameter: f64, good: &[Known<()>]) -> Option<Known<()>> {
        let (guess, period) = extrapolated(good, parameter)?;
        self.orbit(parameter, &guess, period)
    }

    pub(super) fn orbit(&self, parameter: f64, guess: &Anchor, period: f64) -> Option<Known<()>> {
        let system = &*(self.family)(parameter);
        let is_forced = self.forced.is_some();
        let period = self.forced.unwrap_or(period);
        // Only the forcing knows the time.
        let at = guess.at_time(if is_forced { guess.t } else { 0.0 });
        let (cycle, closing) = shoot(system, &at, period, is_forced, &self.options).ok()?;
        let start = Anchor::new(cycle.t, cycle.x, guess.mode);
        let circuit = Circuit::follow(system, &start, cycle.period, &self.options).ok()?;
        let circuit = circuit.that_closes(system, &start, &closing, &self.options);
        Some(Known {
            s: parameter,
            circuit,
            branch: (),
        })
    }
}

/// The orbits up to a change.
struct About<'b, 'a> {
    shooting: &'b Shooting<'a>,
    good: &'b [Known<()>],
}

impl Orbits<()> for About<'_, '_> {
    fn at(&self, parameter: f64, new: &[Known<()>]) -> Option<Known<()>> {
        self.shooting.by_line(parameter, &[self.good, new].concat())
    }

    fn finer(&self, orbit: &Known<()>) -> Option<Circuit> {
        let Circuit { anchor, period, .. } = &orbit.circuit;
        let finer = self.shooting.finer().orbit(orbit.s, anchor, *period);
        Some(finer?.circuit)
    }
}

/// Where the orbit is expected by those known: on the line through two of them, no further than they are apart.
pub(in crate::analysis) fn extrapolated<B>(good: &[Known<B>], s: f64) -> Option<(Anchor, f64)> {
    let last = good.last()?;
    let Some(([one, two], part)) = pair_for(good, s) else {
        return Some((last.circuit.anchor.clone(), last.circuit.period));
    };
    let (a, b) = (&one.circuit, &two.circuit);
    let t = b.anchor.t + part * (b.anchor.t - a.anchor.t);
    let x = &b.anchor.x + (&b.anchor.x - &a.anchor.x) * part;
    let guess = Anchor::new(t, x, b.anchor.mode);
    Some((guess, b.period + part * (b.period - a.period)))
}

/// The last orbit, one before it that is at least as far from it as the place is, if there is such a one, and how far beyond the last the place is, in
/// parts of the way between the two.
pub(in crate::analysis) fn pair_for<B>(good: &[Known<B>], s: f64) -> Option<([&Known<B>; 2], f64)> {
    let (two, before) = good.split_last()?;
    let is_apart = |one: &&Known<B>| (one.s - two.s).abs() >= (s - two.s).abs();
    let apart = before.iter().rev().find(is_apart);
    let one = apart.or_else(|| {
        let away = |one: &&Known<B>| (one.s - two.s).abs();
        before.iter().max_by(|a, b| away(a).total_cmp(&away(b)))
    })?;
    let part = (s - two.s) / (two.s - one.s);
    (two.s != one.s).then_some(([one, two], part.clamp(-1.0, 1.0)))
}
