//! The estimator.

use rayon::prelude::*;

use super::averages::{Average, average};
use super::chain::{Stretch, advance};
use super::cloud::Cloud;
use super::directions::{self, Kind};
use super::error::DataError;
use super::fit::{LocalMap, Rule, Scratch};
use super::neighbours::{Finder, Neighbour};
use super::result::{Counts, DataExponent, DataSpectrum, Running, Status};
use super::series::Series;
use super::settings::DataSettings;
use super::svd::Square;

/// Part of the reference points that may fail to determine a direction that counts as determined.
const UNDETERMINED: f64 = 0.01;
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
/// assert!((spectrum.exponents[0].value - 2f64.ln()).abs() < 0.02);
/// # Ok::<(), stickslip::analysis::data_spectrum::DataError>(())
/// ```
///
/// # Errors
/// [`DataError::Setting`] for a setting that is not allowed, [`DataError::TooFew`], [`DataError::TooMany`],
/// [`DataError::Constant`].
pub fn data_spectrum(series: &Series, settings: &DataSettings) -> Result<DataSpectrum, DataError> {
    data_spectrum_with(series, settings, &|_, _| ())
}

/// As [`data_spectrum`], calling `progress(done, total)` in between, with numbers of reference points.
///
/// # Errors
/// As [`data_spectrum`].
pub fn data_spectrum_with(
    series: &Series,
    settings: &DataSettings,
    progress: &dyn Fn(usize, usize),
) -> Result<DataSpectrum, DataError> {
    settings.check(series.columns())?;
    macro_rules! of_size {
        ($($n:literal)*) => {
            match series.columns() {
                $($n => estimate::<$n>(series, settings, progress),)*
                columns => Err(DataError::Columns {
                    columns,
                    max: super::series::MAX_COLUMNS,
                }),
            }
        };
    }
    of_size!(1 2 3 4 5 6 7 8 9 10)
}

/// What is kept of a reference point.
struct Local<const N: usize> {
    full: LocalMap<N>,
    fixed: LocalMap<N>,
    neighbours: usize,
    radius: f64,
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

    let references = (series.len() - step).div_ceil(settings.stride);
    let references = settings
        .references
        .map_or(references, |r| r.min(references));
    let mut locals: Vec<Local<N>> = Vec::with_capacity(references);
    while locals.len() < references {
        progress(locals.len(), references);
        let until = (locals.len() + CHUNK).min(references);
        locals.par_extend((locals.len()..until).into_par_iter().map_init(
            || (Scratch::default(), Vec::<Neighbour>::new()),
            |(scratch, found), i| {
                let j = i * settings.stride;
                let starved = finder.select(j, &settings.neighbours, cloud.spread, found);
                let decomposed = scratch.decompose(&cloud, j, found, &rule);
                Local {
                    full: decomposed.map(N, &rule),
                    fixed: decomposed.map(fixed_rank, &rule),
                    neighbours: found.len(),
                    radius: found.last().map_or(0.0, |furthest| furthest.0.sqrt()),
                    starved,
                }
            },
        ));
    }
    progress(references, references);

    // Where a chain begins: the directions of the neighbourhood, so that undetermined ones come last.
    let begin = |i: usize| -> Square<N> {
        let (mut scratch, mut found) = (Scratch::default(), Vec::new());
        let j = i * settings.stride;
        finder.select(j, &settings.neighbours, cloud.spread, &mut found);
        *scratch.decompose(&cloud, j, &found, &rule).directions()
    };
    let chains = step / settings.stride;
    let tau = step as f64 * series.dt();
    let full: Vec<Stretch<N>> = chain(&locals, chains, N, &begin, |local| &local.full);
    let fixed: Vec<Stretch<N>> = chain(&locals, chains, fixed_rank, &begin, |local| &local.fixed);
    let (averages, running) = average(&full, tau);
    let (fixed, _) = average(&fixed, tau);

    let exponents = (0..N)
        .map(|i| {
            exponent(
                i,
                dimension,
                &averages[i],
                (i < fixed_rank).then_some(&fixed[i]),
                references,
            )
        })
        .collect();
    let time = |count: usize| (count * settings.stride) as f64 * series.dt();
    let distances: f64 = locals.iter().map(|local| local.radius).sum();
    Ok(DataSpectrum {
        exponents,
        dimension,
        fixed_rank,
        directions,
        spread: cloud.unit * cloud.spread,
        mean_eps: cloud.unit * distances / references as f64,
        neighbours: counts(&locals),
        references,
        starved: locals.iter().filter(|local| local.starved).count(),
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
    let needed = [2 * theiler.min(rows), 1, settings.step]
        .into_iter()
        .fold(neighbours, usize::saturating_add);
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

/// Puts together what is known of exponent `i`.
fn exponent(
    i: usize,
    dimension: usize,
    full: &Average,
    fixed: Option<&Average>,
    references: usize,
) -> DataExponent {
    let known = i < dimension && full.undetermined as f64 <= UNDETERMINED * references as f64;
    let status = match (known, full.collapses) {
        (false, _) => Status::Unidentified,
        (true, 0) => Status::Ok,
        (true, _) => Status::Annihilated,
    };
    let of = |average: &Average| match status {
        Status::Annihilated => (f64::NEG_INFINITY, f64::NAN),
        _ => (average.mean, average.stderr),
    };
    let (value, stderr) = of(full);
    DataExponent {
        value,
        stderr,
        status,
        fixed_rank: fixed.map(of),
        collapses: full.collapses,
        undetermined: full.undetermined,
    }
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
