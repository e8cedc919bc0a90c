//! The estimator.

use rayon::prelude::*;

use super::averages::{average, running, volume};
use super::chain::Chains;
use super::cloud::Cloud;
use super::directions::{self, DirectionKind};
use super::error::DataError;
use super::evidence::Evidence;
use super::extrapolation::{Extrapolation, Maps, Plan};
use super::fit::{Decomposed, LocalMap};
use super::least_squares::{LeastSquares, Scratch, ShiftedColumns};
use super::matrix::Matrix;
use super::neighbours::Finder;
use super::progress::{Progress, report, unwatched};
use super::result::{Counts, DataExponent, DataSpectrum, Running};
use super::series::Series;
use super::settings::{DataSettings, Estimator, Neighbourhood};
use super::tree::Neighbour;
use numerics::upper_median;

/// Reference points between two reports of progress: few enough that their maps stay in the cache.
const POINTS_PER_REPORT: usize = 128;

/// A reference point is starved if the smaller neighbourhood of an extrapolated estimate reaches
/// beyond this many times the given radius. For one column the true value is within two errors of
/// exponents called ok in 99 % of cases with 1, and in 96 % with 1.5. It is in 92 % with 2, and in
/// 87 % without a limit. For whole states it is in 98 % with each. This was measured on seeds 1007
/// to 1009, up to 50000 points, which the table of `spectrum_coverage` does not use.
const STARVED_RADIUS: f64 = 1.5;

/// The smallest neighbourhood for measuring directions has this many points, or twice the number of
/// columns. Singular values then scatter by a sixth.
const FEWEST_IN_DIRECTIONS: usize = 20;

/// Estimates the Lyapunov spectrum of a series.
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
/// [`DataError::Setting`] for a setting that is not allowed, [`DataError::TooFew`],
/// [`DataError::TooMany`], [`DataError::Constant`].
pub fn data_spectrum(series: &Series, settings: &DataSettings) -> Result<DataSpectrum, DataError> {
    data_spectrum_with(series, settings, &unwatched)
}

