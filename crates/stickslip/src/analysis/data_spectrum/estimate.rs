//! The estimator.

use rayon::prelude::*;

use super::averages::{average, volume};
use super::chain::{Stretch, advance};
use super::cloud::Cloud;
use super::directions::{self, Kind, upper_median};
use super::error::DataError;
use super::evidence::Evidence;
use super::extrapolation::{self, Plan};
use super::fit::{LocalMap, Rule, Scratch};
use super::neighbours::{Finder, Neighbour};
use super::result::{Counts, DataSpectrum, Running};
use super::series::Series;
#[cfg(feature = "data")]
use super::series::for_columns;
use super::settings::{DataSettings, Estimator, FEWEST_REFERENCES};
use super::svd::Square;

/// Reference points between two reports of progress.
const CHUNK: usize = 2048;

/// The spectrum of a series.
///
/// ```
/// use stickslip::analysis::data_spectrum::{DataSettings, Series, Status, data_spectrum};
///
/// // The logistic map at 4 has the exponent ln 2.
/// let mut x = 0.3;
/// let rows = (0..4000).map(|_| {
///     x = 4.0 * x * (1.0 - x);
///     [x]
/// });
/// let spectrum = data_spectrum(&Series::from_rows(rows, 1.0)?, &DataSettings::default())?;
/// assert_eq!(spectrum.exponents[0].status, Status::Ok);
/// assert!((spectrum.exponents[0].value - std::f64::consts::LN_2).abs() < 0.02);
/// # Ok::<(), stickslip::analysis::data_spectrum::DataError>(())
/// ```
///
/// # Errors
/// [`DataError::Setting`] for a setting that is not allowed, [`DataError::TooFew`], [`DataError::TooMany`],
/// [`DataError::Constant`].
#[cfg(feature = "data")]
pub fn data_spectrum(series: &Series, settings: &DataSettings) -> Result<DataSpectrum, DataError> {
    data_spectrum_with(series, settings, &|_, _| ())
}

/// As [`data_spectrum`], calling `progress(done, total)` in between, with numbers of reference points, each counted as often as maps are
/// fitted around it.
///
/// # Errors
/// As [`data_spectrum`].
#[cfg(feature = "data")]
pub fn data_spectrum_with(
    series: &Series,
    settings: &DataSettings,
    progress: &dyn Fn(usize, usize),
) -> Result<DataSpectrum, DataError> {
    settings.check(series.columns())?;
    for_columns!(series, estimate(series, settings, progress))
}

/// The spectrum of rows whose length is known to the compiler, with the bits of `data_spectrum`. Needs the feature `data-rows` only, with which no
/// code is made for other lengths. `dt` is the time between two rows, 1 for a map.
///
/// ```
/// use stickslip::analysis::data_spectrum::{DataSettings, data_spectrum_of_rows};
///
/// let mut x = [0.1, 0.1];
/// let henon: Vec<[f64; 2]> = std::iter::repeat_with(|| {
///     x = [1.0 - 1.4 * x[0] * x[0] + x[1], 0.3 * x[0]];
///     x
/// })
/// .take(5000)
/// .collect();
/// let spectrum = data_spectrum_of_rows(&henon, 1.0, &DataSettings::default())?;
/// assert!((spectrum.exponents[0].value - 0.419).abs() < 0.02);
/// # Ok::<(), stickslip::analysis::data_spectrum::DataError>(())
/// ```
///
/// # Errors
/// [`DataError::Columns`] for more than [`super::MAX_COLUMNS`] columns; as [`Series::new`]; [`DataError::Setting`] for a setting that is not allowed, [`DataError::TooFew`], [`DataError::TooMany`],
/// [`DataError::Constant`].
pub fn data_spectrum_of_rows<const N: usize>(
    rows: &[[f64; N]],
    dt: f64,
    settings: &DataSettings,
) -> Result<DataSpectrum, DataError> {
    let series = Series::from_rows(rows.iter().copied(), dt)?;
    settings.check(N)?;
    estimate::<N>(&series, settings, &|_, _| ())
}

