//! Whether the points of a section repeat.

use std::collections::VecDeque;

use super::nearness::{Extent, Nearness, OF_SOLVER};
use crate::dynamics::{Moment, Vector};

/// Fraction of the scale that is kept from point to point: a long approach to the attractor is
/// forgotten after some returns.
const KEPT: f64 = 0.9;

/// Number of ratios of differences that are examined.
const RATIOS: usize = 3;

/// Differences count as shrinking if over this many repetitions they fall below this fraction of
/// their former size.
const SHRINKING: (usize, f64) = (4, 0.9);

/// Number of closenesses that may remain of the approach where differences are too small to show a
/// ratio.
const UNSEEN: f64 = 100.0;

/// Two states are the same if they differ by at most so many units in the last place of a
/// component's size. They occur where stick leaves one state only, as in unforced systems of two
/// states.
const SAME: f64 = 64.0;

/// Number of roundings of the solver that a cycle must exceed in width.
const WIDE: f64 = 10.0;

/// Fraction of a cycle's extent that may remain of the approach to it.
const LITTLE: f64 = 0.01;

/// Counts of what has happened.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Count {
    /// Phases that have ended.
    pub phases: u64,
    /// Transitions, touches excluded.
    pub transitions: u64,
}

/// A point with the quantities that are compared, and what lies between it and the one before.
#[derive(Clone, Debug)]
struct Passage {
    at: Moment,
    /// Represents the transitions since the last point.
    tag: u64,
    /// Time modulo the forcing's period, in periods.
    beat: f64,
    /// Counts before this point.
    count: Count,
    extent: Extent,
}

/// The last points of a section, and how long they have repeated with each lag.
pub(super) struct Recurrence {
    near: Nearness,
    forcing: Option<f64>,
    passages: VecDeque<Passage>,
    kept: usize,
    /// For every lag, counted from 1, how many consecutive points are near the point one lag
    /// before.
    runs: Vec<usize>,
    /// Recent size of every component.
    scale: Vector,
}

/// A repeating pattern of the last points.
#[derive(Clone, Debug)]
pub(super) struct Pattern {
    pub returns: usize,
    pub period: f64,
    /// By how much that may be off.
    pub uncertainty: f64,
    /// Counts before it and at its end.
    pub counts: (Count, Count),
    /// The extent of the orbit in it.
    pub extent: Extent,
}

impl Recurrence {
    pub fn new(
        states: usize,
        near: Nearness,
        forcing: Option<f64>,
        (most, kept): (usize, usize),
    ) -> Self {
        let kept = kept.max((SHRINKING.0 + 1) * most + 1);
        Recurrence {
            near,
            forcing,
            passages: VecDeque::new(),
            kept,
            runs: vec![0; most],
            scale: Vector::zeros(states),
        }
    }

    pub fn clear(&mut self) {
        self.passages.clear();
        self.runs.fill(0);
        self.scale.fill(0.0);
    }

    pub fn points(&self) -> impl ExactSizeIterator<Item = &Moment> {
        self.passages.iter().map(|passage| &passage.at)
    }

    /// The last `count` points.
    pub fn last(&self, count: usize) -> Vec<Moment> {
        let from = self.passages.len().saturating_sub(count);
        self.points().skip(from).cloned().collect()
    }

    /// Whether the orbit is still approaching a pattern or leaving one: with some lag all of the
    /// last points came near those before, and their distance grows or shrinks.
    pub fn still_moves(&self, part: f64) -> bool {
        const STEADY: f64 = 1.25;
        let near = Nearness {
            closeness: part,
            ..self.near
        };
        let total = self.passages.len();
        let quarter = total / 4;
        let mean = |lag: usize, last: usize| {
            let mut sum = 0.0;
            for k in last - quarter..last {
                let (here, there) = (&self.passages[k], self.passages.get(k.checked_sub(lag)?)?);
                let apart = self.apart(here, there, &near);
                if here.tag != there.tag || apart > 1.0 {
                    return None;
                }
                sum += apart;
            }
            Some(sum)
        };
        (1..=self.runs.len()).any(|lag| {
            let Some(now) = mean(lag, total) else {
                return false;
            };
            mean(lag, total - quarter)
                .is_none_or(|before| now > STEADY * before || before > STEADY * now)
        })
    }

    /// Adds the next point; returns the shortest pattern that has repeated often enough, if any.
    pub fn pass(&mut self, at: Moment, tag: u64, count: Count, extent: Extent) -> Option<Pattern> {
        for i in 0..self.scale.len() {
            self.scale[i] = extent.size(i).max(KEPT * self.scale[i]);
        }
        if self.passages.len() == self.kept {
            self.passages.pop_front();
        }
        let beats = self.forcing.map_or(0.0, |period| at.t / period);
        self.passages.push_back(Passage {
            at,
            tag,
            beat: beats - beats.floor(),
            count,
            extent,
        });
        let last = self.passages.len() - 1;
        let mut found = None;
        for lag in 1..=self.runs.len().min(last) {
            let (here, there) = (&self.passages[last], &self.passages[last - lag]);
            let repeats = here.tag == there.tag && self.apart(here, there, &self.near) <= 1.0;
            self.runs[lag - 1] = if repeats { self.runs[lag - 1] + 1 } else { 0 };
            // A state has one future: the whole pattern need not be seen again.
            let wanted = if self.is_same(here, there) { 1 } else { lag };
            if found.is_none()
                && self.runs[lag - 1] >= wanted
                && let Some(left) = self.left(last, lag)
            {
                let pattern = self.pattern(last, lag, left);
                if self.forcing.is_some() || self.is_wide(&pattern, left) {
                    let shortest = self.shortest(last, lag);
                    found = shortest.map(|lag| self.pattern(last, lag, left));
                }
            }
        }
        found
    }

