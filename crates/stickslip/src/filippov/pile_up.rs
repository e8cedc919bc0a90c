//! Detects transitions, or branchings of a field, that pile up (Zeno), and extrapolates where they
//! accumulate.
//!
//! Near an accumulation point every round of phases is the previous one, scaled by a ratio. The
//! durations are a geometric series, and Aitken's extrapolation gives its limit.

use std::ops::Range;

use super::memory::state;
use super::options::Options;
use super::run::{StepState, TIME_ROUNDING};
use crate::dynamics::{Modes, Vector};
use crate::error::{Accumulation, Error, Point};
use crate::ode::Timed;
use crate::system::{Mode, State};

/// A phase is resolved if some component moves by more than so many tolerances in it. Chosen: the
/// errors of the two events that bound it are then below a hundredth of the motion.
const RESOLVED_MOTION: f64 = 100.0;

/// The ratio of two motions up to so many tolerances says nothing. Chosen: errors of steps and
/// events are a tenth of the smallest of them.
const UNCERTAIN_MOTION: f64 = 10.0 * RESOLVED_MOTION;

/// A motion that has come below so many tolerances shrinks further. Chosen: the errors of steps
/// keep the motion from vanishing, at a size that depends on the method.
const SHRUNK_MOTION: f64 = RESOLVED_MOTION;

/// Number of unresolved phases that tell whether they last. Chosen: so many of a pile-up last only
/// if its ratio exceeds 0.99, and such a ratio forms a series.
const SHRINKING_PHASES: usize = 20;

/// Phases last if half of them take at least this part of the time of the half before. Chosen
/// between 1, the limit as an orbit shrinks to a point, and pile-ups.
const LASTING_PART: f64 = 0.9;

/// Number of transitions that are kept: the ends of three rounds of up to 15 phases.
const HISTORY: usize = 3 * 15 + 1;

/// Largest difference between the extrapolations of two rounds, as a part of the remaining time.
/// Chosen: durations that are no geometric series differ by about all of it.
const SERIES_AGREEMENT: f64 = 0.1;

/// Number of earlier limits that a limit is compared with. Chosen: two that are off by rounding are
/// seldom the same as a third.
const EARLIER_LIMITS: usize = 3;

/// Counts events within a span of time that counts as none.
struct Burst {
    since: f64,
    count: usize,
}

impl Burst {
    fn new() -> Self {
        Burst {
            since: f64::NEG_INFINITY,
            count: 0,
        }
    }

    /// Counts an event at time `t`.
    fn record(&mut self, t: f64, options: &Options) {
        if t - self.since > negligible_span(t, options) {
            (self.since, self.count) = (t, 0);
        }
        self.count += 1;
    }
}

/// Time span that counts as zero at time `t`.
fn negligible_span(t: f64, options: &Options) -> f64 {
    options.pile_up_span * t.abs().max(1.0)
}

/// Rounding of a time.
fn time_rounding(t: f64) -> f64 {
    TIME_ROUNDING * t.abs()
}

/// A transition of the past.
#[derive(Clone, Copy)]
struct PastTransition<const N: usize, K> {
    at: Timed<N>,
    contact: usize,
    to: K,
    /// Extent of the motion since the transition before it.
    extent: f64,
}

/// Half of the recorded phases: how long they last, and the largest extent of the motion in one.
struct Half {
    duration: f64,
    extent: f64,
}

/// The geometric series that the last transitions form.
pub struct GeometricSeries<const N: usize> {
    /// Accumulation point.
    pub at: Timed<N>,
    /// Uncertainty of that time.
    pub uncertainty: f64,
    /// Remaining motion of the state (largest component).
    pub distance: f64,
    /// Ratio of successive durations, as the mean over a round.
    ratio: f64,
    /// The contacts of a round, in order.
    pub contacts: Vec<usize>,
}

/// Transitions pile up if they come ever faster within a span of time that counts as none. They
/// also do if the motion between them falls below what error control resolves and shrinks further.
/// A loose tolerance then stops the orbit before the accumulation point.
pub struct PileUpDetector<const N: usize, K> {
    burst: Burst,
    /// Extent of the motion since the last transition: the largest distance of a component from its
    /// value there, in tolerances; 0 if it is rounding.
    extent: f64,
    /// Extent before the last step.
    before_step: f64,
    /// Whether a phase was resolved.
    has_moved: bool,
    /// Number of unresolved phases in a row over which the motion shrinks, and whether time moves
    /// the state in one of them.
    unresolved: usize,
    is_driven: bool,
    /// The modes of the contacts.
    modes: fn(&K) -> &[Mode],
    /// The number of transitions, and the last of them: number `i` at index `i % HISTORY`.
    count: usize,
    last: [PastTransition<N, K>; HISTORY],
}

