//! The largest exponent by how neighbours part, a second opinion that fits no maps: Rosenstein, Collins and De Luca, Physica D 65, 117
//! (1993); Kantz, Phys. Lett. A 185, 77 (1994).
//!
//! The mean logarithm of the distance of neighbours grows along a straight line, whose slope is the exponent, between the time in which
//! their difference turns into the fastest direction and the time at which it is as large as the attractor. Rosenstein follows the
//! nearest neighbour of each point, Kantz the mean distance of all within a radius. Distances are those of whole vectors.

mod straight;

use rayon::prelude::*;

use super::cloud::{Cloud, distance2};
use super::directions::upper_median;
use super::error::DataError;
use super::neighbours::{Finder, Neighbour};
use super::series::{Series, for_columns};
use crate::math;

pub use straight::StraightPart;
use straight::straight_part;

/// Points that are followed, spread evenly over the series.
const SAMPLES: usize = 1000;
/// Points of time they are followed over, at most,
const LONGEST: usize = 2048;
/// and as a part of the series.
const LONGEST_PART: usize = 4;
/// Neighbours in Kantz' smallest ball at half of the points, and those in the larger ones.
const KANTZ: [usize; 3] = [3, 6, 12];
/// Neighbours of a point in a ball that are followed, at most.
const MOST: usize = 20;
/// Blocks of points for the standard error of a slope.
const BLOCKS: usize = 8;
/// Points that tell the size of the attractor.
const PAIRS: usize = 2000;
/// Whether a curve still rises is asked after so many points.
const LOOKED_BACK: usize = 256;
/// A curve is followed until it is so near to the size of the attractor, in logarithms.
const SATURATED: f64 = 0.3;

/// Mean logarithm of the distance of neighbours over time.
#[derive(Clone, Debug, PartialEq)]
pub struct DivergenceCurve {
    /// Radius within which neighbours were taken, in the unit of the data; `None` for the nearest one.
    pub radius: Option<f64>,
    /// Points whose neighbours were followed.
    pub references: usize,
    /// Time and mean logarithm of the distance, in the unit of the data.
    pub points: Vec<(f64, f64)>,
    /// The straight part; `None` if the distance does not grow by a factor of e before it levels off.
    pub straight: Option<StraightPart>,
}

/// The largest exponent by two ways of following neighbours.
#[derive(Clone, Debug, PartialEq)]
pub struct Divergence {
    /// Nearest neighbours.
    pub rosenstein: DivergenceCurve,
    /// Balls of three radii.
    pub kantz: Vec<DivergenceCurve>,
    /// Mean logarithm of the distance of points that have nothing to do with one another: where the curves end.
    pub saturation: f64,
}

impl Divergence {
    /// Rosenstein's exponent per unit of time with its standard error.
    pub fn by_rosenstein(&self) -> Option<(f64, f64)> {
        let straight = self.rosenstein.straight.as_ref()?;
        Some((straight.slope, straight.stderr))
    }

