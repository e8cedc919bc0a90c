//! Notices when transitions pile up (Zeno).

use super::options::Options;
use crate::error::{Error, Point};
use crate::ode::Timed;
use crate::system::State;

/// A phase over which no component moves by more than so many tolerances is not resolved.
const UNRESOLVED: f64 = 100.0;

/// So many transitions within the span of a pile-up, and then a step too short for the time, are one as well.
const FEWEST: usize = 10;

/// Transitions pile up when many of them happen within no time, or when many phases in a row are too short for error control
/// to tell their ends apart: then a loose tolerance has stopped the orbit short of the accumulation point.
pub struct PileUp<const N: usize> {
    since: f64,
    count: usize,
    last: Option<Timed<N>>,
    unresolved: usize,
}

impl<const N: usize> PileUp<N> {
    pub(crate) fn new() -> Self {
        PileUp {
            since: f64::NEG_INFINITY,
            count: 0,
            last: None,
            unresolved: 0,
        }
    }

    /// Counts a transition, where the state moves with `velocity`.
    pub(crate) fn note(
        &mut self,
        at: &Timed<N>,
        velocity: &State<N>,
        options: &Options,
    ) -> Result<(), Error> {
        if at.t - self.since > options.pile_up_span * at.t.abs().max(1.0) {
            (self.since, self.count) = (at.t, 0);
        }
        self.count += 1;
        let resolved = self.last.is_none_or(|last| {
            let time = at.t - last.t;
            // A body on a floor stands still at either end of a slip: what it has moved by tells, not how fast it is.
            (0..N).any(|i| {
                let moved = f64::max((at.x[i] - last.x[i]).abs(), time * velocity[i].abs());
                moved > UNRESOLVED * (options.atol + options.rtol * at.x[i].abs())
            })
        });
        self.unresolved = if resolved { 0 } else { self.unresolved + 1 };
        self.last = Some(*at);
        let most = options.pile_up_count;
        if self.count < most && self.unresolved < most {
            return Ok(());
        }
        Err(Error::EventPileUp {
            count: self.count.max(self.unresolved),
            span: at.t - self.since,
            t: at.t,
            x: Point::from(&at.x),
        })
    }

    /// The pile-up that a run is in whose steps have become too short.
    pub(crate) fn under_way(&self, t: f64, x: &State<N>, options: &Options) -> Option<Error> {
        let span = t - self.since;
        let near = span <= options.pile_up_span * t.abs().max(1.0);
        (near && self.count >= FEWEST).then(|| Error::EventPileUp {
            count: self.count,
            span,
            t,
            x: Point::from(x),
        })
    }
}
