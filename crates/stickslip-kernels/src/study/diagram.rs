//! A bifurcation diagram, computed value by value.

use std::cell::Cell;

use serde::{Deserialize, Serialize};
use stickslip::analysis::{
    AttractorChange, RecurrenceSettings, SequenceChange, SweepSettings, WhatChanges, attractor,
    attractor_of_many, locate_changes, sweep,
};
use stickslip::dynamics::DynamicsRef;
use stickslip::{Error, Options};

use super::{Largest, recurrence};
use crate::file::{SettingError, System};
use crate::kernel::{Change, Motion, Outcome};

/// Tolerance of the runs that locate changes. It is chosen near rounding: the parameter of a change
/// is less accurate than the orbit by the slope of the event function.
const LOCATION_TOLERANCE: f64 = 1e-13;

/// How an attractor is followed along a parameter.
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
    /// Whether changes of the attractor are located.
    pub locates: bool,
    /// Settings of the solver.
    pub options: &'a Options,
}

/// The result at one parameter value.
#[derive(Debug, Serialize, Deserialize)]
pub struct AtValue {
    /// Parameter value.
    pub value: f64,
    /// Outcome of the orbit.
    pub outcome: Outcome,
    /// Its largest exponent.
    pub largest: Largest,
}

/// A change between two neighbouring parameter values.
#[derive(Debug)]
pub struct ChangeBetween {
    /// The two values.
    pub values: (f64, f64),
    /// The change.
    pub change: Change,
}

impl ChangeBetween {
    /// The changes along all values, from those since each last one.
    pub fn along(located: Vec<AttractorChange>) -> Vec<Self> {
        let merged = AttractorChange::merged(located).into_iter();
        let changes = merged.map(|AttractorChange { between, what }| ChangeBetween {
            values: between,
            change: Change::from(&what),
        });
        changes.collect()
    }
}

/// Start of the computation at the next value.
#[derive(Debug, Serialize, Deserialize)]
pub struct ValueEnd {
    /// Parameter value.
    pub value: f64,
    /// Class of the motion, by [`System::class`].
    pub class: String,
    /// Initial state of the orbit at this value.
    pub start: Vec<f64>,
    /// Initial state of the orbit at the next value.
    pub carried: Vec<f64>,
}

impl Diagram<'_> {
    /// Computes the result at a value, the changes of the attractor since the last value, and the
    /// start for the next one. The first orbit begins at `start`. `describe` formats the error of a
    /// failed integration of the system at the value.
    ///
    /// # Errors
    /// Those of [`attractor`], of the settings and of `start`.
    pub fn at<E: From<Error> + From<SettingError>>(
        &self,
        value: f64,
        last: Option<&ValueEnd>,
        start: impl FnOnce(&System) -> Result<Vec<f64>, E>,
        describe: &dyn Fn(&Error, &System) -> String,
    ) -> Result<(AtValue, Vec<AttractorChange>, ValueEnd), E> {
        let here = self.system.with_values(&[(self.parameter, value)])?;
        let settings = recurrence(&here, self.until);
        let start = match last {
            Some(last) => last.carried.clone(),
            None => start(&here)?,
        };
        // A start that is given must be one; where an orbit is carried to, it may not be.
        let system = here.dynamics();
        let reached = match last {
            None => attractor(system, &*start, &settings, self.options)?,
            Some(_) => attractor_of_many(system, &*start, &settings, self.options)?,
        };
        let outcome = Outcome::of(&reached, &|error| describe(error, &here));
        let class = here.class(&outcome);
        let changes = match last.filter(|last| self.locates && last.class != class) {
            Some(last) => self.located::<E>(last, &here, value, &settings)?,
            None => Vec::new(),
        };
        let end = ValueEnd {
            value,
            class,
            carried: carried_on(&outcome, settings.forcing.is_some())
                .unwrap_or_else(|| start.clone()),
            start,
        };
        let largest = match self.duration {
            Some(duration) => Largest::on(&here, &outcome, duration, self.options),
            None => Largest::Unmeasured,
        };
        let found = AtValue {
            value,
            outcome,
            largest,
        };
        Ok((found, changes, end))
    }

    /// Changes of the attractor between the last value and this one.
    fn located<E: From<Error> + From<SettingError>>(
        &self,
        last: &ValueEnd,
        here: &System,
        value: f64,
        recurrence: &RecurrenceSettings,
    ) -> Result<Vec<AttractorChange>, E> {
        let settings = SweepSettings {
            recurrence: *recurrence,
            ..SweepSettings::within(self.until)
        };
        // Time is scaled so that the drive keeps one period, even if its own period depends on the
        // parameter. If the system cannot be built at a value, the sweep continues with the present
        // one, and its result is discarded.
        let complete = Cell::new(true);
        let family = |value| {
            let there = self.system.with_values(&[(self.parameter, value)]).ok();
            let there = there.and_then(|there| there.in_period(recurrence.forcing).ok());
            there.unwrap_or_else(|| {
                complete.set(false);
                DynamicsRef::Borrowed(&**self.system.dynamics())
            })
        };
        let between = [last.value, value];
        let (number, options) = (
            here.file.parameter(self.parameter)?,
            Options::tol(LOCATION_TOLERANCE),
        );
        let along = here.along(number)?;
        // The orbit may not exist all the way.
        let located = sweep(family, between, &*last.start, &settings, self.options)
            .and_then(|points| locate_changes(&along, &points, recurrence.forcing, &options));
        let Some(mut located) = located.ok().filter(|_| complete.get()) else {
            let (between, what) = ((last.value, value), WhatChanges::Unlocated);
            return Ok(vec![AttractorChange { between, what }]);
        };
        for AttractorChange { what, .. } in &mut located {
            if let (
                WhatChanges::Sequence(SequenceChange {
                    parameter, period, ..
                })
                | WhatChanges::Multiplier {
                    parameter, period, ..
                },
                Some(reference),
            ) = (what, recurrence.forcing)
            {
                let there = self.system.with_values(&[(self.parameter, *parameter)])?;
                *period *= there.built.period.map_or(1.0, |there| there / reference);
            }
        }
        Ok(located)
    }
}

/// Initial state of the orbit at the next value; `None` if this one has reached no attractor.
fn carried_on(outcome: &Outcome, is_forced: bool) -> Option<Vec<f64>> {
    match outcome.motion {
        Motion::Escape | Motion::Failure(_) | Motion::Repelling | Motion::TwoFold => None,
        // The state is taken at a strobe time, so that the next orbit begins at the same phase of
        // the forcing.
        _ if is_forced => outcome.points.last().map(|(_, x)| x.clone()),
        _ => Some(outcome.left_at.1.clone()),
    }
}
