//! A guard over one step, whatever made the step, and the search for its first event.

use super::event::Event;
use super::scan::{Bracket, NARROWEST, first_bracket, zero_in};
use crate::ode::Timed;

/// A guard as a function of the part `s` of a step: 0 at the start of the step, 1 at its end.
pub(crate) trait StepGuard<const N: usize> {
    /// The part of the step up to which probes mean something: a contact that the step's end cuts in two has its turning point
    /// beyond it.
    fn beyond(&self) -> f64;

    /// The step's length in the unit of time that the rates of probes are given in.
    fn length(&self) -> f64;

    /// Whether it has a zero at the start, where the state has touched or left its boundary.
    fn starts_at_zero(&self) -> bool;

    /// What is added to a guard that starts flat at zero; see [`super::leaving::Leaving`].
    fn lift(&self) -> f64;

    /// The guard; with a zero at the start, it is divided out.
    fn value(&self, s: f64) -> f64;

    /// State and guard, lifted, as exactly as they can be had at `s`.
    fn probe(&self, s: f64) -> Probe<N>;

    /// Brackets the first zero behind `from`, found by resolving the values over all that is left of the step.
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

/// The first event of a guard over a step, by `locate`: it is given a bracket, the zero in it, and whether the bracket is all
/// that is left of the step. What it finds nothing in was a dip that the exact step does not have.
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
        // The search goes on where the values are positive again; if they nowhere are, the step's end, where values and
        // probes agree, closes the bracket.
        let Some(back) = first_bracket(&mut |s| -guard.value(s), bracket.b, 1.0) else {
            let rest = Bracket {
                a: bracket.b,
                b: 1.0,
            };
            return locate(rest, 1.0, true);
        };
        from = back.b.max(from + NARROWEST);
    }
    None
}

/// What a zero of a guard comes to.
pub(crate) enum Fall<const N: usize> {
    /// It falls below.
    Exit,
    /// It turns back there.
    Touch(Probe<N>),
    /// It has not been away since it was zero at the start.
    Nothing,
}

impl<const N: usize> Fall<N> {
    /// What the guard, zero at the probe and falling, does behind it: whether it turns back no deeper than `depth` below zero.
    pub(crate) fn behind(zero: &Probe<N>, guard: &dyn StepGuard<N>, depth: f64) -> Self {
        if zero.bend > 0.0 && zero.rate * zero.rate <= 2.0 * depth * zero.bend {
            let turn = turning_point(guard, zero.s);
            // Behind a corner it may fall on, however it bends before.
            if turn.guard.abs() <= depth {
                return Fall::turning(turn, guard, depth);
            }
        }
        Fall::Exit
    }

    /// What it comes to that the guard turns back here, no farther than `depth` from zero.
    pub(crate) fn turning(turn: Probe<N>, guard: &dyn StepGuard<N>, depth: f64) -> Self {
        let is_near = |s: f64| guard.probe(s).guard.abs() <= depth;
        if guard.starts_at_zero() && is_near(0.5 * turn.s) {
            Fall::Nothing
        } else {
            Fall::Touch(turn)
        }
    }
}

/// Where the guard is least: a zero of its rate near the part `s` of the step, by Newton's iteration.
pub(crate) fn turning_point<const N: usize>(guard: &dyn StepGuard<N>, s: f64) -> Probe<N> {
    let mut s = s;
    let mut here = guard.probe(s);
    for _ in 0..30 {
        if here.bend <= 0.0 || here.rate == 0.0 {
            break;
        }
        let change = (-here.rate / (here.bend * guard.length())).clamp(-0.5, 0.5);
        let next = (s + change).clamp(0.0, guard.beyond());
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
