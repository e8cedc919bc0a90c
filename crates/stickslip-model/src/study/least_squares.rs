//! Nonlinear least squares within bounds, for residuals that are smooth in pieces.

use stickslip::dynamics::{Matrix, Vector};
use stickslip::nalgebra::{QR, SVD};

/// Least part of the predicted decrease with which a step is taken (Moré, as in MINPACK).
const LEAST_RATIO: f64 = 1e-4;

/// Refused steps into another piece after which the change is located. It is chosen: a shorter step
/// often stays on this side of it, or leads beyond.
const REFUSED_BEFORE_HOLDING: u32 = 2;

/// Halvings of a step that is held: a billionth of it is left.
const HALVINGS: u32 = 30;

/// Part of the change along a whole step that is left where residuals are continuous. After
/// [`HALVINGS`] a square root has 3e-5 of it.
const JUMP: f64 = 1e-3;

/// Slopes of the directions that are tried beside a change, as tangents of their angles to those in
/// which the cost stays. At the last, the change counts as orthogonal to the gradient.
const SLOPES_BESIDE: [f64; 5] = [1.0, 0.3, 0.1, 0.03, 0.01];

/// Residuals at a point, and their derivatives with one column for each variable.
#[derive(Clone, Debug, PartialEq)]
pub struct Residuals<P> {
    /// Residuals, in units of their standard deviation.
    pub values: Vector,
    /// Derivatives. A NaN makes the point one that cannot be used.
    pub jacobian: Matrix,
    /// The piece on which the residuals are smooth: equal on the same one.
    pub piece: P,
    /// Number of last residuals that are constraints. [`constrained_least_squares`] makes them
    /// zero; [`least_squares`] counts them as squares, whatever the loss.
    pub constraints: usize,
}

/// Loss function: the weight of large residuals. A scale is in units of the standard deviation.
///
/// The cost of a residual `r` is `c² ρ((r/c)²)/2` with the scale `c` (Triggs et al., *Vision
/// Algorithms*, 1999, 298).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Loss {
    /// Squares: `ρ(z) = z`.
    #[default]
    Squares,
    /// Squares of small residuals, sizes of large ones: `ρ(z) = 2 (√(1 + z) − 1)`.
    SoftL1(f64),
    /// Squares up to the scale, sizes above it (Huber).
    Huber(f64),
}

impl Loss {
    /// `ρ`, its derivative, and twice its second one times `z`, for a residual; and the scale.
    fn derivatives(self, residual: f64) -> [f64; 4] {
        let (scale, z) = match self {
            Loss::Squares => return [residual * residual, 1.0, 0.0, 1.0],
            Loss::SoftL1(scale) | Loss::Huber(scale) => {
                (scale, (residual / scale) * (residual / scale))
            }
        };
        let root = z.sqrt();
        match self {
            Loss::Huber(_) if z <= 1.0 => [z, 1.0, 0.0, scale],
            Loss::Huber(_) => [2.0 * root - 1.0, 1.0 / root, -1.0 / root, scale],
            _ => {
                let (t, rise) = (1.0 + z, (1.0 + z).sqrt());
                [2.0 * z / (1.0 + rise), 1.0 / rise, -z / (t * rise), scale]
            }
        }
    }

    /// The cost of a residual, and the factor of it and of its derivatives in a problem of squares
    /// with the same gradient.
    ///
    /// `ρ` is concave, so that no parabola in the residual with this value and gradient is flatter
    /// and nowhere below the cost (Huber, *Robust Statistics*, 1981, section 7.8). A step of least
    /// squares therefore decreases the cost of linear residuals. One of the cost's own curvature
    /// need not: large residuals of Huber's loss have none.
    pub fn of(self, residual: f64) -> (f64, f64) {
        let [rho, first, _, scale] = self.derivatives(residual);
        (0.5 * scale * scale * rho, first.sqrt())
    }

