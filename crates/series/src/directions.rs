//! The directions in which the points of a series spread.
//!
//! Around a point of a smooth manifold of dimension m, neighbours within r lie at distances of
//! order r in m directions. In further directions they lie at distances of order r² or less, by the
//! curvature of the manifold. Distances due to noise do not depend on r. The slope of `log s_i`
//! over `log r`, with `s_i` the singular values of the neighbour matrix, distinguishes the three.

use super::cloud::Cloud;
use super::error::DataError;
use super::fit::Decomposed;
use super::least_squares::Scratch;
use super::matrix::Row;
use super::neighbours::{Finder, POINTS_PER_NEIGHBOUR};
use super::progress::in_parallel;
use super::series::MAX_COLUMNS;
use super::settings::DataSettings;
use super::tree::Neighbour;
use numerics::{PowerLaw, upper_median};

/// Number of neighbourhood sizes compared.
const SIZES: usize = 4;
/// Number of points sampled evenly from the series. The median of their slopes has an error of a
/// twentieth of the scatter.
const SAMPLES: usize = 512;
/// Ratio of the numbers of points in the largest and smallest neighbourhoods, where the series is
/// long enough. The ratio of radii is then four in two dimensions, and two in four.
const COUNT_RATIO: usize = 16;
/// Least ratio of the radii of the largest and smallest neighbourhoods for which a slope is
/// measured. The error of a slope is that of the singular values, over the logarithm of this.
const LEAST_RADIUS_RATIO: f64 = 1.2;

/// Spread of the neighbours in a direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DirectionKind {
    /// Spread in proportion to the size of the neighbourhood: the manifold extends there.
    Tangent,
    /// Spread with a higher power of the size: the manifold curves into this direction. The
    /// neighbours carry no information on a perturbation along it.
    Curvature,
    /// Spread to the same extent at all sizes.
    Noise,
    /// Spread not beyond rounding.
    Flat,
}

impl DirectionKind {
    /// A word for tables.
    pub fn word(self) -> &'static str {
        match self {
            DirectionKind::Tangent => "tangent",
            DirectionKind::Curvature => "curvature",
            DirectionKind::Noise => "noise",
            DirectionKind::Flat => "flat",
        }
    }
}

/// One direction of the neighbourhoods, the widest first.
#[derive(Clone, Debug, PartialEq)]
pub struct Direction {
    /// Spread of the neighbours in the direction.
    pub kind: DirectionKind,
    /// Median slope of the singular value over the radius, both logarithmic; NaN for a flat
    /// direction.
    pub slope: f64,
    /// Median radius and median singular value per root of the number of neighbours, in the unit of
    /// the data, at sizes from small to large.
    pub sizes: Vec<(f64, f64)>,
}

/// The spread of the neighbours of one point.
struct LocalSpread {
    radius: [f64; SIZES],
    /// The singular values at each size.
    sizes: [Row; SIZES],
    /// NaN where a singular value is zero at some size.
    slopes: Row,
}

/// Settings and workspace of the measurement at a point.
struct Probe<'a> {
    cloud: &'a Cloud,
    finder: &'a Finder<'a>,
    settings: &'a DataSettings,
    /// Neighbours at each size.
    counts: [usize; SIZES],
}

/// Measures the directions. `smallest` is the number of neighbours in the smallest neighbourhood.
pub(crate) fn measure(
    (cloud, finder): (&Cloud, &Finder<'_>),
    settings: &DataSettings,
    smallest: usize,
    goes_on: &dyn Fn() -> Result<(), DataError>,
) -> Result<Vec<Direction>, DataError> {
    let points = cloud.points.len() - settings.step;
    let every = points.div_ceil(SAMPLES).max(1);
    let probe = Probe {
        cloud,
        finder,
        settings,
        counts: counts(smallest, points),
    };
    let spreads = in_parallel(
        points.div_ceil(every),
        goes_on,
        || (Scratch::default(), Vec::new()),
        |(scratch, nearest), i| probe.spread(i * every, scratch, nearest),
    )?;
    let spreads: Vec<LocalSpread> = spreads.into_iter().flatten().collect();
    let columns = 0..cloud.points.columns();
    Ok(columns
        .map(|i| direction(&spreads, i, cloud.unit))
        .collect())
}

/// Numbers of neighbours, in geometric progression.
fn counts(smallest: usize, points: usize) -> [usize; SIZES] {
    let largest = (COUNT_RATIO * smallest).min((points / POINTS_PER_NEIGHBOUR).max(4 * smallest));
    let ratio = largest as f64 / smallest as f64;
    std::array::from_fn(|level| {
        let part = level as f64 / (SIZES - 1) as f64;
        (smallest as f64 * libm::pow(ratio, part)).round() as usize
    })
}

impl Probe<'_> {
    fn spread(
        &self,
        j: usize,
        scratch: &mut Scratch,
        nearest: &mut Vec<Neighbour>,
    ) -> Option<LocalSpread> {
        let (cloud, settings) = (self.cloud, self.settings);
        let most = self.counts[SIZES - 1];
        self.finder.nearest(j, most, f64::INFINITY, nearest);
        let mut spread = LocalSpread {
            radius: [0.0; SIZES],
            sizes: [[0.0; MAX_COLUMNS]; SIZES],
            slopes: [0.0; MAX_COLUMNS],
        };
        for (level, &count) in self.counts.iter().enumerate() {
            let inside = nearest.get(..count)?;
            spread.radius[level] = inside.last()?.0.sqrt();
            let decomposed = Decomposed::new(scratch, cloud, (j, inside), false, settings);
            let root = (count as f64).sqrt();
            let sizes = decomposed.sizes().map(|s| s / root);
            let zero = cloud.rounding.max(settings.rank_tolerance * sizes[0]);
            for (slope, size) in spread.slopes.iter_mut().zip(sizes) {
                if size <= zero {
                    *slope = f64::NAN;
                }
            }
            spread.sizes[level] = sizes;
        }
        if spread.radius[SIZES - 1] < LEAST_RADIUS_RATIO * spread.radius[0] {
            return None;
        }
        for (i, slope) in spread.slopes.iter_mut().enumerate() {
            if !slope.is_nan() {
                let sizes = spread.sizes.iter().map(|sizes| sizes[i]);
                *slope = PowerLaw::through(spread.radius.into_iter().zip(sizes)).exponent;
            }
        }
        Some(spread)
    }
}

