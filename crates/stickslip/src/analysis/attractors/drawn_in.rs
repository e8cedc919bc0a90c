//! Whether a slipping orbit can no longer escape from an equilibrium.

use nalgebra::Cholesky;

use super::rest::{Rest, ZERO, equilibrium_near, velocities_from};
use crate::analysis::multipliers;
use crate::dynamics::{Dynamics, Matrix, Modes, Moment, Vector};
use crate::interval::Interval;
use crate::math;

/// Factor by which the ellipsoid exceeds what the orbit needs; it leaves room for rounding.
const ROOM: f64 = 1.0 + 1e-6;

/// Fraction of the decay near the equilibrium that the field's nonlinearity may take away, and the
/// fraction that rounding of the equilibrium may.
const MOST_TAKEN: f64 = 0.9;
const MOST_ROUNDED: f64 = 0.05;

/// Fractions of the distance from the equilibrium. Between each two the Jacobian has its own
/// bounds.
const PARTS: u32 = 8;

/// Ratio of successive sizes for which an ellipsoid is tried.
const SMALLER: f64 = 0.85;
const STEPS: u32 = 16;

/// Largest number of states for which a trap is sought: each entry of `P` is an unknown of the
/// equations.
const MOST_STATES: usize = 12;

/// A neighbourhood of an equilibrium that no slipping orbit leaves. Every orbit in it converges to
/// the equilibrium without another event, even from far away.
pub(super) struct Trap {
    /// The equilibrium.
    pub x: Vector,
    falling: Falling,
    level: f64,
    /// State of the orbit when the trap was sought.
    from: f64,
}

impl Trap {
    /// The largest of some sizes that is proved around an equilibrium near `at`. The first size is
    /// the one that the orbit there needs. States stay within `escape`.
    ///
    /// Near a stable equilibrium `x` the function `V(y) = yᵀPy` with `JᵀP + PJ = −1` decreases
    /// along the linear flow (Lyapunov). The field at `x + y` is `A y`, where `A` is the mean of
    /// the Jacobian between `x` and `x + y`. So `V` decreases along the flow itself wherever `A`
    /// differs little enough from `J`. Over the box around an ellipsoid on which `V` is constant,
    /// interval arithmetic bounds this difference and shows that no boundary is met. The ellipsoid
    /// is then never left, and `V` decreases to the level of rounding. Interval bounds are not
    /// rounded outward; a tenth of the decay is reserved for that.
    pub fn near(system: &dyn Dynamics, mode: Modes, at: &Moment, escape: f64) -> Option<Self> {
        let n = system.states();
        // In stick, what ends the phase requires derivatives, which intervals do not have.
        if mode.any_sticks() || n > MOST_STATES {
            return None;
        }
        let Rest { x, jacobian } = equilibrium_near(system, mode, at.t, &at.x, n)?;
        if !attracts(&jacobian) {
            return None;
        }
        let falling = Falling::along(&jacobian)?;
        let there = Moment { t: at.t, x };
        let velocities = velocities_from(system, mode, &there)?;
        if velocities.iter().any(|v| v.low != v.high) {
            return None;
        }
        let velocity = velocities.iter().map(|v| v.low * v.low).sum::<f64>().sqrt();
        let is_trap = |level: f64| {
            let radius: Vec<f64> = (0..n).map(|i| falling.reach(level, i)).collect();
            (0..n).all(|i| there.x[i].abs() + radius[i] <= escape)
                && falling.outweighs(velocity, level)
                && stays_clear(system, mode, &there, &radius)
                && differs(system, mode, &there, &radius, &jacobian)
                    .is_some_and(|differs| falling.withstands(&differs))
        };
        let from = ROOM * falling.at((&at.x - &there.x).as_slice());
        let level = largest(from, is_trap)?;
        Some(Trap {
            x: there.x,
            falling,
            level,
            from,
        })
    }

    /// Whether a state, of the same mode and at no earlier time, lies inside.
    pub fn holds(&self, x: &Vector) -> bool {
        self.level_of(x) <= self.level
    }

    /// Whether an orbit at this state is closer than when the trap was sought.
    pub fn draws(&self, x: &Vector) -> bool {
        self.level_of(x) < self.from
    }

    fn level_of(&self, x: &Vector) -> f64 {
        ROOM * self.falling.at((x - &self.x).as_slice())
    }
}

/// The largest level, in steps downwards from one, for which the claim holds, provided that it
/// holds for all smaller levels, too. The claim of a trap does, except for rounding of the
/// equilibrium. Where a smaller level fails for that reason, a valid one may be missed.
fn largest(from: f64, claim: impl Fn(f64) -> bool) -> Option<f64> {
    let level = |step: u32| from * math::powi(SMALLER * SMALLER, step as i32);
    if claim(from) {
        return Some(from);
    }
    let (mut too_large, mut known) = (0, None);
    let mut small = STEPS;
    while small - too_large > 1 {
        let middle = u32::midpoint(too_large, small);
        if claim(level(middle)) {
            small = middle;
            known = Some(level(middle));
        } else {
            too_large = middle;
        }
    }
    known
}

