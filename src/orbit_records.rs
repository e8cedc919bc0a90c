//! Records of an orbit of Figs. 10–12: equidistant samples, and a Poincaré section at the block's
//! turning points.

use crate::paper::models::BlockAndBracket;
use stickslip::{Direction, EventFunctions, EventSearch, Options, Scalar, StepRecord};

/// Event function: the block's velocity falls through zero.
struct TurningPointEvent;

impl EventFunctions<4> for TurningPointEvent {
    #[inline(always)]
    fn value<T: Scalar>(&self, _number: usize, _t: T, x: &[T; 4]) -> T {
        x[1]
    }

    fn direction(&self, _number: usize) -> Direction {
        Direction::Falling
    }
}

/// The returns of an orbit to the section.
pub(crate) struct TurningPoints<'a> {
    search: EventSearch<'a, BlockAndBracket, TurningPointEvent, 4>,
    /// Times and states.
    pub(crate) points: Vec<(f64, [f64; 4])>,
}

impl<'a> TurningPoints<'a> {
    /// Empty, for a run with these options.
    pub(crate) fn new(model: &'a BlockAndBracket, options: &Options) -> Self {
        TurningPoints {
            search: EventSearch::new(model, TurningPointEvent, options),
            points: Vec::new(),
        }
    }

    /// Searches the next step of the run for returns.
    pub(crate) fn step(&mut self, step: &StepRecord<4>) {
        let events = self.search.in_step(step);
        self.points
            .extend(events.iter().map(|at| (at.t, at.x.into())));
    }
}

/// States at equidistant times.
pub(crate) struct Samples {
    from: f64,
    dt: f64,
    limit: usize,
    pub(crate) states: Vec<[f64; 4]>,
}

impl Samples {
    /// Empty, for at most `limit` states from time `from` on.
    pub(crate) fn new(from: f64, dt: f64, limit: usize) -> Self {
        Samples {
            from,
            dt,
            limit,
            states: Vec::new(),
        }
    }

    /// Takes the samples that are due within the next step of the run.
    pub(crate) fn step(&mut self, step: &StepRecord<4>) {
        while self.states.len() < self.limit {
            let t = self.from + self.states.len() as f64 / (1.0 / self.dt);
            if t > step.t_end {
                return;
            }
            let x = if t == step.t_end {
                step.x_end
            } else {
                step.dense.at_time(t)
            };
            self.states.push(x.into());
        }
    }
}
