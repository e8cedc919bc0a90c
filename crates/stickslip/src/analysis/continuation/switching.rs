//! Branch switching: at a flip to the branch of twice the period, and at a branch point to the
//! other branch.

use std::num::NonZeroUsize;
use std::ops::ControlFlow;

use super::stepping::FIRST_STEP;
use super::steps::{Continuation, Junction};
use super::tangent_line::{TangentLine, Units};
use super::{Branch, ContinuationSettings, CycleBifurcation, SpecialPoint, Stop};
use crate::analysis::cycle::{Cycle, Shooting};
use crate::dynamics::{AsDynamics, Components, Vector};
use crate::error::Error;
use crate::filippov::Options;

/// The branches that meet a given one.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SwitchedBranch {
    /// The flip or branch point at which they meet.
    pub at: SpecialPoint,
    /// The branches that begin there: one of twice the period at a flip, both directions of the
    /// other branch at a branch point.
    pub branches: Vec<Branch>,
    /// The branches that begin at flips of each of these, where they were followed.
    pub further: Vec<Vec<SwitchedBranch>>,
}

impl SwitchedBranch {
    /// Whether the branch from this flip ends in another flip of the same branch. The orbits of
    /// twice the period between both are a bubble, and the other flip begins the same branch.
    pub fn is_bubble_to(&self, other: &SpecialPoint) -> bool {
        let ends = self.branches.iter().any(|branch| match branch.stop {
            Stop::Flip {
                parameter,
                uncertainty,
            } => {
                let off = (parameter - other.parameter).abs();
                // Two flips nearer than this are not told apart.
                off <= 2.0 * (uncertainty + other.uncertainty)
            }
            _ => false,
        });
        let is_other = self.at.parameter != other.parameter || self.at.behind != other.behind;
        ends && is_other && other.what == CycleBifurcation::Flip
    }
}

impl SwitchedBranch {
    /// Follows the branches that begin at a flip or branch point, by its number counted from 0, on
    /// the branch of the periodic orbit near `x`.
    ///
    /// At a branch point, the equations of the orbit have two tangents; at a flip, those of the
    /// orbit traversed twice do. The tangent across the given branch leads to the other one (Keller
    /// 1977; Govaerts 2000, Ch. 9).
    ///
    /// The flips of these branches are followed in turn, to a depth: at 1 there are only these
    /// branches, at 2 those of four times the period, too. A branch that ends in another flip of
    /// the same branch is followed from one of both.
    ///
    /// # Errors
    /// Those of [`super::continue_periodic_orbit`]; [`Error::NotFound`] where the branch has no
    /// such point, or no other branch was found there.
    pub fn of_special<Kind>(
        system: &impl AsDynamics<Kind>,
        x: impl Components,
        (period, upwards, number): (f64, bool, usize),
        (settings, depth): (&ContinuationSettings, NonZeroUsize),
        options: &Options,
    ) -> Result<SwitchedBranch, Error> {
        settings.check()?;
        let system = &*system.dynamics();
        let start = (x.vector(), period, upwards);
        let mut continuation = Continuation::begin(system, start, settings, (None, options), None)?;
        let is_wanted = |what: &CycleBifurcation| {
            matches!(what, CycleBifurcation::Flip | CycleBifurcation::BranchPoint)
        };
        let not_found = |what| Error::NotFound {
            what,
            t: 0.0,
            span: period,
        };
        let junction = continuation.seek(is_wanted, number);
        let junction = junction.ok_or(not_found("a flip or branch point on the branch"))?;
        let from = (continuation.shooting, &continuation.branch.units);
        switched(from, settings, junction, depth.get()).map_err(not_found)
    }
}

/// The branches that begin at a special orbit.
fn switched(
    (shooting, units): (Shooting<'_>, &Units),
    settings: &ContinuationSettings,
    junction: Junction,
    depth: usize,
) -> Result<SwitchedBranch, &'static str> {
    let Junction {
        at, cycle, line, ..
    } = junction;
    let is_flip = at.what == CycleBifurcation::Flip;
    let times = if is_flip { 2.0 } else { 1.0 };
    let shooting = Shooting {
        forced: shooting.forced.map(|periods| times * periods),
        ..shooting
    };
    let start = match is_flip {
        true => shooting.evaluated(&cycle.outline.twice(shooting.system)),
        false => Some(cycle),
    };
    let start = start.ok_or("the orbit run through twice")?;
    let row = across(&start, (!is_flip).then_some(&line));
    let row = row.ok_or("another branch at the point")?;
    // Both directions along the branch of twice the period yield the same orbits.
    let signs: &[f64] = if is_flip { &[1.0] } else { &[1.0, -1.0] };
    let branches = signs.iter().filter_map(|sign| {
        let along = |direction| TangentLine::along(&shooting, units, &start, direction);
        let tangent = along(&row * *sign)?;
        // Where the field has a corner, the branch leaves its tangent at once.
        let next = tangent.on(&shooting, FIRST_STEP * settings.step);
        let secant =
            next.and_then(|next| along(next.outline.unknowns() - start.outline.unknowns()));
        let begun = (start.clone(), secant.or(Some(tangent)));
        let mut other = Continuation::from_orbit(shooting, settings, units.clone(), begun);
        other.flips = (depth > 1).then(Vec::new);
        other.begins_on_other = true;
        let stop = other.go_on(&mut |_| ControlFlow::Continue(()));
        let flips = other.flips.take().unwrap_or_default();
        let mut branch = other.into_branch(stop);
        // At its beginning, test functions are zero to rounding, which decides their sign.
        let is_own = |one: &SpecialPoint| {
            let off = (one.parameter - at.parameter).abs();
            one.behind > 1 || off > one.uncertainty + at.uncertainty
        };
        branch.special.retain(is_own);
        let flips = flips.into_iter().filter(|flip| is_own(&flip.at));
        let mut further: Vec<SwitchedBranch> = Vec::new();
        for flip in flips {
            if !further.iter().any(|one| one.is_bubble_to(&flip.at)) {
                let from = (shooting, units);
                further.extend(switched(from, settings, flip, depth - 1).ok());
            }
        }
        Some((branch, further))
    });
    let (branches, further) = branches.unzip();
    Ok(SwitchedBranch {
        at,
        branches,
        further,
    })
}

/// The direction in which another branch leaves an orbit at which the equations have two tangents.
/// It is across a tangent or, without one, that along which the parameter does not change.
fn across(cycle: &Cycle, tangent: Option<&TangentLine>) -> Option<Vector> {
    let mut directions = cycle.jacobian.least_determined()?.into_iter();
    let [one, two] = [directions.next()?, directions.next()?].map(|(_, direction)| direction);
    let number = cycle.outline.begin.x.len() - 1;
    let of = |vector: &Vector| match tangent {
        Some(line) => line.across().dot(vector),
        None => vector[number],
    };
    let (a, b) = (of(&one), of(&two));
    let direction = one * b - two * a;
    let length = direction.norm();
    (length > 0.0).then(|| direction / length)
}
