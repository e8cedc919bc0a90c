//! Motion to and from a boundary at which a field is a root of the distance, and from a state at
//! which it is one.
//!
//! A law such as `√|v|` has an infinite slope on its own boundary, where no step of a method of
//! order resolves it. Towards it the steps shrink until the boundary is reached to rounding. Away
//! from it the first step is short and follows the law: over a time `τ` a rate `f + c τ^α` moves
//! the state by `f τ + c τ^(1+α)/(1+α)`. What error control leaves of the motion beside that is of
//! higher order in a time so short.

use super::flow::{Flow, gradient};
use super::run::{StepState, TIME_ROUNDING, Trial};
use super::switched::UseFlow;
use super::uncertainty::uncertainty;
use crate::dual::Dual;
use crate::error::{Error, Point};
use crate::math;
use crate::ode::{Dense, Linear, Timed, Tolerance};
use crate::system::{State, components};

/// Distances at which the slope is compared, each this part of the one before. Chosen: a root
/// doubles its slope and more, and a smooth law keeps it.
const NEARER: f64 = 1.0 / 16.0;

/// Largest distance at which the slope is compared, in tolerances of the guard. Chosen: behind it
/// a smooth law is a straight line.
const FARTHEST: f64 = 1e3;

/// Powers of the distance that are no Lipschitz law. Chosen: a smooth law has power 1, and one that
/// does not depend on the distance has none.
const LEAST_POWER: f64 = 0.05;
const LARGEST_POWER: f64 = 0.95;

/// Largest difference of two powers of the same law.
const SAME_POWER: f64 = 0.05;

/// Steps, or roundings of time, that a collapsed step is away from what it collapsed at. Chosen: a
/// series step takes at least a tenth of the time to a singularity.
const STEPS_LEFT: f64 = 16.0;

/// Halvings that find a root to rounding, from any start.
const HALVINGS: usize = 120;

/// The field as a function of the distance from a guard's zero.
struct RootLaw<const N: usize> {
    power: f64,
    /// The motion that moves the guard by one.
    normal: State<N>,
}

/// The law at a state on the boundary; `None` if the field is smooth there.
fn root_law<F: Flow<N>, const N: usize, const G: usize>(
    run: &StepState<N, G>,
    flow: &F,
    (guard, at): (usize, &Timed<N>),
) -> Option<RootLaw<N>> {
    let Timed { t, x } = *at;
    let (gradient, _) = gradient(|t, x| flow.guard(guard, t, x), at, run.states);
    let normal = gradient / gradient.norm_squared();
    let tolerance = run.options.tolerance();
    // A law without a root does not change over what counts as no distance.
    let nearest = x.add_scaled(run.slack(), &normal);
    let (here, there) = (flow.velocity(t, &x), flow.velocity(t, &nearest));
    if (0..run.states).all(|i| is_same(i, (here[i], there[i]), &tolerance)) {
        return None;
    }
    let farthest = FARTHEST * uncertainty(flow, guard, at, &tolerance).by_tolerance;
    let steepest = |distance: f64| {
        let there = x.add_scaled(distance, &normal);
        let along: [_; N] = std::array::from_fn(|i| Dual::new(there[i], normal[i]));
        let rates = flow.field(Dual::new(t, 0.0), &along);
        rates
            .iter()
            .fold(0.0_f64, |most, rate| most.max(rate.eps.abs()))
    };
    let slopes = [1.0, NEARER, NEARER * NEARER].map(|part| steepest(farthest * part));
    let power = |one: f64, nearer: f64| 1.0 - math::ln(nearer / one) / math::ln(1.0 / NEARER);
    let [first, second] = [power(slopes[0], slopes[1]), power(slopes[1], slopes[2])];
    // Slopes that are zero or infinite have no power.
    let is_law = (LEAST_POWER..=LARGEST_POWER).contains(&second);
    (is_law && (first - second).abs() < SAME_POWER).then_some(RootLaw {
        power: second,
        normal,
    })
}