/// [`data_spectrum`] with calls of `progress(done, total)` at intervals, in numbers of
/// reference points.
///
/// # Errors
/// As [`data_spectrum`], and [`DataError::Stopped`].
pub fn data_spectrum_with(
    series: &Series,
    settings: &DataSettings,
    progress: Progress<'_>,
) -> Result<DataSpectrum, DataError> {
    let columns = series.columns();
    settings.check(columns)?;
    let step = settings.step;
    // Too few points take precedence over other errors.
    let cloud = Cloud::new(series);
    let decorrelation = || cloud.as_ref().map_or(0, Cloud::decorrelation);
    let theiler = settings.theiler.unwrap_or_else(decorrelation);
    let (rows, needed) = (series.len(), settings.fewest_points(theiler));
    if rows < needed {
        return Err(DataError::TooFew {
            rows,
            needed,
            neighbours: settings.neighbours.fewest(),
            theiler,
            step,
        });
    }
    let cloud = cloud?;
    let finder = Finder::new(&cloud, step, theiler)?;
    let shifted = ShiftedColumns::of(&cloud.points, step);
    let smallest = FEWEST_IN_DIRECTIONS.max(2 * columns);
    let goes_on = || report(progress, 0, references(rows, settings));
    let directions = directions::measure((&cloud, &finder), settings, smallest, &goes_on)?;
    let are_tangent = directions
        .iter()
        .map(|one| one.kind == DirectionKind::Tangent);
    let dimension = are_tangent.take_while(|is_tangent| *is_tangent).count();
    let fixed_rank = settings.fixed_rank.unwrap_or(dimension);
    let count = settings.chains();
    let mut extrapolation = match settings.estimator {
        Estimator::Extrapolated { degree } if dimension > 0 => {
            let plan = Plan::new(&cloud, settings, degree, dimension);
            Some(Extrapolation::new(plan, count, columns))
        }
        _ => None,
    };
    let around = Around {
        cloud: &cloud,
        finder,
        settings,
        // The extrapolated estimator has two sizes of its own.
        has_wide: settings.sensitivity && settings.estimator == Estimator::SanoSawada,
        fixed_rank,
    };
    let [mut full, mut wide] = [0; 2].map(|_| Chains::new(count, columns));
    let mut fixed = Chains::new(count, fixed_rank);
    let references = references(rows, settings);
    let mut points: Vec<Point> = Vec::with_capacity(references);
    while points.len() < references {
        report(progress, points.len(), references)?;
        let until = (points.len() + POINTS_PER_REPORT).min(references);
        let plan = extrapolation.as_ref().map(Extrapolation::plan);
        let locals: Vec<Local> = (points.len()..until)
            .into_par_iter()
            .map_init(
                || Memory {
                    nearest: Vec::new(),
                    of: None,
                    scratch: Scratch::default(),
                    fit: LeastSquares::new(&cloud.points, &shifted),
                },
                |memory, i| around.point(settings.reference(i), plan, memory),
            )
            .collect();
        for local in locals {
            full.push(&local.full, &local.directions);
            fixed.push(&local.fixed, &local.directions);
            if let Some((map, directions)) = &local.wide {
                wide.push(map, directions);
            }
            if let (Some(extrapolation), Some(maps)) = (&mut extrapolation, &local.maps) {
                extrapolation.push(maps, &local.directions);
            }
            points.push(local.point);
        }
    }
    report(progress, references, references)?;

    let tau = step as f64 * series.dt();
    let corrected = extrapolation.map(|extrapolation| extrapolation.corrected(tau, cloud.unit));
    let residual_ratio = upper_median(points.iter().map(|point| point.residual_ratio));
    let evidence = Evidence {
        dimension,
        references,
        starved: points.iter().filter(|point| point.starved).count(),
        residual_ratio,
        tau,
    };
    let mut exponents: Vec<DataExponent> = (0..columns)
        .map(|i| {
            let of = |chains: &Chains| average(&chains.stretches, i, tau);
            evidence.exponent(
                i,
                &of(&full),
                (i < fixed_rank).then(|| of(&fixed)).as_ref(),
                around.has_wide.then(|| of(&wide)).as_ref(),
                corrected.as_ref().map(|corrected| &corrected.exponents[i]),
            )
        })
        .collect();
    evidence.require_zero(&mut exponents, &cloud.points);
    let (sum, running) = match &corrected {
        Some(corrected) => (corrected.sum, corrected.running.clone()),
        None => (
            volume(&full.stretches, dimension, tau),
            running(&full.stretches, columns, tau),
        ),
    };
    let time = |count: usize| settings.reference(count) as f64 * series.dt();
    let distances: f64 = points.iter().map(|point| point.radius).sum();
    let mut counts: Vec<usize> = points.iter().map(|point| point.neighbours).collect();
    counts.sort_unstable();
    let count = |at: usize| counts.get(at).copied().unwrap_or(0);
    Ok(DataSpectrum {
        exponents,
        sum: (sum.mean, sum.stderr),
        dimension,
        fixed_rank,
        directions,
        spread: cloud.unit * cloud.spread,
        // The sum alone may overflow in the unit of the data.
        mean_eps: cloud.unit * (distances / references as f64),
        neighbours: Counts {
            min: count(0),
            median: count(counts.len() / 2),
            max: count(counts.len().saturating_sub(1)),
        },
        references,
        starved: evidence.starved,
        residual_ratio,
        sizes: corrected.map(|corrected| corrected.sizes),
        convergence: running
            .into_iter()
            .map(|(count, exponents)| Running {
                t: time(count),
                exponents,
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

/// Workspace, reused for the next reference point.
struct Memory<'a> {
    /// Neighbours, the nearest first, and the point that they belong to.
    nearest: Vec<Neighbour>,
    of: Option<usize>,
    scratch: Scratch,
    fit: LeastSquares<'a>,
}

/// The result at a reference point.
struct Point {
    neighbours: usize,
    radius: f64,
    residual_ratio: f64,
    starved: bool,
}

/// The maps around a reference point, and the directions of its neighbourhood.
struct Local {
    directions: Matrix,
    full: LocalMap,
    fixed: LocalMap,
    /// Map from twice the neighbourhood, with its directions.
    wide: Option<(LocalMap, Matrix)>,
    maps: Option<Maps>,
    point: Point,
}

/// Estimates around a reference point.
struct Around<'a> {
    cloud: &'a Cloud,
    finder: Finder<'a>,
    settings: &'a DataSettings,
    has_wide: bool,
    fixed_rank: usize,
}

impl Around<'_> {
    fn point(&self, j: usize, plan: Option<&Plan>, memory: &mut Memory<'_>) -> Local {
        let (settings, cloud) = (self.settings, self.cloud);
        let (columns, spread) = (cloud.points.columns(), cloud.spread);
        // The neighbourhood of Eq. (25), among the nearest points used for extrapolation.
        let size = (
            1 + usize::from(self.has_wide),
            plan.map_or(0, Plan::furthest),
        );
        let from = (memory.of.replace(j), j);
        let nearest = &mut memory.nearest;
        let selection = (self.finder).select(from, &settings.neighbours, size, spread, nearest);
        let (nearest, inside) = (nearest.as_slice(), &nearest[..selection.count]);
        let scratch = &mut memory.scratch;
        let mut decomposed = |neighbours| {
            Decomposed::new(scratch, cloud, (j, neighbours), settings.affine, settings)
        };
        let narrow = decomposed(inside);
        let wide = self.has_wide.then(|| {
            let wide = decomposed(nearest);
            (wide.map(columns, settings), wide.into_directions())
        });
        let mut point = Point {
            neighbours: selection.count,
            radius: inside.last().map_or(0.0, |furthest| furthest.0.sqrt()),
            residual_ratio: narrow.residual_ratio(),
            starved: selection.starved,
        };
        let full = narrow.map(columns, settings);
        let fixed = narrow.map(self.fixed_rank, settings);
        let directions = narrow.into_directions();
        let maps = plan.map(|plan| plan.maps(&mut memory.fit, j, nearest, &directions));
        // Judged by the maps that the exponents come from.
        if let (Some(plan), Some(maps), Neighbourhood::Ball { eps, .. }) =
            (plan, &maps, settings.neighbours)
        {
            point.starved = maps.radius[0] > STARVED_RADIUS * eps * spread
                || nearest.len() < plan.neighbours[0];
        }
        Local {
            directions,
            full,
            fixed,
            wide,
            maps,
            point,
        }
    }
}

/// Reference points for this many rows.
fn references(rows: usize, settings: &DataSettings) -> usize {
    let all = settings.references_before(rows - settings.step);
    settings.references.map_or(all, |asked| asked.min(all))
}
