//! Periodic orbits by shooting.

use super::anchor::Anchor;
use super::monodromy::{Monodromy, Turn, turn};
use crate::dynamics::{
    AsDynamics, Components, Dynamics, Happening, Matrix, Moment, Section, Vector,
};
use crate::error::Error;
use crate::filippov::{Direction, Options};
use crate::orbit::Ending;

/// A periodic orbit.
#[derive(Clone, Debug, PartialEq)]
pub struct PeriodicOrbit {
    /// Time at which the orbit is at `x`.
    pub t: f64,
    /// A state on it.
    pub x: Vector,
    /// Period.
    pub period: f64,
    /// Monodromy matrix over one period; its eigenvalues are the Floquet multipliers.
    pub monodromy: Matrix,
    /// Largest component of `x(t + period) − x`.
    pub residual: f64,
    /// Dimension of the family of periodic orbits that it is one of; 0 where it is isolated. So
    /// many multipliers are 1 besides the trivial one of a system that does not depend on time, as
    /// far as the tolerances tell. The one found is the nearest to the start.
    pub family: usize,
}

/// Iterations allowed.
const MOST: usize = 30;

/// Tolerances within which an orbit has come back.
const TOLERANCES: f64 = 100.0;

/// Units in the last place that a step may leave of a gap.
const ULPS: f64 = 16.0;

/// The periodic orbit near `x` of a system with period `period` in time (a forced one), by Newton's iteration on
/// `x(t + period) − x` with the monodromy matrix.
///
/// # Errors
/// Those of [`crate::run`]; [`Error::NoUniqueFuture`] and [`Error::TangentSingular`] as for [`crate::analysis::monodromy`]; [`Error::NotConverged`] when the iteration reaches neither 100 tolerances nor what rounding leaves.
pub fn periodic_orbit_forced<Kind>(
    system: &impl AsDynamics<Kind>,
    t: f64,
    x: impl Components,
    period: f64,
    options: &Options,
) -> Result<PeriodicOrbit, Error> {
    let system = &*system.dynamics();
    let at = Moment { t, x: x.vector() };
    let start = Anchor::at_start(system, at, t + period, options)?;
    shoot(system, &start, period, true, options)
}

