//! Locates the zero of a guard inside a Runge–Kutta step. The dense output gives an estimate; steps
//! repeated up to it give the exact place.

mod henon;
mod root_search;

use std::cell::Cell;

use super::deflation::DeflatedGuard;
use super::flow::Flow;
use super::guard::{Event, Probe, StepGuard, ZeroKind};
use super::options::Locator;
use super::scan::{Bounds, BoundsBudget, Bracket, first_bracket_within};
use crate::interval::Interval;
use crate::ode::{Dense, RungeKutta, Timed, henon_step, step_end};
use crate::system::State;
use root_search::SearchResult;

/// A Runge–Kutta method for location, which is rare. It is not compiled into each field.
#[derive(Clone, Copy)]
pub(crate) struct StepMethod<const N: usize> {
    /// Calls of the field in a step.
    calls: u64,
    /// The end of a step from a time and a state, with the slope there, over a length.
    step_end: StepEnd<N>,
    /// A Hénon step from a state, over a change of the guard.
    henon_step: HenonStep<N>,
}

type StepEnd<const N: usize> =
    fn(&mut dyn FnMut(f64, &State<N>) -> State<N>, f64, &State<N>, State<N>, f64) -> State<N>;
type HenonStep<const N: usize> =
    fn(&mut dyn FnMut(&Timed<N>) -> Timed<N>, &Timed<N>, f64) -> Timed<N>;

impl<const N: usize> StepMethod<N> {
    pub(crate) fn by<M: RungeKutta>() -> Self {
        StepMethod {
            calls: M::COEFFICIENTS.stages as u64,
            step_end: step_end::<M, State<N>>,
            henon_step: henon_step::<M, N>,
        }
    }
}

/// Start of an accepted step, for re-integration.
pub(crate) struct Origin<'a, F, const N: usize> {
    pub flow: &'a F,
    pub t: f64,
    pub x: State<N>,
    pub slope: State<N>,
    pub h: f64,
    /// The run's end time as a part of the step, 1 or more.
    pub to_end: f64,
    /// Whether error control would allow a longer step.
    pub allows_longer: bool,
    pub method: StepMethod<N>,
    /// Calls of the user's field by location.
    pub field_calls: Cell<u64>,
}

impl<F: Flow<N>, const N: usize> Origin<'_, F, N> {
    fn count(&self, evaluations: u64) {
        let calls = self.field_calls.get() + self.flow.field_calls() * evaluations;
        self.field_calls.set(calls);
    }
}

/// Tolerances of location.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// Contacts no deeper than this are touches.
    pub touch: f64,
    /// Allowed difference in the guard between a Hénon step over a whole step and an ordinary one.
    pub mismatch: f64,
    /// Rounding of a guard at its zero: a unit in the last place of state and time.
    pub rounding: f64,
}

/// A guard over a Runge–Kutta step: its values on the dense output, its probes on repeated steps.
pub(crate) struct DenseGuard<'a, F, const N: usize> {
    pub origin: &'a Origin<'a, F, N>,
    pub dense: &'a Dense<N>,
    pub guard: usize,
    /// Zero at the start, if it has one there.
    pub start: Option<DeflatedGuard>,
    /// The bounds that may still be computed in the search.
    pub bounds_budget: BoundsBudget,
}

/// Up to this part of the step, samples decide for a guard that is zero at the start. Chosen: near
/// its zero a guard has no bounds that exclude one.
const SAMPLED_START: f64 = 0.0625;

impl<F: Flow<N>, const N: usize> StepGuard<N> for DenseGuard<'_, F, N> {
    fn probe_end(&self) -> f64 {
        self.origin.to_end.min(1.5)
    }

    fn length(&self) -> f64 {
        self.origin.h
    }

    fn starts_at_zero(&self) -> bool {
        self.start.is_some()
    }

    fn offset(&self) -> f64 {
        self.start.as_ref().map_or(0.0, |start| start.offset)
    }

    #[inline(always)]
    fn value(&self, s: f64) -> f64 {
        let origin = self.origin;
        let on_dense = || {
            let t = origin.t + s * origin.h;
            origin.flow.guard_at(self.guard, t, &self.dense.at(s))
        };
        match &self.start {
            Some(start) => start.value(s, on_dense),
            None => on_dense(),
        }
    }

    fn probe(&self, s: f64) -> Probe<N> {
        self.probe_at(self.state_at(s))
    }

    fn first_zero(&self, from: f64) -> Option<Bracket> {
        let bounds = &mut |from, to| self.bounds(from, to);
        first_bracket_within(&mut |s| self.value(s), bounds, from, 1.0)
    }
}

