//! The uncertainty exponent of a basin boundary, and the boundary's dimension.

use numerics::PowerLaw;

use super::grid::{Grid, indices};
use crate::error::{Error, require};

/// Part of the shortest axis up to which starts are compared. Chosen: farther apart, the law of
/// small distances need not hold.
const LARGEST_PART: usize = 16;

/// Fewest points along an axis: with three distances, 1, 2 and 4.
const FEWEST_POINTS: usize = 64;

/// Number of parts of the grid, each of which is left out once for the errors. Chosen.
const PARTS: usize = 16;

/// Uncertainty exponent and dimension of the boundary between basins; see
/// [`UncertaintyExponent::of`].
#[derive(Clone, Debug, PartialEq)]
pub struct UncertaintyExponent {
    /// The exponent `α` of `f ~ ε^α`.
    pub exponent: f64,
    /// Standard error of the exponent, and of the dimension.
    pub std_error: f64,
    /// Dimension of the boundary: that of the space of starts less `α`.
    pub dimension: f64,
    /// Distances `ε` in steps of the grid, with the fraction `f` of uncertain pairs.
    pub fractions: Vec<(usize, f64)>,
}

impl UncertaintyExponent {
    /// The uncertainty exponent of starts on a regular grid; `None` where at some distance no pair
    /// is uncertain, as without a boundary.
    ///
    /// Two starts at a distance `ε` along an axis are uncertain if they lead to different
    /// attractors. Their fraction among all pairs is `f ~ ε^α`, and the boundary has the dimension
    /// `D − α` in a space of dimension `D`. A smooth boundary has `α = 1`. The smaller `α`, the
    /// less a smaller error of the start helps to predict its attractor. Sources: Grebogi,
    /// McDonald, Ott & Yorke, *Physics Letters A* 99 (1983) 415; McDonald, Grebogi, Ott & Yorke,
    /// *Physica D* 17 (1985) 125.
    ///
    /// Distances are 1, 2, 4, … steps of the grid, up to a sixteenth of the shortest axis. The
    /// exponent is the slope of `ln f` over `ln ε` by least squares. Its standard error is the
    /// larger of that slope's and of a jackknife that leaves out one of sixteen parts of the first
    /// axis.
    ///
    /// `reached` has the number of the attractor of each start, `shape` the number of starts along
    /// each axis. The last axis varies fastest.
    ///
    /// ```
    /// use stickslip::analysis::UncertaintyExponent;
    ///
    /// // A straight boundary: of starts that are k columns apart, k in each row are uncertain.
    /// let reached: Vec<usize> = (0..128 * 128).map(|k| usize::from(k % 128 >= 50)).collect();
    /// let found = UncertaintyExponent::of(&reached, &[128, 128])?.unwrap();
    /// assert!((found.exponent - 1.0).abs() < 1e-12 && (found.dimension - 1.0).abs() < 1e-12);
    /// # Ok::<(), stickslip::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Option`] where the shape is not that of the starts, or an axis has fewer than 64.
    pub fn of(reached: &[usize], shape: &[usize]) -> Result<Option<UncertaintyExponent>, Error> {
        let grid = Grid::new(reached, shape)?;
        let shortest = grid.shortest();
        let bound = "64 starts along each axis, or more";
        require(shortest >= FEWEST_POINTS, "shape", shortest as f64, bound)?;
        let steps: Vec<usize> = (0..usize::BITS)
            .map(|power| 1 << power)
            .take_while(|step| step * LARGEST_PART <= shortest)
            .collect();
        let largest = shortest / LARGEST_PART;
        let of_parts: Vec<Vec<Pairs>> = steps
            .iter()
            .map(|step| pairs(&grid, *step, largest))
            .collect();
        let fractions = |left_out: Option<usize>| -> Vec<(usize, f64)> {
            let of_step = |(step, parts): (&usize, &Vec<Pairs>)| {
                let kept = parts.iter().enumerate();
                let kept = kept.filter(|(part, _)| Some(*part) != left_out);
                let (mut uncertain, mut all) = (0, 0);
                for (_, pairs) in kept {
                    uncertain += pairs.uncertain;
                    all += pairs.all;
                }
                (*step, uncertain as f64 / all as f64)
            };
            steps.iter().zip(&of_parts).map(of_step).collect()
        };
        let law = |left_out| {
            let points = fractions(left_out);
            let is_complete = points.iter().all(|(_, fraction)| *fraction > 0.0);
            let points = points
                .into_iter()
                .map(|(step, fraction)| (step as f64, fraction));
            is_complete.then(|| PowerLaw::through(points))
        };
        let Some(found) = law(None) else {
            return Ok(None);
        };
        // A part that holds the whole boundary cannot be left out, and the others have no effect.
        let others = (0..PARTS).filter_map(|part| Some(law(Some(part))?.exponent));
        let others: Vec<f64> = others.collect();
        let parts = others.len() as f64;
        let mean = others.iter().sum::<f64>() / parts;
        let squares: f64 = others.iter().map(|one| (one - mean) * (one - mean)).sum();
        let jackknife = ((parts - 1.0) / parts * squares).sqrt();
        Ok(Some(UncertaintyExponent {
            exponent: found.exponent,
            std_error: jackknife.max(found.std_error),
            dimension: shape.len() as f64 - found.exponent,
            fractions: fractions(None),
        }))
    }
}

/// Pairs of starts at one distance.
#[derive(Clone, Copy, Default)]
struct Pairs {
    uncertain: usize,
    all: usize,
}

/// The pairs that are so many steps apart along an axis, by parts of the first axis. The first of
/// a pair is at least `largest` steps from the edge towards which the second lies. The same starts
/// are then compared at all distances.
fn pairs(grid: &Grid<'_>, step: usize, largest: usize) -> Vec<Pairs> {
    let mut parts = vec![Pairs::default(); PARTS];
    let strides = grid.strides();
    for (axis, stride) in strides.iter().enumerate() {
        let mut counts = grid.shape.to_vec();
        counts[axis] -= largest;
        for index in indices(&counts) {
            let at: usize = index
                .iter()
                .zip(&strides)
                .map(|(k, stride)| k * stride)
                .sum();
            let from_end = at + largest * stride;
            for (one, other) in [
                (at, at + step * stride),
                (from_end, from_end - step * stride),
            ] {
                let row = one / strides[0];
                let part = &mut parts[row * PARTS / grid.shape[0]];
                part.all += 1;
                part.uncertain += usize::from(grid.reached[one] != grid.reached[other]);
            }
        }
    }
    parts
}
