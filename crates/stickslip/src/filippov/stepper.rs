//! Steps within the tolerance, and what can go wrong with them.

use super::flow::Flow;
use super::march::Run;
use crate::error::{Error, Point};
use crate::ode::control::{first_step, squared_error, step_factor};
use crate::ode::{RungeKutta, Stages, Timed, stages};
use crate::system::State;

/// Steps shorter than this part of the time no longer move it.
pub(crate) const SHORTEST: f64 = 4.0 * f64::EPSILON;

impl<O> Run<'_, O> {
    pub(crate) fn choose_first_step<const N: usize>(
        &self,
        field: &mut impl FnMut(f64, &State<f64, N>) -> State<f64, N>,
        t: f64,
        x: &State<f64, N>,
        slope: &State<f64, N>,
    ) -> f64 {
        let longest = self.options.longest_step.min(self.t_end - t);
        if let Some(step) = self.options.fixed_step().or(self.options.first_step) {
            return step.min(longest);
        }
        first_step(field, t, x, slope, &self.options.tolerance(), longest)
    }

    /// The next step within the tolerance: its length, whether it ends at the end time, its slopes and end.
    #[inline(always)]
    pub(crate) fn accepted_step<M: RungeKutta, F: Flow<N>, const N: usize>(
        &mut self,
        flow: &F,
        t: f64,
        x: &State<f64, N>,
        slope: State<f64, N>,
    ) -> Result<(f64, bool, Stages<State<f64, N>>), Error> {
        let field = &mut |t: f64, x: &State<f64, N>| flow.field(t, x);
        let tolerance = self.options.tolerance();
        let mut rejected = false;
        loop {
            let mut h = self.h.min(self.options.longest_step);
            // A last step is stretched a little rather than followed by one of rounding's length.
            let is_last = t + 1.01 * h >= self.t_end;
            if is_last {
                h = self.t_end - t;
            }
            if !is_last && h <= SHORTEST * t.abs() || h < f64::MIN_POSITIVE {
                return Err(self.collapse(t, x, &slope, h));
            }
            let step = stages::<M, f64, _>(field, t, x, slope, h);
            self.counters.field_calls += F::FIELD_CALLS * (M::COEFFICIENTS.stages as u64 - 1);
            let error = squared_error::<M, N>(&step, x, h, &tolerance);
            if self.options.fixed_step().is_some() {
                if error.is_finite() {
                    return Ok((h, is_last, step));
                }
                return Err(Error::NonFinite {
                    t,
                    x: Point::from(x),
                    step: h,
                });
            }
            if error <= 1.0 {
                let factor = step_factor(error);
                // After a rejection the step does not grow at once, and a last step cut short by the end time says
                // nothing against the one that was planned.
                let next = h * if rejected { factor.min(1.0) } else { factor };
                self.h = if is_last { next.max(self.h) } else { next };
                return Ok((h, is_last, step));
            }
            self.counters.rejected += 1;
            rejected = true;
            self.h = h * if error.is_finite() {
                step_factor(error)
            } else {
                0.1
            };
        }
    }

    /// What a step says that has shrunk until time no longer moves, right behind transitions that pile up: each was resolved.
    pub(crate) fn collapsed<const N: usize>(
        &self,
        t: f64,
        x: &State<f64, N>,
        slope: &State<f64, N>,
        step: f64,
    ) -> Error {
        self.pile_up
            .under_way(t, x, self.options)
            .unwrap_or_else(|| self.collapse(t, x, slope, step))
    }

    /// The step shrank until time no longer moves.
    fn collapse<const N: usize>(
        &self,
        t: f64,
        x: &State<f64, N>,
        slope: &State<f64, N>,
        step: f64,
    ) -> Error {
        let x = Point::from(x);
        if slope.iter().any(|v| !v.is_finite()) {
            return Error::NonFinite { t, x, step };
        }
        Error::StepCollapse {
            t,
            x,
            step,
            rtol: self.options.rtol,
            atol: self.options.atol,
        }
    }

    /// Shortens the next step after one on which the field was not defined throughout.
    pub(crate) fn reject_undefined<const N: usize>(
        &mut self,
        t: f64,
        x: &State<f64, N>,
        step: f64,
    ) -> Result<(), Error> {
        if self.options.fixed_step().is_some() {
            let x = Point::from(x);
            return Err(Error::NonFinite { t, x, step });
        }
        self.counters.rejected += 1;
        self.h = 0.1 * step;
        Ok(())
    }

    pub(crate) fn check_escape<const N: usize>(&self, at: &Timed<f64, N>) -> Result<(), Error> {
        let bound = self.options.escape;
        if at.x.iter().all(|v| v.abs() <= bound) {
            return Ok(());
        }
        Err(Error::Escaped {
            t: at.t,
            x: Point::from(&at.x),
            bound,
        })
    }
}
