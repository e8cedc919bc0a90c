//! The series of one step, in fractions of the step.

use crate::filippov::flow::Flow;
use crate::filippov::options::Options;
use crate::filippov::uncertainty::SERIES_DEFECT;
use crate::ode::{Linear, Timed, power_series};
use crate::system::State;
use crate::taylor::MAX_COEFFICIENTS;
use crate::taylor::row::{Lanes, lanes};

/// Time and state zero.
pub(super) fn origin<const N: usize>() -> Timed<N> {
    <Timed<N> as Linear<f64>>::zero()
}

/// A sum and its rounding error (Knuth).
#[inline(always)]
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let of_b = sum - a;
    (sum, (a - (sum - of_b)) + (b - of_b))
}

/// Coefficients of the powers of `s`, the fraction of the step.
pub(super) type StepPolynomial = [f64; MAX_COEFFICIENTS];

/// Room for as many powers as a series has coefficients, rounded up to a multiple of four.
pub(super) const POWERS: usize = MAX_COEFFICIENTS.next_multiple_of(4);

/// The powers of a ratio, computed four at a time to shorten the chain of dependent products.
#[inline(always)]
pub(super) fn powers<const L: usize>(ratio: Lanes<L>) -> [Lanes<L>; POWERS] {
    let by = |a: Lanes<L>, b: Lanes<L>| lanes(|l| a[l] * b[l]);
    let square = by(ratio, ratio);
    let fourth = by(square, square);
    let mut four = [[1.0; L], ratio, square, by(square, ratio)];
    let mut powers = [[0.0; L]; POWERS];
    for powers in powers.as_chunks_mut::<4>().0 {
        *powers = four;
        for power in &mut four {
            *power = by(*power, fourth);
        }
    }
    powers
}

/// The series of one step, in fractions of the step.
pub(super) struct StepSeries<const N: usize> {
    pub(super) t: f64,
    pub(super) h: f64,
    /// The end time of the run in fractions of the step, at least 1.
    pub(super) to_end: f64,
    pub(super) order: usize,
    pub(super) x: [State<N>; MAX_COEFFICIENTS],
    pub(super) remainder: Timed<N>,
}

impl<const N: usize> StepSeries<N> {
    /// Time and state at `s`, and their rounding remainders. Rarely called, and compiled once for
    /// all fields.
    #[inline(never)]
    pub(super) fn at(&self, s: f64) -> (Timed<N>, Timed<N>) {
        let (rise, _) = power_series(&self.x[1..=self.order], s);
        self.moved(s, &rise)
    }

    /// Time and state at `s`, and their rounding remainders, from `rise`: the sum of the series
    /// without its first coefficient, divided by `s`.
    #[inline(always)]
    pub(super) fn moved(&self, s: f64, rise: &State<N>) -> (Timed<N>, Timed<N>) {
        let (mut at, mut remainder) = (origin(), origin());
        (at.t, remainder.t) = two_sum(self.t, self.remainder.t + s * self.h);
        for i in 0..N {
            (at.x[i], remainder.x[i]) = two_sum(self.x[0][i], self.remainder.x[i] + s * rise[i]);
        }
        (at, remainder)
    }

    /// Slope of the series at `s`.
    #[inline(never)]
    pub(super) fn slope(&self, s: f64) -> State<N> {
        power_series(&self.x[..=self.order], s).1
    }

    /// Whether the series solves the equation at `at`: its slope there must agree with the field.
    /// It does not outside the field's domain, or where the field takes another branch than the
    /// series.
    #[inline(always)]
    pub(super) fn solves_equation<F: Flow<N>>(
        &self,
        flow: &F,
        slope: &State<N>,
        at: &Timed<N>,
        options: &Options,
    ) -> bool {
        let field = flow.velocity(at.t, &at.x);
        (0..N).all(|i| {
            let rise = self.h * field[i];
            let size = f64::max(at.x[i].abs(), rise.abs());
            let allowed = SERIES_DEFECT * options.allowed(i, size);
            at.x[i].is_finite() && (rise - slope[i]).abs() <= allowed
        })
    }
}

#[cfg(test)]
mod tests {
    use super::two_sum;

    #[test]
    fn what_rounding_takes_from_a_sum_is_kept() {
        let tiny = f64::EPSILON * f64::EPSILON;
        for (a, b) in [(1.0, tiny), (tiny, 1.0), (-3.0, tiny), (1.0, -tiny)] {
            let (large, small) = if f64::abs(a) > f64::abs(b) {
                (a, b)
            } else {
                (b, a)
            };
            assert_eq!(two_sum(a, b), (large, small));
        }
        // 0.1 + 0.2 is 2^-55 below what it is rounded to.
        assert_eq!(two_sum(0.1, 0.2), (0.1 + 0.2, -f64::EPSILON / 8.0));
    }
}
