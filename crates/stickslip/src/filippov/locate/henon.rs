//! Landing on Σ by Hénon steps: the guard takes the place of time as the independent variable.

use super::OnDense;
use crate::filippov::flow::Flow;
use crate::filippov::guard::Probe;
use crate::ode::{RungeKutta, Timed, henon_step};

impl<M: RungeKutta, F: Flow<N>, const N: usize> OnDense<'_, M, F, N> {
    fn henon(&self, from: &Timed<N>, change: f64) -> Timed<N> {
        self.origin.count(M::COEFFICIENTS.stages as u64);
        let flow = self.origin.flow;
        henon_step::<M, N>(&mut |at| flow.swapped(self.guard, at), from, change)
    }

    /// From a state hardly off the zero, one Hénon step onto it (again where the guard is curved and the first has left
    /// more than rounding). `None` where the guard's rate could change along the way: near grazing.
    pub(super) fn polish(&self, from: Probe<N>) -> Option<Probe<N>> {
        let mut best = from;
        for _ in 0..3 {
            if best.guard == 0.0 {
                break;
            }
            if !steady(&best) {
                return None;
            }
            let to = self.henon(&best.at, -best.guard);
            let to = self.look(Timed {
                t: to.t,
                x: self.origin.flow.settle(to.t, to.x),
            });
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
    pub(super) fn whole_henon_step(&self, start: Probe<N>, mismatch: f64) -> Option<Probe<N>> {
        if start.rate >= 0.0 || start.guard <= 0.0 {
            return None;
        }
        let to = self.henon(&start.at, -start.guard);
        let within = to.t >= self.origin.t && to.t <= self.origin.t + 1.5 * self.origin.h;
        if !within || to.x.iter().any(|v| !v.is_finite()) {
            return None;
        }
        let to = self.look(to);
        // A rate that has lost half its size on the way means a slope that has doubled: no longer one smooth step.
        if to.rate >= 0.5 * start.rate || to.guard.abs() > 0.1 * start.guard {
            return None;
        }
        let landed = self.polish(to)?;
        if mismatch.is_finite() {
            let ordinary = self.reach(landed.s);
            let miss: f64 = self
                .origin
                .flow
                .guard_at(self.guard, ordinary.t, &ordinary.x);
            if miss.abs() > mismatch {
                return None;
            }
        }
        Some(landed)
    }
}

/// Whether the guard's rate keeps its size over the way to the zero, so that the swapped slope is far from singular.
fn steady<const N: usize>(probe: &Probe<N>) -> bool {
    let square = probe.rate * probe.rate;
    probe.rate < 0.0 && (probe.guard * probe.bend).abs() <= 0.02 * square
}
