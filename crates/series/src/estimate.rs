//! The estimator.

use rayon::prelude::*;

use super::averages::Average;
use super::averages::{average, volume};
use super::chain::{Stretch, advance};
use super::cloud::Cloud;
use super::directions::{self, Kind};
use super::error::DataError;
use super::evidence::Evidence;
use super::extrapolation::{Chains, Maps, Plan};
use super::fit::{LocalMap, Rule, Scratch};
use super::images::Images;
use super::neighbours::{Finder, Neighbour, Selection};
use super::polynomial::Fitter;
use super::result::{Counts, DataSpectrum, Running};
use super::series::Series;
use super::series::for_columns;
use super::settings::{DataSettings, Estimator, Neighbourhood};
use super::statistics::upper_median;
use super::svd::Square;

/// Reference points between two reports of progress. Few enough that their maps stay near the processor.
const CHUNK: usize = 512;

/// What is extrapolated comes from neighbourhoods if the smaller ones are within so many times the radius given. On starts that the table of
/// `spectrum_coverage` is not of (the seeds 1007 to 1009, up to 50000 points) the true value is within two errors of 99 % of those exponents
/// of one column that are called ok with 1, of 96 % with 1.5, 92 % with 2 and 87 % with any; of whole states it is of 98 % with each.
const LARGE: f64 = 1.5;

/// The spectrum of a series.
///
/// ```
/// use stickslip_series::{DataSettings, Series, Status, data_spectrum};
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
/// # Ok::<(), stickslip_series::DataError>(())
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
    for_columns!(series, estimate(series, settings, progress))
}

/// The spectrum of rows whose length is known to the compiler, with the bits of `data_spectrum`. Needs the feature `data-rows` only, with which no
/// code is made for other lengths. `dt` is the time between two rows, 1 for a map.
///
/// ```
/// use stickslip_series::{DataSettings, data_spectrum_of_rows};
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
/// # Ok::<(), stickslip_series::DataError>(())
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

/// Neighbours that were found, and of which point.
#[derive(Default)]
struct Found {
    neighbours: Vec<Neighbour>,
    /// None where nothing can be told from them.
    of: Option<usize>,
}

/// Looks for what the maps around a point are fitted to.
struct Search<'a, const N: usize> {
    finder: &'a Finder<'a, N>,
    settings: &'a DataSettings,
    spread: f64,
    times: usize,
    /// Neighbours of the largest neighbourhood that is extrapolated from.
    furthest: Option<usize>,
}

