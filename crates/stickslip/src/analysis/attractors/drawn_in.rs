//! Whether an orbit that slips can no longer get away from an equilibrium.

use nalgebra::Cholesky;

use super::rest::{Rest, ZERO, equilibrium_near, velocities_from};
use crate::analysis::multipliers;
use crate::dynamics::{Dynamics, Matrix, Modes, Moment, Vector};
use crate::interval::Interval;
use crate::math;

/// The ellipsoid is larger than the orbit needs by this, which leaves room for rounding.
const ROOM: f64 = 1.0 + 1e-6;

/// Part of the decay near the equilibrium that the field's nonlinearity may take away, and part
/// that rounding of the equilibrium may.
const MOST_TAKEN: f64 = 0.9;
const MOST_ROUNDED: f64 = 0.05;

/// Parts of the way from the equilibrium for each of which the Jacobian has bounds of its own.
const PARTS: u32 = 8;

/// Sizes that an ellipsoid is looked for in: each so many times the one before.
const SMALLER: f64 = 0.85;
const STEPS: u32 = 16;

/// Systems of more states are not asked: the equations for `P` are as many as its entries.
const MOST_STATES: usize = 12;

/// A neighbourhood of an equilibrium out of which no orbit in slip gets: each comes to the
/// equilibrium without another event, though it may be far from it yet.
pub(super) struct Trap {
    /// The equilibrium.
    pub x: Vector,
    falling: Falling,
    level: f64,
    /// Where the orbit was when it was looked for.
    from: f64,
}

impl Trap {
    /// The largest of some sizes that is proven around an equilibrium near `at`; the first is that
    /// which the orbit there needs. States stay within `escape`.
    ///
    /// Near a stable equilibrium `x` the function `V(y) = yᵀPy` with `JᵀP + PJ = −1` falls along
    /// the linear flow (Lyapunov). The field at `x + y` is `A y`, where `A` is the mean of the
    /// Jacobian on the way from `x`; so `V` falls along the flow itself wherever `A` differs little
    /// enough from `J`. Over the box around an ellipsoid on which `V` is constant, intervals tell
    /// by how much it differs, and that no boundary is met. The ellipsoid then is never left, and
    /// `V` falls to what rounding leaves. Bounds of intervals are not rounded outward; a tenth of
    /// the decay is room for that.
    pub fn near(system: &dyn Dynamics, mode: Modes, at: &Moment, escape: f64) -> Option<Self> {
        let n = system.states();
        // While a contact sticks, what ends that takes derivatives, which intervals do not have.
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

    /// Whether a state, of the same mode and of no earlier time, is in it.
    pub fn holds(&self, x: &Vector) -> bool {
        self.level_of(x) <= self.level
    }

    /// Whether an orbit at this state has come nearer since the trap was looked for.
    pub fn draws(&self, x: &Vector) -> bool {
        self.level_of(x) < self.from
    }

    fn level_of(&self, x: &Vector) -> f64 {
        ROOM * self.falling.at((x - &self.x).as_slice())
    }
}

/// The largest level in steps downwards from one for which the claim holds, if it holds for all
/// smaller ones, too. The claim of a trap does, but for what rounding of the equilibrium leaves;
/// where a smaller level fails for that, one that holds may be missed.
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

/// Whether no guard comes near zero in a box, ever.
fn stays_clear(system: &dyn Dynamics, mode: Modes, at: &Moment, radius: &[f64]) -> bool {
    let ever = Interval::new(at.t, f64::INFINITY);
    system
        .flow(mode, at)
        .is_clear(ever, &around(&at.x, radius, 1.0))
}

/// By how much the mean of the Jacobian on a straight way from a state into the box around it
/// differs from the one given: each part of the ways lies in a smaller box.
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
    // A bound that is no number would be lost in the larger of two.
    low.iter()
        .chain(&high)
        .all(|bound| bound.is_finite())
        .then(|| {
            Matrix::from_fn(n, n, |i, j| {
                (high[(i, j)] - jacobian[(i, j)]).max(jacobian[(i, j)] - low[(i, j)])
            })
        })
}

/// Whether all eigenvalues are to the left of zero for certain.
fn attracts(jacobian: &Matrix) -> bool {
    let bound = -ZERO * jacobian.amax();
    multipliers(jacobian).iter().all(|value| value.re < bound)
}

/// A quadratic function that falls along a linear flow: `P` of `JᵀP + PJ = −1`. Of any number of
/// states, so that it is compiled once.
struct Falling {
    weights: Matrix,
    inverse: Matrix,
    /// No less than the norm of `P`.
    norm: f64,
    /// By how much rounding misses the equation.
    rounded: f64,
}

impl Falling {
    /// That of a Jacobian; `None` where there is none that is positive.
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

    /// How far a component can be off where the function is no more than `level`.
    fn reach(&self, level: f64, i: usize) -> f64 {
        (level * self.inverse[(i, i)]).sqrt()
    }

    /// Whether on the ellipsoid of this level it falls though the field at its middle is off zero.
    fn outweighs(&self, velocity: f64, level: f64) -> bool {
        2.0 * self.norm * velocity <= MOST_ROUNDED * (level / self.norm).sqrt()
    }

    /// Whether it falls along every linear flow that differs by no more.
    fn withstands(&self, differs: &Matrix) -> bool {
        let taken = self.weights.abs() * differs;
        norm(&(&taken + taken.transpose())) + self.rounded <= MOST_TAKEN
    }
}

/// The largest sum of a row of sizes: no less than the norm of a symmetric matrix.
fn norm(matrix: &Matrix) -> f64 {
    let sums = matrix.row_iter().map(|row| row.abs().sum());
    sums.fold(0.0, f64::max)
}
