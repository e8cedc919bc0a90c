//! Standard errors, correlations, and what the data do not determine.

use crate::study::least_squares::{LeastSquares, LeastSquaresEnd, Loss};
use stickslip::dynamics::{Matrix, Vector};

use super::Modelled;
use super::crossing::passable;
use super::directions::{Directions, ERROR_OF_DERIVATIVES};
use super::problem::{FitProblem, Sequence};
use super::statistics::quantile;

/// Halvings to a change of the sequence, and the part of the whole change that is left there where
/// residuals are continuous: a square root has a thousandth.
const HALVINGS: u32 = 20;
pub(super) const JUMP: f64 = 1e-2;

/// Distance from the linear model, over the change itself, above which intervals are doubtful. It
/// is chosen.
const DOUBTFUL: f64 = 0.3;

/// Uncertainties of a fit, from the singular values of its derivatives.
#[derive(Clone, Debug, PartialEq)]
pub struct FitUncertainty {
    /// Standard error of each unknown: none on a bound, where the data do not determine it, or for
    /// [`Self::none`].
    pub std_errors: Vec<Option<f64>>,
    /// Covariances of the unknowns; NaN where there are none.
    pub covariance: Matrix,
    /// Quantile of the 95 % intervals: half their width over the standard error.
    pub quantile: f64,
    /// Combinations that the data do not determine: for each unknown its part, relative to its
    /// value, of which the largest is 1.
    pub undetermined: Vec<Vec<(String, f64)>>,
    /// Reason for which there is no standard error at all.
    pub none: Option<String>,
    /// Distance of the residuals from the linear model within one standard error, relative to
    /// their change; none where only rounding is left.
    pub bend: Option<f64>,
}

impl FitUncertainty {
    /// Whether the model is so curved within a standard error that intervals are doubtful.
    pub fn is_doubtful(&self) -> bool {
        self.bend.is_some_and(|bend| bend > DOUBTFUL)
    }

    /// Correlations of the unknowns; NaN where there are none.
    pub fn correlations(&self) -> Matrix {
        let covariance = &self.covariance;
        Matrix::from_fn(covariance.nrows(), covariance.ncols(), |i, k| {
            covariance[(i, k)] / (covariance[(i, i)] * covariance[(k, k)]).sqrt()
        })
    }

    pub(super) fn of(problem: &FitProblem<'_>, best: &LeastSquares<Sequence>) -> Self {
        let count = best.x.len();
        // The starts of parts come last, and are no results.
        let named = problem.unknowns.named();
        let mut own = FitUncertainty {
            std_errors: vec![None; named],
            covariance: Matrix::repeat(named, named, f64::NAN),
            quantile: quantile(None),
            undetermined: Vec::new(),
            none: None,
            bend: None,
        };
        let Ok(at) = problem.modelled(&best.x) else {
            own.none = Some("the run fails there".to_owned());
            return own;
        };
        if problem.is_estimated() {
            own.quantile = quantile(Some(problem.freedom(&at.residuals)));
        }
        let bounds = problem.unknowns.bounds();
        let is_inside = |&k: &usize| best.x[k] > bounds[k].0 && best.x[k] < bounds[k].1;
        let inside: Vec<usize> = (0..count).filter(is_inside).collect();
        if inside.is_empty() {
            return own;
        }
        let columns = at.jacobian.select_columns(&inside);
        let found = Directions::of(&columns, problem.mismatches(), problem.tolerance());
        let Directions { determined, open } = match found {
            Ok(found) => found,
            Err(why) => {
                own.none = Some(why.to_owned());
                return own;
            }
        };
        let data = problem.of_data(&at.residuals);
        let freedom = problem.freedom(&at.residuals);
        let factor = variance_factor(problem.loss(), &data, freedom).sqrt();
        let directions: Vec<Vector> = determined.iter().map(|one| one * factor).collect();
        let mut is_open = vec![false; inside.len()];
        for direction in open {
            let relative = direction.iter().zip(&inside).map(|(part, &k)| {
                let value = best.x[k].abs();
                part / if value > 0.0 { value } else { 1.0 }
            });
            let relative: Vec<f64> = relative.collect();
            let most = relative
                .iter()
                .fold(0.0_f64, |a, b| if b.abs() > a.abs() { *b } else { a });
            let mut named = Vec::new();
            for ((part, &k), open) in relative.iter().zip(&inside).zip(&mut is_open) {
                let part = part / most;
                // Less is rounding of the singular vectors.
                if part.abs() > 1e-6 && !problem.unknowns.name(k).is_empty() {
                    named.push((problem.unknowns.name(k).to_owned(), part));
                    *open = true;
                }
            }
            own.undetermined.push(named);
        }
        // Parts follow a record that no orbit does; each direction would take a run of all.
        if problem.parts.is_none() {
            own.check_around(problem, (best, &at), (&inside, &directions));
        }
        if best.end == LeastSquaresEnd::Change {
            own.none = Some("the minimum lies where the sequence of phases changes".to_owned());
        }
        // The passage of an event says more than a change of the phases.
        if problem.may_jump() {
            let whole = |direction: &Vector| {
                let mut whole = Vector::zeros(count);
                for (&k, part) in inside.iter().zip(direction) {
                    whole[k] = *part;
                }
                whole
            };
            let directions: Vec<Vector> = directions.iter().map(whole).collect();
            let at = problem.modelled_beyond(&best.x).unwrap_or(at);
            let passable = passable(problem, &at, &directions).into_iter().next();
            if let Some(first) = passable {
                own.none = Some(first.describe(problem));
            }
        }
        if own.none.is_some() {
            return own;
        }
        let reported = || inside.iter().enumerate().filter(|(_, k)| **k < named);
        for (i, &k) in reported() {
            for (j, &l) in reported() {
                if !is_open[i] && !is_open[j] {
                    let products = directions.iter().map(|of| of[i] * of[j]);
                    own.covariance[(k, l)] = products.sum();
                }
            }
            if !is_open[i] {
                own.std_errors[k] = Some(own.covariance[(k, k)].sqrt());
            }
        }
        own
    }

