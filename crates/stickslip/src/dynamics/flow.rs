//! The smooth flow of one mode of a typed system.

use std::cell::OnceCell;

use super::carried::{CarriedOver, TangentVector};
use super::jumps::Jumps;
use super::view::View;
use super::{Carrying, Guard, Modes, Moment, SmoothFlow, Step, TangentFlow, Vector};
use crate::dual::Dual;
use crate::duals::Duals;
use crate::filippov::{Direction, Flow, GuardGradient, Settled, Switched, UseFlow, Velocity};
use crate::interval::Interval;
use crate::ode::Timed;
use crate::scalar::Scalar;
use crate::system::{State, components};
use crate::taylor::row::lanes;

/// Largest error of the duration of a step by its times, in roundings of a time: those of both
/// ends, and of what led there.
const ROUNDINGS: f64 = 4.0;

/// The flow of one mode of a typed system.
pub(super) struct TypedFlow<'a, S: Switched<N, G>, V, J, const N: usize, const G: usize> {
    view: View<'a, S, V, J, N, G>,
    mode: S::Mode,
    /// The moment that decides whether contact is lost or kept.
    at: Timed<N>,
    branch: OnceCell<S::Branch>,
}

impl<'a, S, V, J, const N: usize, const G: usize> TypedFlow<'a, S, V, J, N, G>
where
    S: Switched<N, G>,
    J: Jumps<N>,
{
    /// The flow of a mode, with contact lost or kept as at a moment.
    pub(super) fn new(view: View<'a, S, V, J, N, G>, mode: Modes, at: &Moment) -> Self {
        TypedFlow {
            view,
            mode: S::restored(mode),
            at: view.timed(at),
            branch: OnceCell::new(),
        }
    }

    /// The velocity of one contact does not depend on branches.
    fn with_flow_of_field<U: UseFlow<N>>(&self, user: U) -> U::Output {
        if S::CONTACTS > 1 {
            return self.with_flow_of_guards(user);
        }
        let branch = S::Branch::default();
        self.view.system.with_flow(self.mode, branch, user)
    }

    fn with_flow_of_guards<U: UseFlow<N>>(&self, user: U) -> U::Output {
        let system = self.view.system;
        let branch = *self
            .branch
            .get_or_init(|| system.branch(self.mode, &self.at));
        system.with_flow(self.mode, branch, user)
    }

    /// The velocity, with held inputs as stored in the state.
    pub(super) fn velocity_at(&self, at: &Timed<N>) -> Vector {
        let velocity = self.with_flow_of_field(Velocity(at.t, components(&at.x)));
        self.view.vector(&State::from(velocity))
    }

    /// The duration of a step. The rounding of times may be as long as a short step, as in the last
    /// impacts before a rest. Each state then tells the duration, too, by its motion. The mean of
    /// all is weighted by rounding. The error of mean rates stays within the bound on the result.
    ///
    /// Only jumps have such steps and derivatives: crossings that accumulate end these, by name.
    fn duration(&self, step: &Step) -> f64 {
        // Relative rounding of a duration that counts. Chosen: an orbit at the default tolerance is
        // no more accurate.
        const COUNTS: f64 = 1e-10;
        let length = step.t_end - step.t_start;
        let rounding = f64::EPSILON * step.t_end.abs();
        if self.view.jumps.count() == 0 || rounding < COUNTS * length {
            return length;
        }
        let [from, to] = [step.start(), step.end()];
        let rates = [&from, &to].map(|at| self.velocity_at(&self.view.timed(at)));
        let (mut sum, mut weight) = (length / rounding / rounding, (rounding * rounding).recip());
        for (state, (start, end)) in step.x_start.iter().zip(&step.x_end).enumerate() {
            let [before, after] = [0, 1].map(|end: usize| rates[end][state]);
            // A state that comes back, as a gap between impacts, was further away.
            let way = (before.abs() + after.abs()) * (length + rounding);
            let rounding = f64::EPSILON * (start.abs() + end.abs() + way);
            let rate = 0.5 * (before + after) / rounding;
            let moved = (end - start) / rounding;
            if rate.is_finite() && moved.is_finite() {
                sum += rate * moved;
                weight += rate * rate;
            }
        }
        let known = sum / weight;
        let off = ROUNDINGS * rounding;
        match known.is_finite() {
            true => known.max(length - off).min(length + off),
            false => length,
        }
    }

    /// The function of a guard's jump, if the guard belongs to one.
    fn jump(&self, guard: usize) -> Option<JumpGuard<'_, J>> {
        let (jumps, number) = (self.view.jumps, guard.checked_sub(G)?);
        let value = jumps.when(number, self.at.t, components(&self.at.x));
        let sign = match jumps.direction(number) {
            Direction::Rising => -1.0,
            Direction::Falling => 1.0,
            Direction::Both if value < 0.0 => -1.0,
            Direction::Both => 1.0,
        };
        Some(JumpGuard {
            jumps,
            number,
            sign,
        })
    }

    /// Intervals of all components of the type's state.
    fn ranges(&self, x: &[Interval]) -> [Interval; N] {
        let zero = Interval::around(0.0, 0.0);
        std::array::from_fn(|i| x.get(i).copied().unwrap_or(zero))
    }
}

