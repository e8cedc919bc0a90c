//! Sweeps of one parameter, in which each run continues from the last state. They yield bifurcation
//! diagrams, and hysteresis by a second sweep in the opposite direction.

mod change;

use std::fmt;

use super::attractors::{Attractor, AttractorKind, RecurrenceSettings, attractor_of};
use super::continuation::CycleBifurcation;
use super::cycle::{SequenceChange, StepBudget};
use super::lyapunov::{Exponent, SpectrumOptions, spectrum_of};
use super::normal_form::Criticality;
use crate::dynamics::{AsDynamics, Components, DynamicsRef, Moment, Vector};
use crate::error::Error;
use crate::filippov::Options;

/// The result at one value of the parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepPoint {
    /// The parameter.
    pub parameter: f64,
    /// The attractor: section points, phases with durations and lengths of the sticks, and their
    /// sequence.
    pub reached: Attractor,
    /// The largest Lyapunov exponent, if it was requested and could be measured.
    pub exponent: Option<Exponent>,
}

/// A change between the attractors at two neighbouring values of the parameter.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AttractorChange {
    /// The two values, in the order of the sweep.
    pub between: (f64, f64),
    /// Kind.
    pub what: WhatChanges,
}

impl AttractorChange {
    /// The changes along a sweep, from those of each pair of values. A change at the value that two
    /// pairs share belongs to the first pair. From one of them it may not be located.
    pub fn merged(of_pairs: impl IntoIterator<Item = AttractorChange>) -> Vec<AttractorChange> {
        let mut changes: Vec<AttractorChange> = Vec::new();
        for change in of_pairs {
            let (shared, next) = change.between;
            let distance = change::NEXT_TO * (next - shared).abs();
            let is_same = |before: &&mut AttractorChange| {
                before.between.1 == shared
                    && match (&before.what, &change.what) {
                        (WhatChanges::Unlocated | WhatChanges::NotFollowed(_), one)
                        | (one, WhatChanges::Unlocated | WhatChanges::NotFollowed(_)) => {
                            one.is_near(shared, distance)
                        }
                        (one, other) => one.is_next_to(other, distance),
                    }
            };
            match changes.iter_mut().find(is_same) {
                Some(before) => before.what = change::primary([before.what.clone(), change.what]),
                None => changes.push(change),
            }
        }
        changes
    }
}

/// Change of an attractor between two values of a parameter.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum WhatChanges {
    /// The phases of a periodic orbit change.
    Sequence(SequenceChange),
    /// An equilibrium loses its stability, in the direction of the sweep or against it. A pair of
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
        /// Kind of bifurcation; never [`CycleBifurcation::Sequence`].
        what: CycleBifurcation,
        /// A state on the orbit.
        x: Vector,
        /// Period.
        period: f64,
        /// Side on which orbits branch off at a flip or Neimark–Sacker bifurcation; `None` where
        /// it is not determined, and of others.
        criticality: Option<Criticality>,
    },
    /// The change was not followed to its place, to save work; see [`locate_changes`].
    NotFollowed(NotFollowed),
    /// The change could not be located. The orbits on both sides continue through the interval, are
    /// not periodic, or do not converge.
    Unlocated,
}

/// Reason for which a change was not followed to its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum NotFollowed {
    /// The orbit has so many loops.
    Loops(usize),
    /// The budget of steps was spent.
    Budget,
}

impl fmt::Display for NotFollowed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NotFollowed::Loops(loops) => write!(f, "not followed: an orbit of {loops} loops"),
            NotFollowed::Budget => f.write_str("not followed: the budget of steps was spent"),
        }
    }
}

impl fmt::Display for WhatChanges {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            WhatChanges::Sequence(change) => change.bifurcation.fmt(f),
            WhatChanges::Multiplier { what, .. } => what.fmt(f),
            WhatChanges::Equilibrium { frequency, .. } if *frequency > 0.0 => {
                f.write_str("Hopf bifurcation of the equilibrium")
            }
            WhatChanges::Equilibrium { .. } => {
                f.write_str("fold or branch point of the equilibrium")
            }
            WhatChanges::BoundaryEquilibrium { .. } => {
                f.write_str("boundary-equilibrium bifurcation")
            }
            WhatChanges::NotFollowed(why) => why.fmt(f),
            WhatChanges::Unlocated => f.write_str("not located"),
        }
    }
}

impl WhatChanges {
    /// The parameter; `None` where it could not be located.
    pub fn parameter(&self) -> Option<f64> {
        match self {
            WhatChanges::Sequence(change) => Some(change.parameter),
            WhatChanges::Equilibrium { parameter, .. }
            | WhatChanges::BoundaryEquilibrium { parameter, .. }
            | WhatChanges::Multiplier { parameter, .. } => Some(*parameter),
            WhatChanges::NotFollowed(_) | WhatChanges::Unlocated => None,
        }
    }

