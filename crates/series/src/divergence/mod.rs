//! The largest exponent from the divergence of neighbours, an independent estimate that fits no
//! maps.
//!
//! Rosenstein, Collins and De Luca, Physica D 65, 117 (1993); Kantz, Phys. Lett. A 185, 77 (1994).
//!
//! The mean logarithm of the distance of neighbours grows linearly, and its slope is the exponent.
//! The line begins when the difference has turned into the fastest direction. It ends when the
//! difference is as large as the attractor. Rosenstein follows the nearest neighbour of each point,
//! Kantz the mean distance of all neighbours within a radius. Distances are between whole vectors.

mod straight;

use rayon::prelude::*;

use super::cloud::Cloud;
use super::error::DataError;
use super::matrix::{Matrix, distance2};
use super::neighbours::Finder;
use super::progress::{Progress, report};
use super::series::Series;
use super::tree::Neighbour;
use numerics::upper_median;

pub use straight::StraightPart;
use straight::straight_part;

/// Number of points followed, spread evenly over the series. The error of a mean logarithm is then
/// a few hundredths.
const SAMPLES: usize = 1000;
/// Fewest points for which neighbours are followed: with fewer, eight blocks would hold fewer than
/// seven each. Shorter series are not embedded unless asked.
pub(crate) const FEWEST_POINTS: usize = 50;
/// Largest number of time steps over which neighbours are followed, to bound the time.
const MOST_STEPS: usize = 2048;
/// Rows of the series for each time step over which neighbours are followed: three quarters of the
/// points remain as references.
const ROWS_PER_STEP: usize = 4;
/// Neighbours in Kantz' smallest ball at half of the points, and those in the larger ones.
const KANTZ_COUNTS: [usize; 3] = [3, 6, 12];
/// Largest number of neighbours followed per point: more than the largest ball holds around most
/// points.
const MOST_NEIGHBOURS: usize = 20;
/// Blocks of points for the standard error of a slope.
const BLOCKS: usize = 8;
/// Number of pairs of points that give the logarithm of the size of the attractor, to a few
/// hundredths.
const PAIRS: usize = 2000;
/// Fewest time steps after which a curve may count as flat.
const FLAT_STEPS: usize = 256;
/// A curve is followed until it is this near to the size of the attractor, in logarithms. The
/// straight part ends a factor of e below it.
const SATURATED: f64 = 0.3;
/// Time steps between two checks whether a curve still rises.
const STEPS_PER_CHECK: usize = 16;

/// Mean logarithm of the distance of neighbours over time.
#[derive(Clone, Debug, PartialEq)]
pub struct DivergenceCurve {
    /// Radius within which neighbours were taken, in the unit of the data; `None` for the nearest
    /// one.
    pub radius: Option<f64>,
    /// Points whose neighbours were followed.
    pub references: usize,
    /// Time and mean logarithm of the distance, in the unit of the data.
    pub points: Vec<(f64, f64)>,
    /// The straight part; `None` if the distance does not grow by a factor of e before it levels
    /// off.
    pub straight: Option<StraightPart>,
}

/// The largest exponent by two methods.
#[derive(Clone, Debug, PartialEq)]
pub struct Divergence {
    /// Nearest neighbours.
    pub rosenstein: DivergenceCurve,
    /// Balls of three radii.
    pub kantz: Vec<DivergenceCurve>,
    /// Mean logarithm of the distance of unrelated points: the level at which the curves saturate.
    pub saturation: f64,
}

impl Divergence {
    /// Rosenstein's exponent per unit of time with its standard error.
    pub fn by_rosenstein(&self) -> Option<(f64, f64)> {
        let straight = self.rosenstein.straight.as_ref()?;
        Some((straight.slope, straight.stderr))
    }