impl<F: Flow<N>, const N: usize> DenseGuard<'_, F, N> {
    /// Proof by interval bounds about the guard between two parts of the step.
    fn bounds(&self, from: f64, to: f64) -> Bounds {
        let first = if self.start.is_some() {
            SAMPLED_START
        } else {
            0.0
        };
        if to <= first {
            return Bounds::Unknown;
        }
        if self.bounds_budget.is_unused() && !self.origin.allows_longer && !self.depends_on_time() {
            // Error control has resolved the path of the state.
            self.bounds_budget.exhaust();
        }
        let is_clear = |from, to| self.is_clear(from, to);
        match self.bounds_budget.bounds((from.max(first), to), &is_clear) {
            Bounds::Clear if from < first => Bounds::Unknown,
            bounds => bounds,
        }
    }

    /// Whether the guard changes with time alone, or may.
    fn depends_on_time(&self) -> bool {
        let Origin { flow, t, x, h, .. } = self.origin;
        let states = std::array::from_fn(|i| Interval::new(x[i], x[i]));
        let range = flow.range(self.guard, Interval::new(*t, t + h), &states);
        range.is_none_or(|range| range.low != range.high)
    }

    /// Whether the guard is certain to be positive between two parts of the step.
    fn is_clear(&self, from: f64, to: f64) -> bool {
        let Origin { flow, t, h, .. } = self.origin;
        let times = Interval::new(t + from * h, t + to * h);
        let states = self.dense.enclosure_between(from, to);
        flow.is_clear(self.guard, times, &states)
    }

    /// Time and state at the part `s` of the step, by a step of that length.
    fn state_at(&self, s: f64) -> Timed<N> {
        let origin = self.origin;
        let field = &mut |t: f64, x: &State<N>| origin.flow.velocity(t, x);
        let part = s * origin.h;
        origin.count(origin.method.calls - 1);
        let x = (origin.method.step_end)(field, origin.t, &origin.x, origin.slope, part);
        let t = origin.t + part;
        Timed {
            t,
            x: origin.flow.settle(t, x),
        }
    }

    fn probe_at(&self, at: Timed<N>) -> Probe<N> {
        // Three passes through the field on dual numbers.
        self.origin.count(3);
        let [guard, rate, bend, _] = self.origin.flow.jet(self.guard, at.t, &at.x);
        Probe {
            s: (at.t - self.origin.t) / self.origin.h,
            at,
            guard: guard + self.offset(),
            rate,
            bend,
        }
    }

    /// Locates the zero within `bracket` (parts of the step); `estimate` is the zero of the dense
    /// output. `None` if the re-integrated step has no zero in the bracket.
    pub(crate) fn locate(
        &self,
        bracket: Bracket,
        estimate: f64,
        locator: Locator,
        limits: Limits,
    ) -> Option<Event<N>> {
        let touch = limits.touch;
        let zero = match locator {
            Locator::Auto => self.polish(self.probe(estimate), &limits),
            Locator::Henon => {
                let (t, x) = (self.origin.t, self.origin.x);
                self.whole_henon_step(self.probe_at(Timed { t, x }), &limits)
            }
            Locator::RootSearch => None,
        };
        let zero = match zero {
            Some(probe) => probe,
            None => match self.search(bracket, estimate, limits.rounding) {
                SearchResult::Zero(probe) => probe,
                SearchResult::Turn(turn) if turn.guard.abs() <= touch => {
                    return match ZeroKind::classify_turn(turn, self, touch) {
                        ZeroKind::Touch(turn) => Some(turn.event(self.guard, true)),
                        _ => None,
                    };
                }
                SearchResult::Turn(_) => return None,
            },
        };
        match ZeroKind::classify(&zero, self, touch) {
            ZeroKind::Exit => Some(zero.event(self.guard, false)),
            ZeroKind::Touch(turn) => Some(turn.event(self.guard, true)),
            ZeroKind::StillAtStart => None,
        }
    }
}
