//! Solutions along a path: of a branch by their arclength, of a sweep by their parameter.

use super::{Cycle, Margin};
use crate::analysis::critical::zero_between;
use crate::filippov::Options;

/// Solutions of one kind, each at a place: periodic orbits with one sequence, or equilibria of one
/// mode.
pub(crate) trait Path {
    type Solution: Clone;

    /// The solution at a place.
    fn solution(&self, place: f64, options: &Options) -> Option<Self::Solution>;

    /// The options with which it is computed.
    fn options(&self) -> &Options;

    /// The parameter of the solution at a place, and its derivative by the place.
    fn parameter(&self, place: f64, solution: &Self::Solution) -> f64;
    fn pace(&self) -> f64;

    fn on(&self, place: f64) -> Option<Self::Solution> {
        self.solution(place, self.options())
    }

    /// Two places at which a function has different signs, or one zero, near a place with a known
    /// value; they are usually less than a step apart.
    fn bracket(
        &self,
        (mut a, mut at_a): Value,
        step: f64,
        function: &Function<'_, Self::Solution>,
    ) -> Option<[Value; 2]> {
        // First step, and how far the next one goes beyond the extrapolated zero.
        const FIRST: f64 = 1e-2;
        const FURTHER: f64 = 1.5;
        const MOST: usize = 8;
        let mut b = a + FIRST * step;
        for _ in 0..MOST {
            let at_b = function(&self.on(b)?)?;
            if at_a * at_b <= 0.0 {
                return Some([(a, at_a), (b, at_b)]);
            }
            let slope = (at_b - at_a) / (b - a);
            (a, at_a, b) = (b, at_b, b - FURTHER * at_b / slope);
        }
        None
    }

    /// Where a function is zero, between two places at which it has different signs.
    fn root(
        &self,
        [a, b]: [Value; 2],
        function: &Function<'_, Self::Solution>,
    ) -> Option<(f64, Self::Solution)> {
        let s = zero_between(a, b, |s| function(&self.on(s)?))?;
        // Where another branch meets this one, no solution can be computed; next to it there is
        // one.
        const PARTS: [f64; 5] = [0.0, 1e-10, -1e-10, 1e-9, -1e-9];
        let place = |part: &f64| s + part * (b.0 - a.0);
        let found = |s: f64| Some((s, self.on(s)?));
        let (s, solution) = PARTS.iter().map(place).find_map(found)?;
        // In a family, a function may jump.
        const SMALL: f64 = 1e-3;
        let is_zero = function(&solution)?.abs() <= SMALL * a.1.abs().max(b.1.abs());
        is_zero.then_some((s, solution))
    }

    /// The same, and the uncertainty of its parameter.
    fn zero(
        &self,
        [a, b]: [Value; 2],
        function: &Function<'_, Self::Solution>,
    ) -> Option<Zero<Self::Solution>> {
        let (s, solution) = self.root([a, b], function)?;
        let uncertainty = self.uncertainty((s, &solution), (b.0 - a.0).abs(), function);
        Some(Zero {
            s,
            parameter: self.parameter(s, &solution),
            solution,
            uncertainty: uncertainty.unwrap_or(f64::NAN),
        })
    }

    /// Uncertainty of the parameter near a zero of a function: its residual with its rounding
    /// error, over its slope, and the effect of the tolerances. A run with a tenth of them
    /// estimates that. NaN where there is no estimate.
    fn uncertainty(
        &self,
        (s, solution): (f64, &Self::Solution),
        length: f64,
        function: &Function<'_, Self::Solution>,
    ) -> Option<f64> {
        const APART: f64 = 1e-4;
        // Most of a value's error is its difference to that with a tenth of the tolerances; twice
        // that is safe.
        const SAFE: f64 = 2.0;
        let places = [s - APART * length, s + APART * length];
        let [one, two] = [self.on(places[0])?, self.on(places[1])?];
        let (value, [before, behind]) = (function(solution)?, [function(&one)?, function(&two)?]);
        let finer = self.solution(s, &self.options().finer())?;
        let by_tolerance = SAFE * (function(&finer)? - value).abs();
        let lacks = value.abs() + (behind - 2.0 * value + before).abs() + by_tolerance;
        let parameter = self.parameter(s, solution);
        // At a fold the parameter is quadratic in the place.
        let ways = [(places[0], &one), (places[1], &two)]
            .map(|(s, one)| (self.parameter(s, one) - parameter).abs());
        let along = ways[0].max(ways[1]) * (2.0 * lacks / (behind - before)).abs();
        Some(along + SAFE * (self.parameter(s, &finer) - parameter).abs())
    }

    /// The first margin that is below zero for the orbit at a place behind another one, and where;
    /// `Err` where they are too far apart to decide, as a fraction of a range of places.
    fn passed(
        &self,
        (from, last): (f64, &Cycle),
        (to, next): (f64, &Cycle),
        range: f64,
    ) -> Result<Option<(Zero, Margin)>, ()>
    where
        Self: Path<Solution = Cycle>,
    {
        // Orbits nearer than this fraction of the range differ by one change: a margin that the
        // other one lacks has no cause before the first zero.
        const NEAREST: f64 = 1e-5;
        let mut first: Option<(Zero, Margin)> = None;
        let mut is_unclear = false;
        let violated = next.margins.iter();
        for margin in violated.filter(|margin| margin.is_violated(self.options())) {
            let Some(before) = last.margin_like(margin) else {
                is_unclear = true;
                continue;
            };
            let value = |one: &Cycle| Some(one.margin_like(margin)?.value);
            let zero = if before.value <= 0.0 {
                // The last orbit is at the change, to within its error.
                let slope = (margin.value - before.value) / (to - from);
                Zero {
                    s: from,
                    parameter: self.parameter(from, last),
                    solution: last.clone(),
                    uncertainty: (self.pace() * before.value / slope).abs(),
                }
            } else {
                let ends = [(from, before.value), (to, margin.value)];
                self.zero(ends, &value).ok_or(())?
            };
            let margin = zero.solution.margin_like(margin).ok_or(())?.clone();
            let way = |zero: &Zero| (zero.s - from).abs();
            if first
                .as_ref()
                .is_none_or(|(first, _)| way(&zero) < way(first))
            {
                first = Some((zero, margin));
            }
        }
        // Another one may come first, if the step is not short enough to decide.
        if is_unclear && (first.is_none() || (to - from).abs() > NEAREST * range) {
            return Err(());
        }
        Ok(first)
    }
}

/// An uncertainty of a parameter where the function was resolved, or else the other one. It is at
/// least what Newton's iteration leaves of the last digits in a range of this width.
pub(crate) fn at_least((parameter, uncertainty): (f64, f64), otherwise: f64, width: f64) -> f64 {
    const ROUNDING: f64 = 16.0 * f64::EPSILON;
    let is_known = uncertainty.is_finite();
    let uncertainty = if is_known { uncertainty } else { otherwise };
    uncertainty.max(ROUNDING * parameter.abs().max(width))
}

/// A function of solutions, such as of periodic orbits.
pub(crate) type Function<'f, S = Cycle> = dyn Fn(&S) -> Option<f64> + 'f;

/// A solution at which a function is zero.
pub(crate) struct Zero<S = Cycle> {
    /// Its place.
    pub s: f64,
    /// Its parameter, and the computed solution.
    pub parameter: f64,
    pub solution: S,
    /// Uncertainty of its parameter; NaN where there is no estimate.
    pub uncertainty: f64,
}

/// A place, and the value of a function there.
type Value = (f64, f64);
