//! Detects transitions, or branchings of a field, that pile up (Zeno), and extrapolates where they
//! accumulate.
//!
//! Near an accumulation point every round of phases is the previous one, scaled by a ratio. The
//! durations are a geometric series, and Aitken's extrapolation gives its limit.

use super::options::Options;
use crate::error::{Accumulation, Error, Point};
use crate::ode::Timed;
use crate::system::State;

/// A phase over which no component moves by more than so many tolerances is not resolved.
const UNRESOLVED: f64 = 100.0;

/// An orbit shrinks to a point if it has so many unresolved phases that last …
const FEWEST: usize = 10;

/// … at least this fraction of the first of them.
const LASTS: f64 = 0.9;

/// Number of transitions that are kept: three rounds of up to 15.
const KEPT: usize = 46;

/// The extrapolations of two rounds must agree to this fraction of the remaining time. Durations
/// that are no geometric series differ by about all of it.
const AGREEING: f64 = 0.1;

/// Rounding of a transition's time, in units in the last place.
const ULPS: f64 = 4.0;

/// Counts events that happen within no time.
pub struct Burst {
    since: f64,
    count: usize,
}

impl Burst {
    pub(crate) fn new() -> Self {
        Burst {
            since: f64::NEG_INFINITY,
            count: 0,
        }
    }

    /// Counts one more, at time `t`. Returns how many there are, and within what time.
    #[inline]
    pub(crate) fn note(&mut self, t: f64, options: &Options) -> (usize, f64) {
        if t - self.since > no_time(t, options) {
            (self.since, self.count) = (t, 0);
        }
        self.count += 1;
        (self.count, t - self.since)
    }
}

/// The span that counts as no time at `t`.
fn no_time(t: f64, options: &Options) -> f64 {
    options.pile_up_span * t.abs().max(1.0)
}

/// Rounding of a time.
fn blur(t: f64) -> f64 {
    ULPS * f64::EPSILON * t.abs()
}

/// A recorded transition.
#[derive(Clone, Copy)]
struct Passage<const N: usize, K> {
    at: Timed<N>,
    contact: usize,
    to: K,
}

/// The geometric series that the last transitions form.
pub struct Series<const N: usize> {
    /// Where it accumulates.
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

/// Transitions pile up if many of them happen within no time. They also do if many phases in a row
/// are too short for error control to separate their ends: then a loose tolerance has stopped the
/// orbit before the accumulation point.
pub struct PileUp<const N: usize, K> {
    burst: Burst,
    /// Unresolved phases in a row, the length of the first, and how many last as long.
    unresolved: usize,
    first: f64,
    lasting: usize,
    /// The number of transitions, and the last of them: number `i` at index `i % KEPT`.
    count: usize,
    last: [Passage<N, K>; KEPT],
}

impl<const N: usize, K: Copy + PartialEq> PileUp<N, K> {
    /// Before any transition; `at` and `mode` are placeholders.
    pub(crate) fn new(at: &Timed<N>, mode: K) -> Self {
        let nowhere = Passage {
            at: *at,
            contact: 0,
            to: mode,
        };
        PileUp {
            burst: Burst::new(),
            unresolved: 0,
            first: 0.0,
            lasting: 0,
            count: 0,
            last: [nowhere; KEPT],
        }
    }

    fn kept(&self) -> usize {
        self.count.min(KEPT)
    }

    /// The last recorded transition but so many.
    fn back(&self, back: usize) -> &Passage<N, K> {
        &self.last[(self.count + KEPT - 1 - back) % KEPT]
    }

    /// The contacts of so many of the last transitions, in order.
    fn contacts(&self, count: usize) -> Vec<usize> {
        let mut contacts: Vec<usize> = (0..count).map(|back| self.back(back).contact).collect();
        contacts.sort_unstable();
        contacts.dedup();
        contacts
    }

    /// Counts a transition of a contact into the mode `to`, where the state moves with `velocity`.
    /// Returns whether it belongs to a pile-up.
    pub(crate) fn note(
        &mut self,
        at: &Timed<N>,
        (contact, to): (usize, K),
        velocity: &State<N>,
        options: &Options,
    ) -> bool {
        self.burst.note(at.t, options);
        let before = self.back(0).at;
        let time = at.t - before.t;
        // A body on a floor is at rest at either end of a slip. So its motion decides, not its
        // velocity.
        let is_resolved = |i: usize| {
            let by_rate = time * velocity[i].abs();
            let moved = f64::max((at.x[i] - before.x[i]).abs(), by_rate);
            moved > UNRESOLVED * (options.atol + options.rtol * at.x[i].abs())
        };
        let resolved = self.count == 0 || (0..N).any(is_resolved);
        self.unresolved = if resolved { 0 } else { self.unresolved + 1 };
        if self.unresolved == 1 {
            (self.first, self.lasting) = (time, 0);
        } else if time >= LASTS * self.first {
            self.lasting += 1;
        }
        self.last[self.count % KEPT] = Passage {
            at: *at,
            contact,
            to,
        };
        self.count += 1;
        self.bursts(options) || self.unresolved >= options.pile_up_count
    }

