//! Location of the change of an attractor between two values of a parameter.

use std::ops::ControlFlow;

use super::{NotFollowed, SweepPoint, WhatChanges};
use crate::analysis::attractors::equilibrium::newton_step_at;
use crate::analysis::attractors::{Attractor, AttractorKind, shifts};
use crate::analysis::continuation::{
    Continuation, ContinuationSettings, CycleBifurcation, EquilibriumBifurcation,
    EquilibriumBranch, Stop, is_led, same_attractor,
};
use crate::analysis::cycle::StepBudget;
use crate::dynamics::{Dynamics, DynamicsRef, Moment, Vector};
use crate::filippov::Options;

/// A change counts as hit by a value of the sweep up to this distance behind it, as a fraction of
/// the interval. Chosen: far above rounding. Two changes that are nearer count as one.
pub(super) const NEXT_TO: f64 = 1e-6;

/// Longest step between the values, as a fraction of the interval and of the orbit's size: without
/// a budget, and within one. Chosen: steps are shortened where that is too long. Longer ones save
/// half the orbits, and may pass two changes that undo each other.
const LONGEST_STEP: f64 = 0.1;
const LONGEST_STEP_WITHIN_BUDGET: f64 = 0.5;

/// Most loops of an orbit that is followed within a budget where the other attractor is irregular.
/// Chosen: an orbit of more loops ends in a cascade of flips, of which only the first is that
/// orbit's, or belongs to a window far narrower than the interval.
const MOST_LOOPS_BESIDE_CHAOS: usize = 8;

/// The changes between two values: where the first attractor ends and, if that is elsewhere, where
/// the second one begins. With a budget, an orbit is not followed if it has many loops, or if what
/// is left would not do.
pub(super) fn locate(
    system: &dyn Dynamics,
    ends: [&SweepPoint; 2],
    forcing: Option<f64>,
    (options, budget): (&Options, Option<&StepBudget>),
) -> Vec<WhatChanges> {
    let [one, other] = ends;
    let is_beside_chaos = ends.iter().any(|end| is_irregular(&end.reached));
    let most = match budget {
        Some(_) if is_beside_chaos => MOST_LOOPS_BESIDE_CHAOS,
        _ => usize::MAX,
    };
    let loops = ends.map(|end| loops(&end.reached, forcing.is_some()));
    let phases = ends.map(|end| &end.reached);
    let is_quiet = !phases[0].is_changed_to(phases[1]);
    let (mut found, mut why_not) = ([LocatedChange::default(), LocatedChange::default()], None);
    // The orbit of fewer loops takes fewer steps, and may explain the other one.
    let are_orbits = loops.iter().all(|&loops| loops > 0);
    let order = if are_orbits && loops[1] < loops[0] {
        [1, 0]
    } else {
        [0, 1]
    };
    for from in order {
        let is_explained = |from: usize| {
            let doubles = found[from].is_flip() && is_double(phases[1 - from], phases[from]);
            are_orbits && (doubles || found[from].connects(phases))
        };
        if is_explained(1 - from) {
            why_not = None;
            break;
        }
        if loops[from] > most {
            why_not = Some(NotFollowed::Loops(loops[from]));
            continue;
        }
        let is_short = |budget: &StepBudget| budget.left() < needed(&ends[from].reached);
        if budget.is_some_and(is_short) {
            why_not = Some(NotFollowed::Budget);
            continue;
        }
        let towards = [ends[from], ends[1 - from]];
        let located = LocatedChange::from(system, towards, forcing, (options, budget));
        // One branch has both, and nothing happens on it.
        if is_quiet && located.arrives == Some(true) && located.smooth.is_none() {
            return Vec::new();
        }
        // What ends for want of steps looks as if it had no continuation.
        if budget.is_some_and(StepBudget::is_spent) {
            why_not = Some(NotFollowed::Budget);
            continue;
        }
        found[from] = if from == 0 {
            located
        } else {
            located.reversed()
        };
    }
    let leads = found.each_ref().map(|one| one.arrives);
    let [first, second] = found;
    let width = other.parameter - one.parameter;
    let places = [first.place(), second.place()];
    let connects = [&first, &second].map(|one| one.connects(phases));
    let found = match (connects, places) {
        ([false, true], _) => [second.named, None],
        ([false, false], [Some(a), Some(b)]) if (a - b).abs() > NEXT_TO * width.abs() => {
            [first, second].map(|one| one.named.or(one.smooth))
        }
        _ => {
            let named = first.named.or(second.named);
            let smooth = match (first.smooth, second.smooth) {
                (Some(one), Some(other)) => Some(primary([one, other])),
                (one, other) => one.or(other),
            };
            [named.or(smooth), None]
        }
    };
    // The branch of one leads elsewhere, or it is not known where.
    let jumps = !is_quiet || leads.contains(&Some(false));
    let why_not = why_not.map(WhatChanges::NotFollowed);
    let found: Vec<WhatChanges> = found.into_iter().flatten().chain(why_not).collect();
    match found.is_empty() && jumps {
        true => vec![WhatChanges::Unlocated],
        false => found,
    }
}