/// What is kept of a reference point.
struct Local<const N: usize> {
    full: LocalMap<N>,
    fixed: LocalMap<N>,
    /// From twice the neighbourhood; without the second estimate the first again.
    wide: LocalMap<N>,
    neighbours: usize,
    radius: f64,
    residual_ratio: f64,
    starved: bool,
}

fn estimate<const N: usize>(
    series: &Series,
    settings: &DataSettings,
    progress: &dyn Fn(usize, usize),
) -> Result<DataSpectrum, DataError> {
    let step = settings.step;
    // Before anything is computed from too few points.
    enough(series.len(), settings, settings.theiler.unwrap_or(0))?;
    let cloud = Cloud::<N>::new(series)?;
    let theiler = settings.theiler.unwrap_or_else(|| cloud.decorrelation());
    enough(series.len(), settings, theiler)?;
    let finder = Finder::new(&cloud, step, theiler)?;
    let rule = Rule {
        step,
        affine: settings.affine,
        rank_tolerance: settings.rank_tolerance,
        ridge: settings.ridge,
    };
    let directions = directions::measure(&cloud, &finder, &rule, SMALLEST_LEVEL.max(2 * N));
    let dimension = directions
        .iter()
        .take_while(|direction| direction.kind == Kind::Tangent)
        .count();
    let fixed_rank = settings.fixed_rank.unwrap_or(dimension);

    // The other estimator has two sizes of its own.
    let sensitivity = settings.sensitivity && settings.estimator == Estimator::SanoSawada;
    let times = if sensitivity { 2 } else { 1 };
    let references = (series.len() - step).div_ceil(settings.stride);
    let references = settings
        .references
        .map_or(references, |r| r.min(references));
    let passes = if settings.estimator == Estimator::SanoSawada {
        1
    } else {
        2
    };
    let total = passes * references;
    let mut locals: Vec<Local<N>> = Vec::with_capacity(references);
    while locals.len() < references {
        progress(locals.len(), total);
        let until = (locals.len() + CHUNK).min(references);
        locals.par_extend((locals.len()..until).into_par_iter().map_init(
            || (Scratch::default(), Vec::<Neighbour>::new()),
            |(scratch, found), i| {
                let j = i * settings.stride;
                let selection = finder.select(j, &settings.neighbours, times, cloud.spread, found);
                let neighbours = &found[..selection.count];
                let (wide, decomposed) = if sensitivity {
                    let both = [found.as_slice(), neighbours];
                    let [wide, decomposed] = scratch.decompose_all(&cloud, j, both, &rule);
                    (Some(wide.map(N, &rule)), decomposed)
                } else {
                    (None, scratch.decompose(&cloud, j, neighbours, &rule))
                };
                let full = decomposed.map(N, &rule);
                Local {
                    wide: wide.unwrap_or(full),
                    full,
                    fixed: decomposed.map(fixed_rank, &rule),
                    neighbours: selection.count,
                    radius: neighbours.last().map_or(0.0, |furthest| furthest.0.sqrt()),
                    residual_ratio: decomposed.residual_ratio(),
                    starved: selection.starved,
                }
            },
        ));
    }

    // Where a chain begins: the directions of the neighbourhood, so that undetermined ones come last.
    let begin = |i: usize, twice: bool| -> Square<N> {
        let (mut scratch, mut found) = (Scratch::default(), Vec::new());
        let j = i * settings.stride;
        let selection = finder.select(j, &settings.neighbours, times, cloud.spread, &mut found);
        if !twice {
            found.truncate(selection.count);
        }
        *scratch.decompose(&cloud, j, &found, &rule).directions()
    };
    let chains = step / settings.stride;
    let once = |i: usize| begin(i, false);
    let tau = step as f64 * series.dt();
    let full: Vec<Stretch<N>> = chain(&locals, chains, N, &once, |local| &local.full);
    let fixed: Vec<Stretch<N>> = chain(&locals, chains, fixed_rank, &once, |local| &local.fixed);
    let wide = sensitivity.then(|| {
        let twice = |i: usize| begin(i, true);
        let wide: Vec<Stretch<N>> = chain(&locals, chains, N, &twice, |local| &local.wide);
        average(&wide, tau).0
    });
    let (averages, mut running) = average(&full, tau);
    let (fixed, _) = average(&fixed, tau);
    let mut sum = volume(&full, dimension, tau);
    let corrected = match settings.estimator {
        Estimator::Extrapolated { degree } if dimension > 0 => {
            let plan = Plan::new(&cloud, settings, degree, dimension);
            let directions = |i: usize| locals[i].full.domain;
            let reference = extrapolation::References {
                count: references,
                directions: &directions,
                progress: &|done| progress(references + done, total),
            };
            let stretches = extrapolation::run(&cloud, &finder, &plan, settings, &reference);
            let (corrected, towards) = stretches.corrected(&plan, tau, cloud.unit);
            (sum, running) = (corrected.sum, towards);
            Some(corrected)
        }
        Estimator::Extrapolated { .. } | Estimator::SanoSawada => None,
    };
    progress(total, total);

    let starved = locals.iter().filter(|local| local.starved).count();
    let residual_ratio = upper_median(locals.iter().map(|local| local.residual_ratio));
    let evidence = Evidence {
        dimension,
        references,
        starved,
        residual_ratio,
        tau,
    };
    let exponents = (0..N)
        .map(|i| {
            evidence.exponent(
                i,
                &averages[i],
                (i < fixed_rank).then_some(&fixed[i]),
                wide.as_ref().map(|wide| &wide[i]),
                corrected.as_ref(),
            )
        })
        .collect();
    let time = |count: usize| (count * settings.stride) as f64 * series.dt();
    let distances: f64 = locals.iter().map(|local| local.radius).sum();
    Ok(DataSpectrum {
        exponents,
        sum: (sum.mean, sum.stderr),
        dimension,
        fixed_rank,
        directions,
        spread: cloud.unit * cloud.spread,
        // The sum alone may be too large for the unit.
        mean_eps: cloud.unit * (distances / references as f64),
        neighbours: counts(&locals),
        references,
        starved,
        residual_ratio,
        sizes: corrected.map(|corrected| corrected.sizes),
        convergence: running
            .into_iter()
            .map(|(count, means)| Running {
                t: time(count),
                exponents: means.to_vec(),
            })
            .collect(),
        settings: DataSettings {
            theiler: Some(theiler),
            fixed_rank: Some(fixed_rank),
            references: Some(references),
            ..settings.clone()
        },
    })
}