impl<const N: usize> Search<'_, N> {
    /// The neighbourhood of Eq. (25), among others of the nearest where these are looked for anyway.
    fn around(&self, j: usize, found: &mut Found) -> Selection {
        let neighbours = &self.settings.neighbours;
        let from = (found.of, j);
        match self.furthest {
            Some(wanted) if neighbours.most() <= wanted => {
                self.finder
                    .follow(from, wanted, f64::INFINITY, &mut found.neighbours);
                found.of = Some(j);
                Selection::of(&found.neighbours, neighbours, self.spread)
            }
            Some(_) => {
                // Other points are looked for in between.
                found.of = None;
                self.select((None, j), found)
            }
            None => {
                found.of = Some(j);
                self.select(from, found)
            }
        }
    }

    fn select(&self, from: (Option<usize>, usize), found: &mut Found) -> Selection {
        let (neighbours, times) = (&self.settings.neighbours, self.times);
        self.finder
            .select(from, neighbours, times, self.spread, &mut found.neighbours)
    }

    /// The nearest points, after [`Search::around`].
    fn furthest<'f>(&self, j: usize, found: &'f mut Found) -> &'f [Neighbour] {
        if found.of != Some(j) {
            let wanted = self.furthest.unwrap_or(0);
            self.finder
                .nearest(j, wanted, f64::INFINITY, &mut found.neighbours);
        }
        &found.neighbours
    }
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
    // Of too few points nothing else is to be said.
    let cloud = Cloud::<N>::new(series);
    let decorrelation = || cloud.as_ref().map_or(0, Cloud::decorrelation);
    let theiler = settings.theiler.unwrap_or_else(decorrelation);
    enough(series.len(), settings, theiler)?;
    let cloud = cloud?;
    let finder = Finder::new(&cloud, step, theiler)?;
    let rule = Rule::of(settings);
    let directions = directions::measure(&cloud, &finder, &rule, SMALLEST_LEVEL.max(2 * N));
    let dimension = directions
        .iter()
        .take_while(|direction| direction.kind == Kind::Tangent)
        .count();
    let fixed_rank = settings.fixed_rank.unwrap_or(dimension);

    // The other estimator has two sizes of its own.
    let sensitivity = settings.sensitivity && settings.estimator == Estimator::SanoSawada;
    let times = if sensitivity { 2 } else { 1 };
    let references = references(series.len(), settings);
    let plan = match settings.estimator {
        Estimator::Extrapolated { degree } if dimension > 0 => {
            Some(Plan::new(&cloud, settings, degree, dimension))
        }
        Estimator::Extrapolated { .. } | Estimator::SanoSawada => None,
    };
    let search = Search {
        finder: &finder,
        settings,
        spread: cloud.spread,
        times,
        furthest: plan.as_ref().map(Plan::furthest),
    };
    let chains = settings.chains();
    let images = Images::of(&cloud.points, step);
    let mut extrapolated = plan.as_ref().map(|plan| (plan, Chains::new(plan, chains)));
    let mut locals: Vec<Local<N>> = Vec::with_capacity(references);
    while locals.len() < references {
        progress(locals.len(), references);
        let from = locals.len();
        let until = (from + CHUNK).min(references);
        let maps: Vec<(Local<N>, Option<Maps<N>>)> = (from..until)
            .into_par_iter()
            .map_init(
                || (Scratch::default(), Fitter::new(images), Found::default()),
                |(scratch, fitter, found), i| {
                    let j = settings.reference(i);
                    let selection = search.around(j, found);
                    let neighbours = &found.neighbours[..selection.count];
                    let (wide, decomposed) = if sensitivity {
                        let both = [found.neighbours.as_slice(), neighbours];
                        let [wide, decomposed] = scratch.decompose_all(&cloud, j, both, &rule);
                        (Some(wide.map(N, &rule)), decomposed)
                    } else {
                        (None, scratch.decompose(&cloud, j, neighbours, &rule))
                    };
                    let full = decomposed.map(N, &rule);
                    let local = Local {
                        wide: wide.unwrap_or(full),
                        full,
                        fixed: decomposed.map(fixed_rank, &rule),
                        neighbours: selection.count,
                        radius: neighbours.last().map_or(0.0, |furthest| furthest.0.sqrt()),
                        residual_ratio: decomposed.residual_ratio(),
                        starved: selection.starved,
                    };
                    let Some(plan) = &plan else {
                        return (local, None);
                    };
                    let nearest = search.furthest(j, found);
                    let maps = plan.fit(fitter, &cloud.points, j, nearest, &full.domain);
                    // Judged by what the exponents come from.
                    let is_large = |eps: f64| maps.radius() > LARGE * eps * cloud.spread;
                    let starved = match settings.neighbours {
                        Neighbourhood::Ball { eps, .. } => {
                            is_large(eps) || nearest.len() < plan.neighbours[0]
                        }
                        Neighbourhood::Nearest(_) => local.starved,
                    };
                    (Local { starved, ..local }, Some(maps))
                },
            )
            .collect();
        for (local, maps) in maps {
            if let (Some((_, chains)), Some(maps)) = (&mut extrapolated, &maps) {
                chains.push(maps, &local.full.domain);
            }
            locals.push(local);
        }
    }

    // Where a chain begins: the directions of the neighbourhood, so that undetermined ones come last.
    let begin = |i: usize, twice: bool| -> Square<N> {
        let (mut scratch, mut found) = (Scratch::default(), Vec::new());
        let j = settings.reference(i);
        let neighbours = &settings.neighbours;
        let selection = finder.select((None, j), neighbours, times, cloud.spread, &mut found);
        if !twice {
            found.truncate(selection.count);
        }
        *scratch.decompose(&cloud, j, &found, &rule).directions()
    };
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
    let corrected = extrapolated.map(|(plan, chains)| {
        let (corrected, towards) = chains.corrected(plan, tau, cloud.unit);
        (sum, running) = (corrected.sum, towards);
        corrected
    });
    progress(references, references);

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
    let time = |count: usize| settings.reference(count) as f64 * series.dt();
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

