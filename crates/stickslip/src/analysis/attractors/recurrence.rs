//! Whether the points of a section repeat.

use std::collections::VecDeque;

use super::SectionPoint;
use crate::system::State;

/// Tolerances by which two points may differ that the solver cannot tell apart.
const OF_SOLVER: f64 = 100.0;

/// Part of the scale that is kept from point to point: of a long way to the attractor nothing is left after some returns.
const KEPT: f64 = 0.9;

/// Ratios of differences that are looked at.
const RATIOS: usize = 3;

/// An orbit this many tolerances wide is more than a point of rest.
const WIDE: f64 = 100.0;

/// How near counts as the same.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nearness {
    /// Part of a component's size.
    pub closeness: f64,
    /// Of the solver.
    pub rtol: f64,
    pub atol: f64,
}

impl Nearness {
    /// By how much a component of this size may differ.
    pub fn allowed(&self, scale: f64) -> f64 {
        self.closeness * scale + self.rounding(scale)
    }

    /// What the solver leaves of a difference.
    pub fn rounding(&self, scale: f64) -> f64 {
        OF_SOLVER * (self.atol + self.rtol * scale)
    }
}

/// Smallest and largest value of each component at the ends of steps.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent<const N: usize> {
    pub low: State<N>,
    pub high: State<N>,
}

impl<const N: usize> Extent<N> {
    pub fn of(x: &State<N>) -> Self {
        Extent { low: *x, high: *x }
    }

    pub fn include(&mut self, x: &State<N>) {
        for i in 0..N {
            self.low[i] = self.low[i].min(x[i]);
            self.high[i] = self.high[i].max(x[i]);
        }
    }

    fn join(&mut self, other: &Self) {
        self.include(&other.low);
        self.include(&other.high);
    }

    /// Largest size of a component.
    pub fn size(&self, i: usize) -> f64 {
        self.low[i].abs().max(self.high[i].abs())
    }
}

/// A point with what is compared of it and what lies between it and the one before.
#[derive(Clone, Copy, Debug)]
struct Passage<const N: usize> {
    at: SectionPoint<N>,
    /// Stands for the transitions since the last point.
    tag: u64,
    /// Time modulo the forcing's period, in periods.
    beat: f64,
    /// How many phases had ended.
    phases: u64,
    extent: Extent<N>,
}

/// The last points of a section, and how long they have repeated with every lag.
pub(super) struct Recurrence<const N: usize> {
    near: Nearness,
    forcing: Option<f64>,
    passages: VecDeque<Passage<N>>,
    kept: usize,
    /// For every lag, counted from 1, how many points in a row are near those as many before.
    runs: Vec<usize>,
    /// Size of every component lately.
    scale: State<N>,
}

/// A pattern of the last points that repeats.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pattern<const N: usize> {
    pub returns: usize,
    pub period: f64,
    /// How many phases had ended before it and at its end.
    pub phases: (u64, u64),
    /// What the orbit covers in it.
    pub extent: Extent<N>,
}

impl<const N: usize> Recurrence<N> {
    pub fn new(near: Nearness, forcing: Option<f64>, most: usize, kept: usize) -> Self {
        let kept = kept.max((RATIOS + 1) * most + 1);
        Recurrence {
            near,
            forcing,
            passages: VecDeque::with_capacity(kept),
            kept,
            runs: vec![0; most],
            scale: State::zeros(),
        }
    }

    pub fn clear(&mut self) {
        self.passages.clear();
        self.runs.fill(0);
        self.scale = State::zeros();
    }

    pub fn points(&self) -> impl ExactSizeIterator<Item = &SectionPoint<N>> {
        self.passages.iter().map(|passage| &passage.at)
    }

    /// The last `count` points.
    pub fn last(&self, count: usize) -> Vec<SectionPoint<N>> {
        let from = self.passages.len().saturating_sub(count);
        self.points().skip(from).copied().collect()
    }

    /// Whether the orbit is still on its way to a pattern, or away from one: with some lag all of the last points came near to those before,
    /// and nearer, or less near, than earlier.
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

    /// Takes the next point; the shortest pattern that has now repeated often enough, if there is one.
    pub fn pass(
        &mut self,
        at: SectionPoint<N>,
        tag: u64,
        phases: u64,
        extent: Extent<N>,
    ) -> Option<Pattern<N>> {
        for i in 0..N {
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
            phases,
            extent,
        });
        let last = self.passages.len() - 1;
        let mut found = None;
        for lag in 1..=self.runs.len().min(last) {
            let (here, there) = (&self.passages[last], &self.passages[last - lag]);
            let repeats = here.tag == there.tag && self.apart(here, there, &self.near) <= 1.0;
            self.runs[lag - 1] = if repeats { self.runs[lag - 1] + 1 } else { 0 };
            if found.is_none() && self.runs[lag - 1] >= lag && self.has_settled(last, lag) {
                found = Some(self.pattern(last, lag));
            }
        }
        found
    }

    /// Largest difference of two points in units of what is allowed.
    fn apart(&self, one: &Passage<N>, other: &Passage<N>, near: &Nearness) -> f64 {
        let mut most = 0.0_f64;
        for i in 0..N {
            let allowed = near.allowed(self.scale[i]);
            most = most.max((one.at.x[i] - other.at.x[i]).abs() / allowed);
        }
        if self.forcing.is_some() {
            let gap = (one.beat - other.beat).abs();
            most = most.max(gap.min(1.0 - gap) / near.allowed(1.0));
        }
        most
    }

    /// Whether what is left of the way to the pattern is little: a geometric series of the differences of points a lag apart, by the
    /// slowest of the last few of its ratios. Points that creep past each other differ little, too.
    fn has_settled(&self, last: usize, lag: usize) -> bool {
        let apart = |k: usize, near: &Nearness| {
            let (here, before) = (&self.passages[k], &self.passages[k - lag]);
            let comparable = here.tag == before.tag;
            comparable.then(|| self.apart(here, before, near))
        };
        let tolerance = Nearness {
            closeness: 0.0,
            atol: self.near.atol / OF_SOLVER,
            rtol: self.near.rtol / OF_SOLVER,
        };
        if apart(last, &tolerance).is_some_and(|by| by <= 1.0) {
            return true;
        }
        if last < (RATIOS + 1) * lag {
            return false;
        }
        let mut slowest = 0.0_f64;
        for k in 0..RATIOS {
            let now = apart(last - k * lag, &self.near);
            let before = apart(last - (k + 1) * lag, &self.near);
            let (Some(now), Some(before)) = (now, before) else {
                return false;
            };
            slowest = slowest.max(now / before);
        }
        let now = apart(last, &self.near).unwrap_or(f64::INFINITY);
        slowest < 1.0 && now * slowest / (1.0 - slowest) <= 1.0
    }

    fn pattern(&self, last: usize, lag: usize) -> Pattern<N> {
        let (here, there) = (&self.passages[last], &self.passages[last - lag]);
        let mut extent = here.extent;
        for passage in self.passages.range(last + 1 - lag..last) {
            extent.join(&passage.extent);
        }
        Pattern {
            returns: lag,
            period: here.at.t - there.at.t,
            phases: (there.phases, here.phases),
            extent,
        }
    }

    /// Whether the pattern is more than a point of rest that the orbit turns about ever closer.
    pub fn is_wide(&self, pattern: &Pattern<N>) -> bool {
        let Extent { low, high } = pattern.extent;
        (0..N).any(|i| high[i] - low[i] > WIDE * self.near.allowed(pattern.extent.size(i)))
    }
}
