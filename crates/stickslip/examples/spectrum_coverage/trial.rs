//! One series: what the estimators say of it, held against the truth.

use stickslip::analysis::data_spectrum::{
    DataError, DataExponent, DataSettings, Embedding, EmbeddingSettings, Origin, Series, Status,
    choose_embedding, data_spectrum, reversal,
};

use super::systems::Case;

/// What a series holds of the states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Observed {
    /// All of them.
    States,
    /// Their first value, which is embedded as the program `spectrum` embeds a column.
    Column,
}

impl Observed {
    /// Both.
    pub const ALL: [Observed; 2] = [Observed::States, Observed::Column];

    /// A word for tables.
    pub fn word(self) -> &'static str {
        match self {
            Observed::States => "states",
            Observed::Column => "first column",
        }
    }
}

/// An exponent by both estimators.
pub struct Row {
    /// Name of the system.
    pub system: &'static str,
    /// What of it was seen.
    pub observed: Observed,
    /// Points of the series.
    pub points: usize,
    /// Seed of its start.
    pub seed: u64,
    /// Number of the exponent, from 1.
    pub index: usize,
    /// The system's exponent; not a number where the series has more than the system.
    pub known: f64,
    /// By the default settings; none where there are fewer.
    pub found: Option<Verdict>,
    /// By Sano and Sawada's estimator.
    pub sano_sawada: Option<Verdict>,
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
/// Those of the series, its embedding and [`data_spectrum`].
pub fn trial(
    case: &Case,
    observed: Observed,
    points: usize,
    seed: u64,
) -> Result<Vec<Row>, DataError> {
    let values = (case.series)(seed, points);
    let [found, sano_sawada] = match observed {
        Observed::States => {
            let series = Series::new(values, case.columns, case.dt)?;
            settings().map(|settings| of_states(&series, &settings))
        }
        Observed::Column => {
            let column = values.into_iter().step_by(case.columns).collect();
            let column = Series::new(column, 1, case.dt)?;
            let chosen = choose_embedding(&column, &EmbeddingSettings::default(), &|_, _| ())?;
            settings().map(|settings| of_column(&column, chosen.embedding, settings))
        }
    };
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

fn settings() -> [DataSettings; 2] {
    [DataSettings::default(), DataSettings::sano_sawada()]
}

fn of_states(series: &Series, settings: &DataSettings) -> Result<Vec<Verdict>, DataError> {
    let spectrum = data_spectrum(series, settings)?;
    Ok(spectrum.exponents.iter().map(Verdict::new).collect())
}

/// Those that are not told to be the embedding's own.
fn of_column(
    column: &Series,
    embedding: Embedding,
    settings: DataSettings,
) -> Result<Vec<Verdict>, DataError> {
    if embedding.dimension == 1 {
        return of_states(column, &settings);
    }
    let vectors = embedding.of(column)?;
    let spectrum = data_spectrum(&vectors, &settings.delayed(embedding.delay, &vectors))?;
    let origins = reversal(&vectors, &spectrum, &|_, _| ())?.origins;
    let told = spectrum.exponents.iter().zip(origins);
    Ok(told
        .filter(|(_, origin)| *origin != Origin::Spurious)
        .map(|(exponent, _)| Verdict::new(exponent))
        .collect())
}