    fn is_same(&self, one: &Passage, other: &Passage) -> bool {
        let rounding = Nearness {
            closeness: 0.0,
            atol: 0.0,
            rtol: SAME * f64::EPSILON / OF_SOLVER,
        };
        self.apart(one, other, &rounding) <= 1.0
    }

    /// Largest difference of two points in units of the allowed one.
    fn apart(&self, one: &Passage, other: &Passage, near: &Nearness) -> f64 {
        let mut most = 0.0_f64;
        for i in 0..self.scale.len() {
            let allowed = near.allowed(self.scale[i]);
            most = most.max((one.at.x[i] - other.at.x[i]).abs() / allowed);
        }
        if self.forcing.is_some() {
            let gap = (one.beat - other.beat).abs();
            most = most.max(gap.min(1.0 - gap) / near.allowed(1.0));
        }
        most
    }

    /// Whether the last point equals the one a lag before it, to the tolerance.
    fn is_closed(&self, last: usize, lag: usize) -> bool {
        let (here, before) = (&self.passages[last], &self.passages[last - lag]);
        let tolerance = Nearness {
            closeness: 0.0,
            atol: self.near.atol / OF_SOLVER,
            rtol: self.near.rtol / OF_SOLVER,
        };
        here.tag == before.tag && self.apart(here, before, &tolerance) <= 1.0
    }

    /// Remaining distance to the pattern, in differences of points a lag apart, if it is small. It
    /// is the sum of a geometric series of these differences, with the slowest of the last few
    /// ratios: points that creep past each other differ little, too.
    fn left(&self, last: usize, lag: usize) -> Option<f64> {
        let apart = |k: usize, near: &Nearness| {
            let (here, before) = (&self.passages[k], &self.passages[k - lag]);
            let comparable = here.tag == before.tag;
            comparable.then(|| self.apart(here, before, near))
        };
        if self.is_closed(last, lag) {
            return Some(UNSEEN);
        }
        if last < (RATIOS + 1) * lag {
            return None;
        }
        let mut slowest = 0.0_f64;
        for k in 0..RATIOS {
            let now = apart(last - k * lag, &self.near)?;
            let before = apart(last - (k + 1) * lag, &self.near)?;
            slowest = slowest.max(now / before);
        }
        let left = slowest / (1.0 - slowest);
        (slowest < 1.0 && apart(last, &self.near)? * left <= 1.0).then_some(left)
    }

    /// The shortest pattern of which a repeating one consists; none if the orbit approaches a
    /// shorter one. An orbit that winds around a cycle nearly returns after several turns before it
    /// does after each.
    fn shortest(&self, last: usize, lag: usize) -> Option<usize> {
        for part in (1..lag).filter(|part| lag.is_multiple_of(*part)) {
            if self.runs[part - 1] >= lag {
                return Some(part);
            }
            let apart = |k: usize| {
                let (here, there) = (&self.passages[k], self.passages.get(k.checked_sub(part)?)?);
                (here.tag == there.tag).then(|| self.apart(here, there, &self.near))
            };
            // A part with other transitions is no pattern.
            let Some(now) = apart(last) else {
                continue;
            };
            let before = last.checked_sub(SHRINKING.0 * lag).and_then(apart)?;
            if now < SHRINKING.1 * before {
                return None;
            }
        }
        Some(lag)
    }

    /// A pattern with this remaining distance, in differences of points.
    fn pattern(&self, last: usize, lag: usize, left: f64) -> Pattern {
        let (here, there) = (&self.passages[last], &self.passages[last - lag]);
        let mut extent = here.extent.clone();
        for passage in self.passages.range(last + 1 - lag..last) {
            extent.join(&passage.extent);
        }
        let time = |periods: usize| {
            let passage = self.passages.get(last.checked_sub(periods * lag)?)?;
            Some(passage.at.t)
        };
        let period = |k: usize| Some(time(k)? - time(k + 1)?);
        let change = |k: usize| Some((period(k)? - period(k + 1)?).abs());
        // For an orbit that winds around the pattern, one of two differences may be small by
        // chance. Where points are the same, those before them may still have been approaching.
        let changes = match self.is_closed(last, lag) {
            true => [0.0; 2],
            false => [0, 1].map(|k| change(k).unwrap_or(0.0)),
        };
        let period = here.at.t - there.at.t;
        let rounding = match self.forcing {
            Some(_) => f64::EPSILON * here.at.t.abs(),
            None => self.near.rounding(period),
        };
        Pattern {
            returns: lag,
            period,
            uncertainty: left * changes[0].max(changes[1]) + rounding,
            counts: (there.count, here.count),
            extent,
        }
    }

    /// Whether the remaining distance is small against the orbit's extent as well: an orbit that
    /// winds around an equilibrium also repeats itself ever more closely.
    fn is_wide(&self, pattern: &Pattern, left: f64) -> bool {
        let last = self.passages.len() - 1;
        let (here, there) = (&self.passages[last], &self.passages[last - pattern.returns]);
        let Extent { low, high } = &pattern.extent;
        let mut moves = false;
        for i in 0..low.len() {
            let width = high[i] - low[i];
            let rounding = self.near.rounding(pattern.extent.size(i));
            if width > rounding {
                moves |= width > WIDE * rounding;
                if left * (here.at.x[i] - there.at.x[i]).abs() > LITTLE * width {
                    return false;
                }
            }
        }
        moves
    }
}