/// A detector between two steps.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct PileUpMemory {
    /// Start of the burst, if there is one, and its number of events.
    burst: (Option<f64>, usize),
    extent: f64,
    has_moved: bool,
    unresolved: (usize, bool),
    count: usize,
    /// Time, state, contact, modes and extent of the last transitions, the oldest first; of the
    /// start if there was none.
    last: Vec<(f64, Vector, usize, Modes, f64)>,
}

impl<const N: usize, K: Copy + PartialEq> PileUpDetector<N, K> {
    /// The detector between two steps.
    pub(crate) fn memory(&self) -> PileUpMemory {
        let past = |back: usize| {
            let PastTransition {
                at,
                contact,
                to,
                extent,
            } = self.nth_last(back);
            let x = Vector::from_column_slice(at.x.as_slice());
            (at.t, x, *contact, Modes::new((self.modes)(to)), *extent)
        };
        PileUpMemory {
            burst: (
                Some(self.burst.since).filter(|t| t.is_finite()),
                self.burst.count,
            ),
            extent: self.extent,
            has_moved: self.has_moved,
            unresolved: (self.unresolved, self.is_driven),
            count: self.count,
            last: (0..self.recorded().max(1)).rev().map(past).collect(),
        }
    }

    /// The detector of a memory; `None` if it is of another system.
    pub(crate) fn restored(
        memory: &PileUpMemory,
        restored: fn(Modes) -> K,
        modes: fn(&K) -> &[Mode],
    ) -> Option<Self> {
        let past = |(t, x, contact, to, extent): &(f64, Vector, usize, Modes, f64)| {
            Some(PastTransition {
                at: Timed {
                    t: *t,
                    x: state(x)?,
                },
                contact: *contact,
                to: restored(*to),
                extent: *extent,
            })
        };
        let last: Vec<_> = memory.last.iter().map(past).collect::<Option<_>>()?;
        let recorded = memory.count.clamp(1, HISTORY);
        let is_whole = last.len() == recorded && memory.count.checked_add(HISTORY).is_some();
        let newest = last.last().filter(|_| is_whole)?;
        let mut detector = PileUpDetector::new(&newest.at, newest.to, modes);
        for (back, past) in last.iter().rev().enumerate() {
            detector.last[(memory.count + HISTORY - 1 - back) % HISTORY] = *past;
        }
        detector.burst = Burst {
            since: memory.burst.0.unwrap_or(f64::NEG_INFINITY),
            count: memory.burst.1,
        };
        (detector.extent, detector.has_moved) = (memory.extent, memory.has_moved);
        (detector.unresolved, detector.is_driven) = memory.unresolved;
        detector.count = memory.count;
        Some(detector)
    }

    /// A detector before any transition; `at` and `mode` are placeholders.
    pub(crate) fn new(at: &Timed<N>, mode: K, modes: fn(&K) -> &[Mode]) -> Self {
        let nowhere = PastTransition {
            at: *at,
            contact: 0,
            to: mode,
            extent: 0.0,
        };
        PileUpDetector {
            burst: Burst::new(),
            extent: 0.0,
            before_step: 0.0,
            has_moved: false,
            unresolved: 0,
            is_driven: false,
            modes,
            count: 0,
            last: [nowhere; HISTORY],
        }
    }

    fn recorded(&self) -> usize {
        self.count.min(HISTORY)
    }

    /// The `n`-th last transition, counted from 0.
    fn nth_last(&self, n: usize) -> &PastTransition<N, K> {
        &self.last[(self.count + HISTORY - 1 - n) % HISTORY]
    }

    /// Whether a recorded transition is of one of these contacts and jumps.
    pub(crate) fn has_one_of(&self, numbers: Range<usize>) -> bool {
        (0..self.recorded()).any(|back| numbers.contains(&self.nth_last(back).contact))
    }