impl<S, V, J, const N: usize, const G: usize> SmoothFlow for TypedFlow<'_, S, V, J, N, G>
where
    S: Switched<N, G>,
    J: Jumps<N>,
{
    fn velocity(&self, at: &Moment) -> Vector {
        self.velocity_at(&self.view.timed(at))
    }

    fn guards(&self) -> Vec<Guard> {
        let system = self.view.system;
        let guard = |number: usize| Guard {
            number,
            contact: S::contact_of(number),
            continues_phase: system
                .event_within_mode(number, &mut S::Branch::default())
                .is_some(),
            is_of_jump: false,
            is_watched: true,
            is_condition: true,
            is_reaction: false,
        };
        let guards = self.with_flow_of_field(Guards).iter().copied().map(guard);
        let guards = guards.filter(|guard| guard.contact < self.view.contacts);
        let jumps = (0..self.view.jumps.count()).map(|jump| Guard {
            number: G + jump,
            contact: self.view.contacts + jump,
            continues_phase: false,
            is_of_jump: true,
            is_watched: self.view.jumps.is_searched(jump) && !self.view.jumps.is_conditional(jump),
            is_condition: self.view.jumps.is_never_negative(jump)
                || self.view.jumps.is_reaction(jump),
            is_reaction: self.view.jumps.is_reaction(jump),
        });
        guards.chain(jumps).collect()
    }

    fn guard(&self, number: usize, at: &Moment) -> f64 {
        if let Some(jump) = self.jump(number) {
            let Timed { t, x } = self.view.timed(at);
            return jump.guard(t, components(&x));
        }
        self.with_flow_of_guards(GuardValue(number, self.view.timed(at)))
    }

    fn guard_jet(&self, number: usize, at: &Moment) -> [f64; 4] {
        if let Some(jump) = self.jump(number) {
            return self.with_flow_of_field(JumpJet(&jump, self.view.timed(at)));
        }
        self.with_flow_of_guards(GuardJet(number, self.view.timed(at)))
    }
}

