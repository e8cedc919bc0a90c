//! Whether the points of a section repeat.

use std::collections::VecDeque;

use super::tolerance::{Extent, ROUNDING, SOLVER_TOLERANCES, SameWithin};
use crate::dynamics::{Moment, Vector};

/// Factor of the recent size of a component from point to point. After some twenty returns a long
/// approach to the attractor no longer counts. Chosen.
const SIZE_DECAY: f64 = 0.9;

/// Number of ratios of differences that are examined: one alone may be small by coincidence.
const RATIOS: usize = 3;

/// Repetitions over which an orbit that approaches a shorter pattern is recognised.
const APPROACH_REPETITIONS: usize = 4;

/// An orbit approaches a shorter pattern if its distance falls below this fraction over
/// [`APPROACH_REPETITIONS`]. Chosen.
const APPROACH_RATIO: f64 = 0.9;

/// Remaining distance to a pattern, in differences of points, if those are below the solver's
/// tolerance and show no ratio. It is that of a ratio of 0.99. Chosen.
const UNRESOLVED_DISTANCE: f64 = 100.0;

/// Least width of a cycle, in roundings of the solver. Narrower ones are equilibria. Chosen.
const LEAST_WIDTH: f64 = 10.0;

/// Largest remaining distance to a cycle, as a fraction of its extent. Chosen: an orbit that winds
/// around an equilibrium keeps a larger one.
const LARGEST_REMAINDER: f64 = 0.01;

/// Ratio of the mean distances in two quarters of the points above which they grow or shrink.
/// Chosen.
const STEADY_RATIO: f64 = 1.25;

/// Counts of what has happened.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts {
    /// Phases that have ended.
    pub phases: u64,
    /// Transitions, touches excluded.
    pub transitions: u64,
}

/// A point with the quantities that are compared, and what lies between it and the one before.
#[derive(Clone, Debug)]
struct SectionPoint {
    at: Moment,
    /// Represents the transitions since the last point.
    tag: u64,
    /// Time modulo the forcing's period, in periods.
    beat: f64,
    /// Counts before this point.
    counts: Counts,
    extent: Extent,
}

/// The last points of a section, and how long they have repeated with each lag.
pub(super) struct Recurrence {
    tolerance: SameWithin,
    forcing: Option<f64>,
    points: VecDeque<SectionPoint>,
    kept: usize,
    /// Number of consecutive points near the point one lag before, for every lag, counted from 1.
    runs: Vec<usize>,
    /// Recent size of every component.
    scale: Vector,
}

/// A repeating pattern of the last points.
#[derive(Clone, Debug)]
pub(super) struct Pattern {
    pub returns: usize,
    pub period: f64,
    /// Largest error of that.
    pub uncertainty: f64,
    /// Counts before it and at its end.
    pub counts: (Counts, Counts),
    /// The extent of the orbit in it.
    pub extent: Extent,
}

impl Recurrence {
    pub fn new(
        states: usize,
        tolerance: SameWithin,
        forcing: Option<f64>,
        (most, kept): (usize, usize),
    ) -> Self {
        let kept = kept.max((APPROACH_REPETITIONS + 1) * most + 1);
        Recurrence {
            tolerance,
            forcing,
            points: VecDeque::new(),
            kept,
            runs: vec![0; most],
            scale: Vector::zeros(states),
        }
    }

    pub fn clear(&mut self) {
        self.points.clear();
        self.runs.fill(0);
        self.scale.fill(0.0);
    }

    pub fn moments(&self) -> impl ExactSizeIterator<Item = &Moment> {
        self.points.iter().map(|point| &point.at)
    }

    /// The last `count` points.
    pub fn last(&self, count: usize) -> Vec<Moment> {
        let from = self.points.len().saturating_sub(count);
        self.moments().skip(from).cloned().collect()
    }

    /// Whether the orbit still approaches a pattern or moves away from one. With some lag all of
    /// the last points are then near those before, and their distance grows or shrinks. Or the
    /// last quarter of them repeats to the tolerance.
    pub fn still_moves(&self, part: f64) -> bool {
        let near = SameWithin {
            closeness: part,
            ..self.tolerance
        };
        let total = self.points.len();
        let quarter = total / 4;
        let mean = |lag: usize, last: usize| {
            let mut sum = 0.0;
            for k in last - quarter..last {
                let (here, there) = (&self.points[k], self.points.get(k.checked_sub(lag)?)?);
                let apart = self.apart(here, there, &near);
                if here.tag != there.tag || apart > 1.0 {
                    return None;
                }
                sum += apart;
            }
            Some(sum)
        };
        // Each point has others a lag apart in all quarters.
        (1..=self.runs.len().min(quarter)).any(|lag| {
            if self.runs[lag - 1] >= quarter {
                return true;
            }
            let Some(now) = mean(lag, total) else {
                return false;
            };
            mean(lag, total - quarter)
                .is_none_or(|before| now > STEADY_RATIO * before || before > STEADY_RATIO * now)
        })
    }

