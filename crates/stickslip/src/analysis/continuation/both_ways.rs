//! Curves in two parameters, followed both ways from one solution.

use super::stepping::{SHORTER, StepOutcome, Stepping, follow};
use super::{ContinuationSettings, CurveStop};

/// A special solution on a curve.
pub(super) trait SpecialOnCurve {
    /// The kind.
    type What: PartialEq;

    /// The kind, both parameters and their uncertainties.
    fn known(&self) -> (&Self::What, [f64; 2], [f64; 2]);

    /// Number of solutions on the curve before it.
    fn behind(&mut self) -> &mut usize;

    /// Whether it may be another one, within the uncertainties of both.
    fn is_same(&self, other: &Self) -> bool {
        let ((what, at, known), (its, there, its_known)) = (self.known(), other.known());
        let is_near = |k: usize| (at[k] - there[k]).abs() <= known[k] + its_known[k];
        what == its && is_near(0) && is_near(1)
    }
}

/// An end of a curve behind one of its solutions.
pub(super) struct CurveEndOf<P, S> {
    /// Place on the line from that solution.
    pub s: f64,
    pub stop: CurveStop,
    /// The last solution.
    pub last: P,
    /// The special solution that it is, if any.
    pub special: Option<S>,
}

/// The end of a curve `C`.
pub(super) type EndOf<C> = CurveEndOf<<C as FollowedCurve>::Point, <C as FollowedCurve>::Special>;

/// A curve that is followed. Numbers of solutions are those of one direction, with the first.
pub(super) trait FollowedCurve {
    /// The solution at which it begins.
    type First;
    /// A solution on it, and how it goes on from there.
    type At;
    type Point;
    type Special: SpecialOnCurve;

    fn settings(&self) -> &ContinuationSettings;

    /// The solution at which it begins in the direction of a sign.
    fn begin(&self, first: &Self::First, sign: f64) -> Option<Self::At>;

    /// The solution behind a step, with what is told of it and the iterations that it took.
    fn next(&self, at: &Self::At, step: f64) -> Option<(Self::At, Self::Point, usize)>;

    /// The end before a step behind which there is no solution.
    fn end_before(&self, at: &Self::At, step: f64, number: usize) -> Option<EndOf<Self>>;

    /// The ends between two solutions. `Err` where a shorter step is needed, or where the curve
    /// ends at the first of them.
    fn ends(
        &self,
        two: (&Self::At, &Self::At),
        first: &Self::First,
        how: (f64, usize),
    ) -> Result<Vec<EndOf<Self>>, Option<CurveStop>>;

    /// The special solutions between two, with their places on the line from the first.
    fn special(&self, two: (&Self::At, &Self::At), how: (f64, usize)) -> Vec<(f64, Self::Special)>;

    /// The end where no step is short enough.
    fn last_end(&self, at: &Self::At, step: f64, number: usize) -> Result<EndOf<Self>, CurveStop>;
}

/// The steps along a curve in one direction, and what they have found behind its first solution.
struct OneWay<'c, C: FollowedCurve> {
    curve: &'c C,
    first: &'c C::First,
    at: C::At,
    step: f64,
    points: Vec<C::Point>,
    special: Vec<C::Special>,
    /// Whether the last special solution is the end.
    ends_special: bool,
}

impl<C: FollowedCurve> OneWay<'_, C> {
    fn number(&self) -> usize {
        1 + self.points.len()
    }

    /// Records an end.
    fn end(&mut self, end: EndOf<C>) -> CurveStop {
        self.points.push(end.last);
        self.ends_special = end.special.is_some();
        self.special.extend(end.special);
        end.stop
    }
}

impl<C: FollowedCurve> Stepping for OneWay<'_, C> {
    type End = CurveStop;

    fn step(&mut self) -> (&mut f64, f64) {
        (&mut self.step, self.curve.settings().step)
    }

    fn completed(&mut self) -> Option<CurveStop> {
        let is_enough = 2 * self.points.len() >= self.curve.settings().most_points;
        is_enough.then_some(CurveStop::Points)
    }

    fn take_step(&mut self, step: f64) -> StepOutcome<CurveStop> {
        let (curve, at, how) = (self.curve, &self.at, (step, self.number()));
        let shorter = StepOutcome::Shortened(SHORTER * step);
        let Some((next, point, iterations)) = curve.next(at, step) else {
            return match curve.end_before(at, step, how.1) {
                Some(end) => StepOutcome::End(self.end(end)),
                None => shorter,
            };
        };
        let ends = match curve.ends((at, &next), self.first, how) {
            Ok(ends) => ends,
            Err(stop) => return stop.map_or(shorter, StepOutcome::End),
        };
        let end = ends.into_iter().min_by(|a, b| a.s.total_cmp(&b.s));
        let mut special = curve.special((at, &next), how);
        special.retain(|(s, _)| end.as_ref().is_none_or(|end| *s < end.s));
        self.special.extend(special.into_iter().map(|(_, one)| one));
        if let Some(end) = end {
            return StepOutcome::End(self.end(end));
        }
        self.points.push(point);
        self.at = next;
        StepOutcome::Found {
            length: step,
            iterations,
        }
    }

    fn name_end(&mut self) -> CurveStop {
        let end = self.curve.last_end(&self.at, self.step, self.number());
        end.map_or_else(|stop| stop, |end| self.end(end))
    }
}

/// A curve from one end to the other.
pub(super) struct WholeCurve<C: FollowedCurve> {
    pub points: Vec<C::Point>,
    pub special: Vec<C::Special>,
    /// Index of the solution at which it began.
    pub first: usize,
    pub stops: [CurveStop; 2],
}

/// Follows a curve in both directions from its first solution.
pub(super) fn follow_both_ways<C: FollowedCurve>(
    curve: &C,
    first: &C::First,
    point: C::Point,
) -> WholeCurve<C> {
    let nothing = |stop| (stop, Vec::new(), Vec::new(), false);
    let way = |sign: f64| {
        let Some(at) = curve.begin(first, sign) else {
            return nothing(CurveStop::NoConvergence);
        };
        let mut way = OneWay {
            curve,
            first,
            at,
            step: curve.settings().step,
            points: Vec::new(),
            special: Vec::new(),
            ends_special: false,
        };
        let stop = follow(&mut way);
        (stop, way.points, way.special, way.ends_special)
    };
    let (stop_behind, points_behind, special_behind, _) = way(1.0);
    // A closed curve is the same in the other direction.
    let (stop, mut points, mut special, ends_special) = match stop_behind {
        CurveStop::Closed => nothing(CurveStop::Closed),
        _ => way(-1.0),
    };
    points.reverse();
    let begun = points.len();
    points.push(point);
    points.extend(points_behind);
    special.reverse();
    // The first solution may be a special one, which both directions then find.
    if let (Some(one), Some(other)) = (special.last(), special_behind.first())
        && one.is_same(other)
    {
        special.pop();
    }
    for (number, one) in special.iter_mut().enumerate() {
        let is_end = ends_special && number == 0;
        *one.behind() = (begun + 1).saturating_sub(*one.behind() + usize::from(is_end));
    }
    special.extend(special_behind.into_iter().map(|mut one| {
        *one.behind() += begun;
        one
    }));
    WholeCurve {
        points,
        special,
        first: begun,
        stops: [stop, stop_behind],
    }
}
