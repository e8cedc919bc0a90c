//! Branch switching: at a flip to the branch of twice the period, and at a branch point to the
//! other branch.

use std::ops::ControlFlow;

use super::steps::{Continuation, FIRST_STEP, Junction};
use super::tangent_line::TangentLine;
use super::{Branch, ContinuationSettings, CycleBifurcation, SpecialPoint};
use crate::analysis::cycle::{Cycle, Shooting};
use crate::dynamics::{AsDynamics, Components, Vector};
use crate::error::Error;
use crate::filippov::Options;

/// The branches that meet a given one.
#[derive(Clone, Debug, PartialEq)]
pub struct SwitchedBranch {
    /// The flip or branch point at which they meet.
    pub at: SpecialPoint,
    /// The branches that begin there: one of twice the period at a flip, both directions of the
    /// other branch at a branch point.
    pub branches: Vec<Branch>,
}

/// Follows the branches that begin at a flip or branch point, by its number counted from 0, on the
/// branch of the periodic orbit near `x`.
///
/// At a branch point, the equations of the orbit have two tangents; at a flip, those of the orbit
/// traversed twice do. The tangent across the given branch leads to the other one (Keller 1977;
/// Govaerts 2000, Ch. 9).
///
/// # Errors
/// Those of [`super::continue_periodic_orbit`]; [`Error::NotFound`] where the branch has no such
/// point, or no other branch was found there.
pub fn switch_branches<Kind>(
    system: &impl AsDynamics<Kind>,
    x: impl Components,
    (period, upwards, number): (f64, bool, usize),
    settings: &ContinuationSettings,
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
    let Junction {
        at, cycle, line, ..
    } = junction;
    let is_flip = at.what == CycleBifurcation::Flip;
    let times = if is_flip { 2.0 } else { 1.0 };
    let settings = &ContinuationSettings {
        forced: settings.forced.map(|period| times * period),
        ..*settings
    };
    let shooting = Shooting {
        forced: settings.forced,
        ..continuation.shooting
    };
    let start = match is_flip {
        true => shooting.evaluated(&cycle.outline.twice(system)),
        false => Some(cycle),
    };
    let start = start.ok_or(not_found("the orbit run through twice"))?;
    let row = across(&start, (!is_flip).then_some(&line));
    let row = row.ok_or(not_found("another branch at the point"))?;
    // Both directions along the branch of twice the period yield the same orbits.
    let signs: &[f64] = if is_flip { &[1.0] } else { &[1.0, -1.0] };
    let branches = signs.iter().filter_map(|sign| {
        let units = continuation.branch.units;
        let along = |direction| TangentLine::along(&shooting, units, &start, direction);
        let tangent = along(&row * *sign)?;
        // Where the field has a corner, the branch leaves its tangent at once.
        let next = tangent.on(&shooting, FIRST_STEP * settings.step);
        let secant =
            next.and_then(|next| along(next.outline.unknowns() - start.outline.unknowns()));
        let begun = (start.clone(), secant.or(Some(tangent)));
        let mut other = Continuation::from_orbit(shooting, settings, units, begun);
        let stop = other.go_on(&mut |_| ControlFlow::Continue(()));
        let mut branch = other.into_branch(stop);
        // At its beginning, test functions are zero to rounding, which decides their sign.
        branch.special.retain(|one| {
            let off = (one.parameter - at.parameter).abs();
            one.behind > 1 || off > one.uncertainty + at.uncertainty
        });
        Some(branch)
    });
    let branches = branches.collect();
    Ok(SwitchedBranch { at, branches })
}

/// The direction in which another branch leaves an orbit at which the equations have two tangents:
/// across a tangent or, where that is not given, the one along which the parameter does not change.
fn across(cycle: &Cycle, tangent: Option<&TangentLine>) -> Option<Vector> {
    let count = cycle.jacobian.ncols();
    let square = cycle.jacobian.clone().resize_vertically(count, 0.0);
    let parts = square.svd(false, true);
    let rows = parts.v_t?;
    let [one, two] =
        [count.checked_sub(1)?, count.checked_sub(2)?].map(|k| rows.row(k).transpose());
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