    /// Kantz' exponent per unit of time: the median over the radii that have one. Its error is the
    /// larger of its standard error and half the range over the radii.
    pub fn by_kantz(&self) -> Option<(f64, f64)> {
        let parts = self.kantz.iter();
        let mut parts: Vec<&StraightPart> =
            parts.filter_map(|curve| curve.straight.as_ref()).collect();
        parts.sort_by(|a, b| a.slope.total_cmp(&b.slope));
        let (first, last) = (parts.first()?, parts.last()?);
        let middle = parts[parts.len() / 2];
        let range = 0.5 * (last.slope - first.slope);
        Some((middle.slope, middle.stderr.max(range)))
    }
}

/// Follows the neighbours of a series of states or of delayed values. `theiler` as in
/// [`super::DataSettings`]; `None` takes the time in which the autocorrelation falls below 1/e.
/// `progress(done, total)` is called at intervals.
///
/// # Errors
/// [`DataError::TooFew`] for fewer than 50 points or a window that leaves no neighbours,
/// [`DataError::Constant`], [`DataError::Overflow`], [`DataError::TooMany`].
pub fn divergence(
    series: &Series,
    theiler: Option<usize>,
    progress: Progress<'_>,
) -> Result<Divergence, DataError> {
    let rows = series.len();
    let longest = (rows / ROWS_PER_STEP).clamp(1, MOST_STEPS);
    let too_few = |theiler: usize| DataError::TooFew {
        rows,
        needed: theiler
            .saturating_mul(2)
            .saturating_add(1 + longest)
            .max(FEWEST_POINTS),
        neighbours: 1,
        theiler,
        step: longest,
    };
    if rows < FEWEST_POINTS {
        return Err(too_few(theiler.unwrap_or(0)));
    }
    let cloud = Cloud::new(series)?;
    let theiler = theiler.unwrap_or_else(|| cloud.decorrelation());
    if theiler >= rows - longest {
        return Err(too_few(theiler));
    }
    let finder = Finder::new(&cloud, longest, theiler)?;
    let total = 1 + KANTZ_COUNTS.len();
    report(progress, 0, total)?;
    let points = rows - longest;
    let every = points.div_ceil(SAMPLES).max(1);
    let references: Vec<usize> = (0..points).step_by(every).collect();
    let nearest: Vec<Vec<Neighbour>> = references
        .par_iter()
        .map(|&j| {
            let mut nearest = Vec::new();
            finder.nearest(j, MOST_NEIGHBOURS, f64::INFINITY, &mut nearest);
            nearest
        })
        .collect();
    let saturation = saturation(&cloud);
    let curve = |radius2: Option<f64>| {
        let inside = |neighbours: &[Neighbour]| match radius2 {
            Some(radius2) => neighbours.partition_point(|neighbour| neighbour.0 <= radius2),
            None => neighbours.len().min(1),
        };
        let pairs = references.iter().zip(&nearest);
        let pairs = pairs.map(|(&j, neighbours)| (j, &neighbours[..inside(neighbours)]));
        let mut growth = Growth {
            points: &cloud.points,
            pairs: pairs.filter(|(_, inside)| !inside.is_empty()).collect(),
            longest,
            saturation,
            means: Vec::new(),
            blocks: Vec::new(),
        };
        let level = growth.follow().unwrap_or(saturation);
        let ln_unit = libm::log(cloud.unit);
        let points = growth.means.iter().enumerate();
        DivergenceCurve {
            radius: radius2.map(|square| cloud.unit * square.sqrt()),
            references: growth.pairs.len(),
            straight: straight_part(&growth.means, &growth.blocks, level, series.dt()),
            points: points
                .map(|(k, mean)| (k as f64 * series.dt(), mean + ln_unit))
                .collect(),
        }
    };
    report(progress, 1, total)?;
    let rosenstein = curve(None);
    let kantz = KANTZ_COUNTS.iter().enumerate().map(|(i, count)| {
        report(progress, 1 + i, total)?;
        let reach = nearest.iter().filter_map(|found| found.get(count - 1));
        Ok(curve(Some(upper_median(
            reach.map(|neighbour| neighbour.0),
        ))))
    });
    let kantz = kantz.collect::<Result<_, DataError>>()?;
    report(progress, total, total)?;
    Ok(Divergence {
        rosenstein,
        kantz,
        saturation: saturation + libm::log(cloud.unit),
    })
}

