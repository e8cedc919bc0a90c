//! A bifurcation diagram, computed value by value.

use serde::{Deserialize, Serialize};
use stickslip::analysis::{
    Attractor, AttractorChange, AttractorKind, Exponent, StepBudget, SweepPoint, WhatChanges,
    attractor, locate_changes,
};
use stickslip::dynamics::{Moment, Phase, Vector};
use stickslip::{Error, Options};

use super::{largest, recurrence, reported};
use crate::file::{SettingError, System};

/// Tolerance of the runs that locate changes. It is chosen near rounding: the parameter of a change
/// is less accurate than the orbit by the slope of the event function.
const LOCATION_TOLERANCE: f64 = 1e-13;

/// Integration steps that locating changes may take besides those of the attractors. Chosen: one to
/// two seconds, so that short sweeps locate theirs.
const STEPS_AT_START: u64 = 1_000_000;

/// The changes between two values may take the steps that are left, divided by this. Chosen: a
/// branch that never ends leaves half of them to the pairs of values behind it.
const PART_FOR_PAIR: u64 = 2;

/// Selection of the changes of an attractor along a parameter that are located.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Locates {
    /// Each, whatever the work.
    All,
    /// Changes of orbits of few loops, with about as many integration steps as the attractors take
    /// at all values, and some more.
    #[default]
    Periodic,
    /// None.
    Nothing,
}

impl Locates {
    /// Finds a selection by its name on the command line and in Python.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "all" => Some(Locates::All),
            "periodic" => Some(Locates::Periodic),
            "none" => Some(Locates::Nothing),
            _ => None,
        }
    }
}

/// Settings with which an attractor is followed along a parameter.
#[derive(Clone, Copy)]
pub struct Diagram<'a> {
    /// The system.
    pub system: &'a System,
    /// Name of the parameter.
    pub parameter: &'a str,
    /// Time after which an orbit counts as undecided.
    pub until: f64,
    /// Time over which the largest exponent is measured, if it is wanted.
    pub duration: Option<f64>,
    /// Changes of the attractor that are located.
    pub locates: Locates,
    /// Number of values.
    pub values: u64,
    /// Settings of the solver.
    pub options: &'a Options,
}

/// The result at one parameter value.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct AtValue {
    /// Parameter value.
    pub value: f64,
    /// Attractor of the orbit, as [`reported`].
    pub reached: Attractor,
    /// Largest exponent, if it was measured.
    pub largest: Option<Exponent>,
    /// Reason for which it could not be measured, in words.
    pub unmeasured: Option<String>,
    /// Initial state of the orbit at the next value.
    carried: Vector,
    /// Integration steps that locating changes may take.
    unspent: u64,
    /// Steps that every value was taken to need in advance: those of the first.
    credited: u64,
}

impl AtValue {
    /// The phases of a periodic orbit in which a contact sticks.
    pub fn sticks(&self) -> impl Iterator<Item = &Phase> {
        let is_periodic = matches!(self.reached.kind, AttractorKind::Periodic { .. });
        let phases = self.reached.phases.iter().filter(move |_| is_periodic);
        phases.filter(|phase| phase.mode.any_sticks())
    }
}

impl Diagram<'_> {
    /// Computes the result at a value, and the changes of the attractor since the last value. The
    /// first orbit begins at `start`. `describe` formats the error of a failed integration of the
    /// system at the value.
    ///
    /// # Errors
    /// Those of [`attractor`], of the settings and of `start`.
    pub fn at<E: From<Error> + From<SettingError>>(
        &self,
        value: f64,
        last: Option<&AtValue>,
        start: impl FnOnce(&System) -> Result<Vec<f64>, E>,
        describe: &dyn Fn(&Error, &System) -> String,
    ) -> Result<(AtValue, Vec<AttractorChange>), E> {
        let here = self.system.driven_with(&[(self.parameter, value)])?;
        let (system, settings) = (here.dynamics(), recurrence(&here, self.until));
        // A start that is given must be one; where an orbit is carried to, it may not be.
        let (start, reached) = match last {
            Some(AtValue { carried, .. }) => {
                let x = carried.clone();
                let carried = system.admitted(&Moment { t: 0.0, x }).x;
                let reached = Attractor::of_any(system, &carried, &settings, self.options)?;
                (carried, reached)
            }
            None => {
                let start = Vector::from(start(&here)?);
                let reached = attractor(system, &start, &settings, self.options)?;
                (start, reached)
            }
        };
        let reached = reached.by_shooting(system, &settings, self.options);
        let reached = reported(reached, |error| describe(error, &here));
        let steps = reached.steps;
        let (unspent, credited) = match last {
            // The other values count as if they took as many.
            None => (
                STEPS_AT_START.saturating_add(steps.saturating_mul(self.values)),
                steps,
            ),
            Some(AtValue {
                unspent, credited, ..
            }) => (
                unspent.saturating_add(steps.saturating_sub(*credited)),
                *credited,
            ),
        };
        let measured = match self.duration {
            Some(duration) => largest::on(&here, &reached, duration, self.options),
            None => Ok(None),
        };
        let mut found = AtValue {
            value,
            unspent,
            credited,
            carried: reached.next_start(&settings).cloned().unwrap_or(start),
            unmeasured: measured.as_ref().err().map(|error| describe(error, &here)),
            largest: measured.unwrap_or(None),
            reached,
        };
        let budget = match self.locates {
            Locates::Nothing => return Ok((found, Vec::new())),
            Locates::Periodic => Some(StepBudget::of(found.unspent / PART_FOR_PAIR)),
            Locates::All => None,
        };
        let changes = match last {
            Some(last) => self.located([last, &found], &here, budget.as_ref())?,
            None => Vec::new(),
        };
        if let Some(budget) = budget {
            found.unspent -= found.unspent / PART_FOR_PAIR - budget.left();
        }
        Ok((found, changes))
    }

    /// Changes of the attractor between the last value and this one.
    fn located(
        &self,
        ends: [&AtValue; 2],
        here: &System,
        budget: Option<&StepBudget>,
    ) -> Result<Vec<AttractorChange>, SettingError> {
        let points = ends.map(|at| SweepPoint {
            parameter: at.value,
            reached: at.reached.clone(),
            exponent: None,
        });
        let (forcing, options) = (here.built.period, Options::tol(LOCATION_TOLERANCE));
        // The parameter is one state more, which may be one too many.
        let along = here
            .with_states_of(&[here.file.parameter(self.parameter)?])
            .ok();
        let located = along.and_then(|along| {
            let located = locate_changes(&along, &points, forcing, (&options, budget));
            located.ok()
        });
        let is_change = || points[0].reached.is_changed_to(&points[1].reached);
        let Some(located) = located.or_else(|| (!is_change()).then(Vec::new)) else {
            let (between, what) = ((ends[0].value, ends[1].value), WhatChanges::Unlocated);
            return Ok(vec![AttractorChange { between, what }]);
        };
        Ok(located)
    }
}
