//! One series: the results of the estimators, compared with the true exponents.

use std::f64::consts::PI;

use stickslip_series::{
    DataError, DataExponent, DataSettings, Embedding, EmbeddingSettings, Origin, Series, Status,
    data_spectrum, needed_embedding, reversal, unwatched,
};

use numerics::SplitMix;
use stickslip::math;

use super::systems::Case;

/// Standard deviation of the noise, as a fraction of that of the column.
pub const NOISE: f64 = 0.001;

/// Observed components of the states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Observed {
    /// All of them.
    States,
    /// All of them, with noise of [`NOISE`].
    Noisy,
    /// One component of the states, a different one from seed to seed.
    Column,
}

impl Observed {
    /// All variants.
    pub const ALL: [Observed; 3] = [Observed::States, Observed::Noisy, Observed::Column];

    /// A word for tables.
    pub fn word(self) -> &'static str {
        match self {
            Observed::States => "states",
            Observed::Noisy => "noisy states",
            Observed::Column => "one column",
        }
    }
}

/// One exponent from both estimators.
pub struct Row {
    /// Name of the system.
    pub system: &'static str,
    /// Observed components.
    pub observed: Observed,
    /// Points of the series.
    pub points: usize,
    /// Seed of its start.
    pub seed: u64,
    /// Number of the exponent, from 1.
    pub index: usize,
    /// The system's exponent; not a number where the series has more than the system.
    pub known: f64,
    /// Verdict with the default settings; `None` where there are fewer exponents.
    pub found: Option<Verdict>,
    /// Verdict with Sano and Sawada's estimator.
    pub sano_sawada: Option<Verdict>,
}

/// The result of one estimator for one exponent.
pub struct Verdict {
    /// Exponent.
    pub value: f64,
    /// Standard error.
    pub stderr: f64,
    /// Status.
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

    /// Whether the true value is within two standard errors; false where there is no true value.
    pub fn holds(&self, known: f64) -> bool {
        (self.value - known).abs() <= 2.0 * self.stderr
    }
}

/// Runs both estimators on a series.
///
/// # Errors
/// Those of the series, its embedding and [`data_spectrum`].
pub fn trial(
    case: &Case,
    observed: Observed,
    points: usize,
    seed: u64,
) -> Result<Vec<Row>, DataError> {
    let values = (case.series)(seed, points);
    let (values, columns) = match observed {
        Observed::States => (values, case.columns),
        Observed::Noisy => (noisy(values, case.columns, seed), case.columns),
        Observed::Column => {
            let column = seed as usize % case.alone;
            let alone = values.into_iter().skip(column).step_by(case.columns);
            (alone.collect(), 1)
        }
    };
    let series = Series::new(values, columns, case.dt)?;
    let needed = needed_embedding(&series, &EmbeddingSettings::default(), &unwatched)?;
    let embedding = needed.map(|choice| choice.embedding);
    let [found, sano_sawada] = settings().map(|settings| verdicts(&series, embedding, settings));
    let (mut found, mut sano_sawada) = (found?.into_iter(), sano_sawada?.into_iter());
    let exponents = found.len().max(sano_sawada.len()).max(case.known.len());
    Ok((0..exponents)
        .map(|i| Row {
            system: case.name,
            observed,
            points,
            seed,
            index: i + 1,
            known: case.known.get(i).copied().unwrap_or(f64::NAN),
            found: found.next(),
            sano_sawada: sano_sawada.next(),
        })
        .collect())
}

/// Adds independent normal noise to each value, as from a sensor. Its standard deviation is
/// [`NOISE`] times that of the column.
fn noisy(mut values: Vec<f64>, columns: usize, seed: u64) -> Vec<f64> {
    let mut random = SplitMix::new(seed);
    for column in 0..columns {
        let of = || values.iter().skip(column).step_by(columns);
        let count = of().count() as f64;
        let mean = of().sum::<f64>() / count;
        let variance = of().map(|v| (v - mean) * (v - mean)).sum::<f64>() / count;
        let size = NOISE * variance.sqrt();
        for value in values.iter_mut().skip(column).step_by(columns) {
            // Box and Muller, 1958; the logarithm's argument is not zero.
            let radius = (-2.0 * math::ln(1.0 - random.uniform())).sqrt();
            *value += size * radius * math::cos(2.0 * PI * random.uniform());
        }
    }
    values
}

fn settings() -> [DataSettings; 2] {
    [DataSettings::default(), DataSettings::sano_sawada()]
}

/// The exponents that `stickslip spectrum` prints, without those identified as the embedding's own.
fn verdicts(
    series: &Series,
    embedding: Option<Embedding>,
    settings: DataSettings,
) -> Result<Vec<Verdict>, DataError> {
    let Some(embedding) = embedding else {
        let spectrum = data_spectrum(series, &settings)?;
        return Ok(spectrum.exponents.iter().map(Verdict::new).collect());
    };
    let vectors = embedding.of(series)?;
    let spectrum = data_spectrum(&vectors, &settings.delayed(embedding.delay, &vectors))?;
    let origins = reversal(&vectors, &spectrum, &unwatched)?.origins;
    let exponents = spectrum.exponents.iter().zip(origins);
    Ok(exponents
        .filter(|(_, origin)| *origin != Origin::Spurious)
        .map(|(exponent, _)| Verdict::new(exponent))
        .collect())
}
