//! Where exactly, inside a step, a guard reaches zero.

use std::cell::Cell;

use num_dual::Dual;

use super::event::Event;
use super::flow::Flow;
use super::options::Locator;
use super::scan::Bracket;
use crate::ode::{RungeKutta, Timed, Tolerance, henon_step, stages};
use crate::system::State;

/// Start of an accepted step: what re-integration from there needs.
pub(crate) struct Origin<'a, F, const N: usize> {
    pub flow: &'a F,
    pub t: f64,
    pub x: State<f64, N>,
    pub slope: State<f64, N>,
    pub h: f64,
    /// Calls of the user's field by location.
    pub field_calls: Cell<u64>,
}

/// What location is held to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// Contacts no deeper than this are touches.
    pub touch: f64,
    /// A Hénon step over a whole step and an ordinary one may differ by this much in the guard.
    pub mismatch: f64,
}

/// A state on the re-integrated step with what decides there.
#[derive(Clone, Copy)]
struct Probe<const N: usize> {
    at: Timed<f64, N>,
    guard: f64,
    rate: f64,
    bend: f64,
}

impl<F: Flow<N>, const N: usize> Origin<'_, F, N> {
    /// Time and state at the part `s` of the step, by a step of that length.
    fn reach<M: RungeKutta>(&self, s: f64) -> Timed<f64, N> {
        let field = &mut |t: f64, x: &State<f64, N>| self.flow.field(t, x);
        let part = s * self.h;
        self.count(M::COEFFICIENTS.stages as u64 - 1);
        let x = stages::<M, f64, _>(field, self.t, &self.x, self.slope, part).end;
        let t = self.t + part;
        Timed {
            t,
            x: self.flow.settle(t, x),
        }
    }

    fn probe<M: RungeKutta>(&self, i: usize, s: f64) -> Probe<N> {
        let at = self.reach::<M>(s);
        self.look(i, at)
    }

    fn count(&self, evaluations: u64) {
        let calls = self.field_calls.get() + F::FIELD_CALLS * evaluations;
        self.field_calls.set(calls);
    }

    fn henon<M: RungeKutta>(&self, i: usize, from: &Timed<f64, N>, change: f64) -> Timed<f64, N> {
        self.count(M::COEFFICIENTS.stages as u64);
        henon_step::<M, f64, N>(&mut |at| self.flow.swapped(i, at), from, change)
    }

    fn look(&self, i: usize, at: Timed<f64, N>) -> Probe<N> {
        // Three passes through the field on dual numbers.
        self.count(3);
        let [guard, rate, bend, _] = self.flow.jet(i, at.t, &at.x);
        Probe {
            at,
            guard,
            rate,
            bend,
        }
    }

    /// Locates the zero of guard `i` within `bracket` (parts of the step); `estimate` is where the dense output has it. `None`
    /// where the re-integrated step has no zero in the bracket.
    pub(crate) fn locate<M: RungeKutta>(
        &self,
        i: usize,
        bracket: Bracket,
        estimate: f64,
        locator: Locator,
        limits: Limits,
    ) -> Option<Event<N>> {
        let touch = limits.touch;
        let event = |probe: Probe<N>, is_touch| {
            Some(Event {
                guard: i,
                at: probe.at,
                is_touch,
                residual: probe.guard.abs(),
            })
        };
        let found = match locator {
            Locator::Auto => self.polish::<M>(i, self.probe::<M>(i, estimate)),
            Locator::Henon => {
                let start = Timed {
                    t: self.t,
                    x: self.x,
                };
                self.whole_henon_step::<M>(i, self.look(i, start), limits.mismatch)
            }
            Locator::RootSearch => None,
        };
        let found = match found {
            Some(probe) => probe,
            None => match self.search::<M>(i, bracket, estimate) {
                Search::Zero(probe) => probe,
                Search::Turn(probe) if probe.guard.abs() <= touch => return event(probe, true),
                Search::Turn(_) => return None,
            },
        };
        // How far the guard will go below zero before it turns back, if it does.
        if found.bend > 0.0 && found.rate * found.rate <= 2.0 * touch * found.bend {
            let s = (found.at.t - self.t) / self.h;
            return event(self.turning_point::<M>(i, s), true);
        }
        event(found, false)
    }

    /// From a state hardly off the zero, one Hénon step onto it (again where the guard is curved and the first has left
    /// more than rounding). `None` where the guard's rate could change along the way: near grazing.
    fn polish<M: RungeKutta>(&self, i: usize, from: Probe<N>) -> Option<Probe<N>> {
        let mut best = from;
        for _ in 0..3 {
            if best.guard == 0.0 {
                break;
            }
            if !steady(&best) {
                return None;
            }
            let to = self.henon::<M>(i, &best.at, -best.guard);
            let to = self.look(
                i,
                Timed {
                    t: to.t,
                    x: self.flow.settle(to.t, to.x),
                },
            );
            if to.guard.abs() >= best.guard.abs() {
                break;
            }
            best = to;
        }
        (best.rate < 0.0).then_some(best)
    }

    /// The paper's Hénon step from the start of the integration step, then the same from where it ends while more than
    /// rounding is left. `None` where the swapped slope is or comes near to being singular on the way, and where an
    /// ordinary step of that length misses Σ by more than `mismatch`: a step chosen for the one independent variable may be
    /// too long for the other.
    fn whole_henon_step<M: RungeKutta>(
        &self,
        i: usize,
        start: Probe<N>,
        mismatch: f64,
    ) -> Option<Probe<N>> {
        if start.rate >= 0.0 || start.guard <= 0.0 {
            return None;
        }
        let to = self.henon::<M>(i, &start.at, -start.guard);
        let within = to.t >= self.t && to.t <= self.t + 1.5 * self.h;
        if !within || to.x.iter().any(|v| !v.is_finite()) {
            return None;
        }
        let to = self.look(i, to);
        // A rate that has lost half its size on the way means a slope that has doubled: no longer one smooth step.
        if to.rate >= 0.5 * start.rate || to.guard.abs() > 0.1 * start.guard {
            return None;
        }
        let landed = self.polish::<M>(i, to)?;
        if mismatch.is_finite() {
            let ordinary = self.reach::<M>((landed.at.t - self.t) / self.h);
            let miss: f64 = self.flow.guard(i, ordinary.t, &ordinary.x);
            if miss.abs() > mismatch {
                return None;
            }
        }
        Some(landed)
    }

    /// Newton's iteration on re-integrated steps, held in a bracket by bisection.
    fn search<M: RungeKutta>(&self, i: usize, bracket: Bracket, estimate: f64) -> Search<N> {
        let (mut a, mut b) = (bracket.a, bracket.b);
        let end = self.probe::<M>(i, b);
        if end.guard > 0.0 {
            let turn = self.turning_point::<M>(i, estimate);
            if turn.guard > 0.0 {
                return Search::Turn(turn);
            }
            let s = (turn.at.t - self.t) / self.h;
            if s <= a || s > b.max(1.0) {
                // The turning point that was found belongs to another dip than the bracket's.
                return Search::Turn(turn);
            }
            b = s;
        }
        let mut s = estimate.clamp(a, b);
        let mut here = self.probe::<M>(i, s);
        for _ in 0..200 {
            if here.guard == 0.0 {
                break;
            }
            if here.guard > 0.0 {
                a = s;
            } else {
                b = s;
            }
            let newton = s - here.guard / (here.rate * self.h);
            let next = if newton > a && newton < b {
                newton
            } else {
                0.5 * (a + b)
            };
            if next == s || next <= a || next >= b {
                break;
            }
            let there = self.probe::<M>(i, next);
            let stalled = (next - s).abs() <= 2.0 * f64::EPSILON * s.abs()
                && there.guard.abs() >= here.guard.abs();
            (s, here) = (next, there);
            if stalled {
                break;
            }
        }
        Search::Zero(here)
    }

    /// Where the guard is least: a zero of its rate near the part `s` of the step, by Newton's iteration.
    fn turning_point<M: RungeKutta>(&self, i: usize, s: f64) -> Probe<N> {
        let mut s = s;
        let mut here = self.probe::<M>(i, s);
        for _ in 0..30 {
            if here.bend <= 0.0 || here.rate == 0.0 {
                break;
            }
            let change = (-here.rate / (here.bend * self.h)).clamp(-0.5, 0.5);
            let next = (s + change).clamp(0.0, 1.5);
            if next == s {
                break;
            }
            let there = self.probe::<M>(i, next);
            let converged = change.abs() <= 1e-15 || there.rate.abs() >= here.rate.abs();
            if there.rate.abs() < here.rate.abs() {
                (s, here) = (next, there);
            }
            if converged {
                break;
            }
        }
        here
    }
}

