//! Periodic orbits by shooting.

use nalgebra::{Complex, DMatrix, DVector, SMatrix};

use super::monodromy::{Monodromy, monodromy};
use crate::error::{Error, Point};
use crate::filippov::{Options, sliding_field};
use crate::orbit::Ending;
use crate::system::{Filippov, Side, State, components};

/// A periodic orbit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeriodicOrbit<const N: usize> {
    /// Time at which the orbit is at `x`.
    pub t: f64,
    /// A state on it.
    pub x: State<N>,
    /// Period.
    pub period: f64,
    /// Monodromy matrix over one period; its eigenvalues are the Floquet multipliers.
    pub monodromy: SMatrix<f64, N, N>,
    /// Largest component of `x(t + period) − x`.
    pub residual: f64,
}

/// Iterations allowed.
const MOST: usize = 30;

/// The periodic orbit near `x` of a system with period `period` in time (a forced one), by Newton's iteration on
/// `x(t + period) − x` with the monodromy matrix.
///
/// # Errors
/// Those of [`crate::run`]; [`Error::NotConverged`] when the iteration does not reach 100 tolerances.
pub fn periodic_orbit_forced<S: Filippov<N>, const N: usize>(
    system: &S,
    t: f64,
    x: impl Into<State<N>>,
    period: f64,
    options: &Options,
) -> Result<PeriodicOrbit<N>, Error> {
    shoot(system, t, x.into(), period, None, options)
}

/// The periodic orbit near `x`, with a period near `period`, of a system that does not depend on time, by Newton's
/// iteration for state and period together. `x` should not lie on Σ.
///
/// # Errors
/// Those of [`crate::run`]; [`Error::NotConverged`] when the iteration does not reach 100 tolerances.
///
/// ```
/// use stickslip::{analysis::{periodic_orbit, planar_multipliers}, models::BeltOscillator, Options};
/// let belt = BeltOscillator::default();
/// let cycle = periodic_orbit(&belt, [-0.27, -0.73], 7.7, &Options::tol(1e-12))?;
/// let [trivial, other] = planar_multipliers(&cycle.monodromy);
/// assert!((trivial.re - 1.0).abs() < 1e-9 && other.re.abs() < 1.0); // stable
/// # Ok::<(), stickslip::Error>(())
/// ```
pub fn periodic_orbit<S: Filippov<N>, const N: usize>(
    system: &S,
    x: impl Into<State<N>>,
    period: f64,
    options: &Options,
) -> Result<PeriodicOrbit<N>, Error> {
    let x = x.into();
    let slope = slope_at(system, 0.0, &x);
    shoot(system, 0.0, x, period, Some(slope), options)
}

/// The vector that moves a state: of its side's field, or on Σ the sliding one.
fn slope_at<S: Filippov<N>, const N: usize>(system: &S, t: f64, x: &State<N>) -> State<N> {
    let x = components(x);
    let h = system.boundary(t, x);
    let slope = if h == 0.0 {
        sliding_field(system, t, x)
    } else {
        let side = if h < 0.0 { Side::Below } else { Side::Above };
        system.field(side, t, x)
    };
    slope.into()
}

/// Newton's iteration; with `phase` (the flow's direction at the guess, along which no correction is made) the period
/// is unknown too.
fn shoot<S: Filippov<N>, const N: usize>(
    system: &S,
    t: f64,
    mut x: State<N>,
    mut period: f64,
    phase: Option<State<N>>,
    options: &Options,
) -> Result<PeriodicOrbit<N>, Error> {
    let wanted = 100.0 * options.atol.max(options.rtol);
    let mut residual = f64::INFINITY;
    for _ in 0..MOST {
        let turn = monodromy(system, t, x, t + period, options)?;
        if turn.summary.ending != Ending::EndTime {
            let (t, x) = (turn.summary.t, Point::from(&turn.summary.x));
            return Err(Error::NoUniqueFuture { t, x });
        }
        let gap = turn.summary.x - x;
        let size = gap.amax();
        // The last halvings of the residual are rounding: stop at the first iterate that is no better.
        if size <= wanted && size >= 0.5 * residual || size == 0.0 {
            return Ok(PeriodicOrbit {
                t,
                x,
                period,
                monodromy: turn.matrix,
                residual: size,
            });
        }
        residual = size;
        // An equilibrium repeats itself after any time; the iteration may fall into one.
        if phase.is_some() && slope_at(system, t, &x).amax() * period < 1e-3 * x.amax().max(1e-3) {
            break;
        }
        let Some((dx, change)) = correction(system, t + period, &turn, &gap, phase.as_ref()) else {
            break;
        };
        x += dx;
        period += change;
        if !(period > 0.0 && x.iter().all(|v| v.is_finite())) {
            break;
        }
    }
    Err(Error::NotConverged {
        what: "the periodic orbit",
        iterations: MOST,
        residual,
        wanted,
    })
}

/// Newton's correction of state and period.
fn correction<S: Filippov<N>, const N: usize>(
    system: &S,
    t_end: f64,
    turn: &Monodromy<N>,
    gap: &State<N>,
    phase: Option<&State<N>>,
) -> Option<(State<N>, f64)> {
    let unknowns = N + usize::from(phase.is_some());
    let mut matrix = DMatrix::<f64>::zeros(unknowns, unknowns);
    let mut right = DVector::<f64>::zeros(unknowns);
    for i in 0..N {
        for j in 0..N {
            matrix[(i, j)] = turn.matrix[(i, j)] - f64::from(u8::from(i == j));
        }
        right[i] = -gap[i];
    }
    if let Some(direction) = phase {
        let slope = slope_at(system, t_end, &turn.summary.x);
        for i in 0..N {
            matrix[(i, N)] = slope[i];
            matrix[(N, i)] = direction[i];
        }
    }
    let solution = matrix.lu().solve(&right)?;
    let dx = State::from_fn(|i, _| solution[i]);
    Some((dx, if phase.is_some() { solution[N] } else { 0.0 }))
}

/// Eigenvalues of a planar monodromy matrix, the one nearest to 1 first (the trivial one of a system that does not
/// depend on time).
pub fn planar_multipliers(matrix: &SMatrix<f64, 2, 2>) -> [Complex<f64>; 2] {
    let half_trace = 0.5 * (matrix[(0, 0)] + matrix[(1, 1)]);
    let determinant = matrix[(0, 0)] * matrix[(1, 1)] - matrix[(0, 1)] * matrix[(1, 0)];
    let discriminant = half_trace * half_trace - determinant;
    if discriminant < 0.0 {
        let imaginary = (-discriminant).sqrt();
        return [
            Complex::new(half_trace, imaginary),
            Complex::new(half_trace, -imaginary),
        ];
    }
    // The larger by size without cancellation, the other from the product.
    let larger = half_trace + discriminant.sqrt() * half_trace.signum();
    let smaller = if larger == 0.0 {
        0.0
    } else {
        determinant / larger
    };
    let pair = [Complex::new(larger, 0.0), Complex::new(smaller, 0.0)];
    if (larger - 1.0).abs() <= (smaller - 1.0).abs() {
        pair
    } else {
        [pair[1], pair[0]]
    }
}
