//! Recording along the orbit.

use std::ops::ControlFlow;

use crate::orbit_records::{Samples, TurningPoints};
use crate::paper::models::BlockAndBracket;
use numerics::golden_section;
use stickslip::{Observer, Options, State, StepRecord, Transition, TransitionKind};

/// Start of the series, as in the paper.
pub(crate) const START: f64 = 3000.0;
/// End of the series.
pub(super) const END: f64 = 12_000.0;
/// Sampling interval.
pub(crate) const DT: f64 = 0.2;
/// Parts of a step, each searched for the minimum of the normal force. A step is a fraction of an
/// oscillation, so each part has at most one minimum.
const SEARCHED_PARTS: u32 = 8;
/// Iterations of the golden-section search. They shrink a part to 1e-12 of its length.
const REFINEMENTS: u32 = 60;
/// Points drawn per step.
const POINTS_PER_STEP: u32 = 10;

/// The sampled series, the section, the minimum of the normal force, and the part of the orbit that
/// is drawn.
pub(super) struct OrbitRecorder<'a> {
    model: &'a BlockAndBracket,
    /// Start of the drawn part.
    drawn_from: f64,
    /// States at `START + k·DT`.
    pub(super) samples: Samples,
    /// The block's turning points.
    pub(super) turning_points: TurningPoints<'a>,
    /// Minimum of the normal force, unclipped, in units of `mg`.
    pub(super) least_force: f64,
    /// Losses of contact.
    pub(super) losses: u64,
    /// Beginning of the flight under way.
    lifted_since: Option<f64>,
    /// Time of the flights that have ended.
    flown: f64,
    /// The drawn part.
    pub(super) curve: Vec<[f64; 4]>,
}

impl<'a> OrbitRecorder<'a> {
    pub(super) fn new(model: &'a BlockAndBracket, options: &Options, shown: f64) -> Self {
        Self {
            model,
            drawn_from: END - shown,
            samples: Samples::new(START, DT, usize::MAX),
            turning_points: TurningPoints::new(model, options),
            least_force: f64::INFINITY,
            losses: 0,
            lifted_since: None,
            flown: 0.0,
            curve: Vec::new(),
        }
    }

    /// Time without contact.
    pub(super) fn lifted_time(&self) -> f64 {
        self.flown + self.lifted_since.map_or(0.0, |since| END - since)
    }

    /// Minimum of the normal force between two times.
    fn least(&self, step: &StepRecord<4>, from: f64, to: f64) -> f64 {
        golden_section(from, to, REFINEMENTS, |t| {
            let state = step.dense.at_time(t);
            self.model.unclipped_normal_force(state.as_ref())
        })
    }

    fn scan(&mut self, step: &StepRecord<4>) {
        let span = step.t_end - step.t_start;
        let at = |k: u32| step.t_start + span * f64::from(k) / f64::from(SEARCHED_PARTS);
        let state = |k: u32| -> State<4> {
            match k {
                SEARCHED_PARTS => step.x_end,
                _ => step.dense.at_time(at(k)),
            }
        };
        for k in 1..=SEARCHED_PARTS {
            let force = self.model.unclipped_normal_force(state(k).as_ref());
            if force < self.least_force {
                let within = self.least(step, at(k - 1), at((k + 1).min(SEARCHED_PARTS)));
                self.least_force = force.min(within);
            }
        }
    }

    fn draw(&mut self, step: &StepRecord<4>) {
        let span = step.t_end - step.t_start;
        for k in 0..POINTS_PER_STEP {
            let t = step.t_start + span * f64::from(k) / f64::from(POINTS_PER_STEP);
            self.curve.push(step.dense.at_time(t).into());
        }
        self.curve.push(step.x_end.into());
    }
}

impl Observer<4> for OrbitRecorder<'_> {
    fn step(&mut self, step: &StepRecord<4>) -> ControlFlow<()> {
        self.samples.step(step);
        self.turning_points.step(step);
        self.scan(step);
        if step.t_start >= self.drawn_from {
            self.draw(step);
        }
        ControlFlow::Continue(())
    }

    fn transition(&mut self, at: &Transition<4>) -> ControlFlow<()> {
        match at.kind {
            TransitionKind::ContactLoss => {
                self.losses += 1;
                self.lifted_since = Some(at.t);
            }
            TransitionKind::ContactGain => {
                // A flight that began before the series counts from its start.
                self.flown += at.t - self.lifted_since.take().unwrap_or(START);
            }
            _ => {}
        }
        ControlFlow::Continue(())
    }
}
