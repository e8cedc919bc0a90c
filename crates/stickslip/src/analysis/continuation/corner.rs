//! The branch behind a change of phases, where the line through its orbits may not lead to it: it may turn back.

use super::corrector::{Corrector, Guess, OnBranch, Solved, parameter, with_parameter};
use super::walk::RESOLUTION;
use crate::analysis::anchor::Anchor;
use crate::analysis::sequence::circuit::Circuit;
use crate::analysis::sequence::locate::{Known, approach};
use crate::analysis::sequence::{Orbits, Place, SequenceBifurcation, SequenceChange, describe};
use crate::dynamics::Vector;

/// Distances in the parameter, as parts of its range, at which orbits with other phases are tried.
pub(super) const DISTANCES: [f64; 4] = [1e-5, 1e-4, 1e-3, 1e-2];

/// How far the orbit may lie from the corner by the way across the flow that the orbits before it have come. Where stick forgets all, and the
/// other orbit has the multiplier λ, it is 1/(1 - λ) of that.
const PARTS: [f64; 8] = [-2.0, -4.0, -1.0, -8.0, -0.5, -16.0, 0.0, 1.0];

/// How many times as far as by the way that has come the orbit may lie.
const FURTHEST: f64 = 32.0;

/// Orbits behind the corner lead back to it by the line through two of them, or as a root does, but for this part of the way.
const OFF: f64 = 0.15;

/// Nearer orbits than this, on the line, do not show where they lead.
const RESOLVED: f64 = 1e-8;

/// What is left of a way where an orbit comes back, in parts of its extent, is rounding.
const SAME: f64 = 1e-9;

/// Part of the parameter's range within which a change that is seen from behind is the one that was come to.
const NEAR: f64 = 1e-3;

/// What was found around a change of phases.
pub(super) struct Behind<'a> {
    pub corrector: &'a Corrector<'a>,
    /// The orbits up to it.
    pub good: &'a [OnBranch],
    /// Orbits with other phases, the nearest one first.
    pub found: &'a [OnBranch],
    /// Width of the parameter's range.
    pub width: f64,
}

/// The change and two orbits behind it, the nearer one first.
pub(super) struct Entered {
    pub change: SequenceChange,
    /// A state on the orbit at the change.
    pub x: Vector,
    pub orbits: Option<[OnBranch; 2]>,
}

