//! Dense output: the solution inside a step as a polynomial.

use super::linear::{Linear, Timed};
use super::step::{Stages, dense_slopes, stages, weigh};
use super::tableau::RungeKutta;
use crate::interval::Interval;
use crate::system::State;
use crate::taylor::MAX_COEFFICIENTS;

/// The solution over one step as a polynomial in `s = (t − t0)/h`, `0 ≤ s ≤ 1`.
///
/// A Runge–Kutta step has (Hairer, Nørsett & Wanner, Sect. II.6), with `r = 1 − s`,
/// `u(s) = c0 + s (c1 + r (c2 + s (c3 + r (c4 + s (c5 + r (c6 + s c7))))))`.
/// The first four coefficients are the cubic Hermite interpolant. RK4 has only those (order 3),
/// DOP853 all eight (order 7). A Taylor step has its series, as accurate inside the step as at its
/// end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dense<const N: usize> {
    /// Time at the start of the step.
    pub t0: f64,
    /// Length of the step.
    pub h: f64,
    polynomial: DensePolynomial<N>,
}

// Stored inline, without a box: step records are copied and never allocate.
#[derive(Clone, Copy, Debug, PartialEq)]
enum DensePolynomial<const N: usize> {
    /// The first four terms, of a method without further stages.
    Hermite([State<N>; 4]),
    RungeKutta([State<N>; 8]),
    /// Coefficients of the powers of `s`, up to the order given.
    Series(usize, [State<N>; MAX_COEFFICIENTS]),
}

impl<const N: usize> Dense<N> {
    /// The polynomial of one step of method `M` from `(t0, x0)` over `h`, for rare steps.
    pub fn over_step<M: RungeKutta>(
        field: &mut dyn FnMut(f64, &State<N>) -> State<N>,
        (t0, x0): (f64, &State<N>),
        h: f64,
    ) -> Self {
        let field = &mut |t: f64, x: &State<N>| field(t, x);
        let slope = field(t0, x0);
        let mut step = stages::<M, f64, _>(field, t0, x0, slope, h);
        dense_slopes::<M, f64, _>(field, t0, x0, h, &mut step);
        Dense::new::<M>(t0, x0, h, &step)
    }

    /// The polynomial of a finished step of length `h` from `(t0, x0)`, with all slopes filled in.
    #[inline(always)]
    pub(crate) fn new<M: RungeKutta>(
        t0: f64,
        x0: &State<N>,
        h: f64,
        step: &Stages<State<N>>,
    ) -> Self {
        let zero = <State<N> as Linear<f64>>::zero();
        let mut c = [zero; 4];
        let slope_at_end = &step.k[M::COEFFICIENTS.stages];
        for i in 0..N {
            let rise = step.end[i] - x0[i];
            let bend = h * step.k[0][i] - rise;
            c[0][i] = x0[i];
            c[1][i] = rise;
            c[2][i] = bend;
            c[3][i] = rise - h * slope_at_end[i] - bend;
        }
        let polynomial = if M::COEFFICIENTS.dense_stages > 0 {
            let mut all = [zero; 8];
            all[..4].copy_from_slice(&c);
            for (coefficient, weights) in all[4..].iter_mut().zip(&M::COEFFICIENTS.d) {
                *coefficient = zero.add_scaled(h, &weigh(&step.k, weights));
            }
            DensePolynomial::RungeKutta(all)
        } else {
            DensePolynomial::Hermite(c)
        };
        Dense { t0, h, polynomial }
    }

    /// A constant state from time `t0` on.
    pub(crate) fn resting(t0: f64, x: State<N>) -> Self {
        let mut c = [<State<N> as Linear<f64>>::zero(); 4];
        c[0] = x;
        Dense {
            t0,
            h: 1.0,
            polynomial: DensePolynomial::Hermite(c),
        }
    }