/// Whether two values of a component agree within the tolerance.
fn is_same<const N: usize>(
    component: usize,
    (one, other): (f64, f64),
    tolerance: &Tolerance<N>,
) -> bool {
    (one - other).abs() <= tolerance.allowed(component, one.abs())
}

impl<const N: usize, const G: usize> StepState<N, G> {
    /// The first step of a phase from the zero of a guard at which the field is a root of the
    /// distance. [`Trial::NoStep`] elsewhere.
    pub(crate) fn leave_by_root<F: Flow<N>>(&mut self, flow: &F) -> Trial {
        let at_zero = |&&guard: &&usize| matches!(self.orders[guard], 1 | 2);
        let laws = flow.guards().iter().filter(at_zero);
        let law = laws.filter_map(|&guard| Some((guard, root_law(self, flow, (guard, &self.at))?)));
        let Some((guard, law)) = { law }.next() else {
            return Trial::NoStep;
        };
        let Some(to) = self.left_by(flow, guard, &law) else {
            return Trial::NoStep;
        };
        self.counters.steps += 1;
        self.dense = Dense::straight(&self.at, &to);
        let length = to.t - self.at.t;
        let trial = self.accept(to, None);
        self.record_departures(flow);
        self.h = length;
        trial
    }

    /// The first step from a state at which the field has a value but no series, as that of `√x`
    /// where `x` leaves 0: straight, and so short that the change of the field over it counts for
    /// less than the tolerance. `None` elsewhere, and where the motion does not leave such states.
    #[cold]
    pub(crate) fn leave_without_series<F: Flow<N>>(&mut self, flow: &F) -> Option<Trial> {
        let from = self.at;
        let start = flow.velocity(from.t, &from.x);
        let has_slope = |at: &Timed<N>, along: &State<N>| {
            let moved: [_; N] = std::array::from_fn(|i| Dual::new(at.x[i], along[i]));
            let rates = flow.field(Dual::new(at.t, 1.0), &moved);
            rates.iter().all(|rate| rate.eps.is_finite())
        };
        if has_slope(&from, &start) {
            return None;
        }
        let mut step = 0.5 * (self.t_end - from.t);
        let to = loop {
            if self.is_too_short(step, false) {
                return None;
            }
            let t = from.t + step;
            let straight = from.x.add_scaled(step, &start);
            let end = flow.velocity(t, &straight);
            let x = flow.settle(t, from.x.add_scaled(0.5 * step, &(start + end)));
            let is_short = (0..self.states).all(|i| {
                let allowed = self.options.allowed(i, from.x[i].abs());
                (x[i] - straight[i]).abs() <= allowed
            });
            let to = Timed { t, x };
            let holds = |&guard: &usize| flow.guard_at(guard, t, &x) > 0.0;
            if is_short && has_slope(&to, &end) && flow.guards().iter().all(holds) {
                break to;
            }
            step *= NEARER;
        };
        self.counters.steps += 1;
        self.dense = Dense::straight(&from, &to);
        let trial = self.accept(to, None);
        self.record_departures(flow);
        self.h = step;
        Some(trial)
    }

