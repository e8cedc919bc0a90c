//! Equilibria: the one that an orbit approaches, and branches of them along a parameter.

use rayon::prelude::*;
use stickslip::analysis::{
    AttractorKind, ContinuationSettings, EquilibriumBifurcation, EquilibriumBranch,
    EquilibriumCurve, EquilibriumPoint, RecurrenceSettings, SpecialEquilibrium, Stop, attractor,
};
use stickslip::dynamics::{DynamicsRef, Vector};
use stickslip::{Error, Options};

use super::branch::{BesideFirst, found_twice};
use super::search::{MOTION_SEARCH_TIME, SearchError, check_time};
use crate::file::System;

/// The equilibrium that the orbit from `x` approaches. With a transient of 0 it is `x` itself, as
/// a guess.
///
/// # Errors
/// [`SearchError`].
pub fn equilibrium(
    system: &System,
    x: &[f64],
    transient: Option<f64>,
    options: &Options,
) -> Result<Vec<f64>, SearchError> {
    if system.built.depends_on_time {
        return Err(SearchError::HasNoEquilibrium);
    }
    if let Some(transient) = transient {
        check_time("transient", transient)?;
    }
    if transient == Some(0.0) {
        return Ok(x.to_vec());
    }
    let settings = RecurrenceSettings::within(
        transient
            .unwrap_or(MOTION_SEARCH_TIME)
            .max(MOTION_SEARCH_TIME),
    );
    let reached = attractor(system.dynamics(), x, &settings, options)?;
    if let AttractorKind::Failure(error) = reached.kind {
        return Err(error.into());
    }
    match (&reached.kind, reached.points.first()) {
        (AttractorKind::Equilibrium, Some(at)) => Ok(at.x.as_slice().to_vec()),
        _ => Err(SearchError::NoEquilibrium(Box::new(reached))),
    }
}

/// A branch of equilibria in both directions, from its lower to its upper end.
pub struct EquilibriaOfBranch {
    /// The equilibria.
    pub points: Vec<EquilibriumPoint>,
    /// The special equilibria, in the same order.
    pub special: Vec<SpecialEquilibrium>,
    /// Size of each state, [`EquilibriumBranch::sizes`].
    pub sizes: Vector,
    /// Index of the equilibrium from which the branch was started.
    pub first: usize,
    /// Reasons for the ends of the branch, downwards and upwards.
    pub stops: [Stop; 2],
}

impl EquilibriaOfBranch {
    /// The curves of its special equilibria in two parameters, each with the index of the one at
    /// which it begins. Branch points have none. A curve is `None` where none continues.
    /// The system `both` has the second parameter, with a value on the branch and a range, as the
    /// state before the own one.
    ///
    /// # Errors
    /// Those of [`SpecialEquilibrium::curve`].
    pub fn curves(
        &self,
        (both, value, range): (&DynamicsRef<'_>, f64, (f64, f64)),
        settings: &ContinuationSettings,
    ) -> Result<Vec<(usize, Option<EquilibriumCurve>)>, Error> {
        let special: Vec<_> = self.special.iter().enumerate().collect();
        let special = special.into_par_iter();
        let special = special.filter(|(_, at)| at.what != EquilibriumBifurcation::BranchPoint);
        let curve = |(k, at): (usize, &SpecialEquilibrium)| {
            let how = (settings, range);
            match at.curve(both, (value, &self.sizes), how) {
                Ok(curve) => Ok((k, Some(curve))),
                Err(Error::NotFound { .. }) => Ok((k, None)),
                Err(error) => Err(error),
            }
        };
        special.map(curve).collect()
    }

    /// Joins both directions.
    pub fn joined([mut down, mut up]: [EquilibriumBranch; 2]) -> Self {
        // A closed branch is the same in the other direction.
        let same = match (&down.stop, &up.stop) {
            (Stop::Closed, _) => Some(&mut up),
            (_, Stop::Closed) => Some(&mut down),
            _ => None,
        };
        if let Some(same) = same {
            same.points.truncate(1);
            same.special.clear();
            same.stop = Stop::Closed;
        }
        let twice = found_twice([&down.special, &up.special], |one| BesideFirst {
            name: one.what.to_string(),
            parameter: one.parameter,
            uncertainty: one.uncertainty,
            behind: one.behind,
        });
        down.special.drain(..twice);
        // Both directions contain the first equilibrium.
        let first = down.points.len().saturating_sub(1);
        let below = down.points.into_iter().skip(1).rev();
        let special_below = down.special.into_iter().rev().map(|mut at| {
            at.behind = (first + 1).saturating_sub(at.behind);
            if let EquilibriumBifurcation::Boundary {
                before,
                after: Some(after),
                ..
            } = &mut at.what
            {
                std::mem::swap(before, after);
            }
            at
        });
        let special_above = up.special.into_iter().map(|at| SpecialEquilibrium {
            behind: at.behind + first,
            ..at
        });
        EquilibriaOfBranch {
            points: below.chain(up.points).collect(),
            special: special_below.chain(special_above).collect(),
            sizes: down.sizes.sup(&up.sizes),
            first,
            stops: [down.stop, up.stop],
        }
    }
}

/// The contact on whose boundary a special equilibrium lies, and the modes before and after it; all
/// empty for another one.
pub fn boundary_of(at: &SpecialEquilibrium, system: &System) -> (String, [String; 2]) {
    match &at.what {
        EquilibriumBifurcation::Boundary {
            contact,
            before,
            after,
            ..
        } => {
            let after = after.map(|after| system.letters(&after));
            let modes = [system.letters(before), after.unwrap_or_default()];
            (system.contact_name(*contact), modes)
        }
        _ => Default::default(),
    }
}

/// The frequency of a special equilibrium that is a Hopf bifurcation.
pub fn frequency_of(at: &SpecialEquilibrium) -> Option<f64> {
    match at.what {
        EquilibriumBifurcation::Hopf { frequency } => Some(frequency),
        _ => None,
    }
}
