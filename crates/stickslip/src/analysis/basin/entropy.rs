//! Basin entropy: how unpredictable the attractor of a start is at a given scale.

use super::grid::{Grid, indices};
use crate::error::{Error, require};
use crate::math;

/// Largest number of places of the covering along each axis from which the errors follow. Chosen,
/// to bound the time.
const MOST_PLACES: usize = 8;

/// Basin entropy of a grid of starts at one size of boxes; see [`BasinEntropy::of`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BasinEntropy {
    /// Number of boxes.
    pub boxes: usize,
    /// Number of boxes from which starts lead to two attractors or more.
    pub boundary_boxes: usize,
    /// Basin entropy `Sb`: the mean entropy of all boxes.
    pub entropy: f64,
    /// Standard error of `Sb`, by the place of the boxes.
    pub entropy_error: f64,
    /// Boundary basin entropy `Sbb`: the mean entropy of the boundary boxes; `None` where there are
    /// none.
    pub boundary_entropy: Option<f64>,
    /// Standard error of `Sbb`, by the place of the boxes; `None` where a covering has no boundary
    /// box.
    pub boundary_entropy_error: Option<f64>,
}

impl BasinEntropy {
    /// Whether `Sbb` exceeds ln 2 by more than two standard errors. Boxes on a smooth boundary hold
    /// two attractors, except for a vanishing fraction of them. So the boundary is then fractal.
    /// The converse does not hold.
    pub fn shows_fractal(&self) -> bool {
        let known = self.boundary_entropy.zip(self.boundary_entropy_error);
        known.is_some_and(|(entropy, error)| entropy - 2.0 * error > std::f64::consts::LN_2)
    }
}

impl BasinEntropy {
    /// Basin entropy of starts on a regular grid, in boxes of `side` starts along each axis.
    ///
    /// In a box of which the part `p_j` leads to attractor `j`, the entropy is `−Σ p_j ln p_j`.
    /// `Sb` is its mean over all boxes of a covering, `Sbb` that over the boxes with two attractors
    /// or more. Both are of Daza, Wagemakers, Georgeot, Guéry-Odelin & Sanjuán, *Scientific
    /// Reports* 6 (2016) 31416.
    ///
    /// The covering begins at the first start. Standard errors are the spread of the values from
    /// coverings that begin elsewhere, at up to eight places along each axis.
    ///
    /// `reached` has the number of the attractor of each start, `shape` the number of starts along
    /// each axis. The last axis varies fastest.
    ///
    /// ```
    /// use stickslip::analysis::BasinEntropy;
    ///
    /// // One basin in four columns of eight: the boundary lies between boxes.
    /// let reached: Vec<usize> = (0..64).map(|k| usize::from(k % 8 >= 4)).collect();
    /// assert_eq!(BasinEntropy::of(&reached, &[8, 8], 4)?.entropy, 0.0);
    /// // A quarter of each box on the boundary belongs to the second basin.
    /// let reached: Vec<usize> = (0..64).map(|k| usize::from(k % 8 >= 3)).collect();
    /// let found = BasinEntropy::of(&reached, &[8, 8], 4)?;
    /// let quarter = 0.25 * 4f64.ln() + 0.75 * (4f64 / 3.0).ln();
    /// assert_eq!((found.boxes, found.boundary_boxes), (4, 2));
    /// assert!((found.boundary_entropy.unwrap() - quarter).abs() < 1e-15);
    /// assert!((found.entropy - 0.5 * quarter).abs() < 1e-15);
    /// # Ok::<(), stickslip::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Option`] where the shape is not that of the starts. A `side` below 2 is one, too,
    /// and one that does not divide each axis into two boxes or more.
    pub fn of(reached: &[usize], shape: &[usize], side: usize) -> Result<BasinEntropy, Error> {
        let grid = Grid::new(reached, shape)?;
        let divides = |points: &usize| points.is_multiple_of(side) && points / side >= 2;
        let is_allowed = side >= 2 && shape.iter().all(divides);
        let bound =
            "at least 2, and such that it divides each axis of the grid into 2 boxes or more";
        require(is_allowed, "side", side as f64, bound)?;
        let places = side.min(MOST_PLACES);
        let counts = vec![places; shape.len()];
        let mut coverings = indices(&counts).map(|place| {
            let origin: Vec<usize> = place.iter().map(|k| k * side / places).collect();
            covering(&grid, &origin, side)
        });
        let Some(first) = coverings.next() else {
            return Err(Error::Option {
                name: "side",
                value: side as f64,
                bound,
            });
        };
        let all: Vec<Covering> = std::iter::once(first).chain(coverings).collect();
        let boundary: Option<Vec<f64>> = all.iter().map(|one| one.of_boundary).collect();
        Ok(BasinEntropy {
            boxes: first.boxes,
            boundary_boxes: first.boundary_boxes,
            entropy: first.of_all,
            entropy_error: spread(&all.iter().map(|one| one.of_all).collect::<Vec<_>>()),
            boundary_entropy: first.of_boundary,
            boundary_entropy_error: boundary.map(|all| spread(&all)),
        })
    }
}

/// Entropies of one covering by boxes.
#[derive(Clone, Copy)]
struct Covering {
    boxes: usize,
    boundary_boxes: usize,
    of_all: f64,
    of_boundary: Option<f64>,
}

/// The covering by all boxes that fit behind an origin.
fn covering(grid: &Grid<'_>, origin: &[usize], side: usize) -> Covering {
    let strides = grid.strides();
    let counts = grid.shape.iter().zip(origin);
    let counts: Vec<usize> = counts
        .map(|(points, first)| (points - first) / side)
        .collect();
    let within: Vec<usize> = indices(&vec![side; counts.len()])
        .map(|index| {
            index
                .iter()
                .zip(&strides)
                .map(|(k, stride)| k * stride)
                .sum()
        })
        .collect();
    let (mut sum, mut boundary_boxes) = (0.0, 0);
    let mut boxes = 0;
    let mut numbers: Vec<(usize, usize)> = Vec::new();
    for index in indices(&counts) {
        let corners = index.iter().zip(origin).zip(&strides);
        let corner: usize = corners
            .map(|((k, first), stride)| (first + k * side) * stride)
            .sum();
        numbers.clear();
        for offset in &within {
            let number = grid.reached[corner + offset];
            match numbers.iter_mut().find(|(known, _)| *known == number) {
                Some((_, count)) => *count += 1,
                None => numbers.push((number, 1)),
            }
        }
        boxes += 1;
        if numbers.len() > 1 {
            boundary_boxes += 1;
            let part = |&(_, count): &(usize, usize)| count as f64 / within.len() as f64;
            sum -= numbers
                .iter()
                .map(part)
                .map(|p| p * math::ln(p))
                .sum::<f64>();
        }
    }
    Covering {
        boxes,
        boundary_boxes,
        of_all: sum / boxes as f64,
        of_boundary: (boundary_boxes > 0).then(|| sum / boundary_boxes as f64),
    }
}

/// Standard deviation.
fn spread(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|one| (one - mean) * (one - mean)).sum();
    (squares / (n - 1.0)).sqrt()
}