    /// Adds the next point; returns the shortest pattern that has repeated often enough, if any.
    pub fn add(&mut self, at: Moment, tag: u64, counts: Counts, extent: Extent) -> Option<Pattern> {
        for i in 0..self.scale.len() {
            self.scale[i] = extent.size(i).max(SIZE_DECAY * self.scale[i]);
        }
        if self.points.len() == self.kept {
            self.points.pop_front();
        }
        let beats = self.forcing.map_or(0.0, |period| at.t / period);
        self.points.push_back(SectionPoint {
            at,
            tag,
            beat: beats - beats.floor(),
            counts,
            extent,
        });
        let last = self.points.len() - 1;
        let mut repeating = None;
        for lag in 1..=self.runs.len().min(last) {
            let (here, there) = (&self.points[last], &self.points[last - lag]);
            let repeats = here.tag == there.tag && self.apart(here, there, &self.tolerance) <= 1.0;
            self.runs[lag - 1] = if repeats { self.runs[lag - 1] + 1 } else { 0 };
            // A state has one future: the complete pattern need not repeat.
            let needed = if self.is_same(here, there) { 1 } else { lag };
            if repeating.is_none()
                && self.runs[lag - 1] >= needed
                && let Some(remainder) = self.remaining(last, lag)
            {
                let pattern = self.pattern(last, lag, remainder);
                let is_wide = || self.forcing.is_some() || self.is_wide(&pattern, remainder);
                // What is left of an approach counts by the sizes on the pattern itself.
                let is_settled = (0..self.scale.len()).all(|i| {
                    let off = remainder * (here.at.x[i] - there.at.x[i]).abs();
                    off <= self.tolerance.allowed(i, pattern.extent.size(i))
                });
                if is_settled && !self.accumulates(last, lag, &pattern) && is_wide() {
                    let shortest = self.shortest(last, lag);
                    repeating = shortest.map(|lag| self.pattern(last, lag, remainder));
                }
            }
        }
        repeating
    }

    /// Whether returns accumulate in time, as impacts do before a landing: they come ever closer in
    /// state as well, and no period is behind it.
    fn accumulates(&self, last: usize, lag: usize, pattern: &Pattern) -> bool {
        if self
            .forcing
            .is_some_and(|forcing| pattern.period < 0.5 * forcing)
        {
            return true;
        }
        let time = |periods: usize| {
            let point = self.points.get(last.checked_sub(periods * lag)?)?;
            Some(point.at.t)
        };
        let period = |k: usize| Some(time(k)? - time(k + 1)?);
        let shrinks = |k: usize| Some(period(k)? < (1.0 - LARGEST_REMAINDER) * period(k + 1)?);
        (0..RATIOS).all(|k| shrinks(k) == Some(true))
    }

    fn is_same(&self, one: &SectionPoint, other: &SectionPoint) -> bool {
        let rounding = SameWithin {
            closeness: 0.0,
            atol: 0.0.into(),
            rtol: ROUNDING / SOLVER_TOLERANCES,
        };
        self.apart(one, other, &rounding) <= 1.0
    }

    /// Largest difference of two points in units of the allowed one.
    fn apart(&self, one: &SectionPoint, other: &SectionPoint, near: &SameWithin) -> f64 {
        let mut most = 0.0_f64;
        for i in 0..self.scale.len() {
            let allowed = near.allowed(i, self.scale[i]);
            most = most.max((one.at.x[i] - other.at.x[i]).abs() / allowed);
        }
        if self.forcing.is_some() {
            let gap = (one.beat - other.beat).abs();
            most = most.max(gap.min(1.0 - gap) / near.allowed_of_phase());
        }
        most
    }

    /// Whether the last point equals the one a lag before it, to the tolerance.
    fn is_closed(&self, last: usize, lag: usize) -> bool {
        let (here, before) = (&self.points[last], &self.points[last - lag]);
        let tolerance = SameWithin {
            closeness: 0.0,
            atol: self.tolerance.atol.map(|atol| atol / SOLVER_TOLERANCES),
            rtol: self.tolerance.rtol / SOLVER_TOLERANCES,
        };
        here.tag == before.tag && self.apart(here, before, &tolerance) <= 1.0
    }