    /// Linear interpolation between two states.
    pub(crate) fn straight(from: &Timed<N>, to: &Timed<N>) -> Self {
        let mut dense = Dense::resting(from.t, from.x);
        dense.h = to.t - from.t;
        if let DensePolynomial::Hermite(c) = &mut dense.polynomial {
            c[1] = to.x - from.x;
        }
        dense
    }

    /// Becomes the series of a Taylor step: coefficients of the powers of `s`.
    #[inline(always)]
    pub(crate) fn become_series(
        &mut self,
        t0: f64,
        h: f64,
        order: usize,
        coefficients: &[State<N>; MAX_COEFFICIENTS],
    ) {
        (self.t0, self.h) = (t0, h);
        self.polynomial = DensePolynomial::Series(order, *coefficients);
    }

    /// Becomes a copy of another one. For Runge–Kutta steps only the method's coefficients are
    /// copied. The compiler copies the largest variant on assignment, even if it knows the variant.
    #[inline(always)]
    pub(crate) fn become_copy(&mut self, of: &Self) {
        (self.t0, self.h) = (of.t0, of.h);
        match (&mut self.polynomial, &of.polynomial) {
            (DensePolynomial::Hermite(to), DensePolynomial::Hermite(c)) => *to = *c,
            (DensePolynomial::RungeKutta(to), DensePolynomial::RungeKutta(c)) => *to = *c,
            (to, c) => *to = *c,
        }
    }

    /// Coefficients of the powers of the part of a Taylor step; `None` for other steps.
    #[inline(always)]
    pub(crate) fn series(&self) -> Option<&[State<N>]> {
        match &self.polynomial {
            DensePolynomial::Series(order, c) => Some(&c[..=*order]),
            DensePolynomial::Hermite(_) | DensePolynomial::RungeKutta(_) => None,
        }
    }

    /// Whether the field was finite at every stage. The slope at the end enters the fourth
    /// coefficient, all further slopes the last.
    #[inline(always)]
    pub(crate) fn is_finite(&self) -> bool {
        match &self.polynomial {
            DensePolynomial::Hermite(c) => c[3].iter().all(|v| v.is_finite()),
            DensePolynomial::RungeKutta(c) => (0..N).all(|i| (c[3][i] + c[7][i]).is_finite()),
            DensePolynomial::Series(_, c) => c.iter().all(|c| c.iter().all(|v| v.is_finite())),
        }
    }

    /// The state at `t0 + s h`.
    #[inline(always)]
    pub fn at(&self, s: f64) -> State<N> {
        match &self.polynomial {
            DensePolynomial::Hermite(c) => nested(c, s),
            DensePolynomial::RungeKutta(c) => nested(c, s),
            DensePolynomial::Series(order, c) => power_series(&c[..=*order], s).0,
        }
    }

    /// A box that contains the state throughout the step. The middle is the linear interpolation;
    /// the radius bounds all other terms of the polynomial between 0 and 1.
    #[inline(always)]
    pub(crate) fn enclosure(&self) -> [Interval; N] {
        match &self.polynomial {
            DensePolynomial::Hermite(c) => enclosure_of_nested(c),
            DensePolynomial::RungeKutta(c) => enclosure_of_nested(c),
            DensePolynomial::Series(order, c) => std::array::from_fn(|i| {
                let reach = c[1..=*order].iter().map(|c| c[i].abs()).sum();
                Interval::around(c[0][i], reach)
            }),
        }
    }

    /// The solution as its mean value and terms that stay within bounds. A power series has large
    /// terms that cancel over a long step; Chebyshev polynomials do not.
    pub(crate) fn terms(&self) -> SolutionTerms<N> {
        let zero = State::from([0.0; N]);
        let mut terms = SolutionTerms {
            mean: zero,
            size: zero,
            bounds: [zero; MAX_COEFFICIENTS],
            count: 0,
        };
        match &self.polynomial {
            DensePolynomial::Hermite(c) => terms.of_nested(c),
            DensePolynomial::RungeKutta(c) => terms.of_nested(c),
            DensePolynomial::Series(order, c) => terms.of_series(&c[..=*order]),
        }
        terms
    }