    /// The end of the first step from the zero of a guard.
    fn left_by<F: Flow<N>>(&self, flow: &F, guard: usize, law: &RootLaw<N>) -> Option<Timed<N>> {
        let from = self.at;
        let start = flow.velocity(from.t, &from.x);
        let rate =
            |t: f64, x: &State<N>, f: &State<N>| flow.rate(guard, t, components(x), components(f));
        let mut step = 0.5 * (self.t_end - from.t);
        loop {
            let t = from.t + step;
            if step <= 2.0 * TIME_ROUNDING * from.t.abs() || step < f64::MIN_POSITIVE {
                return None;
            }
            let straight = from.x.add_scaled(step, &start);
            let to = match self.orders[guard] {
                1 => {
                    let change = flow.velocity(t, &straight) - start;
                    straight.add_scaled(step / (1.0 + law.power), &change)
                }
                _ => {
                    // The distance grows as the square of the time, at a rate that it slows down.
                    let present = flow.guard_at(guard, t, &straight);
                    let at = |distance: f64| straight.add_scaled(distance - present, &law.normal);
                    let [mut low, mut high] = [0.0, 0.0];
                    let excess = |distance: f64| {
                        let x = at(distance);
                        distance - 0.5 * step * rate(t, &x, &flow.velocity(t, &x))
                    };
                    let far = 0.5 * step * rate(t, &straight, &flow.velocity(t, &at(0.0)));
                    if far > 0.0 {
                        high = far;
                    }
                    for _ in 0..HALVINGS {
                        let middle = 0.5 * (low + high);
                        match excess(middle) < 0.0 {
                            true => low = middle,
                            false => high = middle,
                        }
                    }
                    let end = flow.velocity(t, &at(high));
                    from.x.add_scaled(0.5 * step, &(start + end))
                }
            };
            // Along a straight line instead, the step differs by less than the tolerance.
            let is_short = (0..self.states).all(|i| {
                let allowed = self.options.allowed(i, from.x[i].abs());
                (to[i] - straight[i]).abs() <= allowed
            });
            let to = Timed { t, x: to };
            if is_short && flow.guard_at(guard, to.t, &to.x) > 0.0 {
                return Some(to);
            }
            step *= NEARER;
        }
    }
}

/// The state of an event on its boundary, if the field is a root of the distance there: what
/// location leaves of the distance would decide what follows.
pub(super) struct OntoRoot<'a, const N: usize, const G: usize> {
    pub run: &'a StepState<N, G>,
    pub guard: usize,
    /// Whether the rules take such a law.
    pub is_followed: bool,
}

impl<const N: usize, const G: usize> UseFlow<N> for OntoRoot<'_, N, G> {
    type Output = Result<Option<State<N>>, Error>;

    fn with<F: Flow<N>>(self, flow: &F) -> Result<Option<State<N>>, Error> {
        let OntoRoot { run, guard, .. } = self;
        let t = run.at.t;
        let x = flow.land(guard, t, run.at.x);
        let at = Timed { t, x };
        if root_law(run, flow, (guard, &at)).is_none() {
            return Ok(None);
        }
        // What rounding leaves of the distance has a root that is a million times as large. So the
        // distance must stay zero exactly, as a state less a constant does.
        let (slopes, in_time) = gradient(|t, x| flow.guard(guard, t, x), &at, run.states);
        let is_one_state =
            in_time == 0.0 && slopes.iter().filter(|&&slope| slope != 0.0).count() == 1;
        match self.is_followed && is_one_state && flow.guard_at(guard, t, &x) == 0.0 {
            true => Ok(Some(x)),
            false => Err(Error::RootAtBoundary {
                t,
                x: Point::from(&x),
            }),
        }
    }
}

/// The guard at whose zero the field is a root of the distance, and which a step that collapsed was
/// on its way to.
pub(super) struct Reached<'a, const N: usize, const G: usize> {
    pub run: &'a StepState<N, G>,
    pub step: f64,
}

impl<const N: usize, const G: usize> UseFlow<N> for Reached<'_, N, G> {
    type Output = Option<usize>;

    fn with<F: Flow<N>>(self, flow: &F) -> Option<usize> {
        let Timed { t, x } = self.run.at;
        let velocity = flow.velocity(t, &x);
        let left = STEPS_LEFT * f64::max(self.step, TIME_ROUNDING * t.abs());
        let near = flow.guards().iter().copied().find(|&guard| {
            let value = flow.guard_at(guard, t, &x);
            let rate = flow.rate(guard, t, components(&x), components(&velocity));
            self.run.orders[guard] == 0 && rate < 0.0 && value <= -rate * left
        })?;
        let x = flow.land(near, t, x);
        root_law(self.run, flow, (near, &Timed { t, x })).map(|_| near)
    }
}