/// What the fit of fixed rank says by itself.
pub(crate) struct FixedRank {
    /// Exponents with their standard errors.
    pub(crate) exponents: Vec<(f64, f64)>,
    /// As [`DataSpectrum::residual_ratio`].
    pub(crate) residual_ratio: f64,
}

/// The fit of fixed rank of [`data_spectrum`] alone. Stride and references may be others than those of the settings' spectrum.
///
/// # Errors
/// As [`data_spectrum`].
pub(crate) fn fixed_rank<const N: usize>(
    series: &Series,
    settings: &DataSettings,
    rank: usize,
    progress: &dyn Fn(usize, usize),
) -> Result<FixedRank, DataError> {
    settings.check(N)?;
    let cloud = Cloud::<N>::new(series)?;
    let theiler = settings.theiler.unwrap_or_else(|| cloud.decorrelation());
    enough(series.len(), settings, theiler)?;
    let finder = Finder::new(&cloud, settings.step, theiler)?;
    let rule = Rule::of(settings);
    let search = Search {
        finder: &finder,
        settings,
        spread: cloud.spread,
        times: 1,
        furthest: None,
    };
    let references = references(series.len(), settings);
    let mut maps: Vec<(LocalMap<N>, f64)> = Vec::with_capacity(references);
    while maps.len() < references {
        progress(maps.len(), references);
        let until = (maps.len() + CHUNK).min(references);
        maps.par_extend((maps.len()..until).into_par_iter().map_init(
            || (Scratch::default(), Found::default()),
            |(scratch, found), i| {
                let j = settings.reference(i);
                let selection = search.around(j, found);
                let neighbours = &found.neighbours[..selection.count];
                let decomposed = scratch.decompose(&cloud, j, neighbours, &rule);
                (decomposed.map(rank, &rule), decomposed.residual_ratio())
            },
        ));
    }
    progress(references, references);
    // The directions of a neighbourhood are those of its map.
    let begin = |i: usize| maps[i].0.domain;
    let chains = settings.chains();
    let stretches = chain(&maps, chains, rank, &begin, |(map, _)| map);
    let (averages, _) = average(&stretches, settings.step as f64 * series.dt());
    let known = averages.iter().take(rank);
    let finite = |average: &Average| {
        if average.collapses > 0 {
            (f64::NEG_INFINITY, f64::NAN)
        } else {
            (average.mean, average.stderr)
        }
    };
    Ok(FixedRank {
        exponents: known.map(finite).collect(),
        residual_ratio: upper_median(maps.iter().map(|(_, ratio)| *ratio)),
    })
}

/// Reference points of so many rows.
fn references(rows: usize, settings: &DataSettings) -> usize {
    let all = settings.references_before(rows - settings.step);
    settings.references.map_or(all, |asked| asked.min(all))
}

/// The smallest neighbourhood in which directions are measured has so many points, or twice as many as there are columns.
const SMALLEST_LEVEL: usize = 20;

/// # Errors
/// [`DataError::TooFew`] if there are fewer points than the search needs to be able to succeed.
fn enough(rows: usize, settings: &DataSettings, theiler: usize) -> Result<(), DataError> {
    let needed = settings.fewest_points(theiler);
    if rows < needed {
        return Err(DataError::TooFew {
            rows,
            needed,
            neighbours: settings.neighbours.fewest(),
            theiler,
            step: settings.step,
        });
    }
    Ok(())
}

/// Runs through the interleaved chains; the outcome is in the order of time.
fn chain<const N: usize, L>(
    locals: &[L],
    chains: usize,
    width: usize,
    begin: &dyn Fn(usize) -> Square<N>,
    map: impl Fn(&L) -> &LocalMap<N>,
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
