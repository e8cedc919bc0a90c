//! Periodic orbits by shooting.

use nalgebra::Complex;

use super::attractors::SOLVER_TOLERANCES;
use super::continuation::BranchPoint;
use super::cycle::{Cycle, OrbitGuess, Shooting};
use super::monodromy::{flow_derivative, velocity_in};
use super::multipliers::{eigenvalues, multipliers, uncertainties};
use super::passages::{passages, plane};
use super::stability::Stability;
use crate::dynamics::{
    AsDynamics, Components, Dynamics, Matrix, Modes, Moment, OrbitProgress, Vector, run,
};
use crate::error::Error;
use crate::filippov::Options;
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
    /// Residual allowed: what the equations of all segments close to, carried to the end of the
    /// period.
    pub closes_to: f64,
    /// Dimension of the family of periodic orbits to which it belongs; 0 where it is isolated. The
    /// same number of nontrivial multipliers are 1, as far as the tolerances show. The orbit
    /// returned is the one nearest to the start.
    pub family: usize,
}

/// Number of phase sequences that are tried. Chosen: each takes a run over a period and a Newton
/// iteration.
const MOST_SEQUENCES: usize = 8;

impl PeriodicOrbit {
    /// The periodic orbit near `x` of a periodically forced system, with period `period`, at the
    /// time `t`.
    ///
    /// It is computed by Newton's iteration on its segments, with the phase sequence of the run
    /// from `x`. If the resulting orbit does not have this sequence itself, its own is tried next.
    /// If there is no such orbit, the run continues for a period. Eight sequences are tried.
    ///
    /// # Errors
    /// Those of [`crate::run`]; [`Error::NoUniqueFuture`] and [`Error::TangentSingular`] as for
    /// [`crate::analysis::Monodromy::of`], also of the last run from which no orbit was found.
    /// [`Error::NotFound`] where none of the sequences has an orbit
    /// that closes to 100 tolerances, or to the rounding of state and time, and moves by more than
    /// that. [`Error::NotConverged`] where the run from the orbit does not return to it.
    pub fn near_forced<Kind>(
        system: &impl AsDynamics<Kind>,
        t: f64,
        x: impl Components,
        period: f64,
        options: &Options,
    ) -> Result<PeriodicOrbit, Error> {
        let at = Moment { t, x: x.vector() };
        orbit_near(&*system.dynamics(), &at, (period, true), options)
    }
}

impl PeriodicOrbit {
    /// The periodic orbit near `x` of an autonomous system, with a period near `period` (within 30
    /// %). It is computed as in [`PeriodicOrbit::near_forced`], with the period as another unknown.
    ///
    /// The state returned is where the orbit passes the plane through `x` perpendicular to the flow
    /// there.
    ///
    /// # Errors
    /// As [`PeriodicOrbit::near_forced`].
    pub fn near<Kind>(
        system: &impl AsDynamics<Kind>,
        x: impl Components,
        period: f64,
        options: &Options,
    ) -> Result<PeriodicOrbit, Error> {
        let (t, x) = (0.0, x.vector());
        orbit_near(
            &*system.dynamics(),
            &Moment { t, x },
            (period, false),
            options,
        )
    }
}