    /// Whether so many transitions have happened within no time, and at their ratio all others will,
    /// or as fast as rounding allows. A fast clock is no pile-up.
    fn bursts(&self, options: &Options) -> bool {
        let half = self.kept().saturating_sub(1) / 2;
        let t = |back: usize| self.back(back).at.t;
        let (latest, before) = (t(0) - t(half), t(half) - t(2 * half));
        let left = latest * latest / (before - latest);
        let by_rounding = half as f64 * blur(t(0));
        self.burst.count >= options.pile_up_count
            && ((0.0..=no_time(t(0), options)).contains(&left) || latest <= by_rounding)
    }

    /// Whether the transitions come ever faster and the state moves.
    pub(crate) fn accumulates(&self, options: &Options) -> bool {
        self.bursts(options) || !self.shrinks()
    }

    /// Whether the last transition was of this contact at this time.
    pub(crate) fn was_at(&self, contact: usize, t: f64) -> bool {
        let last = self.back(0);
        self.count > 0 && last.at.t == t && last.contact == contact
    }

    /// The geometric series of the last transitions, if they form one: three rounds in a row with
    /// the same ratio. Of all rounds, the one with the least uncertainty of the remaining time
    /// counts. The very last rounds may be rounding.
    pub(crate) fn series(&self) -> Option<Series<N>> {
        let best = |best: Option<Series<N>>, (newest, round)| {
            let one = self.by_rounds_of(round, newest);
            match (&best, &one) {
                (Some(found), Some(other)) if other.uncertainty >= found.uncertainty => best,
                (_, None) => best,
                _ => one,
            }
        };
        let phases = self.kept().saturating_sub(1);
        // Phases as short as rounding have no ratio.
        let blur = blur(self.back(0).at.t) / (AGREEING * AGREEING);
        let lasts = |k: usize| self.back(k).at.t - self.back(k + 1).at.t;
        let newest = (0..phases).find(|&k| lasts(k) > blur)?;
        let rounds = 1..=(phases - newest) / 3;
        rounds.map(|round| (newest, round)).fold(None, best)
    }

    /// The series by three rounds of so many transitions before the last but so many.
    fn by_rounds_of(&self, round: usize, newest: usize) -> Option<Series<N>> {
        let contact = |back: usize| self.back(newest + back).contact;
        if !(0..2 * round).all(|back| contact(back) == contact(back + round)) {
            return None;
        }
        let at = |rounds: usize| &self.back(newest + rounds * round).at;
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
        let by_rounding = blur(now.t) * (1.0 + 2.0 / ((1.0 - ratio) * (1.0 - ratio)));
        let uncertainty = (left - d0 * rounds_left(before)).abs() + by_rounding;
        let is_behind = now.t + left + uncertainty >= self.back(0).at.t;
        if uncertainty > AGREEING * left || !is_behind {
            return None;
        }
        // No component converges slower than time does. One that oscillates has a negative ratio.
        let rest = State::from(std::array::from_fn::<_, N, _>(|i| {
            let own = moved[i] / moved_before[i];
            if own.is_finite() {
                moved[i] * rounds_left(own.clamp(-ratio, ratio))
            } else {
                0.0
            }
        }));
        Some(Series {
            at: Timed {
                t: now.t + left,
                x: now.x + rest,
            },
            uncertainty,
            distance: rounds_left(ratio) * moved.amax(),
            ratio: crate::math::pow(ratio, 1.0 / round as f64),
            contacts: self.contacts(round),
        })
    }

    /// The mode after the present transition at time `t`: as recorded, or as it was the last time
    /// that the previous one led to the same mode.
    pub(crate) fn mode_after(&self, t: f64) -> Option<K> {
        let newest = self.back(0);
        if newest.at.t == t {
            return Some(newest.to);
        }
        let mut earlier = 1..self.kept();
        let like_it = earlier.find(|&back| self.back(back).to == newest.to)?;
        Some(self.back(like_it - 1).to)
    }

    /// The pile-up of the transitions up to `(t, x)`; `holds` as in [`Accumulation`].
    pub(crate) fn error(
        &self,
        at: &Timed<N>,
        series: Option<&Series<N>>,
        holds: bool,
        options: &Options,
    ) -> Error {
        let kept = self.kept();
        let (count, span) = if self.bursts(options) {
            (self.burst.count, at.t - self.burst.since)
        } else {
            (kept, at.t - self.back(kept.saturating_sub(1)).at.t)
        };
        Error::EventPileUp {
            count,
            span,
            t: at.t,
            x: Point::from(&at.x),
            contacts: series.map_or_else(|| self.contacts(kept), |series| series.contacts.clone()),
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

    /// Whether unresolved phases last as long as the first of them: the orbit approaches a point in
    /// infinite time.
    pub(crate) fn shrinks(&self) -> bool {
        self.unresolved >= FEWEST && self.lasting >= FEWEST
    }

    /// The pile-up at time `t` of a run whose steps have become too short.
    pub(crate) fn under_way(&self, t: f64, options: &Options) -> Option<Series<N>> {
        let series = self.series()?;
        (series.at.t - t <= no_time(t, options)).then_some(series)
    }

    /// The pile-up in which contacts reach zero together. All of them are among these; others may
    /// stick meanwhile.
    pub(crate) fn of_contacts(&self, t: f64, contacts: &[usize]) -> Option<Series<N>> {
        let series = self.series()?;
        let are_among = series.contacts.iter().all(|one| contacts.contains(one));
        (are_among && t <= series.at.t + series.uncertainty).then_some(series)
    }
}