    /// Remaining distance to the pattern, in differences of points a lag apart, if it is small. It
    /// is the sum of a geometric series of these differences, with the slowest of the last few
    /// ratios. Points that creep past each other differ little, too.
    fn remaining(&self, last: usize, lag: usize) -> Option<f64> {
        let apart = |k: usize, near: &SameWithin| {
            let (here, before) = (&self.points[k], &self.points[k - lag]);
            let comparable = here.tag == before.tag;
            comparable.then(|| self.apart(here, before, near))
        };
        if self.is_closed(last, lag) {
            return Some(UNRESOLVED_DISTANCE);
        }
        if last < (RATIOS + 1) * lag {
            return None;
        }
        let mut slowest = 0.0_f64;
        for k in 0..RATIOS {
            let now = apart(last - k * lag, &self.tolerance)?;
            let before = apart(last - (k + 1) * lag, &self.tolerance)?;
            slowest = slowest.max(now / before);
        }
        let remainder = slowest / (1.0 - slowest);
        (slowest < 1.0 && apart(last, &self.tolerance)? * remainder <= 1.0).then_some(remainder)
    }

    /// The shortest pattern of which a repeating one consists; none if the orbit approaches a
    /// shorter one. An orbit that winds around a cycle nearly returns after several turns, before
    /// it does so after each.
    fn shortest(&self, last: usize, lag: usize) -> Option<usize> {
        for part in (1..lag).filter(|part| lag.is_multiple_of(*part)) {
            if self.runs[part - 1] >= lag {
                return Some(part);
            }
            let apart = |k: usize| {
                let (here, there) = (&self.points[k], self.points.get(k.checked_sub(part)?)?);
                (here.tag == there.tag).then(|| self.apart(here, there, &self.tolerance))
            };
            // A part with other transitions is no pattern.
            let Some(now) = apart(last) else {
                continue;
            };
            let before = last
                .checked_sub(APPROACH_REPETITIONS * lag)
                .and_then(apart)?;
            if now < APPROACH_RATIO * before {
                return None;
            }
        }
        Some(lag)
    }

    /// A pattern with this remaining distance, in differences of points.
    fn pattern(&self, last: usize, lag: usize, remainder: f64) -> Pattern {
        let (here, there) = (&self.points[last], &self.points[last - lag]);
        let mut extent = here.extent.clone();
        for point in self.points.range(last + 1 - lag..last) {
            extent.join(&point.extent);
        }
        let time = |periods: usize| {
            let point = self.points.get(last.checked_sub(periods * lag)?)?;
            Some(point.at.t)
        };
        let period = |k: usize| Some(time(k)? - time(k + 1)?);
        let change = |k: usize| Some((period(k)? - period(k + 1)?).abs());
        // For an orbit that winds around the pattern, one of two differences may be small by
        // coincidence. If points are the same, those before them may still have been approaching.
        let changes = match self.is_closed(last, lag) {
            true => [0.0; 2],
            false => [0, 1].map(|k| change(k).unwrap_or(0.0)),
        };
        let period = here.at.t - there.at.t;
        let rounding = match self.forcing {
            Some(_) => f64::EPSILON * here.at.t.abs(),
            None => self.tolerance.rounding_of_time(period),
        };
        Pattern {
            returns: lag,
            period,
            uncertainty: remainder * changes[0].max(changes[1]) + rounding,
            counts: (there.counts, here.counts),
            extent,
        }
    }

    /// Whether the remaining distance is small against the orbit's extent as well: an orbit that
    /// winds around an equilibrium also repeats itself ever more closely.
    fn is_wide(&self, pattern: &Pattern, remainder: f64) -> bool {
        let last = self.points.len() - 1;
        let (here, there) = (&self.points[last], &self.points[last - pattern.returns]);
        let Extent { low, high } = &pattern.extent;
        let mut moves = false;
        for i in 0..low.len() {
            let width = high[i] - low[i];
            let rounding = self.tolerance.rounding(i, pattern.extent.size(i));
            if width > rounding {
                moves |= width > LEAST_WIDTH * rounding;
                if remainder * (here.at.x[i] - there.at.x[i]).abs() > LARGEST_REMAINDER * width {
                    return false;
                }
            }
        }
        moves
    }
}