impl PeriodicOrbit {
    /// The periodic orbit that the orbit from `x0` of an autonomous system approaches; no guess is
    /// needed.
    ///
    /// After `transient` the run passes repeatedly through a plane perpendicular to the flow, for
    /// at most `longest`. The first return that is about as near as the nearest one (within a
    /// factor of two) gives the period for [`PeriodicOrbit::near`]. Of the orbit found,
    /// [`PeriodicOrbit::with_shortest_period`] is returned.
    ///
    /// # Errors
    /// Those of [`PeriodicOrbit::near`]; [`Error::NotFound`] where there is no return, as on the
    /// way to an equilibrium.
    ///
    /// ```
    #[doc = include_str!("../../examples/common/belt.rs")]
    /// use stickslip::Options;
    /// use stickslip::analysis::{PeriodicOrbit, multipliers};
    ///
    /// let belt = Belt { speed: 1.0 };
    /// let options = Options::tol(1e-12);
    /// let cycle = PeriodicOrbit::approached(&belt, [-0.3, -0.7], 50.0, 50.0, &options)?;
    /// let found = multipliers(&cycle.monodromy);
    /// assert!((found[0].re - 1.0).abs() < 1e-9 && found[1].re.abs() < 1.0); // stable
    /// # Ok::<(), stickslip::Error>(())
    /// ```
    pub fn approached<Kind>(
        system: &impl AsDynamics<Kind>,
        x0: impl Components,
        transient: f64,
        longest: f64,
        options: &Options,
    ) -> Result<PeriodicOrbit, Error> {
        let system = &*system.dynamics();
        let (t, x) = (0.0, x0.vector());
        let (at, t_end) = (Moment { t, x }, transient + longest);
        let mut orbit = system.begin(&at, t_end, options, &[])?;
        let not_found = || Error::NotFound {
            what: "a return of the orbit",
            t: transient,
            span: longest,
        };
        let mut fewest_sticking: Option<(usize, StateInMode)> = None;
        let (start, mode) = loop {
            match orbit.step()? {
                OrbitProgress::Step => {
                    let step = orbit.last_step();
                    let length = step.t_end - step.t_start;
                    if step.t_start < transient || length <= 0.0 {
                        continue;
                    }
                    let t = step.t_start + 0.5 * length;
                    let x = orbit.solution()(t);
                    let here = (Moment { t, x }, step.mode);
                    let stick = system.normals(step.mode, &here.0).len();
                    // In the middle of a slip it is not on Σ.
                    if stick == 0 {
                        break here;
                    }
                    if fewest_sticking
                        .as_ref()
                        .is_none_or(|(least, _)| stick < *least)
                    {
                        fewest_sticking = Some((stick, (settled(system, &here), step.mode)));
                    }
                }
                OrbitProgress::End(summary) if summary.ending == Ending::EndTime => {
                    let moves = |(_, (at, mode)): &(usize, StateInMode)| {
                        velocity_in(system, *mode, at).amax() * longest > f64::EPSILON * at.x.amax()
                    };
                    let (_, here) = fewest_sticking.filter(moves).ok_or_else(not_found)?;
                    orbit = system.begin(&here.0, t_end, options, &[])?;
                    break here;
                }
                OrbitProgress::End(summary) => return Err(summary.no_future_error()),
                OrbitProgress::PhaseEnd(_)
                | OrbitProgress::Transition(_)
                | OrbitProgress::Passage(_)
                | OrbitProgress::Kink(_) => {}
            }
        };
        orbit.watch(&[plane(system, mode, &start)]);
        // Within the error of the run, all returns are equally good.
        let error = SOLVER_TOLERANCES * (options.atol.largest() + options.rtol * start.x.norm());
        let mut returns = Vec::new();
        loop {
            match orbit.step()? {
                OrbitProgress::Passage(at) => {
                    let distance = (at.x - &start.x).norm();
                    returns.push((at.t - start.t, distance));
                    if distance <= error {
                        break;
                    }
                }
                OrbitProgress::End(summary) if summary.ending == Ending::EndTime => break,
                OrbitProgress::End(summary) => return Err(summary.no_future_error()),
                OrbitProgress::Step
                | OrbitProgress::PhaseEnd(_)
                | OrbitProgress::Transition(_)
                | OrbitProgress::Kink(_) => {}
            }
        }
        let nearest = returns.iter().map(|r| r.1).fold(f64::INFINITY, f64::min);
        let near = 2.0 * nearest.max(error);
        let first = returns.iter().find(|r| r.1 <= near);
        let &(period, _) = first.ok_or_else(not_found)?;
        let start = Moment { t: 0.0, ..start };
        let orbit = orbit_near(system, &start, (period, false), options)?;
        shortest(system, orbit, None, options)
    }
}