/// Whether the guard's rate keeps its size over the way to the zero, so that the swapped slope is far from singular.
fn steady<const N: usize>(probe: &Probe<N>) -> bool {
    let square = probe.rate * probe.rate;
    probe.rate < 0.0 && (probe.guard * probe.bend).abs() <= 0.02 * square
}

enum Search<const N: usize> {
    Zero(Probe<N>),
    Turn(Probe<N>),
}

/// How well guard `i` is known at a state, given how well the state is: by the tolerance of the integration, and by
/// rounding alone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Uncertainty {
    pub by_tolerance: f64,
    pub by_rounding: f64,
}

/// Units in the last place by which rounding is taken to blur state and time.
const ULPS: f64 = 64.0;

pub(crate) fn uncertainty<F: Flow<N>, const N: usize>(
    flow: &F,
    i: usize,
    at: &Timed<f64, N>,
    tolerance: &Tolerance,
) -> Uncertainty {
    let (mut by_tolerance, mut by_rounding) = (0.0, 0.0);
    // Direction N is time, which no tolerance blurs.
    for direction in 0..=N {
        let seed = |at: usize| f64::from(u8::from(at == direction));
        let x = State::<Dual<f64>, N>::from_fn(|k, _| Dual::new(at.x[k], seed(k)));
        let slope = flow.guard(i, Dual::new(at.t, seed(N)), &x).eps.abs();
        if direction < N {
            let size = at.x[direction].abs();
            by_tolerance += slope * (tolerance.atol + tolerance.rtol * size);
            by_rounding += slope * size;
        } else {
            by_rounding += slope * at.t.abs();
        }
    }
    by_rounding *= ULPS * f64::EPSILON;
    Uncertainty {
        by_tolerance,
        by_rounding,
    }
}
