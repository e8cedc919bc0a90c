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
use crate::ode::{Dop853, Rk4, RungeKutta, SolutionTerms, Timed, step_end};
use crate::system::{State, components};

/// The solution over a step, evaluated once for all functions.
pub(super) struct SampledStep<'a, K, const N: usize> {
    pub step: &'a StepRecord<N, K>,
    /// Times and states at the points of [`UNIT_NODES`].
    nodes: OnceCell<[Timed<N>; NODES]>,
    /// The terms of the solution, and a box that contains the states.
    terms: OnceCell<SolutionTerms<N>>,
    enclosure: OnceCell<[Interval; N]>,
    wide: OnceCell<[Interval; N]>,
    /// Such boxes over the halves of the step, each followed by those over its own halves.
    parts: [OnceCell<[Interval; N]>; PARTS.len()],
}

/// The halves of a step, each followed by its own halves.
const PARTS: [(f64, f64); 6] = [
    (0.0, 0.5),
    (0.0, 0.25),
    (0.25, 0.5),
    (0.5, 1.0),
    (0.5, 0.75),
    (0.75, 1.0),
];

impl<'a, K, const N: usize> SampledStep<'a, K, N> {
    pub(super) fn new(step: &'a StepRecord<N, K>) -> Self {
        SampledStep {
            step,
            nodes: OnceCell::new(),
            terms: OnceCell::new(),
            enclosure: OnceCell::new(),
            wide: OnceCell::new(),
            parts: [const { OnceCell::new() }; PARTS.len()],
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

    pub(super) fn terms(&self) -> &SolutionTerms<N> {
        self.terms.get_or_init(|| self.step.dense.terms())
    }

    /// A box that is wider, and takes less time.
    fn wide_enclosure(&self) -> &[Interval; N] {
        self.wide.get_or_init(|| self.step.dense.enclosure())
    }

    fn enclosure(&self) -> &[Interval; N] {
        self.enclosure.get_or_init(|| self.terms().enclosure())
    }

    /// The box over one of [`PARTS`], with its times.
    fn part(&self, number: usize) -> (Interval, &[Interval; N]) {
        let StepRecord {
            t_start,
            t_end,
            dense,
            ..
        } = self.step;
        let length = t_end - t_start;
        let (from, to) = (PARTS[number].0 * length, PARTS[number].1 * length);
        let around = || dense.enclosure_about_middle(from / dense.h, to / dense.h);
        let times = Interval::new(t_start + from, t_start + to);
        (times, self.parts[number].get_or_init(around))
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

    /// Whether boxes of the states prove that the function has the sign `side`.
    pub(super) fn is_clear_throughout(&self, side: f64) -> bool {
        let step = self.step();
        let times = Interval::new(step.t_start, step.t_end);
        let is_clear = |states: &[Interval; N]| self.has_sign(side, times, states);
        if is_clear(self.over.wide_enclosure()) || is_clear(self.over.enclosure()) {
            return true;
        }
        let (t, x) = (step.t_end, step.x_end);
        // Otherwise it changes its sign, and no box excludes that.
        if side * self.value(&Timed { t, x }) <= 0.0 {
            return false;
        }
        let is_clear = |part: usize| {
            let (times, states) = self.over.part(part);
            self.has_sign(side, times, states)
        };
        [0, 3]
            .iter()
            .all(|&half| is_clear(half) || is_clear(half + 1) && is_clear(half + 2))
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
        value.is_some_and(|value| {
            let value = (value - self.zero) * side;
            // A zero at the very end of a step is one to rounding.
            value.low > 0.0 && value.low > STATE_ROUNDING * value.high
        })
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

#[cfg(test)]
mod tests {
    use numerics::SplitMix;

    use super::super::affine::Slopes;
    use super::*;
    use crate::filippov::integration::{Integration, Progress};
    use crate::filippov::options::Options;
    use crate::scalar::Scalar;
    use crate::system::{Filippov, Side};

    /// An oscillator of frequency 1.
    struct Oscillator;
    impl Filippov<2> for Oscillator {
        fn field<T: Scalar>(&self, _side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
            [x[1], -x[0]]
        }
        fn boundary<T: Scalar>(&self, _t: T, _x: &[T; 2]) -> T {
            T::one()
        }
    }

    /// Affine functions by their slopes in time and state and a constant, and one that is not.
    struct Levels(Vec<[f64; 4]>);
    impl EventFunctions<2> for Levels {
        fn count(&self) -> usize {
            self.0.len() + 1
        }
        fn value<T: Scalar>(&self, number: usize, t: T, x: &[T; 2]) -> T {
            match self.0.get(number) {
                Some([in_time, a, b, c]) => t * *in_time + x[0] * *a + x[1] * *b + *c,
                None => x[0] * x[0] + x[1] * x[1] - 2.5,
            }
        }
        fn is_affine(&self, number: usize) -> bool {
            number < self.0.len()
        }
    }

    #[test]
    fn a_function_that_is_called_clear_has_its_sign_throughout_the_step() {
        let mut draw = SplitMix::new(66);
        let level = |_| [0.3, 1.0, 1.0, 2.0].map(|size| draw.between(-size, size));
        let levels = Levels((0..200).map(level).collect());
        for method in [Method::Taylor, Method::Dop853] {
            let options = Options::tol(1e-10).method(method);
            let run = Integration::new(&Oscillator, 1.0, [0.6, -0.8], 30.0, &options);
            let mut run = run.unwrap();
            let (mut clear, mut without_zero) = (0, 0);
            while run.step().unwrap() == Progress::Step {
                let step = run.last_step();
                let over = SampledStep::new(&step);
                let (functions, mut slopes) = Slopes::of(&levels);
                for slopes in &mut slopes {
                    slopes.follow(&over, &step.x_end.abs());
                }
                for (number, affine) in functions.into_iter().enumerate() {
                    let of = OverStep {
                        system: &Oscillator,
                        events: &levels,
                        number,
                        dimension: 2,
                        over: &over,
                        method,
                        size: &step.x_end,
                        zero: 0.0,
                    };
                    let side = of.sampled(0.5).signum();
                    assert_eq!(affine.is_some(), number < 200);
                    let mut is_clear_throughout = |side| match affine {
                        Some(affine) => slopes[affine.slopes].has_sign(side, affine),
                        None => of.is_clear_throughout(side),
                    };
                    let is_clear = is_clear_throughout(side);
                    let mut samples = (0..=64).map(|k| of.sampled(f64::from(k) / 64.0));
                    let has_sign = samples.all(|value| side * value > 0.0);
                    assert!(has_sign || !is_clear, "{number}");
                    assert!(is_clear || number < 200, "half the distance to a circle");
                    clear += u32::from(is_clear);
                    without_zero += u32::from(has_sign);
                    assert!(!is_clear_throughout(-side));
                }
            }
            // Terms that reach their bounds at other times hide some.
            assert!(10 * clear > 9 * without_zero, "{clear} of {without_zero}");
        }
    }
}