/// Number of loops of a periodic orbit; 0 of other motions. With a forcing it is the number of its
/// periods, else that of the rarest transition.
fn loops(attractor: &Attractor, is_forced: bool) -> usize {
    let AttractorKind::Periodic { returns, .. } = attractor.kind else {
        return 0;
    };
    let all = &attractor.transitions;
    let count = |one: &_| all.iter().filter(|other| *other == one).count();
    let rarest = all.iter().map(count).min();
    rarest.filter(|_| !is_forced).unwrap_or(returns)
}

/// Whether an orbit has the transitions of another one twice.
fn is_double(double: &Attractor, single: &Attractor) -> bool {
    let (double, single) = (&double.transitions, &single.transitions);
    let count = single.len();
    let is_alike = |first: usize| {
        let mut pairs = double.iter().zip(single.iter().cycle().skip(first));
        pairs.all(|(one, other)| one == other)
    };
    double.len() == 2 * count && (0..count.max(1)).any(is_alike)
}

/// Estimated work to follow an attractor to its change, in steps without tangent vectors.
fn needed(attractor: &Attractor) -> u64 {
    // Orbits on a branch, with those that Newton's iterations, a zero and its uncertainty take.
    // Chosen: 75 to 150 in a cascade of flips.
    const ORBITS: f64 = 100.0;
    match attractor.kind {
        AttractorKind::Periodic { period, .. } => {
            let orbit = attractor.steps as f64 * period / attractor.t;
            let cost = StepBudget::with_tangents(attractor.x.len());
            (ORBITS * orbit * cost as f64) as u64
        }
        // An equilibrium takes no steps.
        _ => 0,
    }
}

/// Whether an attractor is quasi-periodic or chaotic, or none was found.
fn is_irregular(attractor: &Attractor) -> bool {
    matches!(
        attractor.kind,
        AttractorKind::Recurrent | AttractorKind::Undecided
    )
}

/// Selects of two names of one place the one by the orbit of the shorter period. The other orbit
/// begins there, and its multiplier 1 does not distinguish a flip from a fold.
pub(super) fn primary([one, other]: [WhatChanges; 2]) -> WhatChanges {
    let period = |change: &WhatChanges| match change {
        WhatChanges::Multiplier { period, .. } => *period,
        _ => f64::INFINITY,
    };
    match (one, other) {
        (WhatChanges::Unlocated | WhatChanges::NotFollowed(_), located) => located,
        (one, other) if period(&other) < period(&one) => other,
        (one, _) => one,
    }
}