fn direction(spreads: &[LocalSpread], i: usize, unit: f64) -> Direction {
    let slopes: Vec<f64> = spreads
        .iter()
        .map(|spread| spread.slopes[i])
        .filter(|slope| !slope.is_nan())
        .collect();
    let sizes = (0..SIZES)
        .map(|level| {
            let radius = upper_median(spreads.iter().map(|spread| spread.radius[level]));
            let size = upper_median(spreads.iter().map(|spread| spread.sizes[level][i]));
            (unit * radius, unit * size)
        })
        .collect();
    // Flat where it is flat at most points, and where no point has a slope.
    let (kind, slope) = if 2 * slopes.len() <= spreads.len() {
        (DirectionKind::Flat, f64::NAN)
    } else {
        let slope = upper_median(slopes);
        // The nearest of the slopes 0 of noise, 1 of a tangent direction and 2 of curvature.
        let kind = if slope < 0.5 {
            DirectionKind::Noise
        } else if slope <= 1.5 {
            DirectionKind::Tangent
        } else {
            DirectionKind::Curvature
        };
        (kind, slope)
    };
    Direction { kind, slope, sizes }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::series::Series;

    #[test]
    fn counts_grow_geometrically_and_stay_a_small_part() {
        assert_eq!(counts(20, 45_000), [20, 50, 127, 320]);
        assert_eq!(counts(20, 500), [20, 32, 50, 80]);
    }

    #[test]
    fn a_point_whose_neighbourhoods_do_not_differ_in_size_has_no_spread() {
        // A circle and its centre.
        let rows = (0..300).map(|i| {
            let angle = std::f64::consts::TAU * f64::from(i) / 300.0;
            let radius = f64::from(u8::from(i != 150));
            [radius * libm::cos(angle), radius * libm::sin(angle)]
        });
        let cloud = Cloud::new(&Series::from_rows(rows, 1.0).unwrap()).unwrap();
        let finder = Finder::new(&cloud, 1, 0).unwrap();
        // Nothing is cut off.
        let settings = DataSettings {
            rank_tolerance: 0.0,
            ..DataSettings::default()
        };
        let probe = Probe {
            cloud: &cloud,
            finder: &finder,
            settings: &settings,
            counts: counts(20, 300),
        };
        let has_spread = |j| {
            let mut scratch = Scratch::default();
            probe.spread(j, &mut scratch, &mut Vec::new()).is_some()
        };
        assert!(has_spread(10) && !has_spread(150));
    }

    #[test]
    fn a_direction_is_flat_unless_more_than_half_of_the_points_have_a_slope_there() {
        for (with_slope, kind) in [
            (0, DirectionKind::Flat),
            (5, DirectionKind::Flat),
            (6, DirectionKind::Tangent),
            (10, DirectionKind::Tangent),
        ] {
            let spreads = (0..10).map(|i| LocalSpread {
                radius: [1.0, 2.0, 4.0, 8.0],
                sizes: [0.5, 1.0, 2.0, 4.0].map(|size| [size; MAX_COLUMNS]),
                slopes: [if i < with_slope { 1.0 } else { f64::NAN }; MAX_COLUMNS],
            });
            // The points are in units of 3 of the data.
            let found = direction(&spreads.collect::<Vec<_>>(), 0, 3.0);
            assert_eq!(found.kind, kind, "{with_slope}");
            assert_eq!(
                found.sizes,
                [(3.0, 1.5), (6.0, 3.0), (12.0, 6.0), (24.0, 12.0)]
            );
        }
    }
}