impl PeriodicOrbit {
    /// The periodic orbit with its shortest period. Where a run alternates about the orbit that it
    /// approaches, its nearest return comes after a multiple of the period.
    ///
    /// A part of the orbit is an orbit if it closes to within [`PeriodicOrbit::closes_to`]. With a
    /// drive, whose period divides that of the orbit, a part takes whole periods of the drive.
    /// Shortly before a period doubling, halves close less well. There the orbit of half the period
    /// is taken if it attracts, and both halves agree to what shooting resolves.
    ///
    /// # Errors
    /// Those of [`PeriodicOrbit::near`].
    pub fn with_shortest_period<Kind>(
        self,
        system: &impl AsDynamics<Kind>,
        drive: Option<f64>,
        options: &Options,
    ) -> Result<PeriodicOrbit, Error> {
        shortest(&*system.dynamics(), self, drive, options)
    }
}

fn shortest(
    system: &dyn Dynamics,
    orbit: PeriodicOrbit,
    drive: Option<f64>,
    options: &Options,
) -> Result<PeriodicOrbit, Error> {
    let start = Moment {
        t: orbit.t,
        x: orbit.x.clone(),
    };
    let closes = |x: &Vector| (x - &start.x).amax() <= orbit.closes_to;
    let period = match drive {
        Some(drive) => {
            if drive.is_nan() || drive <= 0.0 {
                return Err(Error::Parameter {
                    name: "the period of the drive",
                    value: drive,
                    bound: "positive",
                });
            }
            let count = (orbit.period / drive).round() as u32;
            let mut at = start.clone();
            let mut part = None;
            for periods in 1..=count / 2 {
                at = a_period_later(system, &at, drive, options)?;
                if count.is_multiple_of(periods) && closes(&at.x) {
                    part = Some(f64::from(periods) * drive);
                    break;
                }
            }
            part
        }
        None => {
            let closes = |at: &Moment| closes(&at.x);
            let passages = passages(system, (&start, orbit.period), &start, options, closes)?;
            let first = passages.last().filter(|at| closes(at));
            // It may be the end of the orbit.
            let part = first.map(|at| at.t - start.t);
            part.filter(|part| *part < 0.75 * orbit.period)
        }
    };
    let Some(period) = period else {
        return match half(system, &orbit, drive, options) {
            Some(half) => shortest(system, half, drive, options),
            None => Ok(orbit),
        };
    };
    match orbit_in_sequences(system, &start, (period, drive.is_some()), options) {
        // At a loose tolerance a part may close so badly that another orbit is near it.
        Ok(Ok(part)) if (&part.x - &start.x).amax() <= orbit.closes_to + part.residual => Ok(part),
        Ok(_) | Err(Error::NotConverged { .. } | Error::NotFound { .. }) => Ok(orbit),
        Err(other) => Err(other),
    }
}

/// The orbit of half the period, where it attracts and both halves agree to what shooting resolves.
fn half(
    system: &dyn Dynamics,
    orbit: &PeriodicOrbit,
    drive: Option<f64>,
    options: &Options,
) -> Option<PeriodicOrbit> {
    let is_forced = drive.is_some();
    let periods = drive.map_or(2.0, |drive| (orbit.period / drive).round());
    if periods % 2.0 != 0.0 {
        return None;
    }
    let start = Moment {
        t: orbit.t,
        x: orbit.x.clone(),
    };
    let outline = OrbitGuess::of_run(system, &start, orbit.period, options).ok()?;
    let forced = is_forced.then_some(orbit.period);
    let cycle = Shooting::of(system, &outline, forced, options).nearest(&outline, None)?;
    if cycle.is_half_twice() != Some(true) {
        return None;
    }
    let half = orbit_near(system, &start, (0.5 * orbit.period, is_forced), options).ok()?;
    let trivial = usize::from(!is_forced);
    let stability = Stability::of(multipliers(&half.monodromy).get(trivial..)?);
    (stability == Stability::Stable).then_some(half)
}

