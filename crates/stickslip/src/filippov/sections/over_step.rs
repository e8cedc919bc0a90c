//! One event function over one step: approximately on the dense output, and as exactly as the
//! step's own end.

use std::cell::OnceCell;

use super::EventFunctions;
use crate::dual::Dual;
use crate::filippov::flow::Flow;
use crate::filippov::flow::gradient;
use crate::filippov::observer::StepRecord;
use crate::filippov::options::Method;
use crate::filippov::scan::{NODES, UNIT_NODES};
use crate::filippov::switched::{Switched, UseFlow, Velocity};
use crate::filippov::uncertainty::STATE_ROUNDING;
use crate::interval::Interval;
use crate::ode::{Dop853, Rk4, RungeKutta, Timed, step_end};
use crate::system::{State, components};

/// The solution over a step, evaluated once for all functions.
pub(super) struct SampledStep<'a, K, const N: usize> {
    pub step: &'a StepRecord<N, K>,
    /// Times and states at the points of [`UNIT_NODES`].
    nodes: OnceCell<[Timed<N>; NODES]>,
    /// A box that contains the states.
    enclosure: OnceCell<[Interval; N]>,
}

impl<'a, K, const N: usize> SampledStep<'a, K, N> {
    pub(super) fn new(step: &'a StepRecord<N, K>) -> Self {
        SampledStep {
            step,
            nodes: OnceCell::new(),
            enclosure: OnceCell::new(),
        }
    }

    /// Time and state on the dense output at a part of the step.
    #[inline(always)]
    fn at(&self, s: f64) -> Timed<N> {
        let StepRecord {
            t_start,
            t_end,
            dense,
            ..
        } = self.step;
        let part = s * (t_end - t_start);
        Timed {
            t: t_start + part,
            x: dense.at(part / dense.h),
        }
    }

    fn nodes(&self) -> &[Timed<N>; NODES] {
        self.nodes.get_or_init(|| UNIT_NODES.map(|s| self.at(s)))
    }

    fn enclosure(&self) -> &[Interval; N] {
        self.enclosure.get_or_init(|| self.step.dense.enclosure())
    }
}

/// An event function over a step; `s` is the part of the step, 0 at its start and 1 at its end.
pub(super) struct OverStep<'a, S, V, K, const N: usize> {
    pub system: &'a S,
    pub events: &'a V,
    pub number: usize,
    /// Number of components of the state in which derivatives are taken.
    pub dimension: usize,
    pub over: &'a SampledStep<'a, K, N>,
    pub method: Method,
    /// Recent size of the state's components. A component that passes through zero is not more
    /// accurate there.
    pub size: &'a State<N>,
    /// Value that counts as zero: 0, or the remainder of a zero at which the function stood.
    pub zero: f64,
}

/// A state in a step, with the function's value and rate.
#[derive(Clone, Copy)]
pub(super) struct EventProbe<const N: usize> {
    pub s: f64,
    pub at: Timed<N>,
    pub value: f64,
    /// Rate in time, along the motion.
    pub rate: f64,
}

