//! Notices when transitions pile up within no time (Zeno).

use super::options::Options;
use crate::error::{Error, Point};
use crate::ode::Timed;

/// Transitions since a moment that lies no further back than the span of the options.
pub(crate) struct PileUp {
    since: f64,
    count: usize,
}

impl PileUp {
    pub(crate) fn new() -> Self {
        PileUp {
            since: f64::NEG_INFINITY,
            count: 0,
        }
    }

    /// Counts a transition.
    pub(crate) fn note<const N: usize>(
        &mut self,
        at: &Timed<f64, N>,
        options: &Options,
    ) -> Result<(), Error> {
        let span = options.pile_up_span * at.t.abs().max(1.0);
        if at.t - self.since > span {
            (self.since, self.count) = (at.t, 0);
        }
        self.count += 1;
        if self.count >= options.pile_up_count {
            return Err(Error::EventPileUp {
                count: self.count,
                span: at.t - self.since,
                t: at.t,
                x: Point::from(&at.x),
            });
        }
        Ok(())
    }
}