/// Value at which the equilibrium loses its stability, or reaches the edge of its mode's domain.
fn equilibrium(
    system: &dyn Dynamics,
    [from, to]: [&SweepPoint; 2],
    upwards: bool,
    settings: &ContinuationSettings,
    options: &Options,
) -> Option<LocatedChange> {
    let x = extended(&from.reached.points.first()?.x, from.parameter);
    let system = DynamicsRef::Borrowed(system);
    let branch = EquilibriumBranch::through(&system, x, upwards, settings, options).ok()?;
    let Some(at) = branch.special.into_iter().next() else {
        let last = branch.points.last().map(|at| states(at.x.clone()));
        let at = &to.reached.points.first()?.x;
        let arrives = last.filter(|_| branch.stop == Stop::Range);
        let arrives = arrives.map(|last| {
            let off = last - at;
            is_led([&off, &(&off * 0.0)], &same_equilibrium(at, options))
        });
        return Some(LocatedChange {
            arrives,
            ..LocatedChange::default()
        });
    };
    let (parameter, x) = (at.parameter, states(at.x));
    let named = match at.what {
        EquilibriumBifurcation::Boundary { .. } => {
            WhatChanges::BoundaryEquilibrium { parameter, x }
        }
        EquilibriumBifurcation::Unresolved { .. } => WhatChanges::Unlocated,
        what => WhatChanges::Equilibrium {
            parameter,
            x,
            frequency: match what {
                EquilibriumBifurcation::Hopf { frequency } => frequency,
                _ => 0.0,
            },
        },
    };
    Some(LocatedChange {
        named: Some(named),
        ..LocatedChange::default()
    })
}

/// Finds the change of the phases of the orbit at a value, or its end; and the first multiplier to
/// reach the unit circle before.
fn orbit(
    system: &dyn Dynamics,
    [from, to]: [&SweepPoint; 2],
    (period, upwards): (f64, bool),
    settings: &ContinuationSettings,
    how: (&Options, Option<&StepBudget>),
) -> Option<LocatedChange> {
    let budget = how.1;
    let mut continuation = begun(system, from, (period, upwards), settings, how)?;
    let returns = match to.reached.kind {
        AttractorKind::Periodic { returns, .. } => returns,
        _ => 1,
    };
    let ends = |what: &CycleBifurcation| {
        matches!(what, CycleBifurcation::Sequence(_) | CycleBifurcation::Fold)
    };
    continuation.wanted = Some((ends, 0));
    let stop = continuation.go_on(&mut |_| ControlFlow::Continue(()));
    // Next to a boundary equilibrium the whole orbit comes to the boundary, and would graze it.
    let is_spent = budget.is_some_and(StepBudget::is_spent);
    if stop != Stop::Range
        && !is_spent
        && let Some((parameter, x)) = continuation.ends_at()
    {
        let x = states(x);
        return Some(LocatedChange {
            named: Some(WhatChanges::BoundaryEquilibrium { parameter, x }),
            ..LocatedChange::default()
        });
    }
    let mut located = LocatedChange {
        arrives: match (&stop, on_orbit(to, settings)) {
            (Stop::Range, Some(at)) => Some(continuation.is_at(&at, returns)),
            _ => None,
        },
        ..LocatedChange::default()
    };
    for at in continuation.into_branch(stop).special {
        match at.what {
            CycleBifurcation::Sequence(mut change) => {
                change.x = states(change.x);
                located.named = Some(WhatChanges::Sequence(*change));
            }
            what => {
                located.smooth.get_or_insert(WhatChanges::Multiplier {
                    parameter: at.parameter,
                    uncertainty: at.uncertainty,
                    what,
                    x: states(at.x),
                    period: at.period,
                    criticality: at.normal_form.and_then(|form| form.criticality()),
                });
            }
        }
    }
    Some(located)
}

/// The branch of an orbit at a value, begun there.
fn begun<'a>(
    system: &'a dyn Dynamics,
    from: &SweepPoint,
    (period, upwards): (f64, bool),
    settings: &'a ContinuationSettings,
    (options, budget): (&'a Options, Option<&'a StepBudget>),
) -> Option<Continuation<'a>> {
    let start = (on_orbit(from, settings)?.x, period, upwards);
    Continuation::begin(system, start, settings, (None, options), budget).ok()
}

