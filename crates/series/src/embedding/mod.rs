//! Delay embedding: states from fewer columns than the system has, and the choice of delay and
//! dimension.

mod delay;
mod false_neighbours;
mod information;

use crate::cloud::{Cloud, longest_lag};
use crate::divergence::FEWEST_POINTS;
use crate::error::DataError;
use crate::progress::{Progress, report, unwatched};
use crate::series::Series;
pub use delay::Embedding;
use delay::most_dimensions;
use false_neighbours::{NeighbourStatistics, statistics};
use information::Classes;

/// Largest number of lags considered, to bound the computing time.
const MOST_LAGS: usize = 2000;
/// A minimum counts if the information rises after it by this fraction of its value at the first
/// lag. Chosen; its scatter is a second bound.
const LEAST_RISE: f64 = 0.01;
/// A minimum with more than this fraction of the information at lag 0 is rejected. One value then
/// determines the other up to two or three classes, as on a closed curve. The information on a
/// curve has no true minimum; apparent ones come from the borders of the classes.
const CURVE_INFORMATION: f64 = 0.5;
/// Decorrelation times after which the search stops on a curve, which are a period or more. The
/// period of a sine has 5.3.
const CURVE_DECORRELATIONS: usize = 6;
/// The curve is reported up to this many times the delay, so that a plot shows the minimum inside.
const REPORTED_DELAYS: usize = 3;
/// A smaller fraction of false neighbours counts as none: Kennel's 1 %.
pub const NO_FALSE_NEIGHBOURS: f64 = 0.01;
/// Fraction of false neighbours above which columns are missing. Whole states have up to 3 %
/// where they stick, and x and z of the Lorenz system at 3000 points have 5 %.
const MANY_FALSE_NEIGHBOURS: f64 = 0.05;
/// Least number of dimensions considered above a given one. Cao's E1 needs the next one, and its
/// change the one after.
const FURTHER_DIMENSIONS: usize = 2;
/// Distance from 1 within which Cao's E1 has stopped changing, and E2 is that of noise. Chosen.
const CAO_NEAR_ONE: f64 = 0.1;
/// Change of E1 to the next dimension below which it has stopped changing. Chosen.
const CAO_CHANGE: f64 = 0.05;

/// Given parts of an embedding, and settings for the choice of the others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EmbeddingSettings {
    /// Delay in points; `None` takes it from the mutual information.
    pub delay: Option<usize>,
    /// Delayed values of each column; `None` takes it from false neighbours.
    pub dimension: Option<usize>,
    /// Theiler window in points, as in [`crate::DataSettings`].
    pub theiler: Option<usize>,
}

/// Origin of the delay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DelayReason {
    /// Given by the user.
    Given,
    /// The autocorrelation is below 1/e after one point: the series is like that of a map, and the
    /// delay is 1.
    Uncorrelated,
    /// The first minimum of the mutual information.
    FirstMinimum,
    /// The first zero of the autocorrelation, a quarter of the period for a sine. It is used where
    /// the values lie on a curve, as for periodic motion without noise. Minima of the mutual
    /// information then come from the borders of the classes.
    OnCurve,
    /// The lag at which the mutual information falls to that of independent values, without an
    /// earlier minimum.
    Independent,
    /// The longest lag considered: there is neither a minimum nor independence.
    NoMinimum,
}

impl DelayReason {
    /// A few words for tables.
    pub fn words(self) -> &'static str {
        match self {
            DelayReason::Given => "given",
            DelayReason::Uncorrelated => "uncorrelated after one point, as a map",
            DelayReason::FirstMinimum => "first minimum of the mutual information",
            DelayReason::OnCurve => "values on a curve, first zero of the autocorrelation",
            DelayReason::Independent => "mutual information falls to zero",
            DelayReason::NoMinimum => "no minimum of the mutual information, longest lag",
        }
    }
}

