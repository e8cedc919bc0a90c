//! What a step's series come to at its end.

use super::piece::powers;
use crate::ode::Linear;
use crate::system::State;
use crate::taylor::row::{Lanes, Row, lanes};
use crate::taylor::series::Expansion;

/// Where a step leads, by the sums of its coefficients.
#[derive(Clone, Copy)]
pub(in crate::filippov) struct End<const N: usize> {
    /// By how much the state moves.
    pub(super) rise: State<N>,
    /// The slope there, in parts of the step.
    pub(super) slope: State<N>,
}

/// The same of several steps, one to a lane.
pub(in crate::filippov) struct Ends<const L: usize, const N: usize> {
    rise: [Lanes<L>; N],
    slope: [Lanes<L>; N],
    are_clear: [bool; L],
}

impl<const L: usize, const N: usize> Ends<L, N> {
    /// Of the steps of these lengths, over those that the series are scaled with.
    #[inline(always)]
    pub(in crate::filippov) fn of<const G: usize>(
        rows: &[Row<L>],
        expansion: &Expansion<G>,
        order: usize,
        ratios: Lanes<L>,
    ) -> Self {
        let powers = powers(ratios);
        let term = |row: &Row<L>, k: usize| {
            let c = row.at(k);
            lanes(|l| c[l] * powers[k][l])
        };
        let mut ends = Ends {
            rise: [[0.0; L]; N],
            slope: [[0.0; L]; N],
            are_clear: [!expansion.value_read; L],
        };
        for (i, row) in rows.iter().enumerate().take(N) {
            (ends.rise[i], ends.slope[i]) = sums(order, |k| term(row, k));
            for l in 0..L {
                ends.are_clear[l] &= ends.rise[i][l].is_finite();
            }
        }
        let guards = expansion.watched.iter().flatten();
        let guards = guards.map(|function| &rows[function.row]);
        for row in guards.chain(expansion.choices_among(rows)) {
            let mut least = row.at(0);
            let mut last = [0.0; L];
            for k in 1..=order {
                last = term(row, k);
                least = lanes(|l| least[l] + if last[l] < 0.0 { last[l] } else { 0.0 });
            }
            for l in 0..L {
                ends.are_clear[l] &= least[l] > 0.0 && last[l].is_finite();
            }
        }
        ends
    }

    /// That of one lane, if the step is sure to come to it: no guard and no comparison can come to zero before.
    #[inline(always)]
    pub(in crate::filippov) fn clear(&self, lane: usize) -> Option<End<N>> {
        self.are_clear[lane].then(|| End {
            rise: State::from(self.rise.map(|rise| rise[lane])),
            slope: State::from(self.slope.map(|slope| slope[lane])),
        })
    }
}

/// The sum of the terms from the first power on, and that of each times its power.
#[inline(always)]
pub(super) fn sums<V: Linear<f64>>(order: usize, term: impl Fn(usize) -> V) -> (V, V) {
    // Odd and even powers apart, neither waits for the other, and from the highest on; above an odd order there is a zero.
    let [mut odd, mut even, mut odd_slope, mut even_slope] = [V::zero(); 4];
    for k in (0..order.div_ceil(2)).rev().map(|j| 2 * j + 1) {
        let (a, b) = (term(k), term(k + 1));
        (odd, even) = (a.add_scaled(1.0, &odd), b.add_scaled(1.0, &even));
        odd_slope = odd_slope.add_scaled(k as f64, &a);
        even_slope = even_slope.add_scaled((k + 1) as f64, &b);
    }
    let sum = odd.add_scaled(1.0, &even);
    (sum, odd_slope.add_scaled(1.0, &even_slope))
}