impl PeriodicOrbit {
    /// Uncertainties of the multipliers of a periodic orbit, in the order of [`multipliers`]; NaN
    /// where the orbit is not found again. It is computed with half the steps, as for places on a
    /// branch, and with the options by which it was found; `is_forced` for a forced system.
    pub fn multiplier_uncertainties<Kind>(
        &self,
        system: &impl AsDynamics<Kind>,
        is_forced: bool,
        options: &Options,
    ) -> Vec<f64> {
        let x = self.x.clone();
        let at = (Moment { t: self.t, x }, self.period, is_forced);
        let again = with_half_steps(&*system.dynamics(), at, options);
        let others = again.map_or_else(Vec::new, |cycle| {
            // The trivial one of an autonomous system is not computed again.
            let trivial = (!is_forced).then_some(Complex::new(1.0, 0.0));
            let mut found = eigenvalues(&cycle.monodromy);
            found.extend(trivial);
            found
        });
        let found = multipliers(&self.monodromy);
        uncertainties(&found, others, self.monodromy.amax())
    }
}

impl BranchPoint {
    /// Uncertainties of the multipliers of an orbit of a branch, in their order, as
    /// [`PeriodicOrbit::multiplier_uncertainties`] computes them. The system has the orbit's value
    /// of the parameter, which is no state there.
    pub fn multiplier_uncertainties<Kind>(
        &self,
        system: &impl AsDynamics<Kind>,
        is_forced: bool,
        options: &Options,
    ) -> Vec<f64> {
        let system = &*system.dynamics();
        let x = self.x.rows(0, system.states()).into_owned();
        let at = (Moment { t: self.t, x }, self.period, is_forced);
        let again = with_half_steps(system, at, options);
        let (others, largest) = again.map_or((Vec::new(), f64::NAN), |cycle| {
            (eigenvalues(&cycle.monodromy), cycle.monodromy.amax())
        });
        uncertainties(&self.multipliers, others, largest)
    }
}

/// A periodic orbit once more, with half the steps.
fn with_half_steps(
    system: &dyn Dynamics,
    (at, period, is_forced): (Moment, f64, bool),
    options: &Options,
) -> Option<Cycle> {
    let outline = OrbitGuess::of_run(system, &at, period, options).ok()?;
    let forced = is_forced.then_some(period);
    let finer = Shooting::of(system, &outline, forced, options).finer();
    finer.nearest(&outline, None)
}

/// A state of an orbit, and its mode there.
type StateInMode = (Moment, Modes);

/// Projects onto the boundaries of sticking contacts a state that lies near them.
fn settled(system: &dyn Dynamics, (at, mode): &StateInMode) -> Moment {
    let onto = |at: Moment| Moment {
        x: system.flow(*mode, &at).projected(&at),
        ..at
    };
    // The first projection leaves the rounding of the original state, which next to zero exceeds
    // the boundary's own.
    onto(onto(at.clone()))
}

/// The periodic orbit near a start, with the phase sequence of the run from there. Where no orbit
/// has it, the sequence of the run one period later is used. Where the resulting orbit has another
/// one itself, that one is used.
///
/// Where there is none since the flow has no derivative along the last attempt, the error is that
/// of the derivative.
fn orbit_near(
    system: &dyn Dynamics,
    start: &Moment,
    (period, is_forced): (f64, bool),
    options: &Options,
) -> Result<PeriodicOrbit, Error> {
    match orbit_in_sequences(system, start, (period, is_forced), options)? {
        Ok(orbit) => Ok(orbit),
        Err(last) => Err(why_not_found(
            system,
            (&last, period),
            options,
            Error::NotFound {
                what: "a periodic orbit near the start",
                t: start.t,
                span: period,
            },
        )),
    }
}

/// The reason for which no periodic orbit was found from a moment on: that the flow has no
/// derivative along the orbit from there, or else that it was not found.
pub(super) fn why_not_found(
    system: &dyn Dynamics,
    (from, period): (&Moment, f64),
    options: &Options,
    not_found: Error,
) -> Error {
    let derivative = flow_derivative(system, from, from.t + period, options, false);
    derivative.err().unwrap_or(not_found)
}

