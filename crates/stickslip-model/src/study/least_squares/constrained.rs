//! Least squares under equality constraints, by elimination.

use super::{
    Iterate, LEAST_RATIO, LeastSquares, LeastSquaresEnd, LeastSquaresSettings, Minimisation, Model,
    Residuals,
};
use stickslip::dynamics::{Matrix, Vector};
use stickslip::math::product;
use stickslip::nalgebra::QR;

/// Part of the radius within which a step goes to the constraints (Byrd and Omojokun).
const NORMAL_PART: f64 = 0.8;

/// Part of the penalty's predicted decrease that the whole merit is predicted to decrease by.
const MERIT_PART: f64 = 0.3;

/// Minimises half the sum of squares of the residuals within bounds, under the constraints that the
/// last residuals are zero: from a point that need not fulfil them.
///
/// Each step is that of Gauss and Newton with linear constraints, which are eliminated (Bock,
/// *Modelling of Chemical Reaction Systems*, 1981, 102). It is the sum of the shortest step to them
/// and the best one in their null space. Both share a trust region (Omojokun's method; Nocedal and
/// Wright,
/// *Numerical Optimization*, 2006, section 18.5). A step is judged by the cost and a multiple of
/// the size of the constraints, which grows as needed.
///
/// A variable on its bound is fixed while the step leads out. An evaluation that fails shortens the
/// step. [`LeastSquares::cost`] is that of the residuals without the constraints.
///
/// # Errors
/// That of the first evaluation.
pub fn constrained_least_squares<P: PartialEq, E>(
    x: &Vector,
    settings: &LeastSquaresSettings,
    mut at: impl FnMut(&Vector) -> Result<Residuals<P>, E>,
) -> Result<LeastSquares<P>, E> {
    let mut search = Minimisation {
        evaluations: 1,
        failures: 0,
        settings,
        at: |x: &Vector| at(x),
    };
    let here = Iterate::of(x.clone(), (search.at)(x)?, settings.loss);
    Ok(search.constrained(here))
}

/// An orthonormal basis of the vectors that a matrix of independent rows maps to zero.
pub fn null_space(matrix: &Matrix) -> Matrix {
    let (rows, columns) = matrix.shape();
    full_basis(matrix)
        .columns_range(rows.min(columns)..)
        .into_owned()
}

/// An orthogonal matrix whose first columns span the rows of a matrix.
fn full_basis(matrix: &Matrix) -> Matrix {
    let size = matrix.ncols();
    if matrix.nrows() == 0 {
        return Matrix::identity(size, size);
    }
    let mut padded = Matrix::zeros(size, size);
    let rows = matrix.nrows().min(size);
    let used = matrix.rows(0, rows).transpose();
    padded.columns_mut(0, rows).copy_from(&used);
    QR::new(padded).q()
}

impl<P> Iterate<P> {
    /// The cost without the constraints.
    fn cost_of_data(&self) -> f64 {
        let gap = self.gap();
        self.cost - 0.5 * gap * gap
    }

    /// Size of the constraints.
    fn gap(&self) -> f64 {
        self.constraints().norm()
    }

    fn data_rows(&self) -> usize {
        self.values.len().saturating_sub(self.at.constraints)
    }

    fn constraints(&self) -> Vector {
        let from = self.data_rows();
        self.values.rows_range(from..).into_owned()
    }
}

/// The linear model around a point, in scaled variables that can move.
struct ReducedModel {
    free: Vec<usize>,
    /// Derivatives of data and constraints.
    of_data: Matrix,
    of_constraints: Matrix,
    data: Vector,
    /// Orthonormal bases: of the rows of the constraints, and of their null space.
    range: Matrix,
    null: Matrix,
}

impl ReducedModel {
    fn of<P>(here: &Iterate<P>, scale: &Vector, free: Vec<usize>) -> Self {
        let rows = here.data_rows();
        let mut scaled = Matrix::zeros(here.values.len(), free.len());
        for (column, &k) in free.iter().enumerate() {
            scaled.set_column(column, &(here.jacobian.column(k) / scale[k]));
        }
        let of_constraints = scaled.rows_range(rows..).into_owned();
        let basis = full_basis(&of_constraints);
        let rank = of_constraints.nrows().min(free.len());
        ReducedModel {
            of_data: scaled.rows(0, rows).into_owned(),
            data: here.values.rows(0, rows).into_owned(),
            range: basis.columns(0, rank).into_owned(),
            null: basis.columns_range(rank..).into_owned(),
            of_constraints,
            free,
        }
    }

    /// The shortest step that makes up for the values of the constraints.
    fn normal(&self, constraints: &Vector) -> Option<Vector> {
        if constraints.is_empty() {
            return Some(Vector::zeros(self.free.len()));
        }
        let square = product(&self.of_constraints, &self.range);
        let step = &self.range * square.lu().solve(&-constraints)?;
        step.iter().all(|part| part.is_finite()).then_some(step)
    }

    /// The step within a radius.
    fn step(&self, normal: &Vector, radius: f64) -> Vector {
        let length = normal.norm();
        let part = (NORMAL_PART * radius / length).min(1.0);
        let normal = normal * if length > 0.0 { part } else { 0.0 };
        let left = (radius * radius - normal.norm_squared()).max(0.0).sqrt();
        let values = &self.data + &self.of_data * &normal;
        let model = Model::of_columns(product(&self.of_data, &self.null), &values);
        match model.singular.is_empty() || left == 0.0 {
            true => normal,
            false => normal + &self.null * model.step(left),
        }
    }
}