    /// The uncertainty of the parameter, where it is known.
    pub fn uncertainty(&self) -> Option<f64> {
        match self {
            WhatChanges::Sequence(SequenceChange { uncertainty, .. })
            | WhatChanges::Multiplier { uncertainty, .. } => Some(*uncertainty),
            _ => None,
        }
    }

    /// The period of the orbit, if it is one.
    pub fn period(&self) -> Option<f64> {
        match self {
            WhatChanges::Sequence(SequenceChange { period, .. })
            | WhatChanges::Multiplier { period, .. } => Some(*period),
            _ => None,
        }
    }

    /// The side on which orbits branch off at a flip or Neimark–Sacker bifurcation, where it is
    /// determined.
    pub fn criticality(&self) -> Option<Criticality> {
        match self {
            WhatChanges::Multiplier { criticality, .. } => *criticality,
            _ => None,
        }
    }

    /// The state; `None` where it could not be located.
    pub fn state(&self) -> Option<&Vector> {
        match self {
            WhatChanges::Sequence(SequenceChange { x, .. })
            | WhatChanges::Equilibrium { x, .. }
            | WhatChanges::BoundaryEquilibrium { x, .. }
            | WhatChanges::Multiplier { x, .. } => Some(x),
            WhatChanges::NotFollowed(_) | WhatChanges::Unlocated => None,
        }
    }

    /// Whether another one is of the same kind and within a distance of it.
    fn is_next_to(&self, other: &WhatChanges, distance: f64) -> bool {
        let kinds = [self, other].map(std::mem::discriminant);
        let other = other.parameter();
        kinds[0] == kinds[1] && other.is_some_and(|other| self.is_near(other, distance))
    }

    /// Whether it is located within a distance of a parameter.
    fn is_near(&self, parameter: f64, distance: f64) -> bool {
        let own = self.parameter();
        own.is_some_and(|own| (own - parameter).abs() <= distance)
    }
}

/// Follows an attractor through `parameters`, in the given order. Each run starts from the state
/// reached at the previous value. `family` constructs the system for each parameter. An unstable
/// periodic orbit is left as in [`super::Attractor::by_shooting`]. With a second setting, the
/// largest Lyapunov exponent is measured, too.
///
/// [`locate_changes`] finds what happens between two values.
///
/// ```
#[doc = include_str!("../../../examples/common/belt.rs")]
/// use stickslip::Options;
/// use stickslip::analysis::{RecurrenceSettings, sweep};
///
/// let family = |speed| Belt { speed };
/// let speeds = (0..5).map(|k| 0.2 + 0.05 * f64::from(k));
/// let how = (&RecurrenceSettings::within(500.0), None);
/// let found = sweep(family, speeds, [0.5, 0.1], how, &Options::default())?;
/// for point in &found {
///     let (kind, in_stick) = (&point.reached.kind, point.reached.in_stick);
///     println!("{}: {kind}, {in_stick:.3} of the time in stick", point.parameter);
/// }
/// assert_eq!(found.len(), 5);
/// # Ok::<(), stickslip::Error>(())
/// ```
///
/// # Errors
/// Those of [`super::attractor`], for the first parameter that fails.
pub fn sweep<S: AsDynamics<Kind>, Kind>(
    family: impl Fn(f64) -> S,
    parameters: impl IntoIterator<Item = f64>,
    x0: impl Components,
    settings: (&RecurrenceSettings, Option<&SpectrumOptions>),
    options: &Options,
) -> Result<Vec<SweepPoint>, Error> {
    let mut x = x0.vector();
    let of_each = parameters.into_iter().map(|parameter| {
        let system = family(parameter);
        point(&system.dynamics(), parameter, &mut x, settings, options)
    });
    of_each.collect()
}

/// The attractor from a state, which becomes that with which the next value continues.
fn point(
    system: &DynamicsRef<'_>,
    parameter: f64,
    x: &mut Vector,
    (settings, spectrum): (&RecurrenceSettings, Option<&SpectrumOptions>),
    options: &Options,
) -> Result<SweepPoint, Error> {
    let reached = attractor_of(&**system, x.clone(), settings, options)?;
    let reached = reached.by_shooting(system, settings, options);
    if let Some(next) = reached.next_start(settings) {
        x.clone_from(next);
    }
    let exponent = spectrum.and_then(|spectrum| {
        let (t, x) = (0.0, x.clone());
        let spectrum = spectrum_of(&**system, Moment { t, x }, spectrum).ok()?;
        spectrum.exponents.first().copied()
    });
    Ok(SweepPoint {
        parameter,
        reached,
        exponent,
    })
}