/// The period of an orbit of a driven system.
fn forced(
    system: &dyn Dynamics,
    at: &SweepPoint,
    returns: usize,
    forcing: Option<f64>,
) -> Option<f64> {
    // The forcing's own period is known exactly.
    let drive = system.period(&extended(&at.reached.x, at.parameter));
    let drive = drive.map(|(period, _)| period);
    forcing.map(|one| drive.unwrap_or(one) * returns as f64)
}

/// Whether attractors that do not differ in kind or phases are where the tangents of their branches
/// lead from each other. Also where no tangent is known, as in a family.
pub(super) fn is_smooth(
    system: &dyn Dynamics,
    ends: [&SweepPoint; 2],
    forcing: Option<f64>,
    how: (&Options, Option<&StepBudget>),
) -> bool {
    if is_unmoved(ends.map(|at| &at.reached), how.0) {
        return true;
    }
    let both = match ends.map(|at| &at.reached.kind) {
        [
            &AttractorKind::Periodic {
                returns: one,
                period: of_one,
            },
            &AttractorKind::Periodic {
                returns: other,
                period: of_other,
            },
        ] => {
            let (returns, periods) = ([one, other], [of_one, of_other]);
            let settings = [0, 1].map(|k| ContinuationSettings {
                forced: forced(system, ends[k], returns[k], forcing),
                ..ContinuationSettings::over(ends[0].parameter, ends[1].parameter)
            });
            let branch = |k: usize| begun(system, ends[k], (periods[k], true), &settings[k], how);
            let (Some(one), Some(other)) = (branch(0), branch(1)) else {
                return true;
            };
            [
                one.leads_to(&other, returns[1]),
                other.leads_to(&one, returns[0]),
            ]
        }
        [AttractorKind::Equilibrium, AttractorKind::Equilibrium] => {
            let [one, other] = ends;
            [[one, other], [other, one]].map(|ends| equilibrium_leads_to(system, ends, how.0))
        }
        _ => return true,
    };
    both.iter().all(|leads| *leads != Some(false))
}

/// Whether two attractors are the same in each state at their points, as orbits of a branch are
/// told apart.
fn is_unmoved([one, other]: [&Attractor; 2], options: &Options) -> bool {
    let ends = one.phases.iter().map(|phase| &phase.x_start);
    let places: Vec<&Vector> = ends.chain(one.points.iter().map(|at| &at.x)).collect();
    let Some(first) = places.first() else {
        return false;
    };
    let ranges = Vector::from_fn(first.len(), |i, _| {
        let values = places.iter().map(|x| x[i]);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        });
        high - low
    });
    let allowed = same_attractor(&ranges, first, options);
    let is_near = |a: &Moment, b: &Moment| {
        let off = &a.x - &b.x;
        is_led([&off, &(&off * 0.0)], &allowed)
    };
    let mut shifts = shifts(&one.points, &other.points, is_near);
    shifts.next().is_some()
}

/// Differences of the states of two equilibria that are the same.
fn same_equilibrium(x: &Vector, options: &Options) -> Vector {
    same_attractor(&Vector::zeros(x.len()), x, options)
}

/// Whether an equilibrium is where Newton's step at its value leads from another one.
fn equilibrium_leads_to(
    system: &dyn Dynamics,
    [from, to]: [&SweepPoint; 2],
    options: &Options,
) -> Option<bool> {
    let [one, other] = [from, to].map(|at| at.reached.points.first().map(|at| &at.x));
    let (one, other) = (one?, other?);
    let at = Moment {
        t: 0.0,
        x: extended(one, to.parameter),
    };
    let step = newton_step_at(system, from.reached.mode, &at, one.len())?;
    let missed = states(at.x + step) - other;
    let moved = one - other;
    Some(is_led([&missed, &moved], &same_equilibrium(other, options)))
}

