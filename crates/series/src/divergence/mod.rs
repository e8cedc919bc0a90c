//! The largest exponent by how neighbours part, a second opinion that fits no maps: Rosenstein,
//! Collins and De Luca, Physica D 65, 117 (1993); Kantz, Phys. Lett. A 185, 77 (1994).
//!
//! The mean logarithm of the distance of neighbours grows along a straight line, whose slope is the
//! exponent, between the time in which their difference turns into the fastest direction and the
//! time at which it is as large as the attractor. Rosenstein follows the nearest neighbour of each
//! point, Kantz the mean distance of all within a radius. Distances are those of whole vectors.

mod straight;

use pulp::Arch;
use rayon::prelude::*;

use super::cloud::Cloud;
use super::error::DataError;
use super::matrix::distance2;
use super::neighbours::{Finder, Neighbour};
use super::series::Series;
use super::statistics::upper_median;

pub use straight::StraightPart;
use straight::straight_part;

/// Points that are followed, spread evenly over the series: a mean logarithm of so many is known to
/// some hundredths.
const SAMPLES: usize = 1000;
/// With fewer points there is nothing to follow, as eight blocks would hold fewer than seven each,
/// and nothing is embedded unasked.
pub(crate) const FEWEST: usize = 50;
/// Points of time they are followed over, at most,
const LONGEST: usize = 2048;
/// and as a part of the series.
const LONGEST_PART: usize = 4;
/// Neighbours in Kantz' smallest ball at half of the points, and those in the larger ones.
const KANTZ: [usize; 3] = [3, 6, 12];
/// Neighbours of a point in a ball that are followed, at most: more than the largest ball holds at
/// most points.
const MOST: usize = 20;
/// Blocks of points for the standard error of a slope.
const BLOCKS: usize = 8;
/// Pairs of points that tell the size of the attractor, in logarithms to some hundredths.
const PAIRS: usize = 2000;
/// Whether a curve still rises is asked after so many points.
const LOOKED_BACK: usize = 256;
/// A curve is followed until it is so near to the size of the attractor, in logarithms.
const SATURATED: f64 = 0.3;

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

/// The largest exponent by two ways of following neighbours.
#[derive(Clone, Debug, PartialEq)]
pub struct Divergence {
    /// Nearest neighbours.
    pub rosenstein: DivergenceCurve,
    /// Balls of three radii.
    pub kantz: Vec<DivergenceCurve>,
    /// Mean logarithm of the distance of points that have nothing to do with one another: where the
    /// curves end.
    pub saturation: f64,
}

impl Divergence {
    /// Rosenstein's exponent per unit of time with its standard error.
    pub fn by_rosenstein(&self) -> Option<(f64, f64)> {
        let straight = self.rosenstein.straight.as_ref()?;
        Some((straight.slope, straight.stderr))
    }

    /// Kantz' exponent per unit of time: the median of those of the radii that have one, with the
    /// larger of its standard error and half the range of all of them.
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
/// `progress(done, total)` is called in between.
///
/// # Errors
/// [`DataError::TooFew`] for fewer than 50 points or a window that leaves no neighbours, [`DataError::Constant`],
/// [`DataError::Overflow`], [`DataError::TooMany`].
pub fn divergence(
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
    let cloud = Cloud::new(series)?;
    let theiler = theiler.unwrap_or_else(|| cloud.decorrelation());
    if theiler >= rows - longest {
        return Err(too_few(theiler));
    }
    let finder = Finder::new(&cloud, longest, theiler)?;
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
    progress(1, total);
    let nearest: Vec<usize> = found.iter().map(|found| found.len().min(1)).collect();
    let balls = KANTZ.map(|count| {
        let reach = found.iter().filter_map(|found| found.get(count - 1));
        let radius2 = upper_median(reach.map(|neighbour| neighbour.0));
        let within = found
            .iter()
            .map(|found| found.partition_point(|neighbour| neighbour.0 <= radius2));
        Course::new(Some(radius2.sqrt()), within.collect())
    });
    let mut courses = vec![Course::new(None, nearest)];
    courses.extend(balls);
    let column = |c: usize| -> Vec<f64> {
        let values = cloud.points.rows().map(|point| point[c]);
        values.chain([0.0; LANES]).collect()
    };
    let follow = Follow {
        columns: (0..series.columns()).map(column).collect(),
        references: &references,
        found: &found,
        longest,
        saturation: saturation(&cloud),
    };
    follow.run(&mut courses);
    progress(total, total);
    let mut curves = courses
        .iter()
        .map(|course| course.curve(&follow, cloud.unit, series.dt()));
    let Some(rosenstein) = curves.next() else {
        return Err(too_few(theiler));
    };
    Ok(Divergence {
        rosenstein,
        kantz: curves.collect(),
        saturation: follow.saturation + libm::log(cloud.unit),
    })
}

/// Mean logarithm of the distance of points half a series apart, and a little more from pair to
/// pair.
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

/// Points of time that are followed together, each in a lane.
const LANES: usize = 8;

/// Sums of logarithms, one in each lane, as the logarithms of products, which are fewer: they were
/// most of the time of a curve.
#[derive(Clone, Copy)]
struct SumsOfLogarithms {
    sums: [f64; LANES],
    products: [f64; LANES],
    counts: [f64; LANES],
}

impl SumsOfLogarithms {
    /// A product within this factor of one can take another such number without overflow.
    const ROOM: f64 = 1e100;