    /// Looks one standard deviation along each direction for what the linear model misses.
    fn check_around(
        &mut self,
        problem: &FitProblem<'_>,
        (best, at): (&LeastSquares<Sequence>, &Modelled),
        (inside, directions): (&[usize], &[Vector]),
    ) {
        let bounds = problem.unknowns.bounds();
        let rounding = ERROR_OF_DERIVATIVES * problem.tolerance() * {
            let columns = at.sizes.iter();
            let columns = columns.flat_map(|record| record.iter().zip(&problem.sigmas));
            let sizes = columns.flat_map(|(sizes, sigma)| sizes.iter().map(move |v| v / sigma));
            sizes.map(|size| size * size).sum::<f64>().sqrt()
        };
        let here = at.sequence();
        for direction in directions {
            for sign in [-1.0, 1.0] {
                let mut step = Vector::zeros(best.x.len());
                for (&k, part) in inside.iter().zip(direction) {
                    step[k] = sign * part;
                }
                let x = &best.x + &step;
                if x.iter()
                    .zip(&bounds)
                    .any(|(x, (low, high))| x < low || x > high)
                {
                    continue;
                }
                let linear = &at.jacobian * &step;
                if linear.norm() <= rounding {
                    continue;
                }
                let Ok(there) = problem.modelled(&x) else {
                    self.none = Some("within one standard error a run fails".to_owned());
                    return;
                };
                let change = &there.residuals - &at.residuals;
                let bend = (&change - &linear).norm() / linear.norm();
                self.bend = Some(self.bend.map_or(bend, |known| known.max(bend)));
                if there.sequence() != here {
                    let left = jump_on_the_way(problem, (&best.x, at), (&step, there));
                    if left.is_none_or(|left| left > JUMP * linear.norm()) {
                        let why = "within one standard error the sequence of phases changes, and \
                                   what is observed jumps there";
                        self.none = Some(why.to_owned());
                        return;
                    }
                }
            }
        }
    }
}

/// Change of the residuals across the first change of the sequence that bisection finds on the way;
/// none where a run fails.
fn jump_on_the_way(
    problem: &FitProblem<'_>,
    (x, at): (&Vector, &Modelled),
    (step, there): (&Vector, Modelled),
) -> Option<f64> {
    let (mut low, mut high) = (0.0, 1.0);
    let (mut before, mut beyond) = (at.clone(), there);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        let now = problem.modelled(&(x + step * middle)).ok()?;
        if now.sequence() == at.sequence() {
            (low, before) = (middle, now);
        } else {
            (high, beyond) = (middle, now);
        }
    }
    Some((beyond.residuals - before.residuals).norm())
}

/// Variance of the estimate over that of squares with known deviations (Huber, *Robust Statistics*,
/// 1981, section 7.6).
fn variance_factor(loss: Loss, residuals: &Vector, freedom: usize) -> f64 {
    if loss == Loss::Squares {
        return 1.0;
    }
    let count = residuals.len() as f64;
    let (mut squares, mut slopes) = (0.0, 0.0);
    for residual in residuals {
        let (influence, slope) = loss.influence(*residual);
        squares += influence * influence;
        slopes += slope;
    }
    let slope = slopes / count;
    squares / freedom as f64 / (slope * slope)
}
