//! Curves of special orbits in two parameters.

mod branch_end;
mod codimension_two;
mod condition;
mod ends;
mod meetings;
mod special;
mod steps;

use super::both_ways::follow_both_ways;
use super::steps::{Continuation, Junction};
use super::tangent_line::Units;
use super::{ContinuationSettings, SpecialPoint, check_start};
use crate::analysis::cycle::{Cycle, SequenceBifurcation, Shooting, unit};
use crate::dynamics::{AsDynamics, Components, Dynamics, Vector};
use crate::error::Error;
use crate::filippov::Options;
use branch_end::EndPeriod;
pub(super) use codimension_two::others;
pub use codimension_two::{CurveBifurcation, CurveSpecialPoint};
use condition::CurveCondition;

/// An orbit on a curve of special ones.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CurvePoint {
    /// The two parameters, which are the last two states; the branch parameter comes last.
    pub parameters: [f64; 2],
    /// Uncertainty of the branch parameter, where that is extrapolated to the end of a branch.
    pub uncertainty: Option<f64>,
    /// A time and a state on the orbit.
    pub t: f64,
    /// See `t`.
    pub x: Vector,
    /// Period.
    pub period: f64,
}

/// Why the continuation of a curve stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum CurveStop {
    /// One of the parameters has reached an end of its range.
    Range,
    /// The curve has as many points as requested.
    Points,
    /// The curve is closed: its last orbit or equilibrium is the first.
    Closed,
    /// A flip of the orbit of half the period: both halves of the last orbit are that orbit. The
    /// curve would return on itself, half a period later.
    Flip,
    /// A pair of multipliers has met at 1 or −1. Beyond, both are real, and no torus emerges.
    Resonance,
    /// The pair of imaginary eigenvalues of a Hopf bifurcation has met at zero. Beyond, both are
    /// real, and no orbit emerges.
    BogdanovTakens,
    /// Another change of the phases occurs at the same orbit behind the last point, or the special
    /// equilibrium comes to another boundary.
    AnotherChange,
    /// No further orbit could be computed within the shortest step behind the last one.
    NoConvergence,
}

/// A curve of special periodic orbits in two parameters.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Curve {
    /// The orbit at which it begins.
    pub at: SpecialPoint,
    /// The orbits, from one end of the curve to the other. A closed curve ends with its first
    /// orbit.
    pub points: Vec<CurvePoint>,
    /// The special orbits between them, in the same order. An end may be one.
    pub special: Vec<CurveSpecialPoint>,
    /// Index of the orbit at which it began.
    pub first: usize,
    /// Why the curve ends before the first and behind the last orbit.
    pub stops: [CurveStop; 2],
}

impl Curve {
    /// Follows in two parameters a special orbit of a branch of periodic orbits, by its number
    /// counted from 0. It is a change of the phases, a fold, a flip or a Neimark–Sacker
    /// bifurcation.
    ///
    /// **The parameters are the last two states.** The last is the branch parameter, as in
    /// [`super::continue_periodic_orbit`]; the other is fixed on the branch and has the range
    /// `other`. In the plane across the curve, orbits form a branch. The function that vanishes at
    /// the special orbit has a zero on it, located as on any branch: a function of the multipliers
    /// or, at a change of the phases, any of the margins. So curves pass their own folds, and
    /// curves of folds pass cusps. Where two contacts switch at once, the phase between them keeps
    /// the duration zero.
    ///
    /// # Errors
    /// Those of [`super::continue_periodic_orbit`]; [`Error::NotFound`] where the branch has no
    /// such orbit, or no curve continues from it: a branch point has none.
    pub fn of_special<Kind>(
        system: &impl AsDynamics<Kind>,
        x: impl Components,
        (period, upwards, number): (f64, bool, usize),
        (settings, other): (&ContinuationSettings, (f64, f64)),
        options: &Options,
    ) -> Result<Curve, Error> {
        let system = &*system.dynamics();
        let start = (x.vector(), period, upwards);
        let how = CurveSettings { settings, other };
        follow_from(system, start, how, options, |continuation| {
            let junction = continuation.seek(|_| true, number)?;
            let condition = CurveCondition::of(&junction)?;
            let Junction { at, cycle, .. } = junction;
            Some((at, condition, cycle))
        })
    }
}