/// Origin of the dimension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DimensionReason {
    /// Given by the user.
    Given,
    /// The first at which less than 1 % of the nearest neighbours are false.
    FalseNeighbours,
    /// The dimension with the fewest false neighbours, as more are false at all dimensions. This
    /// indicates noise, or more dimensions than can be considered.
    FewestFalse,
}

impl DimensionReason {
    /// A few words for tables.
    pub fn words(self) -> &'static str {
        match self {
            DimensionReason::Given => "given",
            DimensionReason::FalseNeighbours => "below 1 % false neighbours",
            DimensionReason::FewestFalse => "fewest false neighbours, never below 1 %",
        }
    }
}

/// Statistics of one dimension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DimensionEvidence {
    /// Delayed values of each column.
    pub dimension: usize,
    /// Fraction of the nearest neighbours that the next value shows to be false.
    pub false_neighbours: f64,
    /// Cao's E1, near 1 where the dimension suffices; NaN at the last dimension.
    pub e1: f64,
    /// Cao's E2, 1 at all dimensions for noise; NaN at the last dimension.
    pub e2: f64,
}

/// An embedding and the evidence for it.
#[derive(Clone, Debug, PartialEq)]
pub struct EmbeddingChoice {
    /// Delay and dimension.
    pub embedding: Embedding,
    /// Origin of the delay.
    pub delay_reason: DelayReason,
    /// Origin of the dimension.
    pub dimension_reason: DimensionReason,
    /// Mutual information in nats over the lag in points, averaged over the columns.
    pub information: Vec<(usize, f64)>,
    /// False neighbours and Cao's averages for ascending dimensions, until both methods have chosen
    /// one.
    pub dimensions: Vec<DimensionEvidence>,
    /// The dimension by Cao's method: the first from which E1 does not change. `None` if it changes
    /// at all dimensions, and for noise.
    pub cao: Option<usize>,
    /// Whether Cao's E2 is 1 at all dimensions: the next value does not depend on those before, as
    /// in noise.
    pub is_noise: bool,
}

/// The embedding that the settings ask for or the data need; `None` if the columns form a state
/// already.
///
/// One column is embedded in as many delayed values as it needs. Several are embedded only if a
/// delay or a dimension is given, or if they [lack columns](lacks_columns) and delayed values
/// remedy that. Fewer than 50 points are too few to decide. `progress(done, total)` is called at
/// intervals.
///
/// # Errors
/// Those of [`choose_embedding`].
pub fn needed_embedding(
    series: &Series,
    settings: &EmbeddingSettings,
    progress: Progress<'_>,
) -> Result<Option<EmbeddingChoice>, DataError> {
    let asked = settings.delay.is_some() || settings.dimension.is_some();
    let is_short = series.len() < FEWEST_POINTS;
    if !asked && (is_short || series.columns() > 1 && !lacks(series, settings.theiler, progress)?) {
        return Ok(None);
    }
    let choice = choose_embedding(series, settings, progress)?;
    let cures = choice.dimension_reason != DimensionReason::FewestFalse;
    let wanted = asked || series.columns() == 1 || cures;
    Ok((wanted && choice.embedding.dimension > 1).then_some(choice))
}

