//! All sign changes of an event function in a step.

use std::ops::ControlFlow;

use super::over_step::{EventProbe, OverStep};
use super::search::Standing;
use super::{Direction, EventFunctions};
use crate::filippov::scan::{
    BoundsBudget, Bracket, NARROWEST_INTERVAL, NODES, UNIT_NODES, far_from_zero,
    first_bracket_within, stays_positive, zero_in,
};
use crate::filippov::switched::Switched;

/// Growth of the distance from a zero to the next point at which the function is evaluated again.
/// Chosen: ten evaluations then cover a step from [`FIRST_PROBE`] on.
const PROBE_GROWTH: f64 = 8.0;

/// Distance from a zero to the first of these points, as a part of the step: 8⁻⁹, which is about
/// [`NARROWEST_INTERVAL`]. The last one is the end of the step.
const FIRST_PROBE: f64 = 1.0 / ((1_u32 << 27) as f64);

/// Least change of a function over a step, in units of its rounding, that shows it passing through
/// zero at the step's end. Chosen far above rounding: a resting function has a rate of rounding.
const PASSING_RATE: f64 = 1024.0;

/// Rounding of a single value, as a part of what many operations accumulate. Chosen: four units in
/// the last place of 64.
const SINGLE_VALUE: f64 = 0.0625;

/// Largest number of Newton iterations for a zero: twice what bisection alone takes.
const MAX_ITERATIONS: usize = 100;

/// Receives a crossing, and may end the search.
type OnCrossing<'a, const N: usize> = dyn FnMut(&EventProbe<N>, Direction) -> ControlFlow<()> + 'a;

/// The search for the sign changes of one function over one step.
pub(super) struct Crossings<'a, S, V, K, const N: usize, const G: usize> {
    pub over: OverStep<'a, S, V, K, N>,
    /// Last sign of the function beyond rounding; 0 while unknown.
    pub side: f64,
    /// Whether the function stands at a zero that it has not left beyond rounding.
    pub stands: bool,
    /// The function on the dense output at the points of [`UNIT_NODES`].
    pub samples: [f64; NODES],
}

/// Crossing that follows a point where the function has its sign beyond rounding.
enum NextCrossing<const N: usize> {
    /// A zero, and a point after it with the other sign, or without one.
    Crossing(EventProbe<N>, EventProbe<N>),
    /// A zero of the dense output alone, or a pole, which ends here.
    Clear(EventProbe<N>),
    /// Nothing in this step, except possibly at its end.
    End,
}