    /// The derivative of the cost of a residual, and its second derivative (Huber's ψ and ψ′).
    pub fn influence(self, residual: f64) -> (f64, f64) {
        let [_, first, second, _] = self.derivatives(residual);
        (residual * first, first + second)
    }
}

/// Settings of [`least_squares`].
#[derive(Clone, Debug, PartialEq)]
pub struct LeastSquaresSettings {
    /// Lower and upper bound of each variable; infinite where there is none.
    pub bounds: Vec<(f64, f64)>,
    /// Weight of large residuals.
    pub loss: Loss,
    /// Relative decrease of the cost, relative step, and cosine between residuals and derivatives
    /// below which the search ends.
    pub tolerance: f64,
    /// Most evaluations.
    pub most_evaluations: usize,
}

/// Reason for the end of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LeastSquaresEnd {
    /// The cost no longer decreases.
    Cost,
    /// The steps have become small.
    Step,
    /// The residuals are orthogonal to their derivatives, but for bounds.
    Gradient,
    /// The minimum lies where the piece changes: across the change and beside it the cost rises.
    Change,
    /// The evaluations were used up.
    Evaluations,
    /// Residuals or derivatives at the start are not finite.
    NotFinite,
}

/// Result of [`least_squares`].
#[derive(Clone, Debug, PartialEq)]
pub struct LeastSquares<P> {
    /// The variables.
    pub x: Vector,
    /// Residuals there.
    pub at: Residuals<P>,
    /// Half the weighted sum of squares.
    pub cost: f64,
    /// Reason for the end of the search.
    pub end: LeastSquaresEnd,
    /// Steps taken.
    pub steps: usize,
    /// Evaluations, failed ones included.
    pub evaluations: usize,
    /// Evaluations that failed, each of which shortened a step.
    pub failures: usize,
    /// Steps that led into another piece.
    pub crossings: usize,
    /// Changes of the piece at which the residuals jump.
    pub jumps: usize,
}

/// Minimises half the sum of squares of residuals within bounds, from a point within them.
///
/// Gauss–Newton steps within a trust region, whose shape follows the derivatives (Moré, *Numerical
/// Analysis*, Lecture Notes in Mathematics 630 (1978) 105). The subproblem is solved exactly by
/// singular values. A variable on its bound is fixed while the gradient leads out; steps end on
/// bounds. An evaluation that fails shortens the step.
///
/// Where the residuals are smooth in pieces, a step into another piece is taken if it decreases the
/// cost. If it is refused again and again, the change is located, and the search goes on beyond it,
/// or before it where that is lower. It ends at a change beside which no step decreases the cost.
///
/// # Errors
/// That of the first evaluation.
pub fn least_squares<P: PartialEq, E>(
    x: &Vector,
    settings: &LeastSquaresSettings,
    mut at: impl FnMut(&Vector) -> Result<Residuals<P>, E>,
) -> Result<LeastSquares<P>, E> {
    let mut search = Minimisation {
        evaluations: 0,
        failures: 0,
        settings,
        at: |x: &Vector| at(x),
    };
    search.evaluations = 1;
    let here = Iterate::of(x.clone(), (search.at)(x)?, settings.loss);
    Ok(search.from(here))
}

/// A point, with residuals and derivatives of the equivalent problem of squares.
struct Iterate<P> {
    x: Vector,
    at: Residuals<P>,
    cost: f64,
    values: Vector,
    jacobian: Matrix,
}

impl<P> Iterate<P> {
    fn of(x: Vector, at: Residuals<P>, loss: Loss) -> Self {
        let (mut values, mut jacobian) = (at.values.clone(), at.jacobian.clone());
        let mut cost = 0.0;
        let lossy = values.len().saturating_sub(at.constraints);
        for (k, value) in values.iter_mut().enumerate() {
            let loss = if k < lossy { loss } else { Loss::Squares };
            let (part, factor) = loss.of(*value);
            cost += part;
            *value *= factor;
            if factor != 1.0 {
                jacobian.row_mut(k).scale_mut(factor);
            }
        }
        Iterate {
            x,
            at,
            cost,
            values,
            jacobian,
        }
    }

