//! The method that makes the steps of a run: Runge–Kutta or Taylor.

use super::flow::Flow;
use super::options::{Method, Options};
use super::run::{StepState, Trial};
use super::runge_kutta::RungeKuttaStepper;
use super::taylor::TaylorStepper;
use crate::error::Error;
use crate::ode::{Dop853, Rk4};
use crate::taylor::recorded_calls::RecordedCalls;

/// The state of a method between steps.
pub(crate) enum Stepper<const N: usize, const G: usize> {
    Dop853(RungeKuttaStepper<N>),
    Rk4(RungeKuttaStepper<N>),
    Taylor(Box<TaylorStepper<N, G>>),
}

/// Work that needs the flow of the mode.
#[derive(Clone, Copy)]
pub(crate) enum Work {
    /// Record which guards have left their zero.
    RecordDepartures,
    /// Prepare the expansion of the next series.
    Prepare,
    /// Try a step.
    Advance,
    /// Leave a boundary at which the field is a root of the distance.
    Leave,
    /// Complete the record of the last step.
    Complete,
}

impl<const N: usize, const G: usize> Stepper<N, G> {
    pub(crate) fn new(options: &Options) -> Self {
        match options.method {
            Method::Dop853 => Stepper::Dop853(RungeKuttaStepper::default()),
            Method::Rk4 { .. } => Stepper::Rk4(RungeKuttaStepper::default()),
            Method::Taylor => Stepper::Taylor(Box::new(TaylorStepper::new(options))),
        }
    }

    /// Forgets what belonged to the flow before.
    pub(crate) fn begin(&mut self) {
        match self {
            Stepper::Dop853(slopes) | Stepper::Rk4(slopes) => slopes.begin(),
            Stepper::Taylor(series) => series.begin(),
        }
    }

    /// Keeps only its memory, for another orbit.
    pub(crate) fn forget(&mut self) {
        match self {
            Stepper::Dop853(slopes) | Stepper::Rk4(slopes) => slopes.begin(),
            Stepper::Taylor(series) => series.forget(),
        }
    }

    /// The Taylor stepper, if it is one.
    pub(crate) fn series_mut(&mut self) -> Option<&mut TaylorStepper<N, G>> {
        match self {
            Stepper::Taylor(series) => Some(series),
            Stepper::Dop853(_) | Stepper::Rk4(_) => None,
        }
    }

    /// Whether a step is prepared before it is tried.
    #[inline(always)]
    pub(crate) fn needs_preparing(&self) -> bool {
        matches!(self, Stepper::Taylor(_))
    }

    /// Does work on a flow. `repeated` holds the recorded calls of its functions, if they are
    /// interpreted.
    #[inline(always)]
    pub(crate) fn work<F: Flow<N>>(
        &mut self,
        work: Work,
        run: &mut StepState<N, G>,
        flow: &F,
        repeated: Option<&mut RecordedCalls<N, G>>,
    ) -> Result<Trial, Error> {
        match (work, self) {
            (Work::RecordDepartures, _) => run.record_departures(flow),
            (Work::Leave, _) => return Ok(run.leave_by_root(flow)),
            (Work::Prepare, Stepper::Taylor(series)) => series.prepare(run, flow),
            (Work::Prepare, _) => {}
            (Work::Complete, Stepper::Dop853(slopes)) => slopes.complete::<Dop853, F, G>(run, flow),
            // Taylor steps have their dense output already.
            (Work::Complete, Stepper::Rk4(_) | Stepper::Taylor(_)) => {}
            (Work::Advance, Stepper::Dop853(slopes)) => {
                return slopes.advance::<Dop853, F, G>(run, flow);
            }
            (Work::Advance, Stepper::Rk4(slopes)) => return slopes.advance::<Rk4, F, G>(run, flow),
            (Work::Advance, Stepper::Taylor(series)) => return series.advance(run, flow, repeated),
        }
        Ok(Trial::NoStep)
    }
}
