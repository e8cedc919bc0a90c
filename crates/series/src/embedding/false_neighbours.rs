//! The number of values that form a state: false nearest neighbours (Kennel, Brown and Abarbanel,
//! Phys. Rev. A 45, 3403, 1992) and Cao's averages (Physica D 110, 43, 1997), both from the nearest
//! neighbour of each point at every dimension.

use super::delay::Embedding;
use crate::cloud::Cloud;
use crate::error::DataError;
use crate::neighbours::Finder;
use crate::progress::in_parallel;
use crate::series::Series;

/// Number of points whose nearest neighbour is examined, spread evenly over the series. A fraction
/// of 1 % of them has a standard error of 0.2 %.
const SAMPLES: usize = 2000;
/// A neighbour is false if the next value differs by more than this many times its distance.
/// Kennel: 10 or more separate clearly.
const FALSE_RATIO: f64 = 15.0;
/// A neighbour is also false if its distance with the next value is more than this many times the
/// spread of the series. This is Kennel's second criterion, for points without near neighbours.
const FALSE_SPREADS: f64 = 2.0;

/// Statistics of one dimension, or of the nearest neighbour of one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NeighbourStatistics {
    /// Fraction of the nearest neighbours that are false.
    pub(crate) false_part: f64,
    /// Cao's E: mean ratio of the distances with and without the next value, in the maximum norm.
    pub(crate) stretching: f64,
    /// Cao's E*: mean difference of the next values.
    pub(crate) next_difference: f64,
}

/// Compares nearest neighbours in `dimension` delayed values by the next value. Returns `None` if
/// no point has a neighbour.
///
/// # Errors
/// [`DataError::Span`] if no point has a next value, [`DataError::Constant`],
/// [`DataError::Overflow`].
pub(crate) fn statistics(
    series: &Series,
    embedding: Embedding,
    theiler: usize,
    spread: f64,
    goes_on: &dyn Fn() -> Result<(), DataError>,
) -> Result<Option<NeighbourStatistics>, DataError> {
    // Checks that the next value exists.
    let next = Embedding {
        dimension: embedding.dimension + 1,
        ..embedding
    };
    if series.len() <= next.span() {
        return Err(DataError::Span {
            rows: series.len(),
            delay: next.delay,
            dimension: next.dimension,
            needed: next.span().saturating_add(1),
        });
    }
    let embedded = embedding.of(series)?;
    let cloud = Cloud::new(&embedded)?;
    // Points less than one delay before the end have no next value.
    let finder = Finder::new(&cloud, embedding.delay, theiler.min(series.len()))?;
    let points = cloud.points.len() - embedding.delay;
    let every = points.div_ceil(SAMPLES).max(1);
    let columns = series.columns();
    let ahead = embedding.delay * embedding.dimension;
    let neighbours = in_parallel(
        points.div_ceil(every),
        goes_on,
        Vec::new,
        |nearest, i| -> Option<NeighbourStatistics> {
            let j = i * every;
            finder.nearest(j, 1, f64::INFINITY, nearest);
            let &(square, k) = nearest.first()?;
            let k = k as usize;
            let coordinates = cloud.points[j].iter().zip(&cloud.points[k]);
            let largest = coordinates.fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
            let (mut next_square, mut next_largest): (f64, f64) = (0.0, 0.0);
            for column in 0..columns {
                let value = |row: usize| series.values()[(row + ahead) * columns + column];
                let difference = value(j) / cloud.unit - value(k) / cloud.unit;
                next_square += difference * difference;
                next_largest = next_largest.max(difference.abs());
            }
            let is_far = (square + next_square).sqrt() > FALSE_SPREADS * spread / cloud.unit;
            let is_false = next_square > FALSE_RATIO * FALSE_RATIO * square || is_far;
            Some(NeighbourStatistics {
                false_part: f64::from(u8::from(is_false)),
                stretching: largest.max(next_largest) / largest,
                next_difference: next_largest * cloud.unit,
            })
        },
    )?;
    let neighbours: Vec<NeighbourStatistics> = neighbours.into_iter().flatten().collect();
    let count = neighbours.len() as f64;
    let mean = |of: fn(&NeighbourStatistics) -> f64| neighbours.iter().map(of).sum::<f64>() / count;
    Ok((!neighbours.is_empty()).then(|| NeighbourStatistics {
        false_part: mean(|one| one.false_part),
        stretching: mean(|one| one.stretching),
        next_difference: mean(|one| one.next_difference),
    }))
}