/// Mean logarithm of the distance of points about half a series apart; the lag grows slightly from
/// pair to pair.
fn saturation(cloud: &Cloud) -> f64 {
    let points = &cloud.points;
    let half = points.len() / 2;
    let every = half.div_ceil(PAIRS).max(1);
    let (mut sum, mut count) = (0.0, 0.0);
    for (k, j) in (0..half).step_by(every).enumerate() {
        let square = distance2(&points[j], &points[half + (j + 7 * k) % half]);
        if square > 0.0 {
            sum += 0.5 * libm::log(square);
            count += 1.0;
        }
    }
    sum / count
}

/// A curve under construction.
struct Growth<'a> {
    points: &'a Matrix,
    /// Reference points, and the neighbours of each that are followed.
    pairs: Vec<(usize, &'a [Neighbour])>,
    longest: usize,
    saturation: f64,
    /// Mean logarithms of the distance, over time.
    means: Vec<f64>,
    /// Curves of each block of reference points.
    blocks: Vec<[f64; BLOCKS]>,
}

impl Growth<'_> {
    /// Follows the neighbours until the distances are those of any two points, and returns where
    /// the curve levels off, if it does.
    fn follow(&mut self) -> Option<f64> {
        while !self.pairs.is_empty() && self.means.len() < self.longest {
            let from = self.means.len();
            let until = (from + STEPS_PER_CHECK).min(self.longest);
            let sums = (from..until).into_par_iter();
            let sums: Vec<_> = sums.map(|ahead| self.logarithms(ahead)).collect();
            for of_blocks in sums {
                let all = |(sum, count), &(more, others)| (sum + more, count + others);
                let (sum, count) = of_blocks.iter().fold((0.0, 0.0), all);
                self.means.push(sum / count);
                self.blocks.push(of_blocks.map(|(sum, count)| sum / count));
            }
            if *self.means.last()? > self.saturation - SATURATED {
                return Some(self.saturation);
            }
            // Neighbours that stay in phase, as in the Rössler system, never get as far apart as
            // unrelated points.
            if self.is_flat() {
                return self.means.iter().copied().reduce(f64::max);
            }
        }
        None
    }

    /// Sums of the logarithms of mean distances this many points later, and their counts, for each
    /// block of reference points. Zero distances are skipped.
    fn logarithms(&self, ahead: usize) -> [(f64, f64); BLOCKS] {
        let mut sums = [(0.0, 0.0); BLOCKS];
        for (i, (j, neighbours)) in self.pairs.iter().enumerate() {
            let distances = neighbours.iter().map(|&(_, k)| {
                let later = &self.points[k as usize + ahead];
                distance2(&self.points[j + ahead], later).sqrt()
            });
            let mean = distances.sum::<f64>() / neighbours.len() as f64;
            if mean > 0.0 {
                let (sum, count) = &mut sums[i * BLOCKS / self.pairs.len()];
                *sum += libm::log(mean);
                *count += 1.0;
            }
        }
        sums
    }

    /// Whether the curve, extrapolated from its last half, would rise by less than half a factor of
    /// e.
    fn is_flat(&self) -> bool {
        let (curve, quarter) = (&self.means, self.means.len() / 4);
        if curve.len() < FLAT_STEPS {
            return false;
        }
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        let later = mean(&curve[curve.len() - quarter..]);
        let before = mean(&curve[curve.len() - 2 * quarter..curve.len() - quarter]);
        let left = (self.longest - curve.len()) as f64;
        (later - before) / quarter as f64 * left < 0.5
    }
}