    const fn new() -> Self {
        Self {
            sums: [0.0; LANES],
            products: [1.0; LANES],
            counts: [0.0; LANES],
        }
    }

    /// Adds the logarithm of a number to each lane, where it is positive.
    #[inline(always)]
    fn add(&mut self, numbers: &[f64; LANES]) {
        let are_within = |numbers: &[f64; LANES]| {
            let is_within = |v: &f64| (*v >= Self::ROOM.recip()) & (*v <= Self::ROOM);
            numbers.iter().fold(true, |all, v| all & is_within(v))
        };
        if !are_within(numbers) {
            for (lane, number) in numbers.iter().enumerate() {
                self.add_one(lane, *number);
            }
            return;
        }
        for (lane, number) in numbers.iter().enumerate() {
            self.products[lane] *= number;
            self.counts[lane] += 1.0;
        }
        if !are_within(&self.products) {
            (0..LANES).for_each(|lane| self.keep_within(lane));
        }
    }

    fn add_one(&mut self, lane: usize, number: f64) {
        if number <= 0.0 {
            return;
        }
        self.counts[lane] += 1.0;
        if (Self::ROOM.recip()..=Self::ROOM).contains(&number) {
            self.products[lane] *= number;
            self.keep_within(lane);
        } else {
            self.sums[lane] += libm::log(number);
        }
    }

    fn keep_within(&mut self, lane: usize) {
        if !(Self::ROOM.recip()..=Self::ROOM).contains(&self.products[lane]) {
            self.sums[lane] += libm::log(self.products[lane]);
            self.products[lane] = 1.0;
        }
    }

    fn value(&self, lane: usize) -> f64 {
        self.sums[lane] + libm::log(self.products[lane])
    }
}

/// A curve in the making.
struct Course {
    radius: Option<f64>,
    /// How many neighbours of each reference point are followed, the nearest.
    counts: Vec<usize>,
    /// Reference points that have any.
    followed: usize,
    curve: Vec<f64>,
    blocks: Vec<[f64; BLOCKS]>,
    /// Where the curve levels off, once it has.
    level: Option<f64>,
}

impl Course {
    fn new(radius: Option<f64>, counts: Vec<usize>) -> Self {
        Self {
            radius,
            followed: counts.iter().filter(|count| **count > 0).count(),
            counts,
            curve: Vec::new(),
            blocks: Vec::new(),
            level: None,
        }
    }

    /// The next point of time: mean logarithms of the blocks and their numbers.
    fn push(&mut self, sums: &[SumsOfLogarithms; BLOCKS], lane: usize) {
        let sums = sums.map(|sum| (sum.value(lane), sum.counts[lane]));
        let (all, count) = sums
            .iter()
            .fold((0.0, 0.0), |all, sum| (all.0 + sum.0, all.1 + sum.1));
        self.curve.push(all / count);
        self.blocks.push(sums.map(|(sum, count)| sum / count));
    }

    fn curve(&self, follow: &Follow<'_>, unit: f64, dt: f64) -> DivergenceCurve {
        let level = self.level.unwrap_or(follow.saturation);
        let points = self.curve.iter().enumerate();
        DivergenceCurve {
            radius: self.radius.map(|radius| unit * radius),
            references: self.followed,
            straight: straight_part(&self.curve, &self.blocks, level, dt),
            points: points
                .map(|(k, mean)| (k as f64 * dt, mean + libm::log(unit)))
                .collect(),
        }
    }
}

/// How neighbours are followed.
struct Follow<'a> {
    /// The points, column by column: what a neighbour does lies together. Zeros follow, so that
    /// there are always as many as lanes.
    columns: Vec<Vec<f64>>,
    references: &'a [usize],
    /// Their neighbours, the nearest first.
    found: &'a [Vec<Neighbour>],
    longest: usize,
    saturation: f64,
}

/// A point of time after another, until the distances are those of any two points: so many between
/// two looks.
const TOGETHER: usize = 2 * LANES;

