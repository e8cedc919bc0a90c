//! Whether a table repeats itself.

use super::Table;

/// Values are the same again where they differ by no more than this part of their column's range: the rounding of a function of the time.
const REPEAT: f64 = 1e-9;

impl Table {
    /// The smallest number of rows after which all of them come again, twice at least.
    pub fn period(&self) -> Option<usize> {
        let columns = self.names.len();
        let rows = self.values.len() / columns.max(1);
        let allowed: Vec<f64> = (0..columns)
            .map(|column| {
                let range = |(low, high): (f64, f64), v: f64| (low.min(v), high.max(v));
                let (low, high) = self
                    .column(column)
                    .fold((f64::INFINITY, f64::NEG_INFINITY), range);
                REPEAT * (high - low)
            })
            .collect();
        let state = |row: usize| &self.values[row * columns..][..columns];
        let agree = |row: usize, other: usize| {
            let pairs = state(row).iter().zip(state(other));
            pairs
                .zip(&allowed)
                .all(|((a, b), allowed)| (a - b).abs() <= *allowed)
        };
        // The longest end that is a beginning, too, of all rows up to each one (Knuth, Morris and Pratt, SIAM J. Comput. 6, 323, 1977).
        let mut borders = vec![0; rows];
        for row in 1..rows {
            let mut border = borders[row - 1];
            while border > 0 && !agree(border, row) {
                border = borders[border - 1];
            }
            borders[row] = border + usize::from(agree(border, row));
        }
        let period = rows - borders.last()?;
        (2 * period <= rows).then_some(period)
    }
}