    /// A box that contains the state between two fractions of the step; for a series a narrower one
    /// than [`Dense::enclosure_between`], about the middle.
    pub(crate) fn enclosure_about_middle(&self, from: f64, to: f64) -> [Interval; N] {
        let DensePolynomial::Series(order, c) = &self.polynomial else {
            return self.enclosure_between(from, to);
        };
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let mut shifted = *c;
        let shifted = &mut shifted[..=*order];
        let mut size = State::from([0.0; N]);
        for c in shifted.iter() {
            size = size.add_scaled(1.0, &c.abs());
        }
        // Repeated synthetic division.
        for first in 0..*order {
            for k in (first..*order).rev() {
                shifted[k] = shifted[k].add_scaled(middle, &shifted[k + 1]);
            }
        }
        std::array::from_fn(|i| {
            let reach = shifted[1..].iter().rev();
            let reach = reach.fold(0.0, |sum: f64, c| half * (c[i].abs() + sum));
            Interval::around(shifted[0][i], reach + TERMS_ROUNDING * size[i])
        })
    }

    /// A box that contains the state between two fractions of the step.
    pub(crate) fn enclosure_between(&self, from: f64, to: f64) -> [Interval; N] {
        let (s, r) = ([from, to], [1.0 - to, 1.0 - from]);
        match &self.polynomial {
            DensePolynomial::Hermite(c) => horner_between(c, [s, r]),
            DensePolynomial::RungeKutta(c) => horner_between(c, [s, r]),
            DensePolynomial::Series(order, c) => horner_between(&c[..=*order], [s, s]),
        }
    }

    /// The state at time `t`.
    pub fn at_time(&self, t: f64) -> State<N> {
        self.at((t - self.t0) / self.h)
    }
}

/// Rounding of [`SolutionTerms`], relative to the sum of the polynomial's coefficients. Chosen:
/// four units in the last place for each of 64 operations, more than any term takes.
const TERMS_ROUNDING: f64 = 256.0 * f64::EPSILON;

/// A polynomial over a step as a mean value and terms whose factors stay between −1 and 1. The
/// factor of the first is `2s − 1`.
pub(crate) struct SolutionTerms<const N: usize> {
    mean: State<N>,
    /// Most that each term adds, with its sign.
    bounds: [State<N>; MAX_COEFFICIENTS],
    count: usize,
    /// Sum of the sizes of the coefficients.
    size: State<N>,
}

impl<const N: usize> SolutionTerms<N> {
    #[inline(always)]
    fn of_nested<const K: usize>(&mut self, c: &[State<N>; K]) {
        self.mean = c[0].add_scaled(0.5, &c[1]);
        self.bounds[0] = c[1] * 0.5;
        for (bound, (c, reach)) in self.bounds[1..].iter_mut().zip(c[2..].iter().zip(REACH)) {
            *bound = c * reach;
        }
        self.count = K - 1;
        for c in c {
            self.size = self.size.add_scaled(1.0, &c.abs());
        }
    }

    fn of_series(&mut self, c: &[State<N>]) {
        for (k, c) in c.iter().enumerate() {
            let weights = &CHEBYSHEV[k];
            self.mean = self.mean.add_scaled(weights[0], c);
            for (bound, weight) in self.bounds[..k].iter_mut().zip(&weights[1..]) {
                *bound = bound.add_scaled(*weight, c);
            }
            self.size = self.size.add_scaled(1.0, &c.abs());
        }
        self.count = c.len() - 1;
    }

    /// A box that contains the state throughout the step.
    pub(crate) fn enclosure(&self) -> [Interval; N] {
        let mut reach = self.size * TERMS_ROUNDING;
        for bound in &self.bounds[..self.count] {
            reach = reach.add_scaled(1.0, &bound.abs());
        }
        std::array::from_fn(|i| Interval::around(self.mean[i], reach[i]))
    }