impl Follow<'_> {
    /// All curves at once: the neighbours of one are among those of the next.
    fn run(&self, courses: &mut [Course]) {
        let mut from = 0;
        while from < self.longest {
            let mut open: Vec<&mut Course> = courses
                .iter_mut()
                .filter(|course| course.followed > 0 && course.level.is_none())
                .collect();
            if open.is_empty() {
                return;
            }
            let until = (from + TOGETHER).min(self.longest);
            let counts: Vec<(&[usize], usize)> = open
                .iter()
                .map(|course| (course.counts.as_slice(), course.followed))
                .collect();
            let sums: Vec<Vec<[SumsOfLogarithms; BLOCKS]>> = (from..until)
                .into_par_iter()
                .step_by(LANES)
                .map(|ahead| {
                    // With the machine's vectors, which change no bit: every point of time is a
                    // lane.
                    Arch::new().dispatch(
                        #[inline(always)]
                        || self.sums(&counts, ahead),
                    )
                })
                .collect();
            for (course, open) in open.iter_mut().enumerate() {
                for ahead in from..until {
                    let (part, lane) = ((ahead - from) / LANES, (ahead - from) % LANES);
                    open.push(&sums[part][course], lane);
                }
                open.level = self.level(&open.curve);
            }
            from = until;
        }
    }

    /// Where a curve levels off, if it does.
    fn level(&self, curve: &[f64]) -> Option<f64> {
        let last = curve.last()?;
        if *last > self.saturation - SATURATED {
            return Some(self.saturation);
        }
        // Neighbours that keep in phase, as Rössler's do, never come to be as far apart as any two
        // points.
        let highest = || curve.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        self.is_flat(curve).then(highest)
    }

    /// Whether the curve, going on as over its last half, would not rise any more by half a factor
    /// of e.
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

    /// Distances of a reference point and its neighbour from so many points ahead on. Beyond the
    /// end of the series, which no curve reaches, they mean nothing.
    #[inline(always)]
    fn distances(&self, j: usize, k: usize, ahead: usize) -> [f64; LANES] {
        let mut squares = [0.0; LANES];
        for column in &self.columns {
            let at = |i: usize| column[i + ahead..].first_chunk::<LANES>();
            if let (Some(a), Some(b)) = (at(j), at(k)) {
                for lane in 0..LANES {
                    squares[lane] += (a[lane] - b[lane]) * (a[lane] - b[lane]);
                }
            }
        }
        squares.map(f64::sqrt)
    }

    /// Some points of time that are followed together: the logarithms of the mean distances of the
    /// neighbours, for each curve and block of reference points. Distances of zero are passed over.
    /// `counts` holds for each curve how many neighbours are followed, and how many reference
    /// points have any.
    #[inline(always)]
    fn sums(&self, counts: &[(&[usize], usize)], ahead: usize) -> Vec<[SumsOfLogarithms; BLOCKS]> {
        let mut sums = vec![[SumsOfLogarithms::new(); BLOCKS]; counts.len()];
        let mut orders = vec![0; counts.len()];
        for (i, &j) in self.references.iter().enumerate() {
            let mut total = [0.0; LANES];
            let mut done = 0;
            // Each curve's neighbours are the nearest so many, and each curve has more than the one
            // before.
            for (course, (counts, followed)) in counts.iter().enumerate() {
                let count = counts[i];
                if count == 0 {
                    continue;
                }
                if count < done {
                    (total, done) = ([0.0; LANES], 0);
                }
                for &(_, k) in &self.found[i][done..count] {
                    let distances = self.distances(j, k as usize, ahead);
                    for (total, distance) in total.iter_mut().zip(distances) {
                        *total += distance;
                    }
                }
                done = count;
                let mean = total.map(|total| total / count as f64);
                let block = orders[course] * BLOCKS / followed;
                orders[course] += 1;
                sums[course][block].add(&mean);
            }
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_of_logarithms_are_those_of_each_at_any_size() {
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
        let mut sums = SumsOfLogarithms::new();
        for v in numbers {
            // One lane has other numbers, and one nothing but zeros.
            sums.add(&[v, v, 2.0, v, 0.0, v, v, v]);
        }
        let wanted: f64 = numbers.map(libm::log).iter().sum();
        for lane in [0, 1, 3, 5, 6, 7] {
            let value = sums.value(lane);
            assert!((value - wanted).abs() < 1e-12, "{value} {wanted}");
            assert_eq!(sums.counts[lane], 10.0);
        }
        assert!((sums.value(2) - 10.0 * libm::log(2.0)).abs() < 1e-13);
        assert_eq!((sums.value(4), sums.counts[4]), (0.0, 0.0));
    }
}