impl<S, V, J, const N: usize, const G: usize> TangentFlow for TypedFlow<'_, S, V, J, N, G>
where
    S: Switched<N, G>,
    J: Jumps<N>,
{
    fn moving(&self) -> usize {
        self.view.system.dimension().min(self.view.states)
    }

    fn derivative(&self, at: &Moment, along: &Vector) -> Vector {
        let Timed { t, x } = self.view.timed(at);
        let along = self.view.state(along.as_slice());
        let seeded: [_; N] = std::array::from_fn(|i| Dual::new(x[i], along[i]));
        let velocity = self.with_flow_of_field(Velocity(Dual::new(t, 0.0), &seeded));
        Vector::from_fn(self.view.states, |i, _| velocity[i].eps)
    }

    fn divergence(&self, at: &Moment) -> f64 {
        const AXES: usize = 4;
        let Timed { t, x } = self.view.timed(at);
        let states = self.view.states;
        let axes = (0..states).step_by(AXES);
        let diagonal = axes.flat_map(|first| {
            let seeded: [Duals<AXES>; N] = std::array::from_fn(|i| Duals {
                re: x[i],
                eps: lanes(|l| f64::from(u8::from(i == first + l))),
            });
            let velocity = self.with_flow_of_field(Velocity(Duals::constant(t), &seeded));
            let axes = first..states.min(first + AXES);
            axes.map(move |i| velocity[i].eps[i - first])
        });
        diagonal.sum()
    }

    fn projected(&self, at: &Moment) -> Vector {
        let settled = self.with_flow_of_field(Settled(self.view.timed(at)));
        self.view.vector(&settled)
    }

    fn guard_gradient(&self, number: usize, at: &Moment) -> (Vector, f64) {
        if let Some(jump) = self.jump(number) {
            let (slopes, in_time) = self
                .view
                .gradient(|t, x| jump.guard(t, x), &self.view.timed(at));
            return (self.view.vector(&slopes), in_time);
        }
        let (gradient, in_time) =
            self.with_flow_of_guards(GuardGradient(number, self.view.timed(at), self.view.states));
        (self.view.vector(&gradient), in_time)
    }

    fn transport(&self, step: &Step, vectors: &[Vector], how: Carrying) -> Vec<Vector> {
        let view = &self.view;
        let x = view.timed(&step.start()).x;
        let vectors = vectors.iter().map(|vector| TangentVector {
            x,
            vector: view.state(vector.as_slice()),
        });
        let mut vectors: Vec<TangentVector<N>> = vectors.collect();
        self.with_flow_of_field(CarriedOver {
            start: step.t_start,
            length: self.duration(step),
            vectors: &mut vectors,
            states: view.states,
            how,
        });
        vectors.iter().map(|end| view.vector(&end.vector)).collect()
    }

    fn is_clear(&self, t: Interval, x: &[Interval]) -> bool {
        let x = self.ranges(x);
        let is_clear = |jump: usize| {
            let over = Interval::decided(|| self.view.jumps.when(jump, t, &x));
            over.is_some_and(|over| over.low > 0.0 || over.high < 0.0)
        };
        self.with_flow_of_guards(StaysClear(t, &x)) && (0..self.view.jumps.count()).all(is_clear)
    }

    fn velocity_over(&self, t: Interval, x: &[Interval]) -> Option<Vec<Interval>> {
        let x = self.ranges(x);
        let velocity = || self.view.system.slip_field(self.mode, t, &x);
        let mut velocity = Vec::from(Interval::decided(velocity).flatten()?);
        velocity.truncate(self.view.states);
        Some(velocity)
    }

    fn derivative_over(&self, t: Interval, x: &[Interval], by: usize) -> Option<Vec<Interval>> {
        let x = self.ranges(x);
        let [zero, one] = [0.0, 1.0].map(|value| Interval::around(value, 0.0));
        let seeded = std::array::from_fn(|i| Dual::new(x[i], if i == by { one } else { zero }));
        let time = Dual::new(t, zero);
        let velocity = || self.view.system.slip_field(self.mode, time, &seeded);
        let velocity = Interval::decided(velocity).flatten()?;
        let derivatives = velocity.iter().take(self.view.states);
        Some(derivatives.map(|component| component.eps).collect())
    }
}

/// The function of a jump, positive before the jump.
struct JumpGuard<'a, J> {
    jumps: &'a J,
    number: usize,
    sign: f64,
}

impl<J> JumpGuard<'_, J> {
    fn guard<T: Scalar, const N: usize>(&self, t: T, x: &[T; N]) -> T
    where
        J: Jumps<N>,
    {
        self.jumps.when(self.number, t, x) * self.sign
    }
}

/// Value and derivatives in time of the function of a jump.
struct JumpJet<'a, J, const N: usize>(&'a JumpGuard<'a, J>, Timed<N>);

impl<J: Jumps<N>, const N: usize> UseFlow<N> for JumpJet<'_, J, N> {
    type Output = [f64; 4];

    fn with<F: Flow<N>>(self, flow: &F) -> [f64; 4] {
        let JumpJet(jump, Timed { t, x }) = self;
        let path = flow.path(t, &x);
        let g = jump.guard(path.0, &path.1);
        [g.re, g.v1, g.v2, g.v3]
    }
}

/// The indices of the guards.
struct Guards;

impl<const N: usize> UseFlow<N> for Guards {
    type Output = &'static [usize];

    fn with<F: Flow<N>>(self, flow: &F) -> &'static [usize] {
        flow.guards()
    }
}

/// The value of a guard.
struct GuardValue<const N: usize>(usize, Timed<N>);

impl<const N: usize> UseFlow<N> for GuardValue<N> {
    type Output = f64;

    fn with<F: Flow<N>>(self, flow: &F) -> f64 {
        flow.guard_at(self.0, self.1.t, &self.1.x)
    }
}

/// Value and derivatives in time of a guard.
struct GuardJet<const N: usize>(usize, Timed<N>);

impl<const N: usize> UseFlow<N> for GuardJet<N> {
    type Output = [f64; 4];

    fn with<F: Flow<N>>(self, flow: &F) -> [f64; 4] {
        flow.jet(self.0, self.1.t, &self.1.x)
    }
}

/// Whether all guards are bounded away from zero over a box.
struct StaysClear<'a, const N: usize>(Interval, &'a [Interval; N]);

impl<const N: usize> UseFlow<N> for StaysClear<'_, N> {
    type Output = bool;

    fn with<F: Flow<N>>(self, flow: &F) -> bool {
        flow.guards()
            .iter()
            .all(|&i| flow.is_clear(i, self.0, self.1))
    }
}