impl<'a, S, V, const N: usize, const G: usize> Crossings<'a, S, V, S::Mode, N, G>
where
    S: Switched<N, G>,
    V: EventFunctions<N>,
{
    pub(super) fn new(over: OverStep<'a, S, V, S::Mode, N>, side: f64) -> Self {
        Crossings {
            over,
            side,
            stands: false,
            samples: [0.0; NODES],
        }
    }

    /// Compares a function that stands at a zero, or leaves it, with its value there. Returns how
    /// it stands at the start of the step.
    pub(super) fn stand(&mut self, mut standing: Standing) -> Standing {
        if matches!(standing, Standing::Left) {
            return standing;
        }
        if let Standing::AtStart(_) = standing {
            standing = Standing::At(self.over.value_at_start());
        }
        let start = self.exact(0.0);
        if self.side * start.value > 4.0 * self.over.rounding_at(&start) {
            return Standing::Left;
        }
        if let Standing::At(zero) | Standing::Leaving(zero) = standing {
            self.over.zero = zero;
        }
        self.stands = matches!(standing, Standing::At(_));
        standing
    }

    /// Reports crossings in order of time. [`Crossings::side`] is then the sign at the step's end,
    /// or after the crossing that ended the search.
    #[inline(always)]
    pub(super) fn each(&mut self, on_crossing: &mut OnCrossing<'_, N>) -> ControlFlow<()> {
        self.samples = self.over.samples();
        let is_far = self.side != 0.0 && far_from_zero(&self.samples.map(|v| self.side * v));
        // Nearly every step returns here. Samples do not see a function that varies faster than
        // they resolve; bounds do.
        let is_clear = || self.over.is_smooth() || self.over.is_clear(self.side, (0.0, 1.0));
        if is_far && (is_clear() || self.first_bracket(0.0).is_none()) || self.passes_by() {
            self.stands = false;
            return ControlFlow::Continue(());
        }
        self.search(on_crossing)
    }

    /// Whether a function that samples resolve keeps its sign beyond rounding.
    fn passes_by(&self) -> bool {
        let heights = self.samples.map(|v| self.side * v);
        if self.side == 0.0 || !self.over.is_smooth() || !stays_positive(&heights) {
            return false;
        }
        // The dense output does not have the zero at which a phase ends.
        let is_beyond = |(value, blur): (f64, f64)| self.side * value > blur;
        heights[0] > self.over.rounding_at_start() && is_beyond(self.over.end())
    }

    #[cold]
    #[inline(never)]
    fn search(&mut self, on_crossing: &mut OnCrossing<'_, N>) -> ControlFlow<()> {
        let mut from = self.exact(0.0);
        loop {
            if !self.is_clear(&from) {
                let Some(left) = self.first_clear(&from) else {
                    return ControlFlow::Continue(());
                };
                if self.side * left.value < 0.0 && !from.value.is_nan() {
                    let before = self.last_before(&from, &left);
                    self.stands &= before.is_none();
                    let zero = before.and_then(|before| self.zero(&before, &left, before.s));
                    self.report(&zero.unwrap_or(from), on_crossing)?;
                }
                self.side = left.value.signum();
                from = left;
            }
            self.stands = false;
            match self.next(&from) {
                NextCrossing::Crossing(zero, after) => {
                    self.report(&zero, on_crossing)?;
                    // It may turn back before the end of the bracket.
                    let soon = self.exact((zero.s + NARROWEST_INTERVAL).min(after.s));
                    from = if self.is_clear(&soon) { soon } else { after };
                }
                NextCrossing::Clear(after) => {
                    if !after.value.is_nan() {
                        self.side = after.value.signum();
                    }
                    from = after;
                }
                NextCrossing::End => break,
            }
        }
        // A zero at the end is reported there: the motion after it may be another one.
        let end = self.exact(1.0);
        let blur = self.over.rounding_at(&end);
        if self.side * end.value < -blur {
            match self.zero(&from, &end, 1.0) {
                Some(zero) => self.report(&zero, on_crossing)?,
                None => self.side = end.value.signum(),
            }
        } else if self.side * end.value <= blur
            && -self.side * end.rate * self.over.length() > PASSING_RATE * blur
        {
            self.report(&end, on_crossing)?;
        }
        ControlFlow::Continue(())
    }

    fn exact(&self, s: f64) -> EventProbe<N> {
        self.over.exact(s)
    }

    /// The function on the dense output, positive on its last side. At the points of [`UNIT_NODES`]
    /// its values are known.
    #[inline(always)]
    fn height(&self, s: f64) -> f64 {
        let node = UNIT_NODES.iter().position(|&node| node == s);
        let value = node.map_or_else(|| self.over.sampled(s), |node| self.samples[node]);
        self.side * value
    }

    /// Whether the function has its last sign, beyond rounding.
    fn is_clear(&self, probe: &EventProbe<N>) -> bool {
        self.side * probe.value > self.over.rounding_at(probe)
    }

    /// A place before the function has passed through zero, as far as single values resolve it:
    /// where the search begins, or where the function turns back.
    fn last_before(&self, from: &EventProbe<N>, left: &EventProbe<N>) -> Option<EventProbe<N>> {
        let is_before = |probe: &EventProbe<N>| {
            self.side * probe.value > SINGLE_VALUE * self.over.rounding_at(probe)
        };
        if is_before(from) {
            return Some(*from);
        }
        let (mut turn, mut after) = (*from, left.s);
        for _ in 0..MAX_ITERATIONS {
            let middle = 0.5 * (turn.s + after);
            if middle <= turn.s || middle >= after {
                break;
            }
            let probe = self.exact(middle);
            if self.side * probe.rate > 0.0 {
                turn = probe;
            } else {
                after = middle;
            }
        }
        Some(turn).filter(is_before)
    }

    fn report(
        &mut self,
        at: &EventProbe<N>,
        on_crossing: &mut OnCrossing<'_, N>,
    ) -> ControlFlow<()> {
        let direction = Direction::leaving(self.side);
        self.side = -self.side;
        on_crossing(at, direction)
    }

    /// First point where a function that may be at zero is beyond rounding; `None` if there is none
    /// in this step.
    fn first_clear(&self, from: &EventProbe<N>) -> Option<EventProbe<N>> {
        let has_left = |probe: &EventProbe<N>| probe.value.abs() > self.over.rounding_at(probe);
        if has_left(from) {
            return Some(*from);
        }
        let mut part = FIRST_PROBE;
        while part <= 1.0 {
            let s = from.s + part * (1.0 - from.s);
            let probe = self.exact(s);
            if s > from.s && has_left(&probe) {
                return Some(probe);
            }
            part *= PROBE_GROWTH;
        }
        None
    }

    /// A bracket of the first zero of the dense output after a part of the step.
    fn first_bracket(&self, from: f64) -> Option<Bracket> {
        let budget = BoundsBudget::default();
        if self.over.is_smooth() {
            budget.exhaust();
        }
        let is_clear = |from, to| self.over.is_clear(self.side, (from, to));
        let bounds = &mut |from, to| budget.bounds((from, to), &is_clear);
        first_bracket_within(&mut |s| self.height(s), bounds, from, 1.0)
    }

    fn next(&self, from: &EventProbe<N>) -> NextCrossing<N> {
        let height = &mut |s: f64| self.height(s);
        let Some(bracket) = self.first_bracket(from.s) else {
            return NextCrossing::End;
        };
        let estimate = zero_in(height, bracket);
        let mut after = self.exact(bracket.b);
        // The step itself passes through zero near the zero of its dense output, or not at all.
        let mut further = NARROWEST_INTERVAL;
        while self.side * after.value > 0.0 {
            if after.s >= 1.0 {
                return NextCrossing::End;
            }
            if self.height(after.s) > 0.0 {
                return NextCrossing::Clear(after);
            }
            after = self.exact((after.s + further).min(1.0));
            further *= 4.0;
        }
        if after.value.is_nan() {
            return NextCrossing::Clear(after);
        }
        let before = Some(bracket.a)
            .filter(|a| *a > from.s)
            .map(|a| self.exact(a));
        let before = before.filter(|before| self.side * before.value > 0.0);
        let before = before.unwrap_or(*from);
        match self.zero(&before, &after, estimate) {
            Some(zero) => NextCrossing::Crossing(zero, after),
            None => NextCrossing::Clear(after),
        }
    }

    /// The zero between two places by Newton's iteration, held between them by bisection; `None`
    /// where the function grows to a pole instead.
    fn zero(
        &self,
        before: &EventProbe<N>,
        after: &EventProbe<N>,
        estimate: f64,
    ) -> Option<EventProbe<N>> {
        // At the end of a phase it has the bits of that end.
        if after.s >= 1.0 && after.value.abs() <= self.over.rounding_at(after) {
            return Some(*after);
        }
        let here = self.newton((before.s, after.s), estimate);
        // Where rounding hides a zero, a value may be larger than those at the ends.
        let size = |end: &EventProbe<N>| end.value.abs().max(self.over.rounding_at(end));
        (here.value.abs() <= size(before).max(size(after))).then_some(here)
    }

    /// Newton's iteration for a zero from an estimate, held between two places by bisection. The
    /// function has its last sign before the zero.
    pub(super) fn newton(&self, (mut a, mut b): (f64, f64), estimate: f64) -> EventProbe<N> {
        let mut here = self.exact(estimate.clamp(a, b));
        for _ in 0..MAX_ITERATIONS {
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
        here
    }
}
