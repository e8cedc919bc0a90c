//! All sign changes of an event function in a step.

use std::ops::ControlFlow;

use super::over_step::{OverStep, Place};
use super::{Direction, EventFunctions};
use crate::filippov::scan::{
    Asked, Bracket, NARROWEST, NODES, UNIT, far_from_zero, first_bracket_within, zero_in,
};
use crate::filippov::switched::Switched;

/// A function at zero is evaluated again after a fraction of the step that grows by this factor
/// from [`SOON`].
const LATER: f64 = 8.0;

/// 8⁻⁹: about [`NARROWEST`], and the last look is at the end of the step.
const SOON: f64 = 1.0 / ((1_u32 << 27) as f64);

/// A function is passing through zero if its rate takes it this many times its rounding in a step.
const PASSING: f64 = 1024.0;

/// Iterations allowed: bisection alone takes some fifty.
const MOST: usize = 100;

/// Receives a crossing, and may end the search.
type Tell<'a, const N: usize> = dyn FnMut(&Place<N>, Direction) -> ControlFlow<()> + 'a;

/// The search for the sign changes of one function over one step.
pub(super) struct Crossings<'a, S, V, K, const N: usize, const G: usize, const E: usize> {
    pub over: OverStep<'a, S, V, K, N>,
    /// Last sign of the function beyond rounding; 0 while unknown.
    pub side: f64,
    /// The function on the dense output at the points of [`UNIT`].
    pub samples: [f64; NODES],
}

/// What follows a point where the function has its sign beyond rounding.
enum Next<const N: usize> {
    /// A zero, and a point behind it with the other sign, or without one.
    Crossing(Place<N>, Place<N>),
    /// A zero of the dense output alone, or a pole, which ends here.
    Clear(Place<N>),
    /// Nothing in this step, except possibly at its end.
    End,
}