    /// Kantz' exponent per unit of time: the median of those of the radii that have one, with the larger of its standard error and half
    /// the range of all of them.
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

/// Follows the neighbours of a series of states or of delayed values. `theiler` as in [`super::DataSettings`]; `None` takes the
/// time in which the autocorrelation falls below 1/e. `progress(done, total)` is called in between.
///
/// # Errors
/// [`DataError::TooFew`] for fewer than 50 points or a window that leaves no neighbours, [`DataError::Constant`],
/// [`DataError::Overflow`], [`DataError::TooMany`].
pub fn divergence(
    series: &Series,
    theiler: Option<usize>,
    progress: &dyn Fn(usize, usize),
) -> Result<Divergence, DataError> {
    for_columns!(series, of_size(series, theiler, progress))
}

/// With fewer points there is nothing to follow.
const FEWEST: usize = 50;

fn of_size<const N: usize>(
    series: &Series,
    theiler: Option<usize>,
    progress: &dyn Fn(usize, usize),
) -> Result<Divergence, DataError> {
    let rows = series.len();
    let longest = (rows / LONGEST_PART).clamp(1, LONGEST);
    let too_few = |theiler: usize| DataError::TooFew {
        rows,
        needed: theiler
            .saturating_mul(2)
            .saturating_add(1 + longest)
            .max(FEWEST),
        neighbours: 1,
        theiler,
        step: longest,
    };
    if rows < FEWEST {
        return Err(too_few(theiler.unwrap_or(0)));
    }
    let cloud = Cloud::<N>::new(series)?;
    let theiler = theiler.unwrap_or_else(|| cloud.decorrelation());
    if theiler >= rows - longest {
        return Err(too_few(theiler));
    }
    let finder = Finder::new(&cloud, longest, theiler)?;
    let follow = Follow {
        cloud: &cloud,
        longest,
        dt: series.dt(),
        saturation: saturation(&cloud),
    };
    let total = 1 + KANTZ.len();
    progress(0, total);
    let points = rows - longest;
    let every = points.div_ceil(SAMPLES).max(1);
    let references: Vec<usize> = (0..points).step_by(every).collect();
    let found: Vec<Vec<Neighbour>> = references
        .par_iter()
        .map(|&j| {
            let mut found = Vec::new();
            finder.nearest(j, MOST, f64::INFINITY, &mut found);
            found
        })
        .collect();
    let nearest = |i: usize| &found[i][..found[i].len().min(1)];
    let rosenstein = follow.curve(&references, None, &nearest);
    let mut kantz = Vec::with_capacity(KANTZ.len());
    for (done, count) in KANTZ.into_iter().enumerate() {
        progress(1 + done, total);
        let reach = found.iter().filter_map(|found| found.get(count - 1));
        let radius2 = upper_median(reach.map(|neighbour| neighbour.0));
        let within = |i: usize| {
            let count = found[i].partition_point(|neighbour| neighbour.0 <= radius2);
            &found[i][..count]
        };
        kantz.push(follow.curve(&references, Some(radius2.sqrt()), &within));
    }
    progress(total, total);
    Ok(Divergence {
        rosenstein,
        kantz,
        saturation: follow.saturation + math::ln(cloud.unit),
    })
}

/// Mean logarithm of the distance of points half a series apart, and a little more from pair to pair.
fn saturation<const N: usize>(cloud: &Cloud<N>) -> f64 {
    let points = &cloud.points;
    let half = points.len() / 2;
    let every = half.div_ceil(PAIRS).max(1);
    let (mut sum, mut count) = (0.0, 0.0);
    for (k, j) in (0..half).step_by(every).enumerate() {
        let square = distance2(&points[j], &points[half + (j + 7 * k) % half]);
        if square > 0.0 {
            sum += 0.5 * math::ln(square);
            count += 1.0;
        }
    }
    sum / count
}

/// A sum of logarithms as the logarithms of products, which are fewer: they were most of the time of a curve.
struct SumOfLogarithms {
    sum: f64,
    product: f64,
}

impl SumOfLogarithms {
    /// A product within this factor of one can take another such number without overflow.
    const ROOM: f64 = 1e100;

    const fn new() -> Self {
        Self {
            sum: 0.0,
            product: 1.0,
        }
    }

    /// Adds the logarithm of a positive number.
    fn add(&mut self, v: f64) {
        let within = Self::ROOM.recip()..=Self::ROOM;
        if !within.contains(&v) {
            self.sum += math::ln(v);
            return;
        }
        self.product *= v;
        if !within.contains(&self.product) {
            self.sum += math::ln(self.product);
            self.product = 1.0;
        }
    }

    fn value(&self) -> f64 {
        self.sum + math::ln(self.product)
    }
}

/// How neighbours are followed.
struct Follow<'a, const N: usize> {
    cloud: &'a Cloud<N>,
    longest: usize,
    dt: f64,
    saturation: f64,
}

