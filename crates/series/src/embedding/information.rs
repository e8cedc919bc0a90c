//! Average mutual information of a series and its delayed copy: Fraser and Swinney, Phys. Rev. A
//! 33, 1134 (1986).

use rayon::prelude::*;

use crate::series::Series;
use numerics::order;

/// Largest number of pairs counted: 32 per cell at the largest number of classes.
const MOST_PAIRS: usize = 1 << 15;
/// Fewest pairs per cell on average. Their relative scatter is then a third.
const PAIRS_PER_CELL: usize = 8;
/// Smallest and largest number of classes. With 32 a correlated Gaussian loses 2 % of its
/// information.
const CLASS_COUNTS: (usize, usize) = (4, 32);

/// A series sorted into classes, ready to be compared with itself at any lag.
pub(crate) struct Classes {
    /// Class of every point, for each column.
    columns: Vec<Vec<u8>>,
    /// Number of classes.
    count: usize,
}

impl Classes {
    /// Sorts into classes with equally many points each, except that equal values share a class.
    pub(crate) fn new(series: &Series) -> Self {
        let rows = series.len();
        let pairs = rows.min(MOST_PAIRS);
        let mut count = CLASS_COUNTS.0;
        while count < CLASS_COUNTS.1 && (count + 1) * (count + 1) * PAIRS_PER_CELL <= pairs {
            count += 1;
        }
        let columns = (0..series.columns())
            .into_par_iter()
            .map(|column| {
                let values: Vec<f64> = series.column(column).collect();
                let order = order(&values);
                let mut classes = vec![0; rows];
                let mut first_equal = 0;
                for (rank, &row) in order.iter().enumerate() {
                    if values[row] != values[order[first_equal]] {
                        first_equal = rank;
                    }
                    // At most 31.
                    classes[row] = (first_equal * count / rows) as u8;
                }
                classes
            })
            .collect();
        Classes { columns, count }
    }

    /// The mutual information at a lag, in nats, averaged over the columns. The mean of
    /// independent values with as many pairs, `(classes − 1)²/2 pairs` (Miller 1955), is
    /// subtracted.
    pub(crate) fn information(&self, lag: usize) -> f64 {
        let sum: f64 = self
            .columns
            .iter()
            .map(|classes| self.of_column(classes, lag))
            .sum();
        sum / self.columns.len() as f64
    }

    /// Three standard deviations of the information of independent values at a lag. Twice that
    /// information times the number of pairs is distributed as χ² with `(classes − 1)²` degrees of
    /// freedom.
    pub(crate) fn independent_level(&self, lag: usize) -> f64 {
        let pairs = self.pairs(lag) as f64;
        3.0 * std::f64::consts::SQRT_2 * (self.count - 1) as f64 / (2.0 * pairs)
    }

    fn pairs(&self, lag: usize) -> usize {
        let rows = self.columns.first().map_or(0, Vec::len);
        let all = rows.saturating_sub(lag);
        all.div_ceil(all.div_ceil(MOST_PAIRS).max(1)).max(1)
    }

    fn of_column(&self, classes: &[u8], lag: usize) -> f64 {
        let later = classes.get(lag..).unwrap_or_default();
        let every = later.len().div_ceil(MOST_PAIRS).max(1);
        let mut cells = vec![0_u32; self.count * self.count];
        let mut pairs = 0.0;
        for (&a, &b) in classes.iter().zip(later).step_by(every) {
            cells[usize::from(a) * self.count + usize::from(b)] += 1;
            pairs += 1.0;
        }
        let mut first = vec![0.0; self.count];
        let mut second = vec![0.0; self.count];
        for (i, &cell) in cells.iter().enumerate() {
            first[i / self.count] += f64::from(cell);
            second[i % self.count] += f64::from(cell);
        }
        let mut sum = 0.0;
        for (i, &cell) in cells.iter().enumerate() {
            if cell > 0 {
                let cell = f64::from(cell);
                let independent = first[i / self.count] * second[i % self.count];
                sum += cell * libm::log(cell * pairs / independent);
            }
        }
        let occupied = |sums: &[f64]| sums.iter().filter(|&&sum| sum > 0.0).count().max(1) - 1;
        let freedom = (occupied(&first) * occupied(&second)) as f64;
        sum / pairs - freedom / (2.0 * pairs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use numerics::SplitMix;

    /// A Gaussian autoregression `x' = φ x + noise` has the information −½ ln(1 − φ^{2 lag}).
    /// Classes lose some of it: 32 of them 2 % at 0.8 nats.
    #[test]
    fn a_gaussian_autoregression_has_the_information_of_its_correlation() {
        let mut random = SplitMix::new(7);
        let mut normal = || {
            let angle = std::f64::consts::TAU * random.uniform();
            (-2.0 * libm::log(1.0 - random.uniform())).sqrt() * libm::cos(angle)
        };
        let phi: f64 = 0.9;
        let mut x = 0.0;
        let rows: Vec<[f64; 1]> = (0..MOST_PAIRS)
            .map(|_| {
                x = phi * x + normal();
                [x]
            })
            .collect();
        let classes = Classes::new(&Series::from_rows(rows, 1.0).unwrap());
        assert_eq!(classes.count, 32);
        for lag in [1, 2, 5] {
            let known = -0.5 * libm::log(1.0 - libm::pow(phi, 2.0 * lag as f64));
            let found = classes.information(lag);
            assert!((found / known - 1.0).abs() < 0.06, "{lag}: {found} {known}");
        }
        let far = classes.information(400);
        assert!(far.abs() < classes.independent_level(400), "{far}");
    }

    /// Equal values form one class, however many there are: a column of two values has at most ln
    /// 2.
    #[test]
    fn equal_values_share_a_class() {
        let rows = (0..4000).map(|i| [f64::from(i / 2 % 2)]);
        let classes = Classes::new(&Series::from_rows(rows, 1.0).unwrap());
        let period = classes.information(4);
        assert!((period - std::f64::consts::LN_2).abs() < 1e-3, "{period}");
        assert!(classes.information(1).abs() < 1e-3);
    }
}
