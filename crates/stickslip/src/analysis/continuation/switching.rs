//! Branch switching: to the branch of twice the period at a flip, and to the other branch at a
//! branch point.

use std::ops::ControlFlow;

use super::line::Line;
use super::walk::{Junction, Vanishing, Walk};
use super::{Branch, ContinuationSettings, Special, SpecialPoint, Stop};
use crate::analysis::cycle::{Cycle, Extra, Shooting};
use crate::dynamics::{AsDynamics, Components, Vector};
use crate::error::Error;
use crate::filippov::Options;

/// The branches that meet a given one.
#[derive(Clone, Debug, PartialEq)]
pub struct SwitchedBranch {
    /// The flip or branch point at which they meet.
    pub at: SpecialPoint,
    /// The branches that begin there: one of twice the period at a flip, two at a branch point.
    pub branches: Vec<Branch>,
}

/// Follows the branches that begin at a flip or branch point, by its number counted from 0, on the
/// branch of the periodic orbit near `x`.
///
/// At a flip, the equations of the orbit traversed twice have two tangents; at a branch point,
/// those of the orbit itself do. The tangent across the known branch leads to the other one (Keller
/// 1977; Govaerts 2000, Ch. 9).
///
/// # Errors
/// Those of [`super::continue_periodic_orbit`]; [`Error::NotFound`] where the branch has no such
/// point, or no other branch could be computed there.
pub fn switch_branches<Kind>(
    system: &impl AsDynamics<Kind>,
    x: impl Components,
    (period, upwards, number): (f64, bool, usize),
    settings: &ContinuationSettings,
    options: &Options,
) -> Result<SwitchedBranch, Error> {
    settings.check()?;
    let system = &*system.dynamics();
    let extra = (Extra::None, options);
    let start = (x.vector(), period, upwards);
    let mut walk = Walk::begin(system, start, settings, extra)?;
    let is_meant = |what: &Special| matches!(what, Special::Flip | Special::BranchPoint);
    walk.wanted = Some((is_meant, number));
    walk.go_on(&mut |_| ControlFlow::Continue(()));
    let not_found = |what| Error::NotFound {
        what,
        t: 0.0,
        span: period,
    };
    let junction = walk.junction.take();
    let junction = junction.ok_or(not_found("a flip or branch point on the branch"))?;
    let Junction { at, cycle, by } = junction;
    let is_flip = at.what == Special::Flip;
    let times = if is_flip { 2.0 } else { 1.0 };
    let settings = &ContinuationSettings {
        forced: settings.forced.map(|period| times * period),
        ..*settings
    };
    let shooting = Shooting {
        forced: settings.forced,
        ..walk.shooting
    };
    let start = match is_flip {
        true => shooting.evaluated(&cycle.outline.twice(system)),
        false => Some(cycle),
    };
    let start = start.ok_or(not_found("the orbit run through twice"))?;
    let known = match &by {
        Vanishing::Multiplier(line) if !is_flip => Some(line),
        _ => None,
    };
    let across = across(&start, known);
    let row = across.ok_or(not_found("another branch at the point"))?;
    // Both directions along the branch of twice the period yield the same orbits.
    let signs: &[f64] = if is_flip { &[1.0] } else { &[1.0, -1.0] };
    let branches = signs.iter().filter_map(|sign| {
        let units = walk.branch.units;
        let line = Line::along(&shooting, units, &start, &row * *sign)?;
        let mut other = Walk::at(shooting, settings, units, (start.clone(), Some(line)));
        let stop = other.go_on(&mut |_| ControlFlow::Continue(()));
        let mut branch = other.into_branch(stop);
        // At its beginning, the functions of folds and branch points are zero to rounding, which
        // decides their sign.
        branch.special.retain(|one| {
            one.behind > 1 || !matches!(one.what, Special::Fold | Special::BranchPoint)
        });
        let is_found = branch.points.len() > 1 || branch.stop == Stop::Range;
        is_found.then_some(branch)
    });
    let branches: Vec<Branch> = branches.collect();
    if branches.is_empty() {
        return Err(not_found("an orbit on the other branch"));
    }
    Ok(SwitchedBranch { at, branches })
}

/// The direction in which another branch leaves an orbit at which the equations have two tangents:
/// across the known direction or, where that is not given, the one along which the parameter does
/// not change.
fn across(cycle: &Cycle, known: Option<&Line>) -> Option<Vector> {
    let count = cycle.jacobian.ncols();
    let square = cycle.jacobian.clone().resize_vertically(count, 0.0);
    let parts = square.svd(false, true);
    let rows = parts.v_t?;
    let [one, two] =
        [count.checked_sub(1)?, count.checked_sub(2)?].map(|k| rows.row(k).transpose());
    let number = cycle.outline.begin.x.len() - 1;
    let of = |vector: &Vector| match known {
        Some(line) => line.across().dot(vector),
        None => vector[number],
    };
    let (a, b) = (of(&one), of(&two));
    let way = one * b - two * a;
    let length = way.norm();
    (length > 0.0).then(|| way / length)
}
