//! A sweep of one parameter that carries the state on: bifurcation diagrams, with hysteresis by a
//! second sweep the other way.

mod change;
mod follow;
mod stability;

use super::attractors::{Kind, Reached, RecurrenceSettings, attractor_of};
use super::continuation::Special;
use super::cycle::SequenceChange;
use super::lyapunov::{Exponent, SpectrumOptions, spectrum_of};
use crate::dynamics::{AsDynamics, Components, DynamicsRef, Moment, Vector};
use crate::error::Error;
use crate::filippov::Options;

/// Makes the system of each parameter.
type Family<'a> = dyn Fn(f64) -> DynamicsRef<'a> + 'a;

/// How a parameter is swept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweepSettings {
    /// When an attractor is reached.
    pub recurrence: RecurrenceSettings,
    /// How the first Lyapunov exponent is measured, if it is wanted.
    pub spectrum: Option<SpectrumOptions>,
    /// The solver's settings for locating changes; none are located without.
    pub locating: Option<Options>,
}

impl SweepSettings {
    /// With this longest time for each attractor; changes are located with a tolerance of 1e-13,
    /// and exponents are not measured.
    pub fn within(longest: f64) -> Self {
        SweepSettings {
            recurrence: RecurrenceSettings::within(longest),
            spectrum: None,
            locating: Some(Options::tol(1e-13)),
        }
    }

    /// With a forcing of this period.
    #[must_use]
    pub fn forced(self, period: f64) -> Self {
        SweepSettings {
            recurrence: self.recurrence.forced(period),
            ..self
        }
    }
}

/// What was found at one value of the parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepPoint {
    /// The parameter.
    pub parameter: f64,
    /// The attractor: section points, phases with the sticks' durations and lengths, and their
    /// sequence.
    pub reached: Reached,
    /// The largest Lyapunov exponent, if it was asked for and could be measured.
    pub exponent: Option<Exponent>,
}

/// A difference between the attractors at two neighbouring values of the parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct AttractorChange {
    /// The two values, in the order of the sweep.
    pub between: (f64, f64),
    /// What it is.
    pub what: WhatChanges,
}

/// What becomes of an attractor between two values of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum WhatChanges {
    /// The phases of a periodic orbit.
    Sequence(SequenceChange),
    /// An equilibrium loses its stability, in the direction of the sweep or against it: a pair of
    /// eigenvalues of its field crosses the imaginary axis, or one passes through zero.
    Equilibrium {
        /// The parameter.
        parameter: f64,
        /// The equilibrium there.
        x: Vector,
        /// Size of the imaginary part of the eigenvalues that cross: 0 where it is one, and
        /// otherwise a Hopf bifurcation.
        frequency: f64,
    },
    /// An equilibrium comes to the discontinuity boundary, or to the edge of the part of it that is
    /// slid on: a boundary-equilibrium bifurcation.
    BoundaryEquilibrium {
        /// The parameter.
        parameter: f64,
        /// The equilibrium there.
        x: Vector,
    },
    /// A periodic orbit keeps its phases and has a multiplier on the unit circle: it doubles its
    /// period or sheds a torus, meets another branch, or ends in a fold.
    Multiplier {
        /// The parameter.
        parameter: f64,
        /// By how much that may be off.
        uncertainty: f64,
        /// Which: never [`Special::Sequence`].
        what: Special,
        /// A state on the orbit.
        x: Vector,
        /// Its period.
        period: f64,
    },
    /// It could not be located: the orbits on both sides go on through the interval, or are not
    /// periodic, or do not converge.
    Unlocated,
}

/// A sweep of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// What was found, in the order of the parameters.
    pub points: Vec<SweepPoint>,
    /// Where it is not the same kind of motion, with the same phases or the same mode of rest, as
    /// at the value before: one, or where one orbit ends and another one begins that has nothing to
    /// do with it, both.
    pub changes: Vec<AttractorChange>,
}