impl<F> Minimisation<'_, F> {
    fn constrained<P: PartialEq, E>(&mut self, mut here: Iterate<P>) -> LeastSquares<P>
    where
        F: FnMut(&Vector) -> Result<Residuals<P>, E>,
    {
        let tolerance = self.settings.tolerance;
        let norms =
            |of: &Matrix| Vector::from_iterator(of.ncols(), of.column_iter().map(|c| c.norm()));
        let mut scale = norms(&here.jacobian).map(|norm| if norm > 0.0 { norm } else { 1.0 });
        let mut radius = match here.x.component_mul(&scale).norm() {
            0.0 => 1.0,
            size => size,
        };
        let (mut steps, mut crossings) = (0, 0);
        // From the start the constraints weigh as much as the data, and as their own squares.
        let gap = here.gap();
        let mut penalty = match gap > 0.0 {
            true => gap + here.cost_of_data() / gap,
            false => 0.0,
        };
        let end = 'search: loop {
            if !here.is_usable() {
                break LeastSquaresEnd::NotFinite;
            }
            let constraints = here.constraints();
            let gap = constraints.norm();
            let mut fixed = Vec::new();
            let mut model = self.eliminated(&here, &scale, &fixed);
            loop {
                if self.evaluations >= self.settings.most_evaluations {
                    break 'search LeastSquaresEnd::Evaluations;
                }
                let Some(normal) = model.normal(&constraints) else {
                    break 'search LeastSquaresEnd::NotFinite;
                };
                let x = self.moved(&here, &model, &model.step(&normal, radius), &scale);
                // What would leave its bound is fixed, and the others step again.
                let left: Vec<usize> = self.stuck(&here, &model, &x).collect();
                if !left.is_empty() {
                    fixed.extend(left);
                    model = self.eliminated(&here, &scale, &fixed);
                    continue;
                }
                let x = self.within(x);
                let step = &x - &here.x;
                let length = step.component_mul(&scale).norm();
                if length <= tolerance * here.x.component_mul(&scale).norm() || length == 0.0 {
                    break 'search LeastSquaresEnd::Step;
                }
                let linear = &here.values + &here.jacobian * &step;
                let (data, closed) = (
                    linear.rows(0, here.data_rows()),
                    linear.rows_range(here.data_rows()..),
                );
                let gain = 0.5 * (model.data.norm_squared() - data.norm_squared());
                let closes = gap - closed.norm();
                if gain < 0.0 && closes > 0.0 {
                    penalty = penalty.max(-gain / ((1.0 - MERIT_PART) * closes));
                }
                let predicted = gain + penalty * closes;
                if predicted <= 0.0 {
                    radius = 0.25 * length;
                    continue;
                }
                let Some(mut there) = self.evaluated(x) else {
                    radius = 0.25 * length;
                    continue;
                };
                let merit = |of: &Iterate<P>| of.cost_of_data() + penalty * of.gap();
                let (before, mut after) = (merit(&here), merit(&there));
                // The curvature of the constraints is made up for.
                if (before - after) < LEAST_RATIO * predicted
                    && there.gap() > gap
                    && let Some(again) = model.normal(&there.constraints())
                {
                    let x = self.moved(&there, &model, &again, &scale);
                    let x = self.within(x);
                    if let Some(corrected) = self.evaluated(x).filter(|at| merit(at) < after) {
                        after = merit(&corrected);
                        there = corrected;
                    }
                }
                let decrease = before - after;
                let ratio = decrease / predicted;
                let is_flat =
                    decrease.abs() <= tolerance * before && predicted <= tolerance * before;
                if ratio < 0.25 {
                    radius = 0.25 * length;
                } else if ratio > 0.75 {
                    radius = radius.max(2.0 * length);
                }
                if ratio >= LEAST_RATIO {
                    steps += 1;
                    crossings += usize::from(there.at.piece != here.at.piece);
                    here = there;
                    if is_flat || after == 0.0 {
                        break 'search LeastSquaresEnd::Cost;
                    }
                    break;
                }
                if is_flat {
                    break 'search LeastSquaresEnd::Cost;
                }
            }
            let now = norms(&here.jacobian);
            scale = scale.zip_map(&now, f64::max);
        };
        LeastSquares {
            cost: here.cost_of_data(),
            x: here.x,
            at: here.at,
            end,
            steps,
            evaluations: self.evaluations,
            failures: self.failures,
            crossings,
            jumps: 0,
        }
    }

    fn eliminated<P>(&self, here: &Iterate<P>, scale: &Vector, fixed: &[usize]) -> ReducedModel {
        let free = (0..here.x.len()).filter(|k| !fixed.contains(k));
        ReducedModel::of(here, scale, free.collect())
    }

    /// A point moved by a step of the scaled variables.
    fn moved<P>(
        &self,
        from: &Iterate<P>,
        model: &ReducedModel,
        step: &Vector,
        scale: &Vector,
    ) -> Vector {
        let mut x = from.x.clone();
        for (&k, part) in model.free.iter().zip(step) {
            x[k] += part / scale[k];
        }
        x
    }

    /// Free variables on a bound that a step leads out of.
    fn stuck<P>(
        &self,
        here: &Iterate<P>,
        model: &ReducedModel,
        to: &Vector,
    ) -> impl Iterator<Item = usize> {
        let is_stuck = |&&k: &&usize| {
            let (low, high) = self.settings.bounds[k];
            here.x[k] <= low && to[k] < low || here.x[k] >= high && to[k] > high
        };
        model.free.iter().filter(is_stuck).copied()
    }
}