impl<S, V, const N: usize, const G: usize, const E: usize> Crossings<'_, S, V, S::Mode, N, G, E>
where
    S: Switched<N, G>,
    V: EventFunctions<N, E>,
{
    /// Reports crossings in order of time. [`Crossings::side`] is then the sign at the step's end,
    /// or behind the crossing that ended the search.
    #[inline(always)]
    pub(super) fn each(&mut self, tell: &mut Tell<'_, N>) -> ControlFlow<()> {
        self.samples = UNIT.map(|s| self.over.sampled(s));
        let is_far = self.side != 0.0 && far_from_zero(&self.samples.map(|v| self.side * v));
        // Nearly every step returns here. Samples do not see a function that varies faster than
        // they resolve; bounds do.
        let is_clear = || self.over.is_smooth() || self.over.is_clear(self.side, (0.0, 1.0));
        if is_far && (is_clear() || self.first_bracket(0.0).is_none()) {
            return ControlFlow::Continue(());
        }
        self.search(tell)
    }

    #[cold]
    #[inline(never)]
    fn search(&mut self, tell: &mut Tell<'_, N>) -> ControlFlow<()> {
        let mut from = self.exact(0.0);
        loop {
            if !self.is_clear(&from) {
                let Some(left) = self.leaves(&from) else {
                    return ControlFlow::Continue(());
                };
                if self.side * left.value < 0.0 && !from.value.is_nan() {
                    self.pass(&from, tell)?;
                }
                self.side = left.value.signum();
                from = left;
            }
            match self.next(&from) {
                Next::Crossing(zero, behind) => {
                    self.pass(&zero, tell)?;
                    // It may turn back before the end of the bracket.
                    let soon = self.exact((zero.s + NARROWEST).min(behind.s));
                    from = if self.is_clear(&soon) { soon } else { behind };
                }
                Next::Clear(behind) => {
                    if !behind.value.is_nan() {
                        self.side = behind.value.signum();
                    }
                    from = behind;
                }
                Next::End => break,
            }
        }
        // A zero at the end is reported there: the motion behind it may be another one.
        let end = self.exact(1.0);
        let blur = self.over.blur(&end);
        if self.side * end.value < -blur {
            match self.zero(&from, &end, 1.0) {
                Some(zero) => self.pass(&zero, tell)?,
                None => self.side = end.value.signum(),
            }
        } else if self.side * end.value <= blur
            && -self.side * end.rate * self.over.length() > PASSING * blur
        {
            self.pass(&end, tell)?;
        }
        ControlFlow::Continue(())
    }

    fn exact(&self, s: f64) -> Place<N> {
        self.over.exact(s)
    }

    /// The function on the dense output, positive on its last side. At the points of [`UNIT`] its
    /// values are known.
    #[inline(always)]
    fn height(&self, s: f64) -> f64 {
        let known = UNIT.iter().position(|&known| known == s);
        let value = known.map_or_else(|| self.over.sampled(s), |known| self.samples[known]);
        self.side * value
    }

    /// Whether the function has its last sign, beyond rounding.
    fn is_clear(&self, place: &Place<N>) -> bool {
        self.side * place.value > self.over.blur(place)
    }

    fn pass(&mut self, at: &Place<N>, tell: &mut Tell<'_, N>) -> ControlFlow<()> {
        let direction = if self.side < 0.0 {
            Direction::Rising
        } else {
            Direction::Falling
        };
        self.side = -self.side;
        tell(at, direction)
    }

    /// First point where a function that may be at zero is beyond rounding; `None` if there is none
    /// in this step.
    fn leaves(&self, from: &Place<N>) -> Option<Place<N>> {
        let has_left = |place: &Place<N>| place.value.abs() > self.over.blur(place);
        if has_left(from) {
            return Some(*from);
        }
        let mut part = SOON;
        while part <= 1.0 {
            let s = from.s + part * (1.0 - from.s);
            let place = self.exact(s);
            if s > from.s && has_left(&place) {
                return Some(place);
            }
            part *= LATER;
        }
        None
    }

    /// A bracket of the first zero of the dense output behind a part of the step.
    fn first_bracket(&self, from: f64) -> Option<Bracket> {
        let asked = Asked::default();
        if self.over.is_smooth() {
            asked.no_more();
        }
        let is_clear = |from, to| self.over.is_clear(self.side, (from, to));
        let bounds = &mut |from, to| asked.bounds((from, to), &is_clear);
        first_bracket_within(&mut |s| self.height(s), bounds, from, 1.0)
    }

    fn next(&self, from: &Place<N>) -> Next<N> {
        let height = &mut |s: f64| self.height(s);
        let Some(bracket) = self.first_bracket(from.s) else {
            return Next::End;
        };
        let estimate = zero_in(height, bracket);
        let mut behind = self.exact(bracket.b);
        // The step itself passes through zero near the zero of its dense output, or not at all.
        let mut further = NARROWEST;
        while self.side * behind.value > 0.0 {
            if behind.s >= 1.0 {
                return Next::End;
            }
            if self.height(behind.s) > 0.0 {
                return Next::Clear(behind);
            }
            behind = self.exact((behind.s + further).min(1.0));
            further *= 4.0;
        }
        if behind.value.is_nan() {
            return Next::Clear(behind);
        }
        let before = Some(bracket.a)
            .filter(|a| *a > from.s)
            .map(|a| self.exact(a));
        let before = before.filter(|before| self.side * before.value > 0.0);
        let before = before.unwrap_or(*from);
        match self.zero(&before, &behind, estimate) {
            Some(zero) => Next::Crossing(zero, behind),
            None => Next::Clear(behind),
        }
    }

    /// The zero between two places by Newton's iteration, held between them by bisection; `None`
    /// where the function grows to a pole instead.
    fn zero(&self, before: &Place<N>, behind: &Place<N>, estimate: f64) -> Option<Place<N>> {
        // At the end of a phase it has the bits of that end.
        if behind.s >= 1.0 && behind.value.abs() <= self.over.blur(behind) {
            return Some(*behind);
        }
        let (mut a, mut b) = (before.s, behind.s);
        let mut here = self.exact(estimate.clamp(a, b));
        for _ in 0..MOST {
            if here.value == 0.0 {
                break;
            }
            if self.side * here.value > 0.0 {
                a = here.s;
            } else {
                b = here.s;
            }
            let newton = here.s - here.value / (here.rate * self.over.length());
            // The next iterate would be the same, to rounding.
            if (newton - here.s).abs() <= f64::EPSILON {
                break;
            }
            let next = if newton > a && newton < b {
                newton
            } else {
                0.5 * (a + b)
            };
            if next <= a || next >= b {
                break;
            }
            here = self.exact(next);
        }
        let size = before.value.abs().max(behind.value.abs());
        (here.value.abs() <= size).then_some(here)
    }
}