/// Chooses an embedding, or gives the evidence for a given one. `progress(done, total)` is called
/// at intervals.
///
/// # Errors
/// [`DataError::Setting`] for a delay or dimension that is not allowed, [`DataError::Span`] for one
/// that the series is too short for, [`DataError::Constant`], [`DataError::Overflow`],
/// [`DataError::TooMany`], [`DataError::Stopped`].
pub fn choose_embedding(
    series: &Series,
    settings: &EmbeddingSettings,
    progress: Progress<'_>,
) -> Result<EmbeddingChoice, DataError> {
    let most = most_dimensions(series.columns());
    // A given embedding is checked before anything is computed.
    Embedding {
        delay: settings.delay.unwrap_or(1),
        dimension: settings.dimension.unwrap_or(1),
    }
    .of(series)?;
    let longest = longest_lag(series.len());
    if let (Some(delay), None) = (settings.delay, settings.dimension)
        && delay > longest
    {
        return Err(DataError::Setting {
            name: "delay",
            value: delay as f64,
            bound: format!("at most {longest}, a tenth of the points, where no dimension is given"),
        });
    }
    let (decorrelation, spread) = Cloud::new(series)?.scales();
    let theiler = settings.theiler.unwrap_or(decorrelation);
    let goes_on = || report(progress, 0, most + 1);
    let (information, (delay, delay_reason)) =
        delay(series, decorrelation, settings.delay, &goes_on)?;

    let mut by_dimension: Vec<NeighbourStatistics> = Vec::new();
    let mut dimensions: Vec<DimensionEvidence> = Vec::new();
    let shown = settings
        .dimension
        .unwrap_or(0)
        .saturating_add(FURTHER_DIMENSIONS);
    for dimension in 1..=most {
        let goes_on = || report(progress, dimension, most + 1);
        let embedding = Embedding { delay, dimension };
        match statistics(series, embedding, theiler, spread, &goes_on) {
            Ok(Some(found)) => by_dimension.push(found),
            // The series is too short for more, or has nothing but repeats.
            Ok(None) | Err(DataError::Span { .. }) => break,
            Err(error) => return Err(error),
        }
        dimensions = evidence(&by_dimension);
        if dimension >= shown && is_settled(&dimensions) {
            break;
        }
    }
    report(progress, most + 1, most + 1)?;
    let (dimension, dimension_reason) = match settings.dimension {
        Some(dimension) => (dimension, DimensionReason::Given),
        None => without_false_neighbours(&dimensions),
    };
    let is_noise = is_noise(&dimensions);
    Ok(EmbeddingChoice {
        embedding: Embedding { delay, dimension },
        delay_reason,
        dimension_reason,
        information,
        // For noise, E1 also approaches 1 slowly, as neighbours move apart.
        cao: cao(&dimensions).filter(|_| !is_noise),
        is_noise,
        dimensions,
    })
}

/// Whether the columns are too few for a state. More than 5 % of the nearest neighbours are then
/// false, by their images one decorrelation time later. This is quicker than [`choose_embedding`],
/// for several columns that may be the whole state.
///
/// # Errors
/// [`DataError::Constant`], [`DataError::Overflow`], [`DataError::TooMany`].
pub fn lacks_columns(series: &Series, theiler: Option<usize>) -> Result<bool, DataError> {
    lacks(series, theiler, &unwatched)
}

fn lacks(
    series: &Series,
    theiler: Option<usize>,
    progress: Progress<'_>,
) -> Result<bool, DataError> {
    let (delay, spread) = Cloud::new(series)?.scales();
    let alone = Embedding {
        delay,
        dimension: 1,
    };
    let goes_on = || report(progress, 0, 1);
    match statistics(series, alone, theiler.unwrap_or(delay), spread, &goes_on) {
        Ok(all) => Ok(all.is_some_and(|all| all.false_part > MANY_FALSE_NEIGHBOURS)),
        Err(DataError::Span { .. }) => Ok(false),
        Err(error) => Err(error),
    }
}

/// Mutual information over the lag.
type Information = Vec<(usize, f64)>;

