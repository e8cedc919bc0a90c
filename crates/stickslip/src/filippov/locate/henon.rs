//! Hénon steps onto Σ: the guard replaces time as the independent variable.

use super::{DenseGuard, Limits, StepMethod};
use crate::filippov::flow::Flow;
use crate::filippov::guard::Probe;
use crate::ode::{Rk4, Timed};

/// Largest rest, as a part of the step, over which a Hénon step of order 4 suffices. Its error is
/// the fifth power of the rest, negligible beside the tolerance of a step of order 8.
const ORDER_FOUR_PART: f64 = 1e-3;

impl<F: Flow<N>, const N: usize> DenseGuard<'_, F, N> {
    fn henon(&self, method: StepMethod<N>, from: &Timed<N>, change: f64) -> Timed<N> {
        self.origin.count(method.calls);
        let flow = self.origin.flow;
        (method.henon_step)(&mut |at| flow.henon_slope(self.guard, at), from, change)
    }

    /// One Hénon step from a state near the zero onto it, of order 4 if the rest is short. Another
    /// follows if the guard is curved and the first leaves more than rounding. `None` near grazing,
    /// where the guard's rate could change its sign on the way, and where the guard jumps.
    pub(super) fn polish(&self, from: Probe<N>, limits: &Limits) -> Option<Probe<N>> {
        let mut best = from;
        for _ in 0..3 {
            if best.guard.abs() <= limits.rounding {
                break;
            }
            if !is_steady(&best) {
                return None;
            }
            let is_short = best.guard.abs() <= ORDER_FOUR_PART * self.origin.h * best.rate.abs();
            let method = if is_short {
                StepMethod::by::<Rk4>()
            } else {
                self.origin.method
            };
            let to = self.henon(method, &best.at, -best.guard);
            let to = self.probe_at(Timed {
                t: to.t,
                x: self.origin.flow.settle(to.t, to.x),
            });
            if to.guard.abs() >= best.guard.abs() {
                break;
            }
            best = to;
        }
        (best.rate < 0.0 && best.guard.abs() <= limits.mismatch).then_some(best)
    }

    /// One Hénon step from the start of the integration step, repeated from its end while
    /// more than rounding is left. `None` if the swapped slope is nearly singular on the way. Also
    /// `None` if an ordinary step of that length misses Σ by more than the limit. A step that suits
    /// one independent variable may be too long for the other.
    pub(super) fn whole_henon_step(&self, start: Probe<N>, limits: &Limits) -> Option<Probe<N>> {
        if start.rate >= 0.0 || start.guard <= 0.0 {
            return None;
        }
        let to = self.henon(self.origin.method, &start.at, -start.guard);
        let within = to.t >= self.origin.t && to.t <= self.origin.t + 1.5 * self.origin.h;
        if !within || to.x.iter().any(|v| !v.is_finite()) {
            return None;
        }
        let to = self.probe_at(to);
        // A rate that has lost half its size means a slope that has doubled: not one smooth step.
        if to.rate >= 0.5 * start.rate || to.guard.abs() > 0.1 * start.guard {
            return None;
        }
        let landed = self.polish(to, limits)?;
        if limits.mismatch.is_finite() {
            let ordinary = self.state_at(landed.s);
            let miss: f64 = self
                .origin
                .flow
                .guard_at(self.guard, ordinary.t, &ordinary.x);
            if miss.abs() > limits.mismatch {
                return None;
            }
        }
        Some(landed)
    }
}

/// Whether the guard's rate keeps its size on the way to the zero, so that the swapped slope is far
/// from singular.
fn is_steady<const N: usize>(probe: &Probe<N>) -> bool {
    let square = probe.rate * probe.rate;
    probe.rate < 0.0 && (probe.guard * probe.bend).abs() <= 0.02 * square
}

#[cfg(test)]
mod tests {
    use super::ORDER_FOUR_PART;
    use crate::math;
    use crate::ode::control::squared_error;
    use crate::ode::{Dop853, Rk4, RungeKutta, Timed, Tolerance, henon_step, stages};
    use crate::system::State;
    use numerics::SplitMix;

    /// State of a shaken pendulum when its speed has changed by what it changes by in the part
    /// `rest` of a step.
    fn by_henon<M: RungeKutta>(from: &Timed<2>, push: f64, rest: f64) -> State<2> {
        let field =
            |t: f64, x: &State<2>| State::from([x[1], push + math::cos(t) - math::sin(x[0])]);
        let change = rest * field(from.t, &from.x)[1];
        let mut slope = |at: &Timed<2>| {
            let f = field(at.t, &at.x);
            Timed {
                t: 1.0 / f[1],
                x: f / f[1],
            }
        };
        henon_step::<M, 2>(&mut slope, from, change).x
    }

    /// The longest step within the tolerance.
    fn longest(from: &Timed<2>, push: f64, tol: f64) -> f64 {
        let mut field =
            |t: f64, x: &State<2>| State::from([x[1], push + math::cos(t) - math::sin(x[0])]);
        let slope = field(from.t, &from.x);
        let tolerance = Tolerance {
            rtol: tol,
            atol: [tol; 2],
        };
        let mut h = 8.0;
        loop {
            let step = stages::<Dop853, f64, _>(&mut field, from.t, &from.x, slope, h);
            if squared_error::<Dop853, 2>(&step, &from.x, h, (&tolerance, 2)) <= 1.0 {
                return h;
            }
            h *= 0.9;
        }
    }

    #[test]
    fn over_a_short_way_order_four_is_as_good_as_eight() {
        let mut draw = SplitMix::new(14);
        // The largest differences over a short way and one thirty times as long, in units of what
        // is next to nothing.
        let mut worst = [0.0_f64; 2];
        for _ in 0..500 {
            let from = Timed {
                t: draw.between(0.0, 6.3),
                x: State::from([draw.between(-3.0, 3.0), draw.between(-2.0, 2.0)]),
            };
            let push = draw.between(3.0, 5.0);
            let tol = math::pow(10.0, draw.between(-12.0, -1.0));
            let short = ORDER_FOUR_PART * longest(&from, push, tol);
            for (rest, worst) in [short, 30.0 * short].into_iter().zip(&mut worst) {
                let four = by_henon::<Rk4>(&from, push, rest);
                let off = (four - by_henon::<Dop853>(&from, push, rest)).amax();
                *worst = worst.max(off / (1e-10 * tol + 4e-15));
            }
        }
        assert!(worst[0] <= 1.0 && worst[1] > 10.0, "{worst:?}");
    }
}
