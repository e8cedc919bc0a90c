//! Solutions along a path, by their arclength.

use super::{Cycle, ULPS};
use crate::analysis::critical::zero_between;

/// Solutions of one kind, each with its place: periodic orbits with one sequence, or equilibria of
/// one mode.
pub(crate) trait SolutionsOnLine {
    type Solution: Clone;

    /// The solution at a place.
    fn on(&self, place: f64) -> Option<Self::Solution>;

    /// Solution at `place` with a far smaller error of integration.
    fn finer(&self, place: f64) -> Option<Self::Solution>;

    /// The parameter of a solution.
    fn parameter(&self, solution: &Self::Solution) -> f64;

    /// Two places at which a function has different signs, or one zero, near a place with a known
    /// value; they are usually less than a step apart.
    fn bracket(
        &self,
        (mut a, mut at_a): PlaceAndValue,
        step: f64,
        function: &SolutionFunction<'_, Self::Solution>,
    ) -> Option<[PlaceAndValue; 2]> {
        // First step, as a fraction of the given one. Chosen: short beside it, long beside
        // rounding.
        const FIRST_STEP: f64 = 1e-2;
        // The next steps lead beyond the extrapolated zero by half the distance to it.
        const OVERSHOOT: f64 = 1.5;
        const MOST_STEPS: usize = 8;
        let mut b = a + FIRST_STEP * step;
        for _ in 0..MOST_STEPS {
            let at_b = function(&self.on(b)?)?;
            if at_a * at_b <= 0.0 {
                return Some([(a, at_a), (b, at_b)]);
            }
            let slope = (at_b - at_a) / (b - a);
            (a, at_a, b) = (b, at_b, b - OVERSHOOT * at_b / slope);
        }
        None
    }

    /// Zero of a function between two places at which it has different signs.
    fn root(
        &self,
        [a, b]: [PlaceAndValue; 2],
        function: &SolutionFunction<'_, Self::Solution>,
    ) -> Option<(f64, Self::Solution)> {
        let s = zero_between(a, b, |s| function(&self.on(s)?))?;
        let solution = self.on(s)?;
        let is_zero = function(&solution)?.abs() <= AT_ZERO * a.1.abs().max(b.1.abs());
        is_zero.then_some((s, solution))
    }

    /// Zero of a function, and the uncertainty of its parameter.
    fn zero(
        &self,
        [a, b]: [PlaceAndValue; 2],
        function: &SolutionFunction<'_, Self::Solution>,
    ) -> Option<LocatedZero<Self::Solution>> {
        let (s, solution) = self.root([a, b], function)?;
        let uncertainty = self.uncertainty((s, &solution), (b.0 - a.0).abs(), function);
        Some(LocatedZero {
            s,
            parameter: self.parameter(&solution),
            solution,
            uncertainty: uncertainty.unwrap_or(f64::NAN),
        })
    }

    /// Uncertainty of the parameter near a zero of a function: its residual with its rounding
    /// error, over its slope, and the error of integration. Half the steps show that. NaN where
    /// there is no estimate.
    fn uncertainty(
        &self,
        (s, solution): (f64, &Self::Solution),
        length: f64,
        function: &SolutionFunction<'_, Self::Solution>,
    ) -> Option<f64> {
        // Distance of the places between which the slope is measured, as a fraction of the bracket.
        // Chosen: the curvature then changes the slope by about as much.
        const NEIGHBOUR: f64 = 1e-4;
        let places = [s - NEIGHBOUR * length, s + NEIGHBOUR * length];
        let [one, two] = [self.on(places[0])?, self.on(places[1])?];
        let (value, [before, behind]) = (function(solution)?, [function(&one)?, function(&two)?]);
        let finer = self.finer(s)?;
        let of_steps = SAFETY * (function(&finer)? - value).abs();
        let error = value.abs() + (behind - 2.0 * value + before).abs() + of_steps;
        let parameter = self.parameter(solution);
        // At a fold the parameter is quadratic in the place.
        let steps = [&one, &two].map(|one| (self.parameter(one) - parameter).abs());
        let along = steps[0].max(steps[1]) * (2.0 * error / (behind - before)).abs();
        Some(along + SAFETY * (self.parameter(&finer) - parameter).abs())
    }
}

/// Value at a zero of a function, as a fraction of those at the ends of a path. Chosen: at a jump
/// of the function, as in a family, it is about 1; at a zero it is rounding.
pub(crate) const AT_ZERO: f64 = 1e-3;

/// Ratio of an error of integration to the change that half the steps cause. At order 4 and more,
/// that change is the error to a tenth or so, and twice the change bounds it.
pub(crate) const SAFETY: f64 = 2.0;

/// An uncertainty of a parameter or, where that is not finite, the other one. On top comes what the
/// rounding of so many steps leaves of the last digits in a range of this width.
pub(crate) fn with_last_digits(
    (parameter, uncertainty): (f64, f64),
    otherwise: f64,
    (width, steps): (f64, usize),
) -> f64 {
    let is_known = uncertainty.is_finite();
    let uncertainty = if is_known { uncertainty } else { otherwise };
    uncertainty + ULPS * steps as f64 * f64::EPSILON * parameter.abs().max(width)
}

/// A function of solutions, such as of periodic orbits.
pub(crate) type SolutionFunction<'f, S = Cycle> = dyn Fn(&S) -> Option<f64> + 'f;

/// A solution at which a function is zero.
pub(crate) struct LocatedZero<S = Cycle> {
    /// Place.
    pub s: f64,
    pub parameter: f64,
    pub solution: S,
    /// Uncertainty of the parameter; NaN where there is no estimate.
    pub uncertainty: f64,
}

/// A place, and the value of a function there.
type PlaceAndValue = (f64, f64);
