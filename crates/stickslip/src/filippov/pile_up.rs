//! Notices when transitions pile up (Zeno), or the branchings of a field.

use super::options::Options;
use crate::error::{Error, Point};
use crate::ode::Timed;
use crate::system::State;

/// A phase over which no component moves by more than so many tolerances is not resolved.
const UNRESOLVED: f64 = 100.0;

/// So many transitions within the span of a pile-up, and then a step too short for the time, are one as well.
const FEWEST: usize = 10;

/// Phases that shrink geometrically to less than this part of the first within [`FEWEST`]
/// accumulate.
const LASTS: f64 = 0.9;

/// How many times something has happened within no time.
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

    /// Whether `t` is within the span of a pile-up from when it began.
    #[inline]
    fn lasts(&self, t: f64, options: &Options) -> bool {
        t - self.since <= options.pile_up_span * t.abs().max(1.0)
    }

    /// Counts one more, at time `t`; how many there are, and within what time.
    #[inline]
    pub(crate) fn note(&mut self, t: f64, options: &Options) -> (usize, f64) {
        if !self.lasts(t, options) {
            (self.since, self.count) = (t, 0);
        }
        self.count += 1;
        (self.count, t - self.since)
    }
}

/// Transitions pile up when many of them happen within no time, or when many phases in a row are too short for error control
/// to tell their ends apart: then a loose tolerance has stopped the orbit short of the accumulation point.
pub struct PileUp<const N: usize> {
    burst: Burst,
    last: Option<Timed<N>>,
    /// Phases in a row that are not resolved, the length of the first, and how many last as long.
    unresolved: usize,
    first: f64,
    lasting: usize,
}

impl<const N: usize> PileUp<N> {
    pub(crate) fn new() -> Self {
        PileUp {
            burst: Burst::new(),
            last: None,
            unresolved: 0,
            first: 0.0,
            lasting: 0,
        }
    }

    /// Counts a transition, where the state moves with `velocity`.
    pub(crate) fn note(
        &mut self,
        at: &Timed<N>,
        velocity: &State<N>,
        options: &Options,
    ) -> Result<(), Error> {
        let (count, _) = self.burst.note(at.t, options);
        let time = self.last.map_or(f64::INFINITY, |last| at.t - last.t);
        let resolved = self.last.is_none_or(|last| {
            // A body on a floor stands still at either end of a slip: what it has moved by tells, not how fast it is.
            (0..N).any(|i| {
                let moved = f64::max((at.x[i] - last.x[i]).abs(), time * velocity[i].abs());
                moved > UNRESOLVED * (options.atol + options.rtol * at.x[i].abs())
            })
        });
        self.unresolved = if resolved { 0 } else { self.unresolved + 1 };
        if self.unresolved == 1 {
            (self.first, self.lasting) = (time, 0);
        } else if time >= LASTS * self.first {
            self.lasting += 1;
        }
        self.last = Some(*at);
        let most = options.pile_up_count;
        if count < most && self.unresolved < most {
            return Ok(());
        }
        Err(self.error(at.t, &at.x))
    }

    /// The pile-up that the transitions so far are.
    fn error(&self, t: f64, x: &State<N>) -> Error {
        Error::EventPileUp {
            count: self.burst.count.max(self.unresolved),
            span: t - self.burst.since,
            t,
            x: Point::from(x),
        }
    }

    /// Whether phases that are not resolved last as long as the first of them: the orbit shrinks to
    /// a point that it reaches in no finite time.
    pub(crate) fn shrinks(&self) -> bool {
        self.unresolved >= FEWEST && self.lasting >= FEWEST
    }

    /// The pile-up that a run is in whose steps have become too short.
    pub(crate) fn under_way(&self, t: f64, x: &State<N>, options: &Options) -> Option<Error> {
        let is_under_way = self.burst.count >= FEWEST && self.burst.lasts(t, options);
        is_under_way.then(|| self.error(t, x))
    }
}
