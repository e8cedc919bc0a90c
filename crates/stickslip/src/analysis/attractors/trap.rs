//! Neighbourhoods of an equilibrium that no slipping orbit leaves.

use nalgebra::Cholesky;

use super::equilibrium::{Equilibrium, ZERO, equilibrium_near, velocities_from};
use crate::analysis::multipliers;
use crate::dynamics::{Dynamics, Matrix, Modes, Moment, Vector};
use crate::interval::Interval;
use crate::math::{self, product};

/// Factor by which the ellipsoid exceeds the one through the orbit, as room for rounding.
const LEVEL_MARGIN: f64 = 1.0 + 1e-6;

/// Largest fraction of the decay near the equilibrium that the nonlinearity of the field may
/// remove. With [`LARGEST_ROUNDED_LOSS`] it leaves a twentieth for the rounding of interval bounds.
const LARGEST_LOSS: f64 = 0.9;

/// Largest fraction of that decay that the rounding of the equilibrium may remove.
const LARGEST_ROUNDED_LOSS: f64 = 0.05;

/// Parts of the distance from the equilibrium, each with its own bounds of the Jacobian. More parts
/// prove larger ellipsoids and take more time. Chosen.
const JACOBIAN_PARTS: u32 = 8;

/// Ratio of successive sizes for which an ellipsoid is tried. Chosen, with [`SIZES`]: the smallest
/// is 9 % of the first.
const SIZE_RATIO: f64 = 0.85;

/// Number of sizes that are tried.
const SIZES: u32 = 16;

/// Largest number of states for which a trap is sought. Each entry of `P` is an unknown of the
/// equations, and the time grows with the sixth power of this.
const MOST_STATES: usize = 12;

/// A neighbourhood of an equilibrium that no slipping orbit leaves. Every orbit in it converges to
/// the equilibrium without another event, even from far away.
pub(super) struct Trap {
    /// The equilibrium.
    pub x: Vector,
    function: LyapunovFunction,
    level: f64,
    /// Level of the orbit when the trap was sought.
    level_at_start: f64,
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
    /// rounded outward; a twentieth of the decay is reserved for that.
    pub fn near(system: &dyn Dynamics, mode: Modes, at: &Moment, escape: f64) -> Option<Self> {
        let n = system.states();
        // In stick, what ends the phase requires derivatives, which intervals do not have.
        if mode.any_sticks() || n > MOST_STATES {
            return None;
        }
        let Equilibrium { x, jacobian } = equilibrium_near(system, mode, at.t, &at.x, n)?;
        if !attracts(&jacobian) {
            return None;
        }
        let function = LyapunovFunction::of(&jacobian)?;
        let there = Moment { t: at.t, x };
        let velocities = velocities_from(system, mode, &there)?;
        if velocities.iter().any(|v| v.low != v.high) {
            return None;
        }
        let velocity = velocities.iter().map(|v| v.low * v.low).sum::<f64>().sqrt();
        let is_trap = |level: f64| {
            let radius: Vec<f64> = (0..n).map(|i| function.reach(level, i)).collect();
            (0..n).all(|i| there.x[i].abs() + radius[i] <= escape)
                && function.outweighs(velocity, level)
                && stays_clear(system, mode, &there, &radius)
                && jacobian_variation(system, mode, &there, &radius, &jacobian)
                    .is_some_and(|variation| function.withstands(&variation))
        };
        let from = LEVEL_MARGIN * function.value((&at.x - &there.x).as_slice());
        let level = largest(from, is_trap)?;
        Some(Trap {
            x: there.x,
            function,
            level,
            level_at_start: from,
        })
    }

    /// Whether a state, of the same mode and at no earlier time, lies inside.
    pub fn contains(&self, x: &Vector) -> bool {
        self.level_of(x) <= self.level
    }

    /// Whether an orbit at this state is closer than when the trap was sought.
    pub fn is_closer_than_at_start(&self, x: &Vector) -> bool {
        self.level_of(x) < self.level_at_start
    }

    fn level_of(&self, x: &Vector) -> f64 {
        LEVEL_MARGIN * self.function.value((x - &self.x).as_slice())
    }
}

/// The largest level, in steps downwards from one, for which the claim holds, provided that it
/// holds for all smaller levels, too. The claim of a trap does, except for rounding of the
/// equilibrium. Where a smaller level fails for that reason, a valid one may be missed.
fn largest(from: f64, claim: impl Fn(f64) -> bool) -> Option<f64> {
    let level = |step: u32| from * math::powi(SIZE_RATIO * SIZE_RATIO, step as i32);
    if claim(from) {
        return Some(from);
    }
    let (mut too_large, mut largest) = (0, None);
    let mut small = SIZES;
    while small - too_large > 1 {
        let middle = u32::midpoint(too_large, small);
        if claim(level(middle)) {
            small = middle;
            largest = Some(level(middle));
        } else {
            too_large = middle;
        }
    }
    largest
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
fn jacobian_variation(
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
    for part in 1..=JACOBIAN_PARTS {
        let over = around(&at.x, radius, f64::from(part) / f64::from(JACOBIAN_PARTS));
        for j in 0..n {
            let column = flow.derivative_over(ever, &over, j)?;
            for i in 0..n {
                low[(i, j)] += column[i].low / f64::from(JACOBIAN_PARTS);
                high[(i, j)] += column[i].high / f64::from(JACOBIAN_PARTS);
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
struct LyapunovFunction {
    weights: Matrix,
    inverse: Matrix,
    /// Upper bound of the norm of `P`.
    norm: f64,
    /// Residual of the equation due to rounding.
    rounded: f64,
}

impl LyapunovFunction {
    /// The function of a Jacobian; `None` where none is positive definite.
    fn of(jacobian: &Matrix) -> Option<Self> {
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
        let half = product(&weights, jacobian);
        let rounded = norm(&(&half + half.transpose() + Matrix::identity(n, n)));
        let inverse = Cholesky::new(weights.clone())?.inverse();
        rounded.is_finite().then(|| LyapunovFunction {
            norm: norm(&weights),
            weights,
            inverse,
            rounded,
        })
    }

    fn value(&self, away: &[f64]) -> f64 {
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
        2.0 * self.norm * velocity <= LARGEST_ROUNDED_LOSS * (level / self.norm).sqrt()
    }

    /// Whether it decreases along every linear flow that variation by at most this much.
    fn withstands(&self, variation: &Matrix) -> bool {
        let taken = self.weights.abs() * variation;
        norm(&(&taken + taken.transpose())) + self.rounded <= LARGEST_LOSS
    }
}

/// The largest sum of absolute values in a row: an upper bound of the norm of a symmetric matrix.
fn norm(matrix: &Matrix) -> f64 {
    let sums = matrix.row_iter().map(|row| row.abs().sum());
    sums.fold(0.0, f64::max)
}