    /// Decrease of the cost by a step, by the model.
    fn predicted(&self, step: &Vector) -> f64 {
        let there = &self.values + &self.jacobian * step;
        0.5 * (self.values.norm_squared() - there.norm_squared())
    }

    fn is_usable(&self) -> bool {
        let all = self.jacobian.iter().chain(&self.values);
        self.cost.is_finite() && all.into_iter().all(|value| value.is_finite())
    }
}

struct Minimisation<'s, F> {
    settings: &'s LeastSquaresSettings,
    at: F,
    evaluations: usize,
    failures: usize,
}

/// The model of the cost around a point: singular values of the scaled derivatives of the variables
/// that can move.
struct Model {
    free: Vec<usize>,
    singular: Vector,
    /// Residuals along the left singular vectors.
    along: Vector,
    right: Matrix,
}

impl Model {
    fn of<P>(here: &Iterate<P>, scale: &Vector, bounds: &[(f64, f64)]) -> Self {
        let slope = here.jacobian.tr_mul(&here.values);
        let is_free = |&k: &usize| {
            let (low, high) = bounds[k];
            !(here.x[k] <= low && slope[k] > 0.0 || here.x[k] >= high && slope[k] < 0.0)
        };
        let free: Vec<usize> = (0..here.x.len()).filter(is_free).collect();
        let columns: Vec<Vector> = free
            .iter()
            .map(|&k| here.jacobian.column(k) / scale[k])
            .collect();
        let matrix = match columns[..] {
            [] => Matrix::zeros(here.values.len(), 0),
            _ => Matrix::from_columns(&columns),
        };
        Model {
            free,
            ..Model::of_columns(matrix, &here.values)
        }
    }

    /// The model of the squares of `values` with these derivatives, all variables of which move.
    fn of_columns(matrix: Matrix, values: &Vector) -> Self {
        let free = (0..matrix.ncols()).collect();
        if matrix.is_empty() {
            let (singular, along) = (Vector::zeros(0), Vector::zeros(0));
            let right = Matrix::zeros(matrix.ncols(), 0);
            return Model {
                free,
                singular,
                along,
                right,
            };
        }
        let mut values = values.clone();
        let qr = QR::new(matrix);
        qr.q_tr_mul(&mut values);
        let r = qr.r();
        let svd = SVD::new(r, true, true);
        let none = || Matrix::zeros(0, 0);
        let u = svd.u.unwrap_or_else(none);
        let along = u.tr_mul(&values.rows(0, u.nrows()));
        let right = svd.v_t.unwrap_or_else(none).transpose();
        Model {
            free,
            singular: svd.singular_values,
            along,
            right,
        }
    }

    /// Components of the step of a damping, along the right singular vectors.
    fn components(&self, damping: f64) -> Vector {
        // Below rounding, a singular value says nothing.
        let least = self.singular.amax() * f64::EPSILON * self.singular.len() as f64;
        let of = |s: f64, w: f64| {
            if s <= least {
                0.0
            } else {
                -s * w / (s * s + damping)
            }
        };
        self.singular.zip_map(&self.along, of)
    }

    /// The step in the scaled variables that minimises the model within a radius.
    fn step(&self, radius: f64) -> Vector {
        let mut damping = 0.0;
        let mut components = self.components(damping);
        // Newton's iteration for the reciprocal of the length, which is nearly linear in the
        // damping, from below: it rises to the solution.
        for _ in 0..50 {
            let length = components.norm();
            if length <= radius * (1.0 + 1e-3) {
                break;
            }
            let slopes = components.zip_map(&self.singular, |p, s| {
                if p == 0.0 {
                    0.0
                } else {
                    p * p / (s * s + damping)
                }
            });
            let slope = slopes.sum() / length;
            damping += (length - radius) / radius * length / slope;
            components = self.components(damping);
        }
        &self.right * components
    }
}