impl<S, V: EventFunctions<N>, K: Copy, const N: usize> OverStep<'_, S, V, K, N> {
    fn step(&self) -> &StepRecord<N, K> {
        self.over.step
    }

    pub(super) fn length(&self) -> f64 {
        self.step().t_end - self.step().t_start
    }

    /// The function on the dense output.
    #[inline(always)]
    pub(super) fn sampled(&self, s: f64) -> f64 {
        self.value(&self.over.at(s))
    }

    /// The function at the points of [`UNIT_NODES`].
    #[inline(always)]
    pub(super) fn samples(&self) -> [f64; NODES] {
        self.over.nodes().map(|at| self.value(&at))
    }

    /// The function at the step's start.
    pub(super) fn value_at_start(&self) -> f64 {
        let StepRecord {
            t_start, x_start, ..
        } = *self.step();
        self.value(&Timed {
            t: t_start,
            x: x_start,
        })
    }

    #[inline(always)]
    fn value(&self, Timed { t, x }: &Timed<N>) -> f64 {
        self.events.value(self.number, *t, components(x)) - self.zero
    }

    /// Whether samples of the step resolve the function.
    pub(super) fn is_smooth(&self) -> bool {
        self.events.is_as_smooth_as_state(self.number)
    }

    /// Whether the box of the states proves that the function has the sign `side`.
    pub(super) fn is_clear_throughout(&self, side: f64) -> bool {
        let step = self.step();
        let times = Interval::new(step.t_start, step.t_end);
        self.has_sign(side, times, self.over.enclosure())
    }

    /// Whether bounds prove that the function has the sign `side` between two parts of the step.
    pub(super) fn is_clear(&self, side: f64, (from, to): (f64, f64)) -> bool {
        let StepRecord { t_start, dense, .. } = self.step();
        let (from, to) = (from * self.length(), to * self.length());
        let times = Interval::new(t_start + from, t_start + to);
        let states = dense.enclosure_between(from / dense.h, to / dense.h);
        self.has_sign(side, times, &states)
    }

    fn has_sign(&self, side: f64, times: Interval, states: &[Interval; N]) -> bool {
        let value = Interval::decided(|| self.events.value(self.number, times, states));
        value.is_some_and(|value| ((value - self.zero) * side).low > 0.0)
    }

    /// State and function as exactly as the step gives them.
    pub(super) fn exact<const G: usize>(&self, s: f64) -> EventProbe<N>
    where
        S: Switched<N, G, Mode = K>,
    {
        let StepRecord {
            mode,
            t_start: t,
            x_start: x,
            ..
        } = *self.step();
        let branch = self.system.branch_of_field(mode, &Timed { t, x });
        let state = StateInStep {
            step: self.step(),
            s,
            method: self.method,
        };
        let at = self.system.with_flow(mode, branch, state);
        let x = components(&at.x);
        let velocity = self.system.with_flow(mode, branch, Velocity(at.t, x));
        let along = std::array::from_fn(|i| Dual::new(x[i], velocity[i]));
        let function = |t, x: &[Dual<f64>; N]| self.events.value(self.number, t, x);
        let Dual { re, eps } = function(Dual::new(at.t, 1.0), &along);
        EventProbe {
            s,
            at,
            value: re - self.zero,
            rate: eps,
        }
    }

    /// Rounding of the function at a zero near a probe.
    pub(super) fn rounding_at(&self, probe: &EventProbe<N>) -> f64 {
        self.rounding(&probe.at)
    }

    /// Rounding of the function at a zero near the step's start.
    pub(super) fn rounding_at_start(&self) -> f64 {
        self.rounding(&self.over.nodes()[0])
    }

    /// The function at the step's end, and its rounding at a zero near there.
    pub(super) fn end(&self) -> (f64, f64) {
        let StepRecord { t_end, x_end, .. } = *self.step();
        let at = Timed { t: t_end, x: x_end };
        (self.value(&at), self.rounding(&at))
    }

    fn rounding(&self, at: &Timed<N>) -> f64 {
        let value = |t, x: &_| self.events.value(self.number, t, x);
        let (slopes, in_time) = gradient(value, at, self.dimension);
        STATE_ROUNDING * (slopes.abs().dot(self.size) + in_time.abs() * at.t.abs())
    }
}

/// Time and state at a part of a step: by the series of a Taylor step, else by a step of that
/// length.
struct StateInStep<'a, K, const N: usize> {
    step: &'a StepRecord<N, K>,
    s: f64,
    method: Method,
}

impl<K, const N: usize> StateInStep<'_, K, N> {
    fn by_step<M: RungeKutta>(&self, flow: &impl Flow<N>, length: f64) -> State<N> {
        let (t, x) = (self.step.t_start, self.step.x_start);
        let field = &mut |t: f64, x: &State<N>| flow.velocity(t, x);
        let slope = field(t, &x);
        step_end::<M, _>(field, t, &x, slope, length)
    }
}

impl<K, const N: usize> UseFlow<N> for StateInStep<'_, K, N> {
    type Output = Timed<N>;

    fn with<F: Flow<N>>(self, flow: &F) -> Timed<N> {
        let step = self.step;
        if self.s >= 1.0 {
            let (t, x) = (step.t_end, step.x_end);
            return Timed { t, x };
        }
        let part = self.s * (step.t_end - step.t_start);
        let t = step.t_start + part;
        let x = match self.method {
            Method::Taylor => step.dense.at(part / step.dense.h),
            Method::Dop853 => self.by_step::<Dop853>(flow, part),
            Method::Rk4 { .. } => self.by_step::<Rk4>(flow, part),
        };
        Timed {
            t,
            x: flow.settle(t, x),
        }
    }
}