/// The smallest neighbourhood in which directions are measured has so many points, or twice as many as there are columns.
const SMALLEST_LEVEL: usize = 20;

/// # Errors
/// [`DataError::TooFew`] if there are fewer points than the search needs to be able to succeed.
fn enough(rows: usize, settings: &DataSettings, theiler: usize) -> Result<(), DataError> {
    let neighbours = settings.neighbours.fewest();
    let searched = [theiler.saturating_mul(2), 1, settings.step]
        .into_iter()
        .fold(neighbours, usize::saturating_add);
    let references = (FEWEST_REFERENCES - 1).saturating_mul(settings.stride);
    let needed = searched.max(references.saturating_add(1).saturating_add(settings.step));
    if rows < needed {
        return Err(DataError::TooFew {
            rows,
            needed,
            neighbours,
            theiler,
            step: settings.step,
        });
    }
    Ok(())
}

/// Runs through the interleaved chains; the outcome is in the order of time.
fn chain<const N: usize>(
    locals: &[Local<N>],
    chains: usize,
    width: usize,
    begin: &dyn Fn(usize) -> Square<N>,
    map: impl Fn(&Local<N>) -> &LocalMap<N>,
) -> Vec<Stretch<N>> {
    let mut bases: Vec<Square<N>> = (0..chains.min(locals.len())).map(begin).collect();
    locals
        .iter()
        .enumerate()
        .map(|(i, local)| advance(map(local), &mut bases[i % chains], width))
        .collect()
}

fn counts<const N: usize>(locals: &[Local<N>]) -> Counts {
    let mut counts: Vec<usize> = locals.iter().map(|local| local.neighbours).collect();
    counts.sort_unstable();
    Counts {
        min: counts.first().copied().unwrap_or(0),
        median: counts.get(counts.len() / 2).copied().unwrap_or(0),
        max: counts.last().copied().unwrap_or(0),
    }
}
