//! Whether a table repeats itself.

use super::Table;

/// Values are the same again where they differ by no more than this part of their column's range: the rounding of a function of the time.
const REPEAT: f64 = 1e-9;
/// Rows that are looked at before all of them are.
const PROBES: usize = 16;

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
        let agree = |row: usize, period: usize| {
            let pairs = state(row).iter().zip(state(row + period));
            pairs
                .zip(&allowed)
                .all(|((a, b), allowed)| (a - b).abs() <= *allowed)
        };
        (1..=rows / 2).find(|&period| {
            let last = rows - period;
            // A series at rest for a while agrees there with itself at many periods.
            let mut probes = (0..last).step_by(last.div_ceil(PROBES));
            probes.all(|row| agree(row, period)) && (0..last).all(|row| agree(row, period))
        })
    }
}