/// The ranges of both parameters, and how the curve is followed.
#[derive(Clone, Copy)]
struct CurveSettings<'a> {
    settings: &'a ContinuationSettings,
    other: (f64, f64),
}

/// A special orbit, the condition that it meets, and that orbit.
type CurveStart = (SpecialPoint, CurveCondition, Cycle);

/// Follows a branch to a special orbit of it, and the curve of that.
fn follow_from(
    system: &dyn Dynamics,
    (x, period, upwards): (Vector, f64, bool),
    CurveSettings { settings, other }: CurveSettings<'_>,
    options: &Options,
    seek: impl FnOnce(&mut Continuation<'_>) -> Option<CurveStart>,
) -> Result<Curve, Error> {
    settings.check()?;
    ContinuationSettings::over(other.0, other.1).check()?;
    check_start(&x, 2, settings)?;
    let place = x.len() - 2;
    let value = x[place];
    let by_other = unit(place + 1, place);
    let start = (x, period, upwards);
    let fixed = Some((&by_other, value));
    let mut continuation = Continuation::begin(system, start, settings, (fixed, options), None)?;
    let not_found = |what| Error::NotFound {
        what,
        t: 0.0,
        span: period,
    };
    let begun = seek(&mut continuation).ok_or(not_found("a curve of the special orbit"))?;
    let (at, condition, cycle) = begun;
    let curve = CurveContinuation {
        shooting: continuation.shooting,
        units: Units {
            other: Some(other.1 - other.0),
            ..continuation.branch.units
        },
        settings,
        place,
        other,
        kind: CurveKind::of(&at.what),
    };
    let plane = (&by_other, value);
    const BEGIN: &str = "an orbit to begin the curve with";
    let first = curve.solve((&condition, cycle.steps), &cycle.outline, plane);
    let (first, condition) = first.ok_or(not_found(BEGIN))?;
    let point = curve.point(&first, &condition).ok_or(not_found(BEGIN))?;
    let whole = follow_both_ways(&curve, &(first, condition), point);
    Ok(Curve {
        at,
        points: whole.points,
        special: whole.special,
        first: whole.first,
        stops: whole.stops,
    })
}

impl CurveContinuation<'_> {
    /// An orbit of the curve, or the end of a branch that is extrapolated from it.
    fn point(&self, cycle: &Cycle, condition: &CurveCondition) -> Option<CurvePoint> {
        let mut point = point(cycle);
        if let CurveCondition::Period(_, end) = condition {
            let (place, uncertainty) = self.at_end(cycle, *end)?;
            point.parameters[1] = place;
            point.x[self.place + 1] = place;
            point.uncertainty = Some(uncertainty);
        }
        Some(point)
    }
}

fn point(cycle: &Cycle) -> CurvePoint {
    CurvePoint {
        parameters: parameters(cycle),
        uncertainty: None,
        t: cycle.anchor.t,
        x: cycle.anchor.x.clone(),
        period: cycle.period,
    }
}

/// Both parameters of an orbit.
fn parameters(cycle: &Cycle) -> [f64; 2] {
    let x = &cycle.outline.begin.x;
    [x[x.len() - 2], x[x.len() - 1]]
}

/// Properties that the orbits of a curve share.
#[derive(Clone, Copy, Debug, PartialEq)]
enum CurveKind {
    Fold,
    Flip,
    Torus,
    Change(SequenceBifurcation),
}

/// The continuation of a curve.
struct CurveContinuation<'a> {
    shooting: Shooting<'a>,
    units: Units,
    settings: &'a ContinuationSettings,
    /// The component of the other parameter, and its range.
    place: usize,
    other: (f64, f64),
    /// `None` for an end of a branch.
    kind: Option<CurveKind>,
}