/// The periodic orbit near `x`, with a period near `period` (less than twice that), of a system that does not depend on time, by Newton's
/// iteration for state and period together. From an `x` on Σ that sticks, to rounding, the orbit is sought on Σ.
///
/// # Errors
/// Those of [`crate::run`]; [`Error::NoUniqueFuture`] and [`Error::TangentSingular`] as for [`crate::analysis::monodromy`]; [`Error::NotConverged`] when the iteration reaches neither 100 tolerances nor what rounding leaves.
///
/// ```
/// use stickslip::{analysis::{periodic_orbit, multipliers}, models::BeltOscillator, Options};
/// let belt = BeltOscillator::default();
/// let cycle = periodic_orbit(&belt, [-0.27, -0.73], 7.7, &Options::tol(1e-12))?;
/// let found = multipliers(&cycle.monodromy);
/// assert!((found[0].re - 1.0).abs() < 1e-9 && found[1].re.abs() < 1.0); // stable
/// # Ok::<(), stickslip::Error>(())
/// ```
pub fn periodic_orbit<Kind>(
    system: &impl AsDynamics<Kind>,
    x: impl Components,
    period: f64,
    options: &Options,
) -> Result<PeriodicOrbit, Error> {
    let system = &*system.dynamics();
    let at = Moment {
        t: 0.0,
        x: x.vector(),
    };
    let start = Anchor::at_start(system, at, period, options)?;
    shoot(system, &start, period, false, options)
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
pub fn find_periodic_orbit<Kind>(
    system: &impl AsDynamics<Kind>,
    x0: impl Components,
    transient: f64,
    longest: f64,
    options: &Options,
) -> Result<PeriodicOrbit, Error> {
    let system = &*system.dynamics();
    let (t, x) = (0.0, x0.vector());
    let (at, t_end) = (Moment { t, x }, transient + longest);
    let mut orbit = system.begin(&at, t_end, options, &Section::None)?;
    let not_found = || Error::NotFound {
        what: "a return of the orbit",
        t: transient,
        span: longest,
    };
    let mut fewest: Option<(usize, Anchor)> = None;
    let start = loop {
        match orbit.step()? {
            Happening::Step => {
                let step = orbit.last_step();
                let length = step.t_end - step.t_start;
                if step.t_start < transient || length <= 0.0 {
                    continue;
                }
                let t = step.t_start + 0.5 * length;
                let here = Anchor::new(t, orbit.solution()(t), step.mode);
                let stick = system.normals(step.mode, &here).len();
                // In the middle of a slip it is not on Σ.
                if stick == 0 {
                    break here;
                }
                if fewest.as_ref().is_none_or(|(least, _)| stick < *least) {
                    fewest = Some((stick, here.settled(system)));
                }
            }
            Happening::End(summary) if summary.ending == Ending::EndTime => {
                let moves = |(_, here): &(usize, Anchor)| {
                    here.velocity(system).amax() * longest > f64::EPSILON * here.x.amax()
                };
                let (_, here) = fewest.filter(moves).ok_or_else(not_found)?;
                orbit = system.begin(&here, t_end, options, &Section::None)?;
                break here;
            }
            Happening::End(summary) => return Err(summary.goes_no_further()),
            Happening::PhaseEnd(_) | Happening::Transition(_) | Happening::Passage(_) => {}
        }
    };
    orbit.watch(&Section::Plane {
        point: start.x.clone(),
        normal: start.velocity(system),
        direction: Direction::Rising,
    });
    let mut returns = Vec::new();
    loop {
        match orbit.step()? {
            Happening::Passage(at) => returns.push((at.t - start.t, (at.x - &start.x).norm())),
            Happening::End(summary) if summary.ending == Ending::EndTime => break,
            Happening::End(summary) => return Err(summary.goes_no_further()),
            Happening::Step | Happening::PhaseEnd(_) | Happening::Transition(_) => {}
        }
    }
    let nearest = returns.iter().map(|r| r.1).fold(f64::INFINITY, f64::min);
    // Nearer than the tolerance tells, one return is as good as another.
    let blurred = options.atol + options.rtol * start.x.norm();
    let near = 2.0 * nearest.max(TOLERANCES * blurred);
    let first = returns.iter().find(|r| r.1 <= near);
    let &(period, _) = first.ok_or_else(not_found)?;
    shoot(system, &start.at_time(0.0), period, false, options)
}

/// Newton's iteration from a guess; unless the system is driven, with that period, the period is
/// unknown too, and along the flow at the guess no correction is made. A guess in stick is kept on
/// its boundary.  Of a family the orbit is found that is nearest to the guess: the iteration goes
/// along no direction that is free, which away from the orbit only the outcome tells.
fn shoot(
    system: &dyn Dynamics,
    guess: &Anchor,
    guessed: f64,
    is_forced: bool,
    options: &Options,
) -> Result<PeriodicOrbit, Error> {
    let with_free = |free| iterate(system, guess, guessed, is_forced, options, free);
    match with_free(0) {
        Ok(found) if found.family > 0 => with_free(found.family).or(Ok(found)),
        Err(error @ Error::NotConverged { .. }) => {
            let of_family = with_free(1).ok().filter(|found| found.family > 0);
            of_family.ok_or(error)
        }
        outcome => outcome,
    }
}

/// The same with so many directions that it does not go along.
fn iterate(
    system: &dyn Dynamics,
    guess: &Anchor,
    guessed: f64,
    is_forced: bool,
    options: &Options,
    free: usize,
) -> Result<PeriodicOrbit, Error> {
    let by_tolerance = TOLERANCES * options.atol.max(options.rtol);
    let (mut residual, mut wanted) = (f64::INFINITY, by_tolerance);
    let mut at = guess.clone().begun(system, guess.t + guessed, options)?;
    let mut period = guessed;
    let phase = (!is_forced).then(|| at.velocity(system));
    for _ in 0..MOST {
        let turn = turn(system, &at, at.t + period, options, !is_forced)?;
        let Turn { monodromy, .. } = &turn;
        if monodromy.summary.ending != Ending::EndTime {
            return Err(monodromy.summary.goes_no_further());
        }
        let gap = &monodromy.summary.x - &at.x;
        let size = gap.amax();
        wanted = by_tolerance.max(rounding(monodromy, &at.x));
        let speed = phase
            .as_ref()
            .map_or(f64::INFINITY, |_| at.velocity(system).amax());
        // What moves no further in a turn than it may be off repeats itself because it rests.
        if speed * period <= wanted {
            residual = size;
            break;
        }
        // The last halvings of the residual are rounding: stop at the first iterate that is no better.
        if size <= wanted && size >= 0.5 * residual || size == 0.0 {
            let solved = correction(&turn, &gap, phase.as_ref(), options, 0);
            let family = solved.map_or(0, |(_, free)| free);
            let cycle = PeriodicOrbit {
                t: at.t,
                x: at.x.clone(),
                period,
                monodromy: monodromy.matrix.clone(),
                residual: size,
                family,
            };
            return Ok(cycle);
        }
        residual = size;
        // An equilibrium repeats itself after any time; the iteration may fall into one.
        if speed * period < 1e-3 * at.x.amax().max(1e-3) {
            break;
        }
        let Some(((dx, change), _)) = correction(&turn, &gap, phase.as_ref(), options, free) else {
            break;
        };
        let moved = guess.moved(&at.x + dx);
        period += change;
        // A bad guess may ask for any period, and as long a run.
        let is_near = (period - guessed).abs() < guessed;
        if !(is_near && moved.x.iter().all(|v| v.is_finite())) {
            break;
        }
        at = moved.begun(system, guess.t + period, options)?;
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
fn rounding(turn: &Monodromy, x: &Vector) -> f64 {
    let size = x.amax().max(turn.summary.x.amax());
    ULPS * f64::EPSILON * turn.summary.counters.steps as f64 * size * turn.matrix.amax().max(1.0)
}

/// Newton's correction of state and period, and in how many directions it is free.
fn correction(
    turn: &Turn,
    gap: &Vector,
    phase: Option<&Vector>,
    options: &Options,
    free: usize,
) -> Option<((Vector, f64), usize)> {
    let states = gap.len();
    let unknowns = states + usize::from(phase.is_some());
    let mut matrix = Matrix::zeros(unknowns, unknowns);
    let mut right = Vector::zeros(unknowns);
    for i in 0..states {
        for j in 0..states {
            matrix[(i, j)] = turn.monodromy.matrix[(i, j)] - f64::from(u8::from(i == j));
        }
        right[i] = -gap[i];
    }
    if let Some(direction) = phase {
        for i in 0..states {
            matrix[(i, states)] = turn.velocity[i];
            matrix[(states, i)] = direction[i];
        }
    }
    let (solution, free) = newton_solution(matrix, &right, (states, free), known(turn, options))?;
    let dx = solution.rows(0, states).into_owned();
    let change = solution.get(states).copied().unwrap_or(0.0);
    Some(((dx, change), free))
}

/// How far the components go in a turn, of one that goes no way as far as the others; and how well
/// its derivative is known, in parts of its largest singular value: by what tolerances and rounding
/// leave of an orbit's gap.
fn known(turn: &Turn, options: &Options) -> (Vector, f64) {
    let by_tolerance = TOLERANCES * options.atol.max(options.rtol);
    let most = turn.reach.amax();
    let other = if most > by_tolerance { most } else { 1.0 };
    let size = |size: f64| if size > by_tolerance { size } else { other };
    let steps = turn.monodromy.summary.counters.steps as f64;
    (
        turn.reach.map(size),
        by_tolerance.max(ULPS * f64::EPSILON * steps),
    )
}

/// Solves the equations of a Newton step, of which the first are those of so many states. They may
/// leave directions free, to how well they are known: the place of a block that nothing depends on,
/// the energy of a pendulum. The solution does not go those ways, and at least so many are left
/// out. With it goes how many these are.
pub(super) fn newton_solution(
    matrix: Matrix,
    right: &Vector,
    (states, least_free): (usize, usize),
    (sizes, error): (Vector, f64),
) -> Option<(Vector, usize)> {
    let count = matrix.nrows();
    let mut scaled = matrix.clone();
    let mut units = Vector::repeat(count, 1.0);
    let mut right_scaled = right.clone();
    for (k, size) in sizes.iter().take(states).enumerate() {
        units[k] = *size;
        scaled.column_mut(k).scale_mut(*size);
        scaled.row_mut(k).unscale_mut(*size);
        right_scaled[k] /= *size;
    }
    // Of other unknowns and equations the size is that of what stands in them.
    for k in states..count {
        units[k] = scaled.column(k).norm().max(f64::MIN_POSITIVE).recip();
        scaled.column_mut(k).scale_mut(units[k]);
        let row = scaled.row(k).norm().max(f64::MIN_POSITIVE);
        scaled.row_mut(k).unscale_mut(row);
        right_scaled[k] /= row;
    }
    if !scaled.iter().all(|v| v.is_finite()) {
        return None;
    }
    if error == 0.0 {
        return Some((matrix.lu().solve(right)?, 0));
    }
    let parts = scaled.svd(true, true);
    let mut values: Vec<f64> = parts.singular_values.iter().copied().collect();
    values.sort_by(f64::total_cmp);
    let known = error.max(count as f64 * f64::EPSILON) * parts.singular_values.max();
    let bound = values
        .iter()
        .take(least_free)
        .copied()
        .fold(known, f64::max);
    let free = values.iter().filter(|value| **value <= bound);
    match free.count() {
        0 => Some((matrix.lu().solve(right)?, 0)),
        free => {
            let solution = parts.solve(&right_scaled, bound).ok()?;
            Some((solution.component_mul(&units), free))
        }
    }
}
