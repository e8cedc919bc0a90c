//! Runge–Kutta steps, and the search for the first event of each.

use std::cell::Cell;

use super::deflation::deflate;
use super::flow::Flow;
use super::guard::{Event, first_event};
use super::locate::{DenseGuard, Limits, Origin, StepMethod};
use super::options::Locator;
use super::run::{StepState, Trial};
use super::scan::{BoundsBudget, is_defined};
use super::uncertainty::{attracts, uncertainty};
use crate::error::Error;
use crate::interval::Interval;
use crate::ode::control::{squared_error, step_factor};
use crate::ode::{Dense, RungeKutta, Stages, Timed, dense_slopes, further_slopes, stages};
use crate::system::State;

/// A guard is not a number in a part of the step.
pub(crate) struct Undefined;

/// Allowed difference, in tolerances, between a step repeated up to an event and the dense output.
/// Chosen far above regular cases, which show up to some hundred, and far below a singular flow.
const DENSE_MISMATCH: f64 = 1e6;

/// The state that Runge–Kutta steps keep from one to the next.
#[derive(Default)]
pub(crate) struct RungeKuttaStepper<const N: usize> {
    /// The slope at the present state, if it is known.
    slope: Option<State<N>>,
    /// Slope at the start and length of the last step, if no guard needed its dense output.
    without_dense: Option<(State<N>, f64)>,
}

/// Factor by which a step could have been longer if error control does not bound it. Chosen: its
/// error is then below 2 % of the tolerance.
const LONGER_STEP: f64 = 1.5;

impl<const N: usize> RungeKuttaStepper<N> {
    /// Forgets what belonged to the flow before.
    pub(crate) fn begin(&mut self) {
        *self = Self::default();
    }

    /// Makes the dense output of the last step, if there is none, by repeating the step.
    pub(crate) fn complete<M: RungeKutta, F: Flow<N>, const G: usize>(
        &mut self,
        run: &mut StepState<N, G>,
        flow: &F,
    ) {
        let Some((slope, h)) = self.without_dense.take() else {
            return;
        };
        let field = &mut |t: f64, x: &State<N>| flow.velocity(t, x);
        run.dense = dense_again::<M, N>(field, run.last, slope, h);
        run.counters.field_calls +=
            flow.field_calls() * (M::COEFFICIENTS.stages + M::COEFFICIENTS.dense_stages) as u64;
    }

    /// Tries a step.
    pub(crate) fn advance<M: RungeKutta, F: Flow<N>, const G: usize>(
        &mut self,
        run: &mut StepState<N, G>,
        flow: &F,
    ) -> Result<Trial, Error> {
        let field = &mut |t: f64, x: &State<N>| flow.velocity(t, x);
        let Timed { t, x } = run.at;
        let slope = match self.slope {
            Some(slope) => slope,
            None => {
                run.counters.field_calls += flow.field_calls();
                field(t, &x)
            }
        };
        if run.h == 0.0 {
            run.h = run.choose_first_step(field, t, &x, &slope);
            run.counters.field_calls += flow.field_calls();
        }
        self.slope = Some(slope);
        if run.next_step().1 && run.waits() {
            return Ok(Trial::BeforeEnd);
        }
        let (h, is_last, allows_longer, mut step) = run.accepted_step::<M, F>(flow, slope)?;
        let t_next = if is_last { run.t_end } else { t + h };
        step.end = flow.settle(t_next, step.end);
        let slope_at_end = field(t + h, &step.end);
        step.k[M::COEFFICIENTS.stages] = slope_at_end;
        run.counters.field_calls += flow.field_calls();
        let is_far = run.is_far::<M, F>(flow, h, &step);
        if is_far && !run.wants_dense {
            run.counters.steps += 1;
            (self.slope, self.without_dense) = (Some(slope_at_end), Some((slope, h)));
            let (t, x) = (t_next, step.end);
            return Ok(run.accept(Timed { t, x }, None));
        }
        further_slopes::<M, f64, _>(field, t, &x, h, &mut step);
        run.counters.field_calls += flow.field_calls() * M::COEFFICIENTS.dense_stages as u64;
        let dense = Dense::new::<M>(t, &x, h, &step);
        if !dense.is_finite() {
            // The solution reaches the edge of the field's domain: a shorter step may stay inside.
            run.reject_undefined(h)?;
            return Ok(Trial::NoStep);
        }
        let origin = Origin {
            flow,
            t,
            x,
            slope,
            h,
            to_end: (run.t_end - t) / h,
            allows_longer,
            method: StepMethod::by::<M>(),
            field_calls: Cell::new(0),
        };
        // The search must not depend on whether anyone watches the step.
        let event = if is_far || run.is_prescribed {
            Ok(None)
        } else {
            run.first_event(&origin, &dense)
        };
        run.counters.field_calls += origin.field_calls.get();
        let Ok(event) = event else {
            run.reject_undefined(h)?;
            return Ok(Trial::NoStep);
        };
        let latest = if is_last {
            t_next
        } else {
            t + origin.to_end * h
        };
        let (at, next_slope, event) = match event {
            Some(event) if event.at.t < latest => (event.at, None, Some(event)),
            // A touch turns back at or after the end time, and the step's end is below zero.
            Some(Event { at, .. }) if !is_last => {
                let (t, x) = (run.t_end, at.x);
                (Timed { t, x }, None, None)
            }
            _ => {
                let (t, x) = (t_next, step.end);
                (Timed { t, x }, Some(slope_at_end), None)
            }
        };
        run.counters.steps += 1;
        if at.x.iter().any(|v| !v.is_finite()) {
            return Err(run.non_finite(h));
        }
        run.dense.become_copy(&dense);
        run.wants_dense = false;
        (self.slope, self.without_dense) = (next_slope, None);
        Ok(run.accept(at, event.as_ref()))
    }
}

