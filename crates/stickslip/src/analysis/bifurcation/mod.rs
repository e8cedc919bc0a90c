//! Sweeps of one parameter, in which each run continues from the last state. They yield bifurcation
//! diagrams, and hysteresis by a second sweep in the opposite direction.

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

/// Constructs the system for each value of the parameter.
type Family<'a> = dyn Fn(f64) -> DynamicsRef<'a> + 'a;

/// Settings of a sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweepSettings {
    /// When an attractor counts as reached.
    pub recurrence: RecurrenceSettings,
    /// Settings for the largest Lyapunov exponent; without them it is not measured.
    pub spectrum: Option<SpectrumOptions>,
    /// The solver's settings for locating changes; without them none are located.
    pub locating: Option<Options>,
}

impl SweepSettings {
    /// The defaults with this longest time for each attractor. Changes are located with a tolerance
    /// of 1e-13, and exponents are not measured.
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

/// The result at one value of the parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepPoint {
    /// The parameter.
    pub parameter: f64,
    /// The attractor: section points, phases with durations and lengths of the sticks, and their
    /// sequence.
    pub reached: Reached,
    /// The largest Lyapunov exponent, if it was requested and could be measured.
    pub exponent: Option<Exponent>,
}

/// A change between the attractors at two neighbouring values of the parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct AttractorChange {
    /// The two values, in the order of the sweep.
    pub between: (f64, f64),
    /// Its kind.
    pub what: WhatChanges,
}

/// What happens to an attractor between two values of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum WhatChanges {
    /// The phases of a periodic orbit change.
    Sequence(SequenceChange),
    /// An equilibrium loses its stability, in the direction of the sweep or against it: a pair of
    /// eigenvalues of its field crosses the imaginary axis, or a real one passes through zero.
    Equilibrium {
        /// The parameter.
        parameter: f64,
        /// The equilibrium there.
        x: Vector,
        /// Absolute imaginary part of the eigenvalues that cross: 0 for a single real one, positive
        /// at a Hopf bifurcation.
        frequency: f64,
    },
    /// A boundary-equilibrium bifurcation: an equilibrium reaches the discontinuity boundary, or
    /// the edge of its sliding region.
    BoundaryEquilibrium {
        /// The parameter.
        parameter: f64,
        /// The equilibrium there.
        x: Vector,
    },
    /// A periodic orbit keeps its phases and has a multiplier on the unit circle: it doubles its
    /// period, sheds a torus, meets another branch, or ends in a fold.
    Multiplier {
        /// The parameter.
        parameter: f64,
        /// Uncertainty of the parameter.
        uncertainty: f64,
        /// Which bifurcation; never [`Special::Sequence`].
        what: Special,
        /// A state on the orbit.
        x: Vector,
        /// Its period.
        period: f64,
    },
    /// The change could not be located. The orbits on both sides continue through the interval, are
    /// not periodic, or do not converge.
    Unlocated,
}

/// The result of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// The attractors, in the order of the parameters.
    pub points: Vec<SweepPoint>,
    /// The changes between neighbouring values: those where the kind of motion, the phases or the
    /// mode of rest differ. There is one; or two, where one orbit ends and an unrelated one begins.
    pub changes: Vec<AttractorChange>,
}

/// Follows an attractor through `parameters`, in the given order. Each run starts from the state
/// reached at the previous value. `family` constructs the system for each parameter.
///
/// Where the phases of a periodic orbit differ between two values, shooting follows the orbit to
/// the change of its phases. The change is located to 1e-10 of the interval and named by the event
/// function that vanishes there ([`super::SequenceBifurcation`]). If no event function vanishes,
/// the orbit is followed to a fold or until a multiplier reaches the unit circle. An equilibrium is
/// followed to where it loses its stability or its mode ceases to hold.
///
/// ```
/// use stickslip::analysis::{SweepSettings, sweep};
/// use stickslip::{Options, models::BeltOscillator};
///
/// let family = |belt_speed| BeltOscillator { belt_speed, ..BeltOscillator::default() };
/// let speeds = (0..5).map(|k| 0.2 + 0.05 * f64::from(k));
/// let settings = SweepSettings::within(500.0);
/// let found = sweep(family, speeds, [0.5, 0.1], &settings, &Options::default())?;
/// for point in &found.points {
///     let (kind, in_stick) = (&point.reached.kind, point.reached.in_stick);
///     println!("{}: {kind}, {in_stick:.3} of the time in stick", point.parameter);
/// }
/// assert_eq!(found.points.len(), 5);
/// # Ok::<(), stickslip::Error>(())
/// ```
///
/// # Errors
/// Those of [`super::attractor`], for the first parameter that fails.
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
        // At a strobe time, where the next run begins, too.
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