impl Behind<'_> {
    /// Describes the change, which was located, and gets behind it.
    pub fn enter(&self, place: Place) -> Option<Entered> {
        let edge = self.good.last()?;
        let mut around = None;
        let mut other = self.found.first().cloned();
        if other.is_none() {
            around = self.around();
            other = around.as_ref().map(|[near, _]| near.clone());
        }
        // From the side with fewer phases all event functions are smooth, and a graze is no root.
        let is_simple = |one: &&OnBranch| one.circuit.parts.len() < edge.circuit.parts.len();
        let simple = self.found.iter().chain(other.as_ref()).filter(is_simple);
        let mut simple: Vec<_> = simple.collect();
        // Those next to it may have some of the phases only, of two changes at once.
        simple.sort_by_key(|one| one.circuit.parts.len());
        simple.dedup_by_key(|one| one.circuit.sequence());
        // An orbit that goes no way is not one that the branch becomes, unless there is no other.
        let found = |fewest: usize| simple.iter().find_map(|one| self.back_from(one, fewest));
        if let Some(mut entered) = found(2).or_else(|| found(1)) {
            // Next to the corner the orbits on that side may be too near to each other.
            entered.orbits = entered.orbits.or_else(|| around.or_else(|| self.around()));
            return Some(entered);
        }
        let after = other.as_ref().map(|one| one.circuit.modes());
        let change = describe(
            self.corrector.system,
            self.good,
            after.unwrap_or_default(),
            place,
            &About::of(self.corrector, self.good),
        )?;
        let is_apart = |one: &&OnBranch| one.s - edge.s > RESOLVED;
        let near = self.found.iter().find(is_apart).cloned();
        let far = near.as_ref().and_then(|near| {
            let is_same = |one: &&OnBranch| {
                one.circuit.sequence() == near.circuit.sequence() && one.s - near.s > 1e-7
            };
            self.found.iter().rev().find(is_same).cloned()
        });
        if !self.found.is_empty() {
            let at = &edge.circuit.anchor;
            let pair = || {
                let (near, far) = (near?, far?);
                self.leads_on(at, &near, &far).then_some([near, far])
            };
            around = self.around().or_else(pair);
        }
        let orbits = around;
        let x = edge.circuit.anchor.x.clone();
        Some(Entered { change, orbits, x })
    }

    /// Comes back to the change from an orbit with fewer phases behind it, by so many orbits at least.
    fn back_from(&self, simple: &OnBranch, fewest: usize) -> Option<Entered> {
        let edge = self.good.last()?;
        let (corner, here) = (edge.parameter(), simple.parameter());
        let least = 1e-6 * self.width;
        let way = (corner - here).abs().max(least) * (corner - here).signum();
        for step in [0.3 * way, -0.3 * way] {
            let mut first = simple.clone();
            first.s = here;
            let by_parameter = |s: f64, good: &[OnBranch]| self.corrector.by_parameter(good, s);
            let resolution = RESOLUTION * self.width;
            let Some((good, bad)) = approach(first, step, resolution, by_parameter) else {
                continue;
            };
            let last = good.last()?;
            if good.len() < fewest {
                continue;
            }
            // Far from here it is another change.
            if (last.s - corner).abs() > NEAR * self.width {
                continue;
            }
            let place = Place::in_parameter(&good, bad)?;
            let before = last.circuit.modes();
            let about = About::of(self.corrector, &good);
            let mut change = describe(self.corrector.system, &good, before, place, &about)?;
            if change.bifurcation == SequenceBifurcation::Unnamed {
                continue;
            }
            (change.before, change.after) = (edge.circuit.modes(), change.before);
            // Away from it again, by an orbit that is far enough to show the way.
            let apart = good.iter().rev().find(|one| (one.s - last.s).abs() > least);
            let further = || {
                // Next to the corner rounding may have taken one side for the other.
                let away = DISTANCES.map(|part| -0.1 * step.signum() * part * self.width);
                let ways = away.into_iter().chain(away.map(|way| -way));
                ways.map(|way| last.s + way).find_map(|s| {
                    let found = self.corrector.next_at(last, s)?;
                    last.goes_on_in(&found).then_some(found)
                })
            };
            let far = apart.cloned().or_else(further);
            let orbits = far.map(|far| [last.clone(), far]);
            let x = last.circuit.anchor.x.clone();
            return Some(Entered { change, orbits, x });
        }
        None
    }

    /// Two orbits next to the last one with other phases than it, the nearer one first.
    fn around(&self) -> Option<[OnBranch; 2]> {
        let corner = self.good.last()?;
        let at = &corner.circuit.anchor;
        let here = corner.parameter();
        let is_apart = |one: &&OnBranch| (one.parameter() - here).abs() > 1e-6 * self.width;
        let before = self.good.iter().rev().find(is_apart)?;
        let way = self.corrector.way(&before.circuit.anchor, at);
        let heading = parameter(&way);
        let slope = way / heading;
        let old = corner.circuit.sequence();
        let orbit = |x: Vector, period: f64| {
            let parameter = parameter(&x);
            let guess = Guess::at_parameter(&at.moved(x), period, parameter);
            let found = self.corrector.orbit(&guess, parameter)?;
            let is_other = found.circuit.sequence() != old && corner.is_as_certain(&found);
            is_other.then_some(found)
        };
        for distance in DISTANCES.map(|part| part * self.width * heading.signum()) {
            for offset in [distance, -distance] {
                for part in PARTS {
                    let guess = &at.x + &slope * (offset * part);
                    let guess = with_parameter(guess, here + offset);
                    let pair = |period: f64| {
                        let near = orbit(guess.clone(), period)?;
                        // Another orbit with other phases may be at the same parameter, but further off.
                        let off = &near.branch.start.x - &at.x;
                        if off.norm() > FURTHEST * offset.abs() * slope.norm() {
                            return None;
                        }
                        let further = &near.branch.start.x + (&guess - &at.x) * 0.5;
                        let far = orbit(further, near.circuit.period)?;
                        let is_same = far.circuit.sequence() == near.circuit.sequence();
                        (is_same && self.leads_on(at, &near, &far)).then_some([near, far])
                    };
                    let period = corner.circuit.period;
                    // Where static friction lets go, the orbit and its period change by a jump behind the same state.
                    let by_return = || {
                        let states = slope.rows(0, slope.len() - 1).norm();
                        let distance = FURTHEST * offset.abs() * states;
                        let distance = distance.max(SAME * self.corrector.extent);
                        let there = at.moved(guess.clone());
                        pair(self.corrector.comes_back(&there, period, distance)?)
                    };
                    if let Some(orbits) = pair(period).or_else(by_return) {
                        return Some(orbits);
                    }
                }
            }
        }
        None
    }

    /// Whether the way from the last orbit's state goes by the first of two to the second, with no fold between these, and they lead back to it: by
    /// the line through them, or as a root does. All three are where Newton's iteration was at this state's time: the middle of a phase may be of
    /// another one.
    fn leads_on(&self, at: &Anchor, near: &OnBranch, far: &OnBranch) -> bool {
        let [first, second] = [near, far].map(|one| &one.branch.start.x);
        let is_forced = self.corrector.forced.is_some();
        let [a, b] = [near, far].map(|one| one.branch.critical(is_forced).one);
        let scale = Vector::repeat(first.len(), self.corrector.extent.recip());
        let scale = with_parameter(scale, self.width.recip());
        let (way, on) = (first - &at.x, second - first);
        let (way, on) = (way.component_mul(&scale), on.component_mul(&scale));
        // How many times as far the second is along the parameter.
        let times = 1.0 + parameter(&on) / parameter(&way);
        if way.dot(&on) <= 0.0 || a * b <= 0.0 || !(times > 1.0 && times.is_finite()) {
            return false;
        }
        let by_line = on / (times - 1.0);
        let of_root = 1.0 - 1.0 / (times.sqrt() + 1.0);
        (&way - by_line).norm() <= (OFF + of_root) * way.norm()
    }
}

/// The orbits up to a change, each with the parameter as its place.
struct About<'a> {
    corrector: &'a Corrector<'a>,
    good: Vec<OnBranch>,
}

impl<'a> About<'a> {
    fn of(corrector: &'a Corrector<'a>, good: &[OnBranch]) -> Self {
        let by_parameter = |one: &OnBranch| Known {
            s: one.parameter(),
            ..one.clone()
        };
        About {
            corrector,
            good: good.iter().map(by_parameter).collect(),
        }
    }
}

impl Orbits<Solved> for About<'_> {
    fn at(&self, parameter: f64, new: &[OnBranch]) -> Option<OnBranch> {
        self.corrector
            .by_parameter(&[&self.good, new].concat(), parameter)
    }

    fn finer(&self, orbit: &OnBranch) -> Option<Circuit> {
        let Circuit { anchor, period, .. } = &orbit.circuit;
        let guess = Guess::at_parameter(anchor, *period, orbit.parameter());
        Some(self.corrector.finer(&guess, orbit.s)?.circuit)
    }
}