impl<const N: usize> Follow<'_, N> {
    /// The curve of these points with their neighbours.
    fn curve<'n>(
        &self,
        references: &[usize],
        radius: Option<f64>,
        neighbours: &(dyn Fn(usize) -> &'n [Neighbour] + Sync),
    ) -> DivergenceCurve {
        let followed: Vec<usize> = (0..references.len())
            .filter(|&i| !neighbours(i).is_empty())
            .collect();
        // A point of time after another, until the distances are those of any two points.
        const TOGETHER: usize = 16;
        let mut means: Vec<[f64; BLOCKS]> = Vec::new();
        let mut curve: Vec<f64> = Vec::new();
        // Neighbours that keep in phase, as Rössler's do, never come to be as far apart as any two points.
        let mut level = self.saturation;
        while !followed.is_empty() && curve.len() < self.longest {
            let from = curve.len();
            let until = (from + TOGETHER).min(self.longest);
            let rows: Vec<(f64, [f64; BLOCKS])> = (from..until)
                .into_par_iter()
                .map(|ahead| self.mean(references, &followed, neighbours, ahead))
                .collect();
            for (mean, blocks) in rows {
                curve.push(mean);
                means.push(blocks);
            }
            let is_saturated = curve
                .last()
                .is_some_and(|last| *last > self.saturation - SATURATED);
            if is_saturated {
                break;
            }
            if self.is_flat(&curve) {
                level = curve.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                break;
            }
        }
        let unit = math::ln(self.cloud.unit);
        let points = curve.iter().enumerate();
        DivergenceCurve {
            radius: radius.map(|radius| self.cloud.unit * radius),
            references: followed.len(),
            straight: straight_part(&curve, &means, level, self.dt),
            points: points
                .map(|(k, mean)| (k as f64 * self.dt, mean + unit))
                .collect(),
        }
    }

    /// Whether the curve, going on as over its last half, would not rise any more by half a factor of e.
    fn is_flat(&self, curve: &[f64]) -> bool {
        let quarter = curve.len() / 4;
        if curve.len() < LOOKED_BACK {
            return false;
        }
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        let later = mean(&curve[curve.len() - quarter..]);
        let before = mean(&curve[curve.len() - 2 * quarter..curve.len() - quarter]);
        let left = (self.longest - curve.len()) as f64;
        (later - before) / quarter as f64 * left < 0.5
    }

    /// Mean over the points of the logarithm of the mean distance of their neighbours after `ahead` points, and the same over
    /// blocks of them. Distances of zero are passed over.
    fn mean<'n>(
        &self,
        references: &[usize],
        followed: &[usize],
        neighbours: &(dyn Fn(usize) -> &'n [Neighbour] + Sync),
        ahead: usize,
    ) -> (f64, [f64; BLOCKS]) {
        let points = &self.cloud.points;
        let mut sums = [const { (SumOfLogarithms::new(), 0.0) }; BLOCKS];
        for (order, &i) in followed.iter().enumerate() {
            let here = &points[references[i] + ahead];
            let near = neighbours(i);
            let distances = near
                .iter()
                .map(|&(_, k)| distance2(&points[k as usize + ahead], here).sqrt());
            let mean = distances.sum::<f64>() / near.len() as f64;
            if mean > 0.0 {
                let (sum, count) = &mut sums[order * BLOCKS / followed.len()];
                sum.add(mean);
                *count += 1.0;
            }
        }
        let sums = sums.map(|(sum, count)| (sum.value(), count));
        let (all, count) = sums
            .iter()
            .fold((0.0, 0.0), |all, sum| (all.0 + sum.0, all.1 + sum.1));
        (all / count, sums.map(|(sum, count)| sum / count))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sum_of_logarithms_is_that_of_each_at_any_size() {
        let numbers = [
            0.3,
            1e-90,
            1e-90,
            7.0,
            5e-324,
            1e99,
            1e99,
            f64::MAX,
            1e-200,
            2.5,
        ];
        let mut sum = SumOfLogarithms::new();
        for v in numbers {
            sum.add(v);
        }
        let wanted: f64 = numbers.map(math::ln).iter().sum();
        assert!(
            (sum.value() - wanted).abs() < 1e-12,
            "{} {wanted}",
            sum.value()
        );
        assert_eq!(SumOfLogarithms::new().value(), 0.0);
    }
}
