//! The series a spectrum is estimated from.

use super::error::{DataError, readable};

/// Largest number of columns: the storage of a point has this many places.
pub const MAX_COLUMNS: usize = 10;
/// Shortest time between two rows; one over it is the longest. A logarithm of a double, below 750,
/// stays a number over either.
const SHORTEST_INTERVAL: f64 = 1e-100;

/// Points of a state space at equal intervals of time.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    values: Vec<f64>,
    columns: usize,
    dt: f64,
}

impl Series {
    /// A series from its values, row after row, and the time `dt` between two rows (1 for a map).
    ///
    /// # Errors
    /// [`DataError::Columns`], [`DataError::Incomplete`], [`DataError::NotFinite`] and, for a `dt`
    /// that is not positive, [`DataError::Setting`].
    pub fn new(values: Vec<f64>, columns: usize, dt: f64) -> Result<Self, DataError> {
        if !(1..=MAX_COLUMNS).contains(&columns) {
            return Err(DataError::Columns {
                columns,
                max: MAX_COLUMNS,
            });
        }
        if !(SHORTEST_INTERVAL..=1.0 / SHORTEST_INTERVAL).contains(&dt) {
            let (low, high) = (
                readable(SHORTEST_INTERVAL),
                readable(1.0 / SHORTEST_INTERVAL),
            );
            return Err(DataError::Setting {
                name: "dt",
                value: dt,
                bound: format!(
                    "{low} to {high}, so that exponents, which are over it, are numbers"
                ),
            });
        }
        if !values.len().is_multiple_of(columns) {
            return Err(DataError::Incomplete {
                values: values.len(),
                columns,
            });
        }
        if let Some(at) = values.iter().position(|v| !v.is_finite()) {
            return Err(DataError::NotFinite {
                row: at / columns + 1,
                column: at % columns + 1,
                value: values[at],
            });
        }
        Ok(Self {
            values,
            columns,
            dt,
        })
    }

    /// A series from states.
    ///
    /// # Errors
    /// As [`Series::new`].
    pub fn from_rows<const N: usize>(
        rows: impl IntoIterator<Item = [f64; N]>,
        dt: f64,
    ) -> Result<Self, DataError> {
        Self::new(rows.into_iter().flatten().collect(), N, dt)
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.values.len() / self.columns
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Number of columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Time between two points.
    pub fn dt(&self) -> f64 {
        self.dt
    }

    /// The values of a column.
    pub(crate) fn column(&self, column: usize) -> impl Iterator<Item = f64> + Clone + '_ {
        let values = self.values.iter().copied().skip(column);
        values.step_by(self.columns)
    }

    /// The values, row after row.
    pub fn values(&self) -> &[f64] {
        &self.values
    }
}