/// Locates the changes between the attractors at neighbouring values of a sweep: where the kind of
/// motion, the phases or the mode of rest differ, or where the tangents of their branches do not
/// lead from one to the other. There is one between two values; or two, where one orbit ends and an
/// unrelated one begins.
///
/// **The parameter is the last state of `system`**, as in [`super::continue_periodic_orbit`]. The
/// orbits and equilibria on both sides are followed towards each other as branches, to the first
/// change of phases, fold, boundary or loss of stability. `forcing` is the period of the forcing.
/// The tolerances of `options` bound the precision; 1e-13 is appropriate. Where a value of the
/// sweep hits a change, they must resolve a millionth of the interval.
///
/// With a budget, it takes about as many integration steps as that has. An orbit that would take
/// more than are left is not followed. Nor is one of more than 8 loops next to a motion that is
/// quasi-periodic, chaotic or undecided. What is left out is [`WhatChanges::NotFollowed`].
///
/// # Errors
/// [`Error::Parameter`] where `system` does not have one state more than the systems of the sweep.
///
/// ```
/// use stickslip::analysis::{RecurrenceSettings, WhatChanges, locate_changes, sweep};
/// use stickslip::{Family, Options, Scalar, Side};
///
/// /// A block on a belt, with damping 0.1 and friction that falls with the slip speed.
/// struct Belt;
/// impl Family<2, 1> for Belt {
///     fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2], speed: &[T; 1]) -> [T; 2] {
///         let slip_speed = (x[1] - speed[0]) * side.sign();
///         let friction = ((slip_speed * -2.0).exp() * 0.5 + 0.5) * side.sign();
///         [x[1], -x[0] - x[1] * 0.1 - friction]
///     }
///     fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2], speed: &[T; 1]) -> T {
///         x[1] - speed[0]
///     }
/// }
///
/// let (at, settings) = (|speed| Belt.at([speed]), RecurrenceSettings::within(3e3));
/// let points = sweep(at, [1.3, 1.1], [0.55, 0.0], (&settings, None), &Options::default())?;
/// let along = at(1.3).free([0])?;
/// let found = locate_changes(&along, &points, None, (&Options::tol(1e-13), None))?;
/// // The slope of the friction takes the damping: 0.1 = exp(-2 v).
/// let WhatChanges::Equilibrium { parameter, .. } = found[0].what else { panic!() };
/// assert!((parameter - 0.5 * 10.0_f64.ln()).abs() < 1e-12);
/// # Ok::<(), stickslip::Error>(())
/// ```
pub fn locate_changes<Kind>(
    system: &impl AsDynamics<Kind>,
    points: &[SweepPoint],
    forcing: Option<f64>,
    within: (&Options, Option<&StepBudget>),
) -> Result<Vec<AttractorChange>, Error> {
    let system = &*system.dynamics();
    let mut of_pairs = Vec::new();
    for ends in points.windows(2) {
        let [one, other] = ends else { continue };
        if one.reached.x.len() + 1 != system.states() {
            return Err(Error::Parameter {
                name: "the number of states",
                value: system.states() as f64,
                bound: "one more than in the sweep: the parameter is the last",
            });
        }
        if one.reached.is_changed_to(&other.reached)
            || !change::is_smooth(system, [one, other], forcing, within)
        {
            let between = (one.parameter, other.parameter);
            let found = change::locate(system, [one, other], forcing, within).into_iter();
            of_pairs.extend(found.map(|what| AttractorChange { between, what }));
        }
    }
    Ok(AttractorChange::merged(of_pairs))
}

impl Attractor {
    /// State from which a run at the next value of the parameter begins, as in [`sweep`]. It is
    /// `None` after an escape, a failure, or an end where the future is not unique.
    pub fn next_start(&self, settings: &RecurrenceSettings) -> Option<&Vector> {
        match self.kind {
            AttractorKind::Escape
            | AttractorKind::Failure(_)
            | AttractorKind::Repelling
            | AttractorKind::TwoFold(_) => None,
            // At a strobe time, where the next run begins, too.
            _ if settings.forcing.is_some() => self.points.last().map(|point| &point.x),
            _ => Some(&self.x),
        }
    }

    /// Whether two attractors at neighbouring values differ in kind, returns, phases, or the mode
    /// of an equilibrium. Others may have jumped: [`locate_changes`] compares them with the
    /// tangents of their branches.
    pub fn is_changed_to(&self, other: &Attractor) -> bool {
        match (&self.kind, &other.kind) {
            (
                AttractorKind::Periodic { returns: p, .. },
                AttractorKind::Periodic { returns: q, .. },
            ) => p != q || !self.has_sequence_of(other),
            // In slip or on the boundary.
            (AttractorKind::Equilibrium, AttractorKind::Equilibrium) => self.mode != other.mode,
            (one, other) => std::mem::discriminant(one) != std::mem::discriminant(other),
        }
    }
}
