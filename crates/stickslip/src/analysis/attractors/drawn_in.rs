//! Whether an orbit that slips can no longer get away from an equilibrium.

use nalgebra::{Cholesky, DMatrix, DVector, SMatrix};

use super::rest::{Rest, ZERO, equilibrium_near};
use crate::analysis::multipliers;
use crate::dual::Dual;
use crate::filippov::{Flow, Switched, UseFlow, Velocity};
use crate::interval::Interval;
use crate::ode::Timed;
use crate::system::State;

/// The ellipsoid is larger than the orbit needs by this, which leaves room for rounding.
const ROOM: f64 = 1.0 + 1e-6;

/// Part of the decay near the equilibrium that the field's nonlinearity may take away.
const MOST_TAKEN: f64 = 0.9;

/// Part of the state's size by which the field may miss zero at the equilibrium: rounding.
const ROUNDING: f64 = 1e-9;

/// Whether no guard comes near zero in a box, ever.
struct StaysClear<'a, const N: usize>(Interval, &'a [Interval; N]);

impl<const N: usize> UseFlow<N> for StaysClear<'_, N> {
    type Output = bool;

    fn with<F: Flow<N>>(self, flow: &F) -> bool {
        F::GUARDS.iter().all(|&i| flow.is_clear(i, self.0, self.1))
    }
}

/// The equilibrium that the orbit at `at` comes to for certain, without another event, though it may be far from it yet.
///
/// Near a stable equilibrium `V(y) = yᵀPy` with `JᵀP + PJ = −1` falls along the linear flow (Lyapunov). It does so along the flow itself
/// wherever the Jacobian differs little enough from `J`; over the box around the ellipsoid on which the orbit is, intervals tell by how
/// much it differs, and that no boundary is met. The ellipsoid then is never left, and `V` goes to zero.
pub(super) fn drawn_to<S: Switched<N, G>, const N: usize, const G: usize>(
    system: &S,
    mode: S::Mode,
    at: &Timed<N>,
) -> Option<State<N>> {
    // While a contact sticks, what ends that takes derivatives, which intervals do not have.
    if S::any_sticks(mode) {
        return None;
    }
    let Rest { x, jacobian } = equilibrium_near(system, mode, at.t, &at.x, N)?;
    if !attracts(&jacobian) {
        return None;
    }
    let weights = weights(&jacobian)?;
    let inverse = Cholesky::new(weights)?.inverse();
    let away = at.x - x;
    let level = ROOM * away.dot(&(weights * away));
    let radius: [f64; N] = std::array::from_fn(|i| (level * inverse[(i, i)]).sqrt());
    let ever = Interval::new(at.t, f64::INFINITY);
    let over: [Interval; N] = std::array::from_fn(|i| Interval::around(x[i], radius[i]));
    let branch = system.branch(at);
    if !system.with_flow(mode, branch, StaysClear(ever, &over)) {
        return None;
    }
    // A field that depends on time has no equilibrium.
    let point: [Interval; N] = std::array::from_fn(|i| Interval::around(x[i], 0.0));
    let there = Interval::decided(|| system.with_flow(mode, branch, Velocity(ever, &point)))?;
    let rounding = ROUNDING * jacobian.amax() * x.amax().max(away.amax());
    let vanishes = |v: &Interval| v.low >= -rounding && v.high <= rounding;
    if !there.iter().all(vanishes) {
        return None;
    }
    let mut differs = SMatrix::<f64, N, N>::zeros();
    for j in 0..N {
        let seeded = std::array::from_fn(|i| {
            let unit = if i == j { 1.0 } else { 0.0 };
            Dual::new(over[i], Interval::around(unit, 0.0))
        });
        let time = Dual::new(ever, Interval::around(0.0, 0.0));
        let column = Interval::decided(|| system.with_flow(mode, branch, Velocity(time, &seeded)))?;
        for i in 0..N {
            let Interval { low, high } = column[i].eps;
            differs[(i, j)] = (high - jacobian[(i, j)]).max(jacobian[(i, j)] - low);
        }
    }
    if differs.iter().any(|d| !d.is_finite()) {
        return None;
    }
    // The largest sum of a row bounds the norm of what is taken from −1.
    let taken = weights.abs() * differs;
    let taken = taken + taken.transpose();
    let most = taken.row_iter().map(|row| row.sum()).fold(0.0, f64::max);
    (most <= MOST_TAKEN).then_some(x)
}

/// Whether all eigenvalues are to the left of zero for certain.
fn attracts<const N: usize>(jacobian: &SMatrix<f64, N, N>) -> bool {
    let bound = -ZERO * jacobian.amax();
    multipliers(jacobian).iter().all(|value| value.re < bound)
}

/// `P` of `JᵀP + PJ = −1`; `None` where there is none.
fn weights<const N: usize>(jacobian: &SMatrix<f64, N, N>) -> Option<SMatrix<f64, N, N>> {
    let place = |i: usize, j: usize| i * N + j;
    let mut equations = DMatrix::zeros(N * N, N * N);
    let mut right = DVector::zeros(N * N);
    for i in 0..N {
        for j in 0..N {
            let row = place(i, j);
            for k in 0..N {
                equations[(row, place(k, j))] += jacobian[(k, i)];
                equations[(row, place(i, k))] += jacobian[(k, j)];
            }
            right[row] = if i == j { -1.0 } else { 0.0 };
        }
    }
    let solution = equations.lu().solve(&right)?;
    let entry = |i, j| 0.5 * (solution[place(i, j)] + solution[place(j, i)]);
    let weights = SMatrix::<f64, N, N>::from_fn(entry);
    let are_finite = weights.iter().all(|weight| weight.is_finite());
    are_finite.then_some(weights)
}