    /// The contacts and jumps of the last `count` transitions, and the contacts whose modes these
    /// jumps change, in ascending order.
    fn contacts(&self, count: usize) -> Vec<usize> {
        let mut contacts: Vec<usize> = (0..count).map(|back| self.nth_last(back).contact).collect();
        for back in 0..count.min(self.recorded().saturating_sub(1)) {
            let [to, from] = [back, back + 1].map(|back| (self.modes)(&self.nth_last(back).to));
            contacts.extend((0..to.len()).filter(|&i| to[i] != from[i]));
        }
        contacts.sort_unstable();
        contacts.dedup();
        contacts
    }

    /// Follows the motion over the last step of a run.
    #[inline]
    pub(crate) fn follow<const G: usize>(&mut self, run: &StepState<N, G>) {
        let ((start, end), options) = (&run.last, &run.options);
        self.before_step = self.extent;
        let from = self.nth_last(0).at.x;
        let reached = |extent: f64, (i, x): (usize, f64)| {
            let (moved, size) = ((x - from[i]).abs(), from[i].abs());
            if moved <= TIME_ROUNDING * size {
                return extent;
            }
            extent.max(moved / options.allowed(i, size))
        };
        self.extent = end.x.iter().copied().enumerate().fold(self.extent, reached);
        // A step may lead back to where it began.
        if self.extent <= RESOLVED_MOTION && run.dense.t0 == start.t {
            let part = ((end.t - start.t) / run.dense.h).min(1.0);
            let ranges = run
                .dense
                .enclosure_between(0.0, part)
                .into_iter()
                .enumerate();
            let bounds = ranges.flat_map(|(i, range)| [(i, range.low), (i, range.high)]);
            self.extent = bounds.fold(self.extent, reached);
        }
    }

    /// Follows the motion over the last step anew, which a jump has cut.
    pub(crate) fn follow_cut<const G: usize>(&mut self, run: &StepState<N, G>) {
        self.extent = self.before_step;
        self.follow(run);
    }

    /// Records a transition of a contact into the mode `to`; `is_driven` tells whether time alone
    /// moves the state there. Returns whether the transition belongs to a pile-up.
    pub(crate) fn record(
        &mut self,
        at: &Timed<N>,
        (contact, to): (usize, K),
        is_driven: impl FnOnce() -> bool,
        options: &Options,
    ) -> bool {
        self.burst.record(at.t, options);
        let extent = std::mem::take(&mut self.extent);
        self.last[self.count % HISTORY] = PastTransition {
            at: *at,
            contact,
            to,
            extent,
        };
        self.count += 1;
        self.has_moved |= extent > RESOLVED_MOTION;
        // What was never resolved may as well go on at its size: errors of steps hide the
        // difference.
        let shrinks = || {
            let [later, earlier] = self.halves();
            later.extent < earlier.extent || later.extent <= SHRUNK_MOTION
        };
        if extent <= RESOLVED_MOTION && self.has_moved && shrinks() {
            self.unresolved += 1;
            self.is_driven |= is_driven();
        } else {
            (self.unresolved, self.is_driven) = (0, false);
        }
        // What is driven may move again, unless its transitions leave no time for that.
        let leads_to_a_point = || !self.is_driven || self.series().is_some();
        let is_unresolved = self.unresolved >= options.pile_up_count || self.shrinks(options);
        self.bursts(options) || is_unresolved && leads_to_a_point()
    }

    /// The newer and the older half of the recorded phases.
    fn halves(&self) -> [Half; 2] {
        self.halves_of(self.recorded().saturating_sub(1))
    }

    /// The newer and the older half of the last phases.
    fn halves_of(&self, phases: usize) -> [Half; 2] {
        let half = phases / 2;
        [0, half].map(|newest| Half {
            duration: self.nth_last(newest).at.t - self.nth_last(newest + half).at.t,
            extent: (newest..newest + half)
                .fold(0.0, |most, back| most.max(self.nth_last(back).extent)),
        })
    }

