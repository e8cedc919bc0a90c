//! Sums of a step's series at the end of the step.

use super::step_series::powers;
use crate::ode::Linear;
use crate::system::State;
use crate::taylor::row::{CoefficientRow, Lanes, lanes};
use crate::taylor::series::Expansion;

/// State increment, slope and guards at the end of a step, as sums of series coefficients.
#[derive(Clone, Copy)]
pub(in crate::filippov) struct TaylorStepEnd<const N: usize, const G: usize> {
    /// Increment of the state over the step.
    pub(super) rise: State<N>,
    /// Slope at the end, per step length.
    pub(super) slope: State<N>,
    /// Values of the guards by their series; only guards with a series have an entry that counts.
    pub(super) guards: [f64; G],
}

/// [`TaylorStepEnd`] for several steps, one per lane.
pub(in crate::filippov) struct Ends<const L: usize, const N: usize, const G: usize> {
    rise: [Lanes<L>; N],
    slope: [Lanes<L>; N],
    guards: [Lanes<L>; G],
    are_clear: [bool; L],
}

impl<const L: usize, const N: usize, const G: usize> Ends<L, N, G> {
    /// Computes the ends of all lanes. `ratios` are the step lengths over the lengths that the
    /// series are scaled with.
    #[inline(always)]
    pub(in crate::filippov) fn of(
        rows: &[CoefficientRow<L>],
        expansion: &Expansion<G>,
        order: usize,
        ratios: Lanes<L>,
    ) -> Self {
        let powers = powers(ratios);
        let term = |row: &CoefficientRow<L>, k: usize| {
            let c = row.at(k);
            lanes(|l| c[l] * powers[k][l])
        };
        let mut ends = Ends {
            rise: [[0.0; L]; N],
            slope: [[0.0; L]; N],
            guards: [[0.0; L]; G],
            are_clear: [true; L],
        };
        for (i, row) in rows.iter().enumerate().take(N) {
            // For an odd order, the coefficient of the next power is zero.
            let pairs =
                (0..order.div_ceil(2)).map(|j| [term(row, 2 * j + 1), term(row, 2 * j + 2)]);
            (ends.rise[i], ends.slope[i]) = sums(pairs);
            for l in 0..L {
                ends.are_clear[l] &= ends.rise[i][l].is_finite();
            }
        }
        // Marks the lanes in which the terms exclude a zero of the series. Returns the sum of the
        // terms.
        let are_clear = &mut ends.are_clear;
        let mut clear = |row: &CoefficientRow<L>| {
            let mut least = row.at(0);
            let (mut sum, mut last) = (least, [0.0; L]);
            for k in 1..=order {
                last = term(row, k);
                least = lanes(|l| least[l] + if last[l] < 0.0 { last[l] } else { 0.0 });
                sum = lanes(|l| sum[l] + last[l]);
            }
            for l in 0..L {
                are_clear[l] &= least[l] > 0.0 && last[l].is_finite();
            }
            sum
        };
        for (guard, watched) in ends.guards.iter_mut().zip(&expansion.watched) {
            if let Some(function) = watched {
                *guard = clear(&rows[function.row]);
            }
        }
        for row in expansion.choices_among(rows) {
            clear(row);
        }
        ends
    }

    /// The end for one lane, or `None` unless the terms exclude a zero of every guard and every
    /// comparison in the step.
    #[inline(always)]
    pub(in crate::filippov) fn clear(&self, lane: usize) -> Option<TaylorStepEnd<N, G>> {
        self.are_clear[lane].then(|| TaylorStepEnd {
            rise: State::from(self.rise.map(|rise| rise[lane])),
            slope: State::from(self.slope.map(|slope| slope[lane])),
            guards: self.guards.map(|guard| guard[lane]),
        })
    }
}

/// Two sums over the terms from the first power on: of the terms, and of the terms times their
/// power. The terms come in pairs of an odd power and the next even one.
#[inline(always)]
pub(super) fn sums<V: Linear<f64>>(pairs: impl DoubleEndedIterator<Item = [V; 2]>) -> (V, V) {
    // Odd and even powers are summed separately, so that neither sum waits for the other, from the
    // highest power down. The sum of the partial sums is half the sum of the terms times their
    // power.
    let add = |a: V, b: V| a.add_scaled(1.0, &b);
    let [mut odd, mut even, mut odd_sums, mut even_sums] = [V::zero(); 4];
    for [odd_term, even_term] in pairs.rev() {
        odd_sums = add(odd_sums, odd);
        (odd, even) = (add(odd_term, odd), add(even_term, even));
        even_sums = add(even_sums, even);
    }
    let sums = add(odd_sums, even_sums);
    (add(odd, even), odd.add_scaled(2.0, &sums))
}