/// A box around a state.
fn around(x: &Vector, radius: &[f64], part: f64) -> Vec<Interval> {
    let sides = x.iter().zip(radius);
    sides
        .map(|(x, radius)| Interval::around(*x, part * radius))
        .collect()
}

/// Whether no guard comes near zero in a box at any time.
fn stays_clear(system: &dyn Dynamics, mode: Modes, at: &Moment, radius: &[f64]) -> bool {
    let ever = Interval::new(at.t, f64::INFINITY);
    system
        .flow(mode, at)
        .is_clear(ever, &around(&at.x, radius, 1.0))
}

/// Difference between the given Jacobian and its mean on a straight line from a state into the box
/// around it. Each part of the lines lies in a smaller box.
fn differs(
    system: &dyn Dynamics,
    mode: Modes,
    at: &Moment,
    radius: &[f64],
    jacobian: &Matrix,
) -> Option<Matrix> {
    let n = system.states();
    let flow = system.flow(mode, at);
    let ever = Interval::new(at.t, f64::INFINITY);
    let mut low = Matrix::zeros(n, n);
    let mut high = low.clone();
    for part in 1..=PARTS {
        let over = around(&at.x, radius, f64::from(part) / f64::from(PARTS));
        for j in 0..n {
            let column = flow.derivative_over(ever, &over, j)?;
            for i in 0..n {
                low[(i, j)] += column[i].low / f64::from(PARTS);
                high[(i, j)] += column[i].high / f64::from(PARTS);
            }
        }
    }
    // Taking the larger of two would lose a bound that is not a number.
    low.iter()
        .chain(&high)
        .all(|bound| bound.is_finite())
        .then(|| {
            Matrix::from_fn(n, n, |i, j| {
                (high[(i, j)] - jacobian[(i, j)]).max(jacobian[(i, j)] - low[(i, j)])
            })
        })
}

/// Whether all eigenvalues are certain to lie left of the imaginary axis.
fn attracts(jacobian: &Matrix) -> bool {
    let bound = -ZERO * jacobian.amax();
    multipliers(jacobian).iter().all(|value| value.re < bound)
}

/// A quadratic function that decreases along a linear flow: `P` of `JᵀP + PJ = −1`. The number of
/// states is known at run time, so that it is compiled once.
struct Falling {
    weights: Matrix,
    inverse: Matrix,
    /// Upper bound of the norm of `P`.
    norm: f64,
    /// Residual of the equation due to rounding.
    rounded: f64,
}

impl Falling {
    /// The function of a Jacobian; `None` where none is positive definite.
    fn along(jacobian: &Matrix) -> Option<Self> {
        let n = jacobian.nrows();
        let place = |i: usize, j: usize| i * n + j;
        let mut equations = Matrix::zeros(n * n, n * n);
        let mut right = Vector::zeros(n * n);
        for i in 0..n {
            for j in 0..n {
                let row = place(i, j);
                for k in 0..n {
                    equations[(row, place(k, j))] += jacobian[(k, i)];
                    equations[(row, place(i, k))] += jacobian[(k, j)];
                }
                right[row] = if i == j { -1.0 } else { 0.0 };
            }
        }
        let solution = equations.lu().solve(&right)?;
        let entry = |i, j| 0.5 * (solution[place(i, j)] + solution[place(j, i)]);
        let weights = Matrix::from_fn(n, n, entry);
        let half = &weights * jacobian;
        let rounded = norm(&(&half + half.transpose() + Matrix::identity(n, n)));
        let inverse = Cholesky::new(weights.clone())?.inverse();
        rounded.is_finite().then(|| Falling {
            norm: norm(&weights),
            weights,
            inverse,
            rounded,
        })
    }

    fn at(&self, away: &[f64]) -> f64 {
        let weighed = |i: usize| {
            away.iter()
                .enumerate()
                .map(move |(j, one)| self.weights[(i, j)] * one)
        };
        away.iter()
            .enumerate()
            .map(|(i, one)| one * weighed(i).sum::<f64>())
            .sum()
    }

    /// Largest deviation of a component where the function is at most `level`.
    fn reach(&self, level: f64, i: usize) -> f64 {
        (level * self.inverse[(i, i)]).sqrt()
    }

    /// Whether it decreases on the ellipsoid of this level although the field at its centre is not
    /// zero.
    fn outweighs(&self, velocity: f64, level: f64) -> bool {
        2.0 * self.norm * velocity <= MOST_ROUNDED * (level / self.norm).sqrt()
    }

    /// Whether it decreases along every linear flow that differs by at most this much.
    fn withstands(&self, differs: &Matrix) -> bool {
        let taken = self.weights.abs() * differs;
        norm(&(&taken + taken.transpose())) + self.rounded <= MOST_TAKEN
    }
}

/// The largest sum of absolute values in a row: an upper bound of the norm of a symmetric matrix.
fn norm(matrix: &Matrix) -> f64 {
    let sums = matrix.row_iter().map(|row| row.abs().sum());
    sums.fold(0.0, f64::max)
}