/// A moment on the orbit at a value, with the parameter in its state.
fn on_orbit(of: &SweepPoint, settings: &ContinuationSettings) -> Option<Moment> {
    // From a start in slip, the next stick removes its error. With a forcing, the orbit begins at
    // the strobe.
    let mut phases = of.reached.phases.iter();
    let slip = phases.find(|phase| settings.forced.is_none() && !phase.mode.any_sticks());
    let points = || of.reached.points.first().map(|at| &at.x);
    let x = slip.map(|phase| &phase.x_start).or_else(points)?;
    Some(Moment {
        t: 0.0,
        x: extended(x, of.parameter),
    })
}

/// A state followed by the parameter.
fn extended(x: &Vector, parameter: f64) -> Vector {
    x.clone().push(parameter)
}

/// A state without the parameter that follows it.
fn states(x: Vector) -> Vector {
    let last = x.len() - 1;
    x.remove_row(last)
}

/// The change located from one side.
#[derive(Default)]
struct LocatedChange {
    /// Whether the branch leads to the attractor at the other value; `None` where it ends before.
    arrives: Option<bool>,
    /// Change by a vanishing event function, or by an equilibrium that loses its stability or
    /// reaches the edge of its mode's domain.
    named: Option<WhatChanges>,
    /// Change by a multiplier.
    smooth: Option<WhatChanges>,
}

impl LocatedChange {
    /// Locates the change on the way from one value towards another.
    fn from(
        system: &dyn Dynamics,
        [from, to]: [&SweepPoint; 2],
        forcing: Option<f64>,
        (options, budget): (&Options, Option<&StepBudget>),
    ) -> Self {
        let (here, there) = (from.parameter, to.parameter);
        let settings = ContinuationSettings {
            // Attractors of the same phases are compared by where the branch leads, and a long step
            // may lead to the other one.
            step: match budget {
                Some(_) if from.reached.is_changed_to(&to.reached) => LONGEST_STEP_WITHIN_BUDGET,
                _ => LONGEST_STEP,
            },
            ..ContinuationSettings::over(here, there + NEXT_TO * (there - here))
        };
        let upwards = there > here;
        let found = match from.reached.kind {
            AttractorKind::Equilibrium => {
                equilibrium(system, [from, to], upwards, &settings, options)
            }
            AttractorKind::Periodic { returns, period } => {
                let forced = forced(system, from, returns, forcing);
                let settings = ContinuationSettings { forced, ..settings };
                orbit(
                    system,
                    [from, to],
                    (period, upwards),
                    &settings,
                    (options, budget),
                )
            }
            _ => None,
        };
        found.unwrap_or_default()
    }

    /// The change in the opposite direction.
    fn reversed(mut self) -> Self {
        if let Some(WhatChanges::Sequence(change)) = &mut self.named {
            std::mem::swap(&mut change.before, &mut change.after);
        }
        self
    }

    /// A place at which an orbit begins or ends: a change of its phases, or a fold.
    fn place(&self) -> Option<f64> {
        match self.named.as_ref().or(self.smooth.as_ref())? {
            WhatChanges::Sequence(change) => Some(change.parameter),
            WhatChanges::Multiplier {
                parameter,
                what: CycleBifurcation::Fold,
                ..
            } => Some(*parameter),
            _ => None,
        }
    }

    /// Whether the orbit's multiplier passes -1, and no phase changes.
    fn is_flip(&self) -> bool {
        let is_flip = |change: &WhatChanges| match change {
            WhatChanges::Multiplier { what, .. } => *what == CycleBifurcation::Flip,
            _ => false,
        };
        self.named.is_none() && self.smooth.as_ref().is_some_and(is_flip)
    }

    /// Whether it is a change from the phases of one attractor to those of the other, or not a
    /// change of phases.
    fn connects(&self, ends: [&Attractor; 2]) -> bool {
        match &self.named {
            Some(WhatChanges::Sequence(change)) => {
                let sides = [&change.before, &change.after];
                let mut sides = sides.into_iter().zip(ends);
                sides.all(|(modes, end)| *modes == end.sequence())
            }
            Some(_) => true,
            None => false,
        }
    }
}