    /// Whether so many transitions have happened within no time, and at their ratio all others
    /// will, or as fast as rounding allows. A fast clock is no pile-up, nor is one that runs faster
    /// for a while. The motion shrinks at least as the root of the time, or it does not accumulate.
    fn bursts(&self, options: &Options) -> bool {
        if self.burst.count < options.pile_up_count {
            return false;
        }
        let [later, earlier] = self.halves();
        let t = self.nth_last(0).at.t;
        let left = later.duration * later.duration / (earlier.duration - later.duration);
        let ratio = later.extent / earlier.extent;
        let accumulates = (0.0..=negligible_span(t, options)).contains(&left)
            && (later.extent <= UNCERTAIN_MOTION
                || ratio * ratio <= later.duration / earlier.duration);
        let by_rounding = (self.recorded().saturating_sub(1) / 2) as f64 * time_rounding(t);
        accumulates || later.duration <= by_rounding
    }

    /// Whether the orbit approaches a point in infinite time: the motion shrinks below what is
    /// resolved, and its phases last.
    pub(crate) fn shrinks(&self, options: &Options) -> bool {
        let unresolved = self.unresolved.min(HISTORY - 1);
        let [later, earlier] = self.halves_of(unresolved);
        unresolved >= SHRINKING_PHASES
            && later.duration >= LASTING_PART * earlier.duration
            && !self.bursts(options)
    }

    /// Whether the last transition belongs to this contact and this time.
    pub(crate) fn is_last(&self, contact: usize, t: f64) -> bool {
        let last = self.nth_last(0);
        self.count > 0 && last.at.t == t && last.contact == contact
    }

    /// The geometric series of the last transitions, if they form one: three rounds in a row with
    /// the same ratio. Of all rounds, those with the least uncertainty of the limit count. Its
    /// differences from the limits by rounds before them are part of it: the last may be rounding.
    /// The state there is that of the last rounds, which are nearest to it.
    pub(crate) fn series(&self) -> Option<GeometricSeries<N>> {
        let best = |best: Option<GeometricSeries<N>>, (newest, round)| {
            let mut one = self.series_by_rounds(round, newest);
            for earlier in 1..=EARLIER_LIMITS {
                let earlier = self.series_by_rounds(round, newest + earlier);
                if let (Some(one), Some(earlier)) = (&mut one, earlier) {
                    one.uncertainty += (one.at.t - earlier.at.t).abs();
                }
            }
            match (&best, &one) {
                (Some(old), Some(new)) if new.uncertainty >= old.uncertainty => best,
                (_, None) => best,
                _ => one,
            }
        };
        let phases = self.recorded().saturating_sub(1);
        // Rounding may change the ratio of shorter phases by more than the agreement required.
        let shortest = time_rounding(self.nth_last(0).at.t) / (SERIES_AGREEMENT * SERIES_AGREEMENT);
        let lasts = |k: usize| self.nth_last(k).at.t - self.nth_last(k + 1).at.t;
        let newest = (0..phases).find(|&k| lasts(k) > shortest)?;
        let until = |newest: usize| {
            let rounds = 1..=(phases - newest) / 3;
            rounds.map(|round| (newest, round)).fold(None, best)
        };
        let mut all = (newest..phases).filter_map(until);
        let latest = all.next()?;
        let (x, distance) = (latest.at.x, latest.distance);
        let mut series = all.fold(latest, |least, other| {
            match other.uncertainty < least.uncertainty {
                true => other,
                false => least,
            }
        });
        (series.at.x, series.distance) = (x, distance);
        Some(series)
    }

