//! One series: what the estimators say of it, held against the truth.

use stickslip::analysis::data_spectrum::{
    DataError, DataExponent, DataSettings, Series, Status, data_spectrum,
};

use super::systems::Case;

/// An exponent by both estimators.
pub struct Row {
    /// Name of the system.
    pub system: &'static str,
    /// Points of the series.
    pub points: usize,
    /// Seed of its start.
    pub seed: u64,
    /// Number of the exponent, from 1.
    pub index: usize,
    /// The system's exponent; not a number where the series has more columns than the system states.
    pub known: f64,
    /// By the default settings.
    pub found: Verdict,
    /// By Sano and Sawada's estimator.
    pub sano_sawada: Verdict,
}

/// What an estimator says of an exponent.
pub struct Verdict {
    /// Exponent.
    pub value: f64,
    /// Its error.
    pub stderr: f64,
    /// What is to be made of it.
    pub status: Status,
}

impl Verdict {
    fn new(exponent: &DataExponent) -> Self {
        Self {
            value: exponent.value,
            stderr: exponent.stderr,
            status: exponent.status,
        }
    }

    /// Whether the truth is within two errors; it is not where there is no truth.
    pub fn holds(&self, known: f64) -> bool {
        (self.value - known).abs() <= 2.0 * self.stderr
    }
}

/// Both estimators on a series.
///
/// # Errors
/// Those of [`data_spectrum`].
pub fn trial(case: &Case, points: usize, seed: u64) -> Result<Vec<Row>, DataError> {
    let series = Series::new((case.series)(seed, points), case.columns, case.dt)?;
    let found = data_spectrum(&series, &DataSettings::default())?;
    let linear = data_spectrum(&series, &DataSettings::sano_sawada())?;
    let pairs = found.exponents.iter().zip(&linear.exponents);
    Ok(pairs
        .enumerate()
        .map(|(i, (found, linear))| Row {
            system: case.name,
            points,
            seed,
            index: i + 1,
            known: case.known.get(i).copied().unwrap_or(f64::NAN),
            found: Verdict::new(found),
            sano_sawada: Verdict::new(linear),
        })
        .collect())
}