/// The periodic orbit of [`orbit_near`], or the moment from which it was last sought.
fn orbit_in_sequences(
    system: &dyn Dynamics,
    start: &Moment,
    (period, is_forced): (f64, bool),
    options: &Options,
) -> Result<Result<PeriodicOrbit, Moment>, Error> {
    let forced = is_forced.then_some(period);
    let mut from = start.clone();
    let mut last = start.clone();
    let mut rejected: Option<Vec<Modes>> = None;
    for _ in 0..MOST_SEQUENCES {
        let outline = OrbitGuess::of_run(system, &from, period, options)?;
        let shooting = Shooting::of(system, &outline, forced, options);
        let next = match shooting.nearest(&outline, None) {
            Some(cycle) if shooting.is_valid(&cycle) || rejected == Some(outline.modes()) => {
                return closed_orbit(&shooting, &cycle, start).map(Ok);
            }
            Some(cycle) => {
                rejected = Some(outline.modes());
                cycle.anchor
            }
            None => a_period_later(system, &from, period, options)?,
        };
        last = std::mem::replace(&mut from, next);
    }
    Ok(Err(last))
}

fn a_period_later(
    system: &dyn Dynamics,
    from: &Moment,
    period: f64,
    options: &Options,
) -> Result<Moment, Error> {
    let t = from.t + period;
    let ended = run(system, from, t, options)?;
    match ended.ending {
        Ending::EndTime => Ok(Moment { t, x: ended.x }),
        _ => Err(ended.no_future_error()),
    }
}

/// A periodic orbit from its state next to the start, by the system's own run from there.
fn closed_orbit(
    shooting: &Shooting<'_>,
    cycle: &Cycle,
    start: &Moment,
) -> Result<PeriodicOrbit, Error> {
    let Shooting {
        system, options, ..
    } = *shooting;
    let t = match shooting.forced {
        Some(_) => start.t,
        None => passage_time(system, cycle, start, options)?.unwrap_or(cycle.anchor.t),
    };
    let state = shooting.place(cycle, t).ok_or(Error::NotFound {
        what: "the state of the periodic orbit",
        t,
        span: cycle.period,
    })?;
    let at = Moment {
        t: start.t,
        ..settled(system, &state)
    };
    let is_autonomous = shooting.forced.is_none();
    let t_end = at.t + cycle.period;
    let (period, _) = flow_derivative(system, &at, t_end, options, is_autonomous)?;
    if period.summary.ending != Ending::EndTime {
        return Err(period.summary.no_future_error());
    }
    let residual = (&period.summary.x - &at.x).amax();
    // The closing error of every segment is carried to the end of the period.
    let segments = cycle.outline.segments.len() as f64;
    let wanted = segments * cycle.closes_to * period.matrix.amax().max(1.0);
    if residual > wanted {
        return Err(Error::NotConverged {
            what: "the periodic orbit",
            iterations: cycle.iterations,
            residual,
            wanted,
        });
    }
    Ok(PeriodicOrbit {
        t: at.t,
        x: at.x,
        period: cycle.period,
        monodromy: period.matrix,
        residual,
        closes_to: wanted,
        family: cycle.family,
    })
}

/// The time at which a periodic orbit passes the plane through a state that is perpendicular to the
/// flow there, nearest to that state.
fn passage_time(
    system: &dyn Dynamics,
    cycle: &Cycle,
    state: &Moment,
    options: &Options,
) -> Result<Option<f64>, Error> {
    let anchor = (&cycle.anchor, cycle.period);
    let passages = passages(system, anchor, state, options, |_| false)?;
    let off = |at: &Moment| (&at.x - &state.x).norm();
    let nearest = passages
        .into_iter()
        .min_by(|a, b| off(a).total_cmp(&off(b)));
    Ok(nearest.map(|at| at.t))
}