/// The dense output of a step between two states, made by repeating it. Not compiled anew for every
/// field.
#[inline(never)]
fn dense_again<M: RungeKutta, const N: usize>(
    field: &mut dyn FnMut(f64, &State<N>) -> State<N>,
    (Timed { t, x }, to): (Timed<N>, Timed<N>),
    slope: State<N>,
    h: f64,
) -> Dense<N> {
    let field = &mut |t: f64, x: &State<N>| field(t, x);
    let mut step = stages::<M, f64, _>(field, t, &x, slope, h);
    step.end = to.x;
    dense_slopes::<M, f64, _>(field, t, &x, h, &mut step);
    Dense::new::<M>(t, &x, h, &step)
}

impl<const N: usize, const G: usize> StepState<N, G> {
    /// The next step within the tolerance: length, whether it ends at the end time, whether error
    /// control allows a longer one, slopes and end.
    #[inline(always)]
    fn accepted_step<M: RungeKutta, F: Flow<N>>(
        &mut self,
        flow: &F,
        slope: State<N>,
    ) -> Result<(f64, bool, bool, Stages<State<N>>), Error> {
        let field = &mut |t: f64, x: &State<N>| flow.velocity(t, x);
        let tolerance = self.options.tolerance();
        let Timed { t, x } = self.at;
        let mut rejected = false;
        loop {
            let (h, is_last) = self.next_step();
            if self.is_too_short(h, is_last) {
                return Err(self.collapse(flow, &slope, h));
            }
            let step = stages::<M, f64, _>(field, t, &x, slope, h);
            self.counters.field_calls += flow.field_calls() * (M::COEFFICIENTS.stages as u64 - 1);
            let error = squared_error::<M, N>(&step, &x, h, (&tolerance, self.states));
            if self.options.fixed_step().is_some() {
                if error.is_finite() {
                    return Ok((h, is_last, true, step));
                }
                return Err(self.non_finite(h));
            }
            if error <= 1.0 {
                let factor = step_factor(error);
                // After a rejection the step does not grow at once. A last step cut short by the
                // end time does not change the planned length.
                let next = h * if rejected { factor.min(1.0) } else { factor };
                self.h = if is_last { next.max(self.h) } else { next };
                return Ok((h, is_last, factor > LONGER_STEP, step));
            }
            if !error.is_finite() {
                self.check_lipschitz(flow)?;
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

    /// Whether a step certainly stays clear of every guard's zero, by its slopes alone. Never so
    /// without error control, which bounds the solution between the stages.
    #[inline(always)]
    fn is_far<M: RungeKutta, F: Flow<N>>(&self, flow: &F, h: f64, step: &Stages<State<N>>) -> bool {
        let may_be = M::COEFFICIENTS.dense_stages > 0 && self.options.fixed_step().is_none();
        if !may_be || self.orders != [0; G] {
            return false;
        }
        let states = step.enclosure::<M>(&self.at.x, h);
        let times = Interval::new(self.at.t, self.at.t + h);
        let is_finite = states.iter().all(|range| range.high.is_finite());
        let leads_back = || {
            let at = Timed {
                t: self.at.t + h,
                x: step.end,
            };
            !flow.may_hide_two_fold() || attracts(flow, (&self.at, &at), &self.options)
        };
        is_finite && flow.are_clear(times, &states) == [true; G] && leads_back()
    }

    /// The first guard that fails in the step, and where.
    ///
    /// # Errors
    /// No guard fails, but one is not a number somewhere in the step; or the step leads a slide to
    /// where its boundary repels. A shorter step may avoid that.
    #[inline(always)]
    fn first_event<F: Flow<N>>(
        &mut self,
        origin: &Origin<'_, F, N>,
        dense: &Dense<N>,
    ) -> Result<Option<Event<N>>, Undefined> {
        let mut first: Option<Event<N>> = None;
        let mut is_undefined = false;
        // Nearly every step returns here: it is certainly far from any event.
        let times = Interval::new(origin.t, origin.t + origin.h);
        let clear: [bool; G] = origin.flow.are_clear(times, &dense.enclosure());
        for &guard in origin.flow.guards() {
            match self.first_event_of(guard, origin, dense, &clear, self.orders[guard]) {
                Ok(Some(event)) if first.is_none_or(|first| event.at.t < first.at.t) => {
                    first = Some(event);
                }
                Ok(_) => {}
                Err(Undefined) => is_undefined = true,
            }
        }
        let is_possible = || {
            let (t, x) = match first {
                Some(Event { at, .. }) => (at.t, at.x),
                None => (origin.t + origin.h, dense.at(1.0)),
            };
            attracts(origin.flow, (&self.at, &Timed { t, x }), &self.options)
        };
        match first {
            None if is_undefined => Err(Undefined),
            None if clear == [true; G] && !origin.flow.may_hide_two_fold() => Ok(None),
            // A slide cannot pass a two-fold, behind which its boundary repels.
            _ if !is_possible() => Err(Undefined),
            first => Ok(first),
        }
    }

    #[inline(always)]
    fn first_event_of<F: Flow<N>>(
        &mut self,
        i: usize,
        origin: &Origin<'_, F, N>,
        dense: &Dense<N>,
        clear: &[bool; G],
        order: usize,
    ) -> Result<Option<Event<N>>, Undefined> {
        let on_dense = |s: f64| {
            origin
                .flow
                .guard_at(i, origin.t + s * origin.h, &dense.at(s))
        };
        let (may_vanish, start) = if order == 0 {
            if clear[i] {
                return Ok(None);
            }
            (true, None)
        } else {
            let (t, x) = (origin.t, origin.x);
            let (at, step) = (Timed { t, x }, (origin.h, order));
            let start = deflate(origin.flow, i, &at, step, &self.options, on_dense);
            (start.is_some(), start)
        };
        let event = if may_vanish {
            self.search_guard(&DenseGuard {
                origin,
                dense,
                guard: i,
                start,
                bounds_budget: BoundsBudget::default(),
            })
        } else {
            None
        };
        match &event {
            Some(event) if !self.agrees(event, dense) => Err(Undefined),
            None if !is_defined(on_dense) => Err(Undefined),
            _ => Ok(event),
        }
    }

    /// Whether the state of an event, by a repeated step, agrees with the dense output. Near a
    /// singular flow, as a sliding field at a two-fold, neither is valid. A step of fixed length is
    /// accepted as it is.
    fn agrees(&self, event: &Event<N>, dense: &Dense<N>) -> bool {
        let there = dense.at_time(event.at.t);
        self.options.fixed_step().is_some()
            || (0..N).all(|i| {
                let allowed = self.options.allowed(i, there[i].abs());
                (event.at.x[i] - there[i]).abs() <= DENSE_MISMATCH * allowed
            })
    }

    /// The first event of a guard that needs a closer search.
    #[cold]
    #[inline(never)]
    fn search_guard<F: Flow<N>>(&mut self, guard: &DenseGuard<'_, F, N>) -> Option<Event<N>> {
        first_event(guard, |bracket, estimate, is_rest| {
            self.counters.locations += 1;
            let estimated = Timed {
                t: guard.origin.t + estimate * guard.origin.h,
                x: guard.dense.at(estimate),
            };
            let limits = self.limits(guard.guard, guard.origin.flow, &estimated);
            let locator = if is_rest {
                Locator::RootSearch
            } else {
                self.options.locator
            };
            guard.locate(bracket, estimate, locator, limits)
        })
    }

    /// Tolerances of an event of guard `i` near a state. A step of fixed length has none: only
    /// error control gives a Hénon step a measure.
    fn limits<F: Flow<N>>(&self, i: usize, flow: &F, estimated: &Timed<N>) -> Limits {
        let blur = uncertainty(flow, i, estimated, &self.options.tolerance());
        let adaptive = self.options.fixed_step().is_none();
        Limits {
            touch: (self.options.touch * blur.by_tolerance).max(blur.by_rounding),
            mismatch: if adaptive {
                blur.by_tolerance.max(blur.by_rounding)
            } else {
                f64::INFINITY
            },
            rounding: blur.of_one_unit(),
        }
    }
}
