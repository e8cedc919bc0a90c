//! Where an attractor changes between two values of a parameter.

use std::ops::ControlFlow;

use super::{SweepPoint, WhatChanges};
use crate::analysis::attractors::{Kind, Reached};
use crate::analysis::continuation::{
    ContinuationSettings, EquilibriumBifurcation, Special, Stop, Walk, continue_equilibrium,
};
use crate::analysis::cycle::Extra;
use crate::dynamics::{Dynamics, DynamicsRef, Vector};
use crate::filippov::Options;

/// A change counts as hit by a value of the sweep within this fraction of the interval behind it;
/// farther on it belongs to another pair.
const NEXT_TO: f64 = 1e-6;

/// Longest step between the values, as a fraction of the interval and of the orbit's size.
const STEP: f64 = 0.1;

/// The change of an attractor between two values: where it ends and, if that is a different place,
/// where the other one begins.
pub(super) fn locate(
    system: &dyn Dynamics,
    ends: [&SweepPoint; 2],
    forcing: Option<f64>,
    options: &Options,
) -> Vec<WhatChanges> {
    let [one, other] = ends;
    let first = Located::from(system, [one, other], forcing, options);
    let second = Located::from(system, [other, one], forcing, options).turned_round();
    let width = other.parameter - one.parameter;
    let phases = ends.map(|end| &end.reached);
    let places = [first.place(), second.place()];
    let joins = [&first, &second].map(|one| one.joins(phases));
    let found = match (joins, places) {
        ([false, true], _) => [second.named, None],
        ([false, false], [Some(a), Some(b)]) if (a - b).abs() > NEXT_TO * width.abs() => {
            [first, second].map(|one| one.named.or(one.smooth))
        }
        _ => {
            let named = first.named.or(second.named);
            [named.or(primary([first.smooth, second.smooth])), None]
        }
    };
    match found {
        [None, None] => vec![WhatChanges::Unlocated],
        some => some.into_iter().flatten().collect(),
    }
}

/// Of two names of one place, that by the orbit of the shorter period. An orbit of twice its period
/// ends there in a singular point of its equations, which locates the place less precisely.
fn primary(changes: [Option<WhatChanges>; 2]) -> Option<WhatChanges> {
    let period = |change: &WhatChanges| match change {
        WhatChanges::Multiplier { period, .. } => *period,
        _ => f64::INFINITY,
    };
    let changes = changes.into_iter().flatten();
    changes.min_by(|one, other| period(one).total_cmp(&period(other)))
}

/// Where the equilibrium at a value loses its stability, or reaches the edge of its mode's domain.
fn equilibrium(
    system: &dyn Dynamics,
    from: &SweepPoint,
    upwards: bool,
    settings: &ContinuationSettings,
    options: &Options,
) -> Option<Located> {
    let x = extended(&from.reached.points.first()?.x, from.parameter);
    let system = DynamicsRef::Borrowed(system);
    let branch = continue_equilibrium(&system, x, upwards, settings, options).ok()?;
    let at = branch.special.into_iter().next()?;
    let (parameter, x) = (at.parameter, states(at.x));
    let named = match at.what {
        EquilibriumBifurcation::Boundary { .. } => {
            WhatChanges::BoundaryEquilibrium { parameter, x }
        }
        what => WhatChanges::Equilibrium {
            parameter,
            x,
            frequency: match what {
                EquilibriumBifurcation::Hopf { frequency } => frequency,
                _ => 0.0,
            },
        },
    };
    Some(Located {
        named: Some(named),
        smooth: None,
    })
}

/// Where the phases of the orbit at a value change, or where it ends; and the first multiplier to
/// reach the unit circle before.
fn orbit(
    system: &dyn Dynamics,
    from: &SweepPoint,
    (period, upwards): (f64, bool),
    settings: &ContinuationSettings,
    options: &Options,
) -> Option<Located> {
    // Stick forgets the error of a start in slip. With a forcing, the orbit begins at the strobe.
    let mut phases = from.reached.phases.iter();
    let slip = phases.find(|phase| settings.forced.is_none() && !phase.mode.any_sticks());
    let points = || from.reached.points.first().map(|at| &at.x);
    let x = slip.map(|phase| &phase.x_start).or_else(points)?;
    let start = (extended(x, from.parameter), period, upwards);
    let mut walk = Walk::begin(system, start, settings, (Extra::None, options)).ok()?;
    let ends = |what: &Special| matches!(what, Special::Sequence(_) | Special::Fold);
    walk.wanted = Some((ends, 0));
    let stop = walk.go_on(&mut |_| ControlFlow::Continue(()));
    // Next to a boundary equilibrium a graze would be reported: the whole orbit comes to the
    // boundary.
    if stop != Stop::Range
        && let Some((parameter, x)) = walk.ends_at()
    {
        let x = states(x);
        return Some(Located {
            named: Some(WhatChanges::BoundaryEquilibrium { parameter, x }),
            smooth: None,
        });
    }
    let mut located = Located::default();
    let branch = walk.into_branch(stop);
    for at in branch.special {
        match at.what {
            Special::Sequence(mut change) => {
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
                });
            }
        }
    }
    if let (
        Stop::Flip {
            parameter,
            uncertainty,
        },
        Some(last),
    ) = (branch.stop, branch.points.last())
    {
        located.smooth.get_or_insert(WhatChanges::Multiplier {
            parameter,
            uncertainty,
            what: Special::Flip,
            x: states(last.x.clone()),
            period: last.period,
        });
    }
    Some(located)
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
struct Located {
    /// By a vanishing event function, or by an equilibrium that loses its stability or reaches the
    /// edge of its mode's domain.
    named: Option<WhatChanges>,
    /// By a multiplier.
    smooth: Option<WhatChanges>,
}

impl Located {
    /// On the way from one value to another.
    fn from(
        system: &dyn Dynamics,
        [from, to]: [&SweepPoint; 2],
        forcing: Option<f64>,
        options: &Options,
    ) -> Self {
        let (here, there) = (from.parameter, to.parameter);
        let settings = ContinuationSettings {
            step: STEP,
            ..ContinuationSettings::over(here, there + NEXT_TO * (there - here))
        };
        let upwards = there > here;
        let found = match from.reached.kind {
            Kind::Equilibrium => equilibrium(system, from, upwards, &settings, options),
            Kind::Periodic { returns, period } => {
                // The forcing's own period is known exactly.
                let forced = forcing.map(|one| one * returns as f64);
                let settings = ContinuationSettings { forced, ..settings };
                orbit(system, from, (period, upwards), &settings, options)
            }
            _ => None,
        };
        found.unwrap_or_default()
    }

    /// The same, of which what was before is behind.
    fn turned_round(mut self) -> Self {
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
                what: Special::Fold,
                ..
            } => Some(*parameter),
            _ => None,
        }
    }

    /// Whether it is a change of one attractor's phases into the other's, or a change without such
    /// sides.
    fn joins(&self, ends: [&Reached; 2]) -> bool {
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
