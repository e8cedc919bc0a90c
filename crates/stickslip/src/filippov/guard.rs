//! A guard over one step of any method, and the search for its first event.

use super::scan::{Bracket, NARROWEST_INTERVAL, first_bracket, zero_in};
use crate::ode::Timed;

/// First zero of a guard.
#[derive(Clone, Copy, Debug)]
pub struct Event<const N: usize> {
    pub guard: usize,
    pub at: Timed<N>,
    /// Whether the guard turns back there, within the touch tolerance, instead of passing through
    /// zero.
    pub is_touch: bool,
    /// Size of the guard that remains at that state.
    pub residual: f64,
}

/// A guard as a function of the part `s` of a step: 0 at the start of the step, 1 at its end.
pub(crate) trait StepGuard<const N: usize> {
    /// Part of the step up to which probes are valid. A touch that the step's end cuts in two turns
    /// back beyond 1.
    fn probe_end(&self) -> f64;

    /// Length of the step in the time unit of the probes' rates.
    fn length(&self) -> f64;

    /// Whether the guard is zero at the start, where the state has touched or left its boundary.
    fn starts_at_zero(&self) -> bool;

    /// Offset of a guard that starts flat at zero; see [`super::deflation::DeflatedGuard`].
    fn offset(&self) -> f64;

    /// The guard. A zero at the start is divided out.
    fn value(&self, s: f64) -> f64;

    /// State and guard at `s` as exactly as the step gives them, with the offset.
    fn probe(&self, s: f64) -> Probe<N>;

    /// Brackets the first zero after `from` by resolving the values over the rest of the step.
    fn first_zero(&self, from: f64) -> Option<Bracket> {
        first_bracket(&mut |s| self.value(s), from, 1.0)
    }

    /// The zero in a bracket.
    fn zero_in(&self, bracket: Bracket) -> f64 {
        zero_in(&mut |s| self.value(s), bracket)
    }
}

/// A state with what decides there: the guard and its first two derivatives in time.
#[derive(Clone, Copy)]
pub(crate) struct Probe<const N: usize> {
    /// Part of the step.
    pub s: f64,
    pub at: Timed<N>,
    pub guard: f64,
    pub rate: f64,
    pub bend: f64,
}

impl<const N: usize> Probe<N> {
    /// The event of guard `guard` here.
    pub(crate) fn event(&self, guard: usize, is_touch: bool) -> Event<N> {
        Event {
            guard,
            at: self.at,
            is_touch,
            residual: self.guard.abs(),
        }
    }
}

/// The first event of a guard over a step. `locate` gets a bracket, the zero in it, and whether the
/// bracket is the whole rest of the step. If it finds no event, the exact step does not have the
/// dip.
pub(crate) fn first_event<E, const N: usize>(
    guard: &dyn StepGuard<N>,
    mut locate: impl FnMut(Bracket, f64, bool) -> Option<E>,
) -> Option<E> {
    let mut from = 0.0;
    while let Some(bracket) = guard.first_zero(from) {
        let zero = guard.zero_in(bracket);
        if let Some(found) = locate(bracket, zero, false) {
            return Some(found);
        }
        // The search continues where the values are positive again. If they never are, the step's
        // end closes the bracket: values and probes agree there.
        let Some(back) = first_bracket(&mut |s| -guard.value(s), bracket.b, 1.0) else {
            let rest = Bracket {
                a: bracket.b,
                b: 1.0,
            };
            return locate(rest, 1.0, true);
        };
        from = back.b.max(from + NARROWEST_INTERVAL);
    }
    None
}

/// Kind of a zero of a guard.
pub(crate) enum ZeroKind<const N: usize> {
    /// The guard passes through zero.
    Exit,
    /// The guard turns back.
    Touch(Probe<N>),
    /// The guard has not left the zero of the start.
    StillAtStart,
}

impl<const N: usize> ZeroKind<N> {
    /// Classifies a guard that is zero at the probe and falls: does it turn back no deeper than
    /// `depth`?
    pub(crate) fn classify(zero: &Probe<N>, guard: &dyn StepGuard<N>, depth: f64) -> Self {
        if zero.bend > 0.0 && zero.rate * zero.rate <= 2.0 * depth * zero.bend {
            let turn = turning_point(guard, zero.s);
            // After a corner the guard may continue to fall, whatever its curvature before.
            if turn.guard.abs() <= depth && !falls_on(zero, guard) {
                return ZeroKind::classify_turn(turn, guard, depth);
            }
        }
        ZeroKind::Exit
    }

    /// Classifies a guard that turns back here, within `depth` of zero.
    pub(crate) fn classify_turn(turn: Probe<N>, guard: &dyn StepGuard<N>, depth: f64) -> Self {
        let is_near = |s: f64| guard.probe(s).guard.abs() <= depth;
        if guard.starts_at_zero() && is_near(0.5 * turn.s) {
            ZeroKind::StillAtStart
        } else {
            ZeroKind::Touch(turn)
        }
    }
}

/// Whether the guard falls on where its curvature tells that it rises again. At a root of the
/// distance the curvature grows without bound, and the rate does not change.
fn falls_on<const N: usize>(zero: &Probe<N>, guard: &dyn StepGuard<N>) -> bool {
    let s = zero.s - 2.0 * zero.rate / (zero.bend * guard.length());
    s < guard.probe_end() && guard.probe(s).rate <= 0.5 * zero.rate && zero.rate < 0.0
}

/// Minimum of the guard: a zero of its rate near the part `s` of the step, by Newton's iteration.
pub(crate) fn turning_point<const N: usize>(guard: &dyn StepGuard<N>, s: f64) -> Probe<N> {
    let mut s = s;
    let mut here = guard.probe(s);
    for _ in 0..30 {
        if here.bend <= 0.0 || here.rate == 0.0 {
            break;
        }
        let change = (-here.rate / (here.bend * guard.length())).clamp(-0.5, 0.5);
        let next = (s + change).clamp(0.0, guard.probe_end());
        if next == s {
            break;
        }
        let there = guard.probe(next);
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
