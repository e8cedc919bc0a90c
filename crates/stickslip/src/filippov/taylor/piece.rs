//! One step's series, in parts of the step.

use crate::filippov::flow::Flow;
use crate::filippov::options::Options;
use crate::ode::{Linear, Timed, power_series};
use crate::system::State;
use crate::taylor::MOST_ORDER;
use crate::taylor::row::{Lanes, lanes};

/// Tolerances by which the slope of a series, times the step, may be off the field.
const DEFECT: f64 = 30.0;

pub(super) fn nowhere<const N: usize>() -> Timed<N> {
    <Timed<N> as Linear<f64>>::zero()
}

/// Sum and rounding error (Knuth).
#[inline(always)]
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let of_b = sum - a;
    (sum, (a - (sum - of_b)) + (b - of_b))
}

/// Coefficients of the powers of the part of a step.
pub(super) type Polynomial = [f64; MOST_ORDER + 1];

/// Room for as many powers as a series has coefficients, four at a time.
pub(super) const POWERS: usize = (MOST_ORDER + 1).next_multiple_of(4);

/// The powers of a ratio, four at a time: none waits for many others.
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

/// One step's series, in parts of the step.
pub(super) struct Piece<const N: usize> {
    pub(super) t: f64,
    pub(super) h: f64,
    /// The part of the step at which the run's end time is, 1 or more.
    pub(super) to_end: f64,
    pub(super) order: usize,
    pub(super) x: [State<N>; MOST_ORDER + 1],
    pub(super) rest: Timed<N>,
}

impl<const N: usize> Piece<N> {
    /// Time and state at the part `s` of the step, and what rounding takes from them. Rarely asked
    /// for, and compiled once for all fields.
    #[inline(never)]
    pub(super) fn at(&self, s: f64) -> (Timed<N>, Timed<N>) {
        let (rise, _) = power_series(&self.x[1..=self.order], s);
        self.moved(s, &rise)
    }

    /// The same from what the series above the first coefficient, over `s`, come to there.
    #[inline(always)]
    pub(super) fn moved(&self, s: f64, rise: &State<N>) -> (Timed<N>, Timed<N>) {
        let (mut at, mut rest) = (nowhere(), nowhere());
        (at.t, rest.t) = two_sum(self.t, self.rest.t + s * self.h);
        for i in 0..N {
            (at.x[i], rest.x[i]) = two_sum(self.x[0][i], self.rest.x[i] + s * rise[i]);
        }
        (at, rest)
    }

    /// The slope of the series at the part `s` of the step.
    #[inline(never)]
    pub(super) fn slope(&self, s: f64) -> State<N> {
        power_series(&self.x[..=self.order], s).1
    }

    /// Whether the series still solves the equation where it leads to `at` with this slope, the
    /// field there. It does not beyond where the field is defined, or where it branches otherwise
    /// than the series.
    #[inline(always)]
    pub(super) fn agrees<F: Flow<N>>(
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
            // The slope's own error is the order times the error of the step.
            let allowed = DEFECT * (options.atol + options.rtol * size);
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
