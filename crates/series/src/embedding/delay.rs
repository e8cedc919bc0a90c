//! Vectors of delayed values: Takens, Lecture Notes in Mathematics 898, 366 (1981); Sauer, Yorke
//! and Casdagli, J. Stat. Phys. 65, 579 (1991).

use crate::cloud::Cloud;
use crate::error::DataError;
use crate::series::{MAX_COLUMNS, Series};
use crate::settings::DataSettings;

/// A delay and a number of delayed values of each column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Embedding {
    /// Points between two values of a column.
    pub delay: usize,
    /// Values taken of each column; with 1 the series is its own embedding.
    pub dimension: usize,
}

impl Embedding {
    /// Points between the first and the last value of a vector. The embedded series is shorter by
    /// as many rows.
    pub fn span(&self) -> usize {
        self.delay.saturating_mul(self.dimension.saturating_sub(1))
    }

    /// The embedded series. Row `i` holds `x_i, x_{i+τ}, …, x_{i+(m−1)τ}` of the first column, then
    /// of the second, and so on.
    ///
    /// ```
    /// use stickslip_series::{Embedding, Series};
    ///
    /// let series = Series::new(vec![1.0, 2.0, 3.0, 4.0, 5.0], 1, 0.1)?;
    /// let embedded = Embedding { delay: 2, dimension: 2 }.of(&series)?;
    /// assert_eq!(embedded.values(), [1.0, 3.0, 2.0, 4.0, 3.0, 5.0]);
    /// # Ok::<(), stickslip_series::DataError>(())
    /// ```
    ///
    /// # Errors
    /// [`DataError::Setting`] for a delay or a dimension of 0, or a dimension that gives more than
    /// [`MAX_COLUMNS`] columns; [`DataError::Span`] if the vectors are longer than the series.
    pub fn of(&self, series: &Series) -> Result<Series, DataError> {
        self.check(series.columns())?;
        let span = self.span();
        let rows = series.len();
        if rows <= span {
            let columns = series.columns() * self.dimension;
            let one = Series::new(vec![0.0; columns], columns, series.dt())?;
            let settings = DataSettings::default().delayed(self.delay, &one);
            let window = Cloud::new(series).map_or(0, |cloud| cloud.scales().0);
            return Err(DataError::Span {
                rows,
                delay: self.delay,
                dimension: self.dimension,
                needed: span.saturating_add(settings.fewest_points(window)),
            });
        }
        let columns = series.columns();
        let values = series.values();
        let mut embedded = Vec::with_capacity((rows - span) * columns * self.dimension);
        for row in 0..rows - span {
            for column in 0..columns {
                let first = row * columns + column;
                embedded.extend(
                    (0..self.dimension).map(|lag| values[first + lag * self.delay * columns]),
                );
            }
        }
        Series::new(embedded, columns * self.dimension, series.dt())
    }

    /// # Errors
    /// [`DataError::Setting`].
    fn check(&self, columns: usize) -> Result<(), DataError> {
        if self.delay == 0 {
            return Err(DataError::Setting {
                name: "delay",
                value: 0.0,
                bound: "at least 1".into(),
            });
        }
        let most = most_dimensions(columns);
        if !(1..=most).contains(&self.dimension) {
            return Err(DataError::Setting {
                name: "dimension",
                value: self.dimension as f64,
                bound: match columns {
                    1 => format!("1 to {most}"),
                    _ => format!(
                        "1 to {most}, as {columns} columns with so many delayed values each make \
                            at most {MAX_COLUMNS}"
                    ),
                },
            });
        }
        Ok(())
    }
}

/// Largest number of delayed values of each of `columns` columns.
pub(crate) fn most_dimensions(columns: usize) -> usize {
    MAX_COLUMNS / columns.max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn several_columns_are_delayed_each_by_itself() {
        let rows = (0..5).map(|i| [f64::from(i), 10.0 * f64::from(i)]);
        let series = Series::from_rows(rows, 0.5).unwrap();
        let embedding = Embedding {
            delay: 1,
            dimension: 3,
        };
        let embedded = embedding.of(&series).unwrap();
        assert_eq!(
            (embedded.columns(), embedded.len(), embedded.dt()),
            (6, 3, 0.5)
        );
        assert_eq!(embedded.values()[6..12], [1.0, 2.0, 3.0, 10.0, 20.0, 30.0]);
        let itself = Embedding {
            delay: 7,
            dimension: 1,
        };
        assert_eq!(itself.of(&series).unwrap(), series);
    }

    #[test]
    fn what_cannot_be_embedded_is_refused_with_the_bound() {
        let series = Series::from_rows((0..9).map(|i| [f64::from(i); 3]), 1.0).unwrap();
        let refused = |delay, dimension| {
            Embedding { delay, dimension }
                .of(&series)
                .unwrap_err()
                .to_string()
        };
        assert!(refused(0, 2).contains("delay = 0"));
        assert!(refused(1, 0).contains("dimension = 0"));
        assert!(refused(1, 4).contains("1 to 3"));
        let long = refused(5, 3);
        // The vectors span 10 rows more than there are states, of which an estimate takes 44.
        assert!(
            long.contains("9 points") && long.contains("54 are needed"),
            "{long}"
        );
        assert!(refused(usize::MAX, 3).contains("9 points"));
        let last = Embedding {
            delay: 4,
            dimension: 2,
        };
        assert_eq!(last.of(&series).unwrap().len(), 5);
    }
}