    /// Bounds of `normal · x + slope (2s − 1)` throughout the step.
    pub(crate) fn range_along(&self, normal: &State<N>, slope: f64) -> Interval {
        let mut reach = TERMS_ROUNDING * normal.abs().dot(&self.size);
        let mut slope = slope;
        for bound in &self.bounds[..self.count.max(1)] {
            reach += (normal.dot(bound) + slope).abs();
            slope = 0.0;
        }
        Interval::around(normal.dot(&self.mean), reach)
    }
}

/// Powers in terms of Chebyshev polynomials on the unit interval: `s^k` is the sum of `T_j(2s − 1)`
/// times entry `j` of row `k`. All are exact.
static CHEBYSHEV: [[f64; MAX_COEFFICIENTS]; MAX_COEFFICIENTS] = {
    let mut all = [[0.0; MAX_COEFFICIENTS]; MAX_COEFFICIENTS];
    all[0][0] = 1.0;
    let mut k = 1;
    while k < MAX_COEFFICIENTS {
        // s T_j = (T_{j−1} + 2 T_j + T_{j+1})/4, and s T_0 = (T_0 + T_1)/2.
        let last = all[k - 1];
        let mut j = 0;
        while j <= k {
            let above = if j + 1 < MAX_COEFFICIENTS {
                last[j + 1]
            } else {
                0.0
            };
            let below = match j {
                0 => 0.0,
                1 => 2.0 * last[0],
                _ => last[j - 1],
            };
            all[k][j] = 0.25 * (below + 2.0 * last[j] + above);
            j += 1;
        }
        k += 1;
    }
    all
};

/// `c0 + s (c1 + r (c2 + s (c3 + …)))` with `r = 1 − s`.
#[inline(always)]
fn nested<const N: usize, const K: usize>(c: &[State<N>; K], s: f64) -> State<N> {
    let r = 1.0 - s;
    let mut x = c[K - 1];
    for k in (0..K - 1).rev() {
        let factor = if k % 2 == 0 { s } else { r };
        for i in 0..N {
            x[i] = c[k][i] + factor * x[i];
        }
    }
    x
}

/// Bounds of a polynomial in nested form while its factors, of even and of odd index, vary between
/// nonnegative bounds.
fn horner_between<const N: usize>(c: &[State<N>], factors: [[f64; 2]; 2]) -> [Interval; N] {
    let mut x = [Interval::new(0.0, 0.0); N];
    for (k, c) in c.iter().enumerate().rev() {
        let [least, most] = factors[k % 2];
        for (x, c) in x.iter_mut().zip(c.iter()) {
            let low = x.low * if x.low < 0.0 { most } else { least };
            let high = x.high * if x.high < 0.0 { least } else { most };
            *x = Interval::new(low + c, high + c);
        }
    }
    x
}

/// The maxima of `s r`, `s² r`, … `s⁴ r³`, rounded up.
const REACH: [f64; 6] = [0.25, 0.148_149, 0.0625, 0.034_561, 0.015_626, 0.008_394];

/// Bounds of [`nested`] between 0 and 1.
#[inline(always)]
fn enclosure_of_nested<const N: usize, const K: usize>(c: &[State<N>; K]) -> [Interval; N] {
    std::array::from_fn(|i| {
        let mut radius = 0.5 * c[1][i].abs();
        for (term, reach) in c[2..].iter().zip(REACH) {
            radius += reach * term[i].abs();
        }
        Interval::around(c[0][i] + 0.5 * c[1][i], radius)
    })
}

