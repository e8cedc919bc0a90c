//! Test whether a series differs from linear noise: Theiler, Eubank, Longtin, Galdrikian and
//! Farmer, Physica D 58, 77 (1992).
//!
//! Surrogates have the power spectrum and the values of the series, and no other order in them. An
//! exponent of noise is positive as well. But maps predict the next point of noise no better than
//! that of its surrogates. So the statistic of the test is the part of the motion that the maps do
//! not explain ([`super::DataSpectrum::residual_ratio`]). For series of low dimension a prediction
//! error is the most powerful statistic in use (Schreiber and Schmitz, Phys. Rev. E 55, 5443,
//! 1997). The series differs if its own is smaller than that of all surrogates, at the level
//! 1/(surrogates + 1). The rank of the first exponent among theirs is reported as well.

mod iaaft;

use rayon::prelude::*;

use super::embedding::Embedding;
use super::error::DataError;
use super::estimate::data_spectrum;
use super::progress::{Progress, report};
use super::series::Series;
use super::settings::DataSettings;
use iaaft::Randomiser;

/// Fewest surrogates: the level is one over one more, 5 %.
pub const FEWEST_SURROGATES: usize = 19;
/// Largest number of surrogates: more add no information, and each takes an estimate.
pub const MOST_SURROGATES: usize = 10_000;

/// The level of the test.
const LEVEL: f64 = 1.0 / (FEWEST_SURROGATES + 1) as f64;
/// Most reference points of an estimate, to bound the time.
const REFERENCES: usize = 2000;
/// Surrogates between two reports of progress. Each takes an estimate.
const SURROGATES_PER_REPORT: usize = 4;

/// Statistics that are compared. Estimates are of fewer reference points than the spectrum, and of
/// the part of the series that surrogates are made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistics {
    /// Part of the motion that the maps do not predict.
    pub residual: f64,
    /// First exponent.
    pub exponent: f64,
}

/// Result of a test against surrogates.
#[derive(Clone, Debug, PartialEq)]
pub struct SurrogateTest {
    /// Statistics of the series.
    pub series: Statistics,
    /// Statistics of the surrogates.
    pub surrogates: Vec<Statistics>,
    /// Probability to find so small a residual, or a smaller one, in linear noise: `(1 + surrogates
    /// that are not above)/(1 + surrogates)`.
    pub p: f64,
}

impl SurrogateTest {
    /// Whether the series differs from linear noise at the level of 5 %.
    pub fn is_significant(&self) -> bool {
        self.p <= LEVEL
    }
}

/// Seed of the surrogates of the program and the Python package. It is fixed so that results are
/// reproducible.
pub const SURROGATE_SEED: u64 = 19_920_901;

/// Whether a test can be made with so many surrogates.
///
/// # Errors
/// [`DataError::Setting`] for fewer than [`FEWEST_SURROGATES`] or more than [`MOST_SURROGATES`].
pub fn check_surrogates(count: usize) -> Result<(), DataError> {
    if (FEWEST_SURROGATES..=MOST_SURROGATES).contains(&count) {
        return Ok(());
    }
    Err(DataError::Setting {
        name: "surrogates",
        value: count as f64,
        bound: format!(
            "{FEWEST_SURROGATES} to {MOST_SURROGATES}: fewer give no level of 5 %, and more tell \
                no more"
        ),
    })
}

/// Compares a series with `count` surrogates, made from random numbers of `seed`. Series and
/// surrogates are embedded alike, if at all, and estimated with the same settings. `progress(done,
/// total)` is called at intervals with numbers of surrogates.
///
/// Surrogates are amplitude-adjusted: iterated phase randomisation (Schreiber and Schmitz, Phys.
/// Rev. Lett. 77, 635, 1996), of several columns with the same random phases (Prichard and Theiler,
/// Phys. Rev. Lett. 73, 951, 1994). They are made of the longest part of the series whose ends fit
/// together, as the transform takes it for periodic.
///
/// # Errors
/// Those of [`check_surrogates`] and of [`data_spectrum`].
pub fn surrogate_test(
    series: &Series,
    embedding: Option<Embedding>,
    settings: &DataSettings,
    count: usize,
    seed: u64,
    progress: Progress<'_>,
) -> Result<SurrogateTest, DataError> {
    check_surrogates(count)?;
    let settings = DataSettings {
        sensitivity: false,
        references: Some(
            settings
                .references
                .map_or(REFERENCES, |r| r.min(REFERENCES)),
        ),
        ..settings.clone()
    };
    let statistics = |series: &Series| -> Result<Statistics, DataError> {
        let embedded = embedding
            .map(|embedding| embedding.of(series))
            .transpose()?;
        let spectrum = data_spectrum(embedded.as_ref().unwrap_or(series), &settings)?;
        let first = spectrum.exponents.first();
        Ok(Statistics {
            residual: spectrum.residual_ratio,
            exponent: first.map_or(f64::NAN, |first| first.value),
        })
    };
    let randomiser = Randomiser::new(series)?;
    let own = statistics(randomiser.original())?;
    let mut surrogates = Vec::with_capacity(count);
    while surrogates.len() < count {
        report(progress, surrogates.len(), count)?;
        let until = (surrogates.len() + SURROGATES_PER_REPORT).min(count);
        let more: Vec<Statistics> = (surrogates.len()..until)
            .into_par_iter()
            .map(|i| statistics(&randomiser.surrogate(seed.wrapping_add(i as u64))?))
            .collect::<Result<_, DataError>>()?;
        surrogates.extend(more);
    }
    report(progress, count, count)?;
    // A surrogate without a residual is no evidence.
    let is_above = |one: &Statistics| one.residual > own.residual;
    Ok(SurrogateTest {
        // Without a residual the test has no result.
        p: if own.residual.is_nan() {
            1.0
        } else {
            (1 + surrogates.iter().filter(|one| !is_above(one)).count()) as f64 / (1 + count) as f64
        },
        series: own,
        surrogates,
    })
}