    /// The series by three rounds of `round` transitions, the last of them the `newest`-th last.
    fn series_by_rounds(&self, round: usize, newest: usize) -> Option<GeometricSeries<N>> {
        if newest + 3 * round >= self.recorded() {
            return None;
        }
        let contact = |back: usize| self.nth_last(newest + back).contact;
        if !(0..2 * round).all(|back| contact(back) == contact(back + round)) {
            return None;
        }
        let at = |rounds: usize| &self.nth_last(newest + rounds * round).at;
        let [d0, d1, d2] = [0, 1, 2].map(|rounds| at(rounds).t - at(rounds + 1).t);
        let [moved, moved_before] = [0, 1].map(|rounds| at(rounds).x - at(rounds + 1).x);
        let (ratio, before) = (d0 / d1, d1 / d2);
        let shrunk_by = moved.amax() / moved_before.amax();
        // An orbit that approaches a point in infinite time has phases that do not shorten.
        let shrinks = |ratio: f64| 0.0 < ratio && ratio < 1.0;
        let lasts = ratio > shrunk_by.sqrt();
        if !shrinks(ratio) || !shrinks(before) || !shrinks(shrunk_by) || lasts {
            return None;
        }
        let rounds_left = |ratio: f64| ratio / (1.0 - ratio);
        let left = d0 * rounds_left(ratio);
        let now = at(0);
        let by_rounding = time_rounding(now.t) * (1.0 + 2.0 / ((1.0 - ratio) * (1.0 - ratio)));
        let uncertainty = (left - d0 * rounds_left(before)).abs() + by_rounding;
        let is_behind = now.t + left + uncertainty >= self.last_resolved();
        if uncertainty > SERIES_AGREEMENT * left || !is_behind {
            return None;
        }
        // The mean rate over a round goes on to change in time as it has. One that oscillates has a
        // negative ratio.
        let remaining = State::from(std::array::from_fn::<_, N, _>(|i| {
            let own = moved[i] / moved_before[i];
            if own > 0.0 && own.is_finite() {
                let [rate, rate_before] = [moved[i] / d0, moved_before[i] / d1];
                let bend = (rate - rate_before) / (d0 + d1);
                left * (rate + bend * (left + d0))
            } else if own.is_finite() {
                moved[i] * rounds_left(own.max(-ratio))
            } else {
                0.0
            }
        }));
        Some(GeometricSeries {
            at: Timed {
                t: now.t + left,
                x: now.x + remaining,
            },
            uncertainty,
            distance: rounds_left(ratio) * moved.amax(),
            ratio: crate::math::pow(ratio, 1.0 / round as f64),
            contacts: self.contacts(round),
        })
    }

    /// Time of the last transition to which the motion is larger than the tolerance. What follows
    /// it within the tolerance contradicts no limit.
    fn last_resolved(&self) -> f64 {
        let all = (0..self.recorded()).map(|back| self.nth_last(back));
        let last = all.clone().find(|one| one.extent >= 1.0);
        let last = last.or(all.last());
        last.map_or(f64::NEG_INFINITY, |one| one.at.t)
    }

    /// The mode after the present transition at time `t`, as recorded. If it is not recorded yet:
    /// the mode that followed the last time that the previous transition led to the same mode.
    pub(crate) fn mode_after(&self, t: f64) -> Option<K> {
        let newest = self.nth_last(0);
        if newest.at.t == t {
            return Some(newest.to);
        }
        let mut earlier = 1..self.recorded();
        let same_mode = earlier.find(|&back| self.nth_last(back).to == newest.to)?;
        Some(self.nth_last(same_mode - 1).to)
    }

    /// The error for a pile-up of the transitions up to `at`; `holds` as in [`Accumulation`].
    pub(crate) fn error(
        &self,
        at: &Timed<N>,
        series: Option<&GeometricSeries<N>>,
        holds: bool,
        options: &Options,
    ) -> Error {
        let recorded = self.recorded();
        let (count, span) = if self.bursts(options) {
            (self.burst.count, at.t - self.burst.since)
        } else {
            (
                recorded,
                at.t - self.nth_last(recorded.saturating_sub(1)).at.t,
            )
        };
        Error::EventPileUp {
            count,
            span,
            t: at.t,
            x: Point::from(&at.x),
            contacts: series
                .map_or_else(|| self.contacts(recorded), |series| series.contacts.clone()),
            accumulation: series.map(|series| {
                Box::new(Accumulation {
                    t: series.at.t,
                    uncertainty: series.uncertainty,
                    x: Point::from(&series.at.x),
                    ratio: series.ratio,
                    holds,
                })
            }),
        }
    }

    /// The series of the last transitions, if it accumulates within no time of `t`.
    pub(crate) fn series_reached_at(
        &self,
        t: f64,
        options: &Options,
    ) -> Option<GeometricSeries<N>> {
        let series = self.series()?;
        (series.at.t - t <= negligible_span(t, options)).then_some(series)
    }

    /// The series of the last transitions, if all its contacts are among those that reach zero
    /// together at time `t`.
    pub(crate) fn series_of_contacts(
        &self,
        t: f64,
        contacts: &[usize],
    ) -> Option<GeometricSeries<N>> {
        let series = self.series()?;
        let are_among = series.contacts.iter().all(|one| contacts.contains(one));
        (are_among && t <= series.at.t + series.uncertainty).then_some(series)
    }
}
