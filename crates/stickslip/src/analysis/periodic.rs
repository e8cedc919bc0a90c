//! Periodic orbits by shooting.

use nalgebra::{DMatrix, DVector, SMatrix};

use super::monodromy::{Monodromy, monodromy};
use crate::error::{Error, Point};
use crate::filippov::{Integration, Options, Progress, Switched, Velocity, first_zero};
use crate::orbit::Ending;
use crate::system::{State, components};

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
/// Those of [`crate::run`]; [`Error::NotConverged`] when the iteration reaches neither 100 tolerances nor what rounding leaves.
pub fn periodic_orbit_forced<S: Switched<N, G>, const N: usize, const G: usize>(
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
/// Those of [`crate::run`]; [`Error::NotConverged`] when the iteration reaches neither 100 tolerances nor what rounding leaves.
///
/// ```
/// use stickslip::{analysis::{periodic_orbit, multipliers}, models::BeltOscillator, Options};
/// let belt = BeltOscillator::default();
/// let cycle = periodic_orbit(&belt, [-0.27, -0.73], 7.7, &Options::tol(1e-12))?;
/// let [trivial, other] = multipliers(&cycle.monodromy);
/// assert!((trivial.re - 1.0).abs() < 1e-9 && other.re.abs() < 1.0); // stable
/// # Ok::<(), stickslip::Error>(())
/// ```
pub fn periodic_orbit<S: Switched<N, G>, const N: usize, const G: usize>(
    system: &S,
    x: impl Into<State<N>>,
    period: f64,
    options: &Options,
) -> Result<PeriodicOrbit<N>, Error> {
    let x = x.into();
    let slope = slope_at(system, 0.0, &x);
    shoot(system, 0.0, x, period, Some(slope), options)
}

/// The periodic orbit that the orbit from `x0` comes to, of a system that does not depend on time; no guess is needed.
///
/// After `transient` the run goes on through a plane across its way, for `longest` at most. Of its returns the first that comes
/// back about as near as any does (within a factor of two) gives the period that [`periodic_orbit`] begins with.
///
/// # Errors
/// As [`periodic_orbit`]; [`Error::NotFound`] where there is no return, as on the way to an equilibrium.
///
/// ```
/// use stickslip::{Options, analysis::find_periodic_orbit, models::BeltOscillator};
///
/// let belt = BeltOscillator { belt_speed: 0.2, ..BeltOscillator::default() };
/// let cycle = find_periodic_orbit(&belt, [0.5, 0.1], 50.0, 50.0, &Options::tol(1e-12))?;
/// assert!(cycle.residual < 1e-10);
/// # Ok::<(), stickslip::Error>(())
/// ```
pub fn find_periodic_orbit<S: Switched<N, G>, const N: usize, const G: usize>(
    system: &S,
    x0: impl Into<State<N>>,
    transient: f64,
    longest: f64,
    options: &Options,
) -> Result<PeriodicOrbit<N>, Error> {
    let mut section: Option<Section<N>> = None;
    let mut returns = Vec::new();
    let mut integration = Integration::new(system, 0.0, x0, transient + longest, options)?;
    loop {
        match integration.step()? {
            Progress::Step if integration.t() > transient => {}
            Progress::Step | Progress::PhaseEnd(_) | Progress::Transition(_) => continue,
            Progress::End(summary) if summary.ending == Ending::EndTime => break,
            Progress::End(summary) => {
                let (t, x) = (summary.t, Point::from(&summary.x));
                return Err(Error::NoUniqueFuture { t, x });
            }
        }
        let step = integration.last_step();
        let length = step.t_end - step.t_start;
        match &section {
            Some(section) => {
                let height =
                    |s: f64| section.height(&step.dense.at_time(step.t_start + s * length));
                if height(0.0) < 0.0
                    && height(1.0) >= 0.0
                    && let Some(s) = first_zero(|s| -height(s), 0.0, 1.0)
                {
                    let t = step.t_start + s * length;
                    let gap = step.dense.at_time(t) - section.x;
                    returns.push((t - section.t, gap.norm()));
                }
            }
            // In the middle of a slip it is not on Σ.
            None => {
                if step.t_start >= transient && !S::sticks(step.mode) && length > 0.0 {
                    let t = step.t_start + 0.5 * length;
                    let x = step.dense.at_time(t);
                    let normal = slope_at(system, t, &x);
                    section = Some(Section { t, x, normal });
                }
            }
        }
    }
    let nearest = returns.iter().map(|r| r.1).fold(f64::INFINITY, f64::min);
    let first = returns.iter().find(|r| r.1 <= 2.0 * nearest);
    let (Some(section), Some(&(period, _))) = (section, first) else {
        return Err(Error::NotFound {
            what: "a return of the orbit",
            t: transient,
            span: longest,
        });
    };
    periodic_orbit(system, section.x, period, options)
}

/// A plane across an orbit.
struct Section<const N: usize> {
    /// When the orbit was first on it, and where.
    t: f64,
    x: State<N>,
    /// The orbit's direction there.
    normal: State<N>,
}

impl<const N: usize> Section<N> {
    fn height(&self, x: &State<N>) -> f64 {
        self.normal.dot(&(x - self.x))
    }
}

/// The vector that moves a state: of its side's field, or on Σ the sliding one.
fn slope_at<S: Switched<N, G>, const N: usize, const G: usize>(
    system: &S,
    t: f64,
    x: &State<N>,
) -> State<N> {
    let mode = system.mode_by_side(t, x);
    let here = Velocity(t, components(x));
    system.with_flow(mode, S::Branch::default(), here).into()
}

/// Newton's iteration; with `phase` (the flow's direction at the guess, along which no correction is made) the period
/// is unknown too.
fn shoot<S: Switched<N, G>, const N: usize, const G: usize>(
    system: &S,
    t: f64,
    mut x: State<N>,
    mut period: f64,
    phase: Option<State<N>>,
    options: &Options,
) -> Result<PeriodicOrbit<N>, Error> {
    let by_tolerance = 100.0 * options.atol.max(options.rtol);
    let (mut residual, mut wanted) = (f64::INFINITY, by_tolerance);
    for _ in 0..MOST {
        let turn = monodromy(system, t, x, t + period, options)?;
        if turn.summary.ending != Ending::EndTime {
            let (t, x) = (turn.summary.t, Point::from(&turn.summary.x));
            return Err(Error::NoUniqueFuture { t, x });
        }
        let gap = turn.summary.x - x;
        let size = gap.amax();
        wanted = by_tolerance.max(rounding(&turn, &x));
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

/// What rounding may leave of a turn's gap: some units in the last place of the state for every step (the weights of a step of
/// order 8 add up to 14), enlarged as far as the turn enlarges what is off at its start.
fn rounding<const N: usize>(turn: &Monodromy<N>, x: &State<N>) -> f64 {
    const ULPS: f64 = 16.0;
    let size = x.amax().max(turn.summary.x.amax());
    ULPS * f64::EPSILON * turn.summary.counters.steps as f64 * size * turn.matrix.amax().max(1.0)
}

/// Newton's correction of state and period.
fn correction<S: Switched<N, G>, const N: usize, const G: usize>(
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
