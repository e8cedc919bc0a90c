//! Whether an orbit that slips can no longer get away from an equilibrium.

use nalgebra::{Cholesky, DMatrix, DVector, SMatrix};

use super::rest::{Rest, ZERO, equilibrium_near, velocities_from};
use crate::analysis::multipliers;
use crate::dual::Dual;
use crate::filippov::{Flow, Switched, UseFlow};
use crate::interval::Interval;
use crate::ode::Timed;
use crate::system::State;

/// The ellipsoid is larger than the orbit needs by this, which leaves room for rounding.
const ROOM: f64 = 1.0 + 1e-6;

/// Part of the decay near the equilibrium that the field's nonlinearity may take away, and part that rounding of the equilibrium may.
const MOST_TAKEN: f64 = 0.9;
const MOST_ROUNDED: f64 = 0.05;

/// Systems of more states are not asked: the equations for `P` are as many as its entries.
const MOST_STATES: usize = 12;

/// Whether no guard comes near zero in a box, ever.
struct StaysClear<'a, const N: usize>(Interval, &'a [Interval; N]);

impl<const N: usize> UseFlow<N> for StaysClear<'_, N> {
    type Output = bool;

    fn with<F: Flow<N>>(self, flow: &F) -> bool {
        F::GUARDS.iter().all(|&i| flow.is_clear(i, self.0, self.1))
    }
}

/// The equilibrium that the orbit at `at` comes to for certain, without another event, though it may be far from it yet. States stay
/// within `escape`.
///
/// Near a stable equilibrium `V(y) = yᵀPy` with `JᵀP + PJ = −1` falls along the linear flow (Lyapunov). It does so along the flow itself
/// wherever the Jacobian differs little enough from `J`; over the box around the ellipsoid on which the orbit is, intervals tell by how
/// much it differs, and that no boundary is met. The ellipsoid then is never left, and `V` falls to what rounding leaves. Bounds of intervals are
/// not rounded outward; a tenth of the decay is room for that.
pub(super) fn drawn_to<S: Switched<N, G>, const N: usize, const G: usize>(
    system: &S,
    mode: S::Mode,
    at: &Timed<N>,
    escape: f64,
) -> Option<State<N>> {
    // While a contact sticks, what ends that takes derivatives, which intervals do not have.
    if S::any_sticks(mode) || N > MOST_STATES {
        return None;
    }
    let Rest { x, jacobian } = equilibrium_near(system, mode, at.t, &at.x, N)?;
    if !attracts(&jacobian) {
        return None;
    }
    let falling = Falling::along(&DMatrix::from_fn(N, N, |i, j| jacobian[(i, j)]))?;
    let away = at.x - x;
    let level = ROOM * falling.at(away.as_slice());
    let radius: [f64; N] = std::array::from_fn(|i| falling.reach(level, i));
    if (0..N).any(|i| x[i].abs() + radius[i] > escape) {
        return None;
    }
    let ever = Interval::new(at.t, f64::INFINITY);
    let over: [Interval; N] = std::array::from_fn(|i| Interval::around(x[i], radius[i]));
    let branch = system.branch(at);
    if !system.with_flow(mode, branch, StaysClear(ever, &over)) {
        return None;
    }
    let there = velocities_from(system, mode, &Timed { t: at.t, x })?;
    if there.iter().any(|v| v.low != v.high) {
        return None;
    }
    let velocity = there.iter().map(|v| v.low * v.low).sum::<f64>().sqrt();
    if !falling.outweighs(velocity, level) {
        return None;
    }
    let mut differs = DMatrix::zeros(N, N);
    for j in 0..N {
        let seeded = std::array::from_fn(|i| {
            let unit = if i == j { 1.0 } else { 0.0 };
            Dual::new(over[i], Interval::around(unit, 0.0))
        });
        let time = Dual::new(ever, Interval::around(0.0, 0.0));
        let column = Interval::decided(|| system.slip_field(mode, time, &seeded)).flatten()?;
        for i in 0..N {
            let Interval { low, high } = column[i].eps;
            if !low.is_finite() || !high.is_finite() {
                return None;
            }
            differs[(i, j)] = (high - jacobian[(i, j)]).max(jacobian[(i, j)] - low);
        }
    }
    falling.withstands(&differs).then_some(x)
}

/// Whether all eigenvalues are to the left of zero for certain.
fn attracts<const N: usize>(jacobian: &SMatrix<f64, N, N>) -> bool {
    let bound = -ZERO * jacobian.amax();
    multipliers(jacobian).iter().all(|value| value.re < bound)
}

/// A quadratic function that falls along a linear flow: `P` of `JᵀP + PJ = −1`. Of any number of states, so that it is compiled once.
struct Falling {
    weights: DMatrix<f64>,
    inverse: DMatrix<f64>,
    /// No less than the norm of `P`.
    norm: f64,
    /// By how much rounding misses the equation.
    rounded: f64,
}

impl Falling {
    /// That of a Jacobian; `None` where there is none that is positive.
    fn along(jacobian: &DMatrix<f64>) -> Option<Self> {
        let n = jacobian.nrows();
        let place = |i: usize, j: usize| i * n + j;
        let mut equations = DMatrix::zeros(n * n, n * n);
        let mut right = DVector::zeros(n * n);
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
        let weights = DMatrix::from_fn(n, n, entry);
        let half = &weights * jacobian;
        let rounded = norm(&(&half + half.transpose() + DMatrix::identity(n, n)));
        let inverse = Cholesky::new(weights.clone())?.inverse();
        rounded.is_finite().then(|| Falling {
            norm: norm(&weights),
            weights,
            inverse,
            rounded,
        })
    }

    fn at(&self, away: &[f64]) -> f64 {
        let away = DVector::from_column_slice(away);
        away.dot(&(&self.weights * &away))
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
    fn withstands(&self, differs: &DMatrix<f64>) -> bool {
        let taken = self.weights.abs() * differs;
        norm(&(&taken + taken.transpose())) + self.rounded <= MOST_TAKEN
    }
}

/// The largest sum of a row of sizes: no less than the norm of a symmetric matrix.
fn norm(matrix: &DMatrix<f64>) -> f64 {
    let sums = matrix.row_iter().map(|row| row.abs().sum());
    sums.fold(0.0, f64::max)
}