/// A delay and its source, with the information at all lags considered.
fn delay(
    series: &Series,
    decorrelation: usize,
    given: Option<usize>,
    goes_on: &dyn Fn() -> Result<(), DataError>,
) -> Result<(Information, (usize, DelayReason)), DataError> {
    let classes = Classes::new(series);
    let longest = longest_lag(series.len()).min(MOST_LAGS);
    let mut curve = Information::new();
    let mut chosen = given.map(|delay| (delay, DelayReason::Given));
    if chosen.is_none() && decorrelation <= 1 {
        chosen = Some((1, DelayReason::Uncorrelated));
    }
    let mut least = (1, f64::INFINITY);
    let mut has_risen = false;
    for lag in 0..=longest {
        goes_on()?;
        let shown = chosen.map(|(delay, _)| delay.saturating_mul(REPORTED_DELAYS).max(10));
        if shown.is_some_and(|shown| lag > shown) {
            break;
        }
        let information = classes.information(lag);
        curve.push((lag, information));
        if lag == 0 || chosen.is_some() {
            continue;
        }
        if information < least.1 {
            least = (lag, information);
        }
        let rise = (LEAST_RISE * curve[1].1).max(classes.independent_level(lag));
        let rises = information > least.1 + rise;
        has_risen |= rises;
        let on_curve = least.1 > CURVE_INFORMATION * curve[0].1;
        if information < classes.independent_level(lag) {
            chosen = Some((lag, DelayReason::Independent));
        } else if rises && !on_curve {
            chosen = Some((least.0, DelayReason::FirstMinimum));
        } else if on_curve
            && has_risen
            && lag >= longest.min(CURVE_DECORRELATIONS.saturating_mul(decorrelation))
        {
            let zero = Cloud::new(series)?.uncorrelated_at(0.0);
            chosen = Some(match zero.filter(|&lag| lag <= longest) {
                Some(lag) => (lag, DelayReason::OnCurve),
                None => (longest, DelayReason::NoMinimum),
            });
        }
    }
    Ok((curve, chosen.unwrap_or((longest, DelayReason::NoMinimum))))
}

fn evidence(by_dimension: &[NeighbourStatistics]) -> Vec<DimensionEvidence> {
    let of_each = by_dimension.iter().enumerate().map(|(i, here)| {
        // Ratio of a quantity between one dimension and the next.
        let ratio = |quantity: fn(&NeighbourStatistics) -> f64| {
            let next = by_dimension.get(i + 1);
            next.map_or(f64::NAN, |next| quantity(next) / quantity(here))
        };
        DimensionEvidence {
            dimension: i + 1,
            false_neighbours: here.false_part,
            e1: ratio(|one| one.stretching),
            e2: ratio(|one| one.next_difference),
        }
    });
    of_each.collect()
}

/// Whether Cao's E2 is 1 at all dimensions.
fn is_noise(dimensions: &[DimensionEvidence]) -> bool {
    let known = || dimensions.iter().filter(|one| !one.e2.is_nan());
    known().count() > 1 && known().all(|one| (one.e2 - 1.0).abs() < CAO_NEAR_ONE)
}

/// Whether both methods have chosen a dimension, so that more delayed values would change nothing.
fn is_settled(dimensions: &[DimensionEvidence]) -> bool {
    let (_, reason) = without_false_neighbours(dimensions);
    let is_enough = reason == DimensionReason::FalseNeighbours;
    is_enough && cao(dimensions).is_some() && !is_noise(dimensions)
}

fn without_false_neighbours(dimensions: &[DimensionEvidence]) -> (usize, DimensionReason) {
    let enough = |one: &&DimensionEvidence| one.false_neighbours < NO_FALSE_NEIGHBOURS;
    if let Some(first) = dimensions.iter().find(enough) {
        return (first.dimension, DimensionReason::FalseNeighbours);
    }
    let fewest = dimensions
        .iter()
        .min_by(|a, b| a.false_neighbours.total_cmp(&b.false_neighbours));
    let dimension = fewest.map_or(1, |one| one.dimension);
    (dimension, DimensionReason::FewestFalse)
}

fn cao(dimensions: &[DimensionEvidence]) -> Option<usize> {
    let settled = |pair: &&[DimensionEvidence]| {
        pair[0].e1 > 1.0 - CAO_NEAR_ONE && (pair[1].e1 - pair[0].e1).abs() < CAO_CHANGE
    };
    let first = dimensions.windows(2).find(settled)?;
    Some(first[0].dimension)
}
