//! Where an attractor changes between two values of a parameter.

use super::follow::Following;
use super::stability::{NEXT_TO, loss_of_stability};
use super::{Family, Reached, WhatChanges};
use crate::analysis::attractors::{Kind, is_same_cycle};
use crate::analysis::continuation::Special;
use crate::dynamics::Modes;
use crate::filippov::Options;

/// A value of the parameter and the attractor reached there.
pub(super) type End<'a> = (f64, &'a Reached);

/// The change of an attractor between two values: where it ends and, if that is a different place,
/// where the other one begins.
pub(super) fn locate<'a>(
    family: &'a Family<'a>,
    ends: [End<'_>; 2],
    forcing: Option<f64>,
    options: &Options,
) -> Vec<WhatChanges> {
    let [one, other] = ends;
    let first = Located::from(family, (one, other), forcing, options);
    let second = Located::from(family, (other, one), forcing, options).turned_round();
    let width = other.0 - one.0;
    let are_two = match (first.place(), second.place()) {
        (Some(a), Some(b)) => (a - b).abs() > NEXT_TO * width.abs(),
        _ => false,
    };
    let phases = ends.map(|end| end.1);
    if are_two && !first.joins(phases) && !second.joins(phases) {
        return [first, second]
            .into_iter()
            .filter_map(Located::best)
            .collect();
    }
    let named = if first.joins(phases) || !second.joins(phases) {
        first.named.or(second.named)
    } else {
        second.named
    };
    let others = first.smooth.or(second.smooth);
    vec![named.or(others).unwrap_or(WhatChanges::Unlocated)]
}

/// The change located from one side.
struct Located {
    /// By a vanishing event function, or by an equilibrium that loses its stability or reaches the
    /// edge of its mode's domain.
    named: Option<WhatChanges>,
    /// By a multiplier.
    smooth: Option<WhatChanges>,
}

impl Located {
    fn from<'a>(
        family: &'a Family<'a>,
        (from, to): (End<'_>, End<'_>),
        forcing: Option<f64>,
        options: &Options,
    ) -> Self {
        let mut located = Located {
            named: None,
            smooth: None,
        };
        let (returns, period) = match from.1.kind {
            Kind::Periodic { returns, period } => (returns, period),
            Kind::Equilibrium => {
                located.named = loss_of_stability(family, from, to.0);
                return located;
            }
            _ => return located,
        };
        // The forcing's own period is known exactly.
        let forced = forcing.map(|one| one * returns as f64);
        let Some(following) = Following::begin(family, from, period, forced, options) else {
            return located;
        };
        let way = following.follow(to.0);
        // Next to a boundary equilibrium a graze would be reported: the whole orbit comes to the
        // boundary.
        located.named = following.boundary_equilibrium(&way, to.0);
        if located.named.is_some() {
            return located;
        }
        located.smooth = following.multiplier(&way);
        located.named = way.change.map(WhatChanges::Sequence);
        located
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

    /// Whether it is a change of one attractor's phases into the other's, or a change without such
    /// sides.
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