/// `Σ c_k s^k` and its slope, from the even and the odd powers separately: neither waits for the
/// other.
#[inline(always)]
pub(crate) fn power_series<V: Linear<f64>>(c: &[V], s: f64) -> (V, V) {
    let square = s * s;
    let (pairs, last) = c.as_chunks::<2>();
    let zero = V::zero();
    let (mut even, mut odd) = (last.first().copied().unwrap_or(zero), zero);
    let (mut even_slope, mut odd_slope) = (zero, zero);
    for [even_next, odd_next] in pairs.iter().rev() {
        even_slope = even.add_scaled(square, &even_slope);
        odd_slope = odd.add_scaled(square, &odd_slope);
        even = even_next.add_scaled(square, &even);
        odd = odd_next.add_scaled(square, &odd);
    }
    let in_square = even_slope.add_scaled(s, &odd_slope);
    (
        even.add_scaled(s, &odd),
        odd.add_scaled(2.0 * s, &in_square),
    )
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #![proptest_config(ProptestConfig {
            failure_persistence: None,
            ..ProptestConfig::default()
        })]
        #[test]
        fn the_enclosure_holds_the_whole_step(
            terms in prop::array::uniform8(-1.0..1.0),
            s in 0.0..=1.0,
        ) {
            let terms = terms.map(|c| State::from([c]));
            let [a, b, c, d, ..] = terms;
            for polynomial in [
                DensePolynomial::RungeKutta(terms),
                DensePolynomial::Hermite([a, b, c, d]),
            ] {
                let dense = Dense::<1> { t0: 0.0, h: 1.0, polynomial };
                let range = dense.enclosure()[0];
                let x = dense.at(s)[0];
                let (from, to) = ((s - 0.01).max(0.0), (s + 0.1).min(1.0));
                let around = dense.enclosure_between(from, to)[0];
                for range in [range, around] {
                    prop_assert!(range.low <= x + 1e-15 && x - 1e-15 <= range.high);
                }
                let (terms, narrow) = (dense.terms(), dense.enclosure_about_middle(from, to)[0]);
                for range in [terms.enclosure()[0], narrow] {
                    prop_assert!(range.low <= x && x <= range.high);
                }
                let along = terms.range_along(&State::from([-3.0]), 0.7);
                let value = -3.0 * x + 0.7 * (2.0 * s - 1.0);
                prop_assert!(along.low <= value && value <= along.high);
                // Each of eight terms adds at most its factor's width times all later terms.
                let width = 28.0 * (to - from);
                prop_assert!(around.high - around.low <= width + 1e-14);
            }
        }
    }

    /// A cosine over half a period: its coefficients add up to ten times its values.
    #[test]
    fn bounds_of_a_long_series_are_close_to_its_values() {
        let length = std::f64::consts::PI;
        let mut c = [State::from([0.0]); MAX_COEFFICIENTS];
        let mut term = 1.0;
        for (k, c) in c.iter_mut().enumerate() {
            c[0] = match k % 4 {
                0 => term,
                2 => -term,
                _ => 0.0,
            };
            term *= length / (k + 1) as f64;
        }
        let polynomial = DensePolynomial::Series(MAX_COEFFICIENTS - 1, c);
        let (t0, h) = (0.0, length);
        let dense = Dense::<1> { t0, h, polynomial };
        let [whole] = dense.terms().enclosure();
        // Twice the sum of the Bessel functions of odd order at π/2 (Jacobi and Anger).
        assert!((whole.low + 1.2763).abs() < 1e-3 && (whole.high - 1.2763).abs() < 1e-3);
        assert!(dense.enclosure()[0].high > 10.0);
        for part in 0..8 {
            let (from, to) = (f64::from(part) / 8.0, f64::from(part + 1) / 8.0);
            let [around] = dense.enclosure_about_middle(from, to);
            let ends = [from, to].map(|s| crate::math::cos(s * length));
            assert!(around.low <= ends[1] && around.high >= ends[0]);
            assert!(around.high - around.low < 2.0 * (ends[0] - ends[1]));
        }
        let line = dense.terms().range_along(&State::from([2.0]), -0.5);
        let sum = 2.0 * 1.2763 + 0.5;
        assert!((line.low + sum).abs() < 2e-3 && (line.high - sum).abs() < 2e-3);
    }
}