impl<F> Minimisation<'_, F> {
    fn evaluated<P, E>(&mut self, x: Vector) -> Option<Iterate<P>>
    where
        F: FnMut(&Vector) -> Result<Residuals<P>, E>,
    {
        self.evaluations += 1;
        let at = (self.at)(&x);
        let point = at
            .ok()
            .map(|at| Iterate::of(x, at, self.settings.loss))
            .filter(Iterate::is_usable);
        self.failures += usize::from(point.is_none());
        point
    }

    fn within(&self, x: Vector) -> Vector {
        let mut x = x;
        for (x, (low, high)) in x.iter_mut().zip(&self.settings.bounds) {
            *x = x.clamp(*low, *high);
        }
        x
    }

    fn from<P: PartialEq, E>(&mut self, mut here: Iterate<P>) -> LeastSquares<P>
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
        let (mut steps, mut crossings, mut jumps) = (0, 0, 0);
        let mut refused = 0;
        let end = 'search: loop {
            if !here.is_usable() {
                break LeastSquaresEnd::NotFinite;
            }
            let model = Model::of(&here, &scale, &self.settings.bounds);
            let sizes = norms(&here.jacobian);
            let slope = here.jacobian.tr_mul(&here.values);
            let size = here.values.norm();
            let is_orthogonal = |&k: &usize| slope[k].abs() <= tolerance * sizes[k] * size;
            if model.free.iter().all(is_orthogonal) {
                break LeastSquaresEnd::Gradient;
            }
            loop {
                if self.evaluations >= self.settings.most_evaluations {
                    break 'search LeastSquaresEnd::Evaluations;
                }
                let scaled = model.step(radius);
                let mut x = here.x.clone();
                for (&k, step) in model.free.iter().zip(&scaled) {
                    x[k] += step / scale[k];
                }
                let x = self.within(x);
                let step = &x - &here.x;
                let length = step.component_mul(&scale).norm();
                if length <= tolerance * here.x.component_mul(&scale).norm() || length == 0.0 {
                    break 'search LeastSquaresEnd::Step;
                }
                let predicted = here.predicted(&step);
                if predicted <= 0.0 {
                    radius = 0.25 * length;
                    continue;
                }
                let Some(there) = self.evaluated(x) else {
                    radius = 0.25 * length;
                    continue;
                };
                let decrease = here.cost - there.cost;
                let ratio = decrease / predicted;
                let is_crossing = there.at.piece != here.at.piece;
                let is_flat =
                    decrease.abs() <= tolerance * here.cost && predicted <= tolerance * here.cost;
                if ratio < 0.25 {
                    radius = 0.25 * length;
                } else if ratio > 0.75 {
                    radius = radius.max(2.0 * length);
                }
                if ratio >= LEAST_RATIO {
                    steps += 1;
                    crossings += usize::from(is_crossing);
                    if is_crossing {
                        refused = 0;
                    }
                    here = there;
                    if is_flat || here.cost == 0.0 {
                        break 'search LeastSquaresEnd::Cost;
                    }
                    break;
                }
                if is_flat {
                    break 'search LeastSquaresEnd::Cost;
                }
                refused += u32::from(is_crossing);
                if !is_crossing || refused <= REFUSED_BEFORE_HOLDING {
                    continue;
                }
                let along = (&there.values - &here.values).norm();
                let (before, beyond) = self.held(&here, there);
                let rest = before.as_ref().unwrap_or(&here);
                let is_jump = (&beyond.values - &rest.values).norm() > JUMP * along;
                jumps += usize::from(is_jump);
                // Beyond a continuous change the other side's derivatives are known.
                let is_lower = beyond.cost < rest.cost || !is_jump;
                let next = if is_lower { Some(beyond) } else { before };
                let is_gain = |next: &Iterate<P>| here.cost - next.cost > tolerance * here.cost;
                let next = next.filter(is_gain);
                crossings += usize::from(is_lower && next.is_some());
                let next = next.or_else(|| self.beside(&here, &model.free, &scale, length));
                let Some(next) = next else {
                    break 'search match self.evaluations < self.settings.most_evaluations {
                        true => LeastSquaresEnd::Change,
                        false => LeastSquaresEnd::Evaluations,
                    };
                };
                steps += 1;
                here = next;
                radius = length;
                break;
            }
            let now = norms(&here.jacobian);
            scale = scale.zip_map(&now, f64::max);
        };
        LeastSquares {
            x: here.x,
            at: here.at,
            cost: here.cost,
            end,
            steps,
            evaluations: self.evaluations,
            failures: self.failures,
            crossings,
            jumps,
        }
    }

    /// A lower point beside a change that steps are held to, at most so far away, unless the change
    /// is orthogonal to the gradient: then the cost falls across the change alone.
    ///
    /// The directions lie on cones around the way down, from steep to nearly flat. A change at
    /// another angle leaves some of them on this side. Each goes on to the minimum of the model.
    fn beside<P: PartialEq, E>(
        &mut self,
        here: &Iterate<P>,
        free: &[usize],
        scale: &Vector,
        farthest: f64,
    ) -> Option<Iterate<P>>
    where
        F: FnMut(&Vector) -> Result<Residuals<P>, E>,
    {
        let slope = here.jacobian.tr_mul(&here.values);
        let slope = Vector::from_iterator(free.len(), free.iter().map(|&k| slope[k] / scale[k]));
        let down = &-slope.normalize();
        let sides = null_space(&Matrix::from_row_slice(1, free.len(), down.as_slice()));
        let sides = || {
            sides
                .column_iter()
                .flat_map(|side| [side.into_owned(), -side])
        };
        for way in SLOPES_BESIDE
            .iter()
            .flat_map(|part| sides().map(move |side| side + down * *part))
        {
            if self.evaluations >= self.settings.most_evaluations {
                return None;
            }
            let mut step = Vector::zeros(here.x.len());
            for (&k, part) in free.iter().zip(&way.normalize()) {
                step[k] = part / scale[k];
            }
            let change = &here.jacobian * &step;
            let best = -here.values.dot(&change) / change.norm_squared();
            let x = self.within(&here.x + step * best.min(farthest));
            let predicted = here.predicted(&(&x - &here.x));
            let there = self.evaluated(x);
            let is_lower = |there: &Iterate<P>| here.cost - there.cost > LEAST_RATIO * predicted;
            if let Some(there) = there.filter(|there| predicted > 0.0 && is_lower(there)) {
                return Some(there);
            }
        }
        None
    }

    /// The points on both sides of the first change found on the way to a point of another piece.
    /// A change at the start of the way has none before it.
    fn held<P: PartialEq, E>(
        &mut self,
        here: &Iterate<P>,
        there: Iterate<P>,
    ) -> (Option<Iterate<P>>, Iterate<P>)
    where
        F: FnMut(&Vector) -> Result<Residuals<P>, E>,
    {
        let way = &there.x - &here.x;
        let (mut low, mut high) = (0.0, 1.0);
        let (mut before, mut beyond) = (None, there);
        for _ in 0..HALVINGS {
            if self.evaluations >= self.settings.most_evaluations {
                break;
            }
            let middle = 0.5 * (low + high);
            match self.evaluated(&here.x + &way * middle) {
                Some(point) if point.at.piece == here.at.piece => {
                    (low, before) = (middle, Some(point));
                }
                Some(point) => (high, beyond) = (middle, point),
                None => high = middle,
            }
        }
        (before, beyond)
    }
}

mod constrained;
pub use constrained::{constrained_least_squares, null_space};

#[cfg(test)]
mod tests;
