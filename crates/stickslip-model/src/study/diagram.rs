//! A bifurcation diagram, computed value by value.

use serde::{Deserialize, Serialize};
use stickslip::analysis::{
    Attractor, AttractorChange, Exponent, SequenceChange, SweepPoint, WhatChanges, attractor,
    attractor_of_many, carried_on, is_change, locate_changes,
};
use stickslip::dynamics::Vector;
use stickslip::{Error, Options};

use super::{largest, recurrence, reported};
use crate::file::{SettingError, System};

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
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct AtValue {
    /// Parameter value.
    pub value: f64,
    /// Attractor of the orbit, as [`reported`].
    pub reached: Attractor,
    /// Largest exponent, if it was measured.
    pub largest: Option<Exponent>,
    /// Initial state of the orbit at the next value.
    carried: Vector,
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
        let here = self.system.with_values(&[(self.parameter, value)])?;
        let (system, settings) = (here.dynamics(), recurrence(&here, self.until));
        // A start that is given must be one; where an orbit is carried to, it may not be.
        let (start, reached) = match last {
            Some(AtValue { carried, .. }) => {
                let reached = attractor_of_many(system, carried, &settings, self.options)?;
                (carried.clone(), reached)
            }
            None => {
                let start = Vector::from(start(&here)?);
                let reached = attractor(system, &start, &settings, self.options)?;
                (start, reached)
            }
        };
        let reached = reported(reached, |error| describe(error, &here));
        let found = AtValue {
            value,
            carried: carried_on(&reached, &settings).cloned().unwrap_or(start),
            largest: self
                .duration
                .and_then(|duration| largest::on(&here, &reached, duration, self.options)),
            reached,
        };
        let changes = match last.filter(|_| self.locates) {
            Some(last) => self.located([last, &found], &here)?,
            None => Vec::new(),
        };
        Ok((found, changes))
    }

    /// Changes of the attractor between the last value and this one. Times are those of the system
    /// `here`, in which the period of the drive is constant.
    fn located(
        &self,
        ends: [&AtValue; 2],
        here: &System,
    ) -> Result<Vec<AttractorChange>, SettingError> {
        let points = ends.map(|at| SweepPoint {
            parameter: at.value,
            reached: at.reached.clone(),
            exponent: None,
        });
        if !is_change(&points[0].reached, &points[1].reached) {
            return Ok(Vec::new());
        }
        let (forcing, options) = (here.built.period, Options::tol(LOCATION_TOLERANCE));
        // The parameter is one state more, which may be one too many.
        let along = here.along(here.file.parameter(self.parameter)?).ok();
        let located = along.and_then(|along| {
            let located = locate_changes(&along, &points, forcing, &options);
            located.ok()
        });
        let Some(mut located) = located else {
            let (between, what) = ((ends[0].value, ends[1].value), WhatChanges::Unlocated);
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
            ) = (what, forcing)
            {
                let there = self.system.with_values(&[(self.parameter, *parameter)])?;
                *period *= there.built.period.map_or(1.0, |there| there / reference);
            }
        }
        Ok(located)
    }
}