/// Follows an attractor through `parameters`, in their order, from the state that was reached at
/// the one before: up, down or as they come. `family` makes the system of each parameter.
///
/// Between two values where the phases of a periodic orbit differ, the orbit itself is followed by
/// shooting, to where its phases change: to 1e-10 of the interval, and named by the event function
/// that vanishes there ([`super::SequenceBifurcation`]). Where none does, it is followed to where
/// one of its multipliers is on the unit circle, or to a fold. An equilibrium is followed to where
/// it loses its stability, or its mode no longer holds.
///
/// ```
/// use stickslip::analysis::{SweepSettings, sweep};
/// use stickslip::{Options, models::BeltOscillator};
///
/// let family = |belt_speed| BeltOscillator { belt_speed, ..BeltOscillator::default() };
/// let speeds = (0..5).map(|k| 0.2 + 0.05 * f64::from(k));
/// let found = sweep(family, speeds, [0.5, 0.1], &SweepSettings::within(500.0), &Options::default())?;
/// for point in &found.points {
///     println!("{}: {}, {:.3} of the time in stick", point.parameter, point.reached.kind, point.reached.in_stick);
/// }
/// assert_eq!(found.points.len(), 5);
/// # Ok::<(), stickslip::Error>(())
/// ```
///
/// # Errors
/// As [`super::attractor`], for the first parameter that has one.
pub fn sweep<S: AsDynamics<Kind>, Kind>(
    family: impl Fn(f64) -> S,
    parameters: impl IntoIterator<Item = f64>,
    x0: impl Components,
    settings: &SweepSettings,
    options: &Options,
) -> Result<Sweep, Error> {
    let family = |parameter| family(parameter).into_dynamics();
    let mut parameters = parameters.into_iter();
    sweep_of(&family, &mut parameters, x0.vector(), settings, options)
}

fn sweep_of<'a>(
    family: &'a Family<'a>,
    parameters: &mut dyn Iterator<Item = f64>,
    mut x: Vector,
    settings: &SweepSettings,
    options: &Options,
) -> Result<Sweep, Error> {
    let mut points: Vec<SweepPoint> = Vec::new();
    let mut changes = Vec::new();
    for parameter in parameters {
        let system = family(parameter);
        let reached = attractor_of(&*system, x.clone(), &settings.recurrence, options)?;
        if let Some(next) = carried_on(&reached, &settings.recurrence) {
            x.clone_from(next);
        }
        let exponent = settings.spectrum.and_then(|spectrum| {
            let (t, x) = (0.0, x.clone());
            let spectrum = spectrum_of(&*system, Moment { t, x }, &spectrum).ok()?;
            spectrum.exponents.first().copied()
        });
        if let (Some(before), Some(locating)) = (points.last(), &settings.locating)
            && is_change(&before.reached, &reached)
        {
            let ends = [(before.parameter, &before.reached), (parameter, &reached)];
            let found = change::locate(family, ends, settings.recurrence.forcing, locating);
            let between = (before.parameter, parameter);
            let found = found.into_iter();
            changes.extend(found.map(|what| AttractorChange { between, what }));
        }
        points.push(SweepPoint {
            parameter,
            reached,
            exponent,
        });
    }
    Ok(Sweep { points, changes })
}

/// The state from which the next parameter's run begins; none after an escape or a failure.
fn carried_on<'r>(reached: &'r Reached, settings: &RecurrenceSettings) -> Option<&'r Vector> {
    match reached.kind {
        Kind::Escape | Kind::Failure(_) | Kind::Repelling | Kind::TwoFold(_) => None,
        // At a flash of the strobe, at which the next run begins, too.
        _ if settings.forcing.is_some() => reached.points.last().map(|point| &point.x),
        _ => Some(&reached.x),
    }
}

fn is_change(one: &Reached, other: &Reached) -> bool {
    match (&one.kind, &other.kind) {
        (Kind::Periodic { .. }, Kind::Periodic { .. }) => !one.has_sequence_of(other),
        // In slip or on the boundary.
        (Kind::Equilibrium, Kind::Equilibrium) => one.mode != other.mode,
        (one, other) => std::mem::discriminant(one) != std::mem::discriminant(other),
    }
}
