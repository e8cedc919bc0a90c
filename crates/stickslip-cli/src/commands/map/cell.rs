//! What is found at one pair of parameters.

use serde::{Deserialize, Serialize};
use stickslip::Options;
use stickslip::analysis::RecurrenceSettings;
use stickslip_kernels::kernel::Motion;

use super::super::exponent::Largest;
use super::super::tables::{exact, known};
use super::super::{Failure, attractors};
use stickslip_kernels::file::System;

/// What is found at one pair of parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Cell {
    pub(super) motion: Motion,
    period_uncertainty: f64,
    /// The phases of a period, wherever it begins; nothing where phases do not tell one motion from another.
    pub(super) phases: String,
    /// Part of the time in stick, if there is an attractor.
    pub(super) in_stick: Option<f64>,
    pub(super) largest: Largest,
}

impl Cell {
    /// What the orbit from the start comes to.
    pub(super) fn at(
        system: &System,
        start: &[f64],
        settings: &RecurrenceSettings,
        duration: f64,
        options: &Options,
    ) -> Result<Self, Failure> {
        let outcome = attractors::reached_from_one_of_many(system, start, settings, options)?;
        let is_there = !outcome.points.is_empty();
        Ok(Self {
            phases: attractors::sequence(&outcome),
            in_stick: is_there.then_some(outcome.in_stick),
            largest: Largest::on(system, &outcome, duration, options),
            period_uncertainty: outcome.period_uncertainty,
            motion: outcome.motion,
        })
    }

    /// The kind of motion, of an attractor with its phases.
    pub(super) fn class(&self) -> String {
        let word = self.motion.word();
        if self.phases.is_empty() {
            return word.to_owned();
        }
        // Long sequences would be wider than a figure; their number of phases tells most of them apart.
        let number = self.phases.split(' ').count();
        if number > 8 {
            format!("{word}, {number} phases")
        } else {
            format!("{word}, {}", self.phases)
        }
    }

    /// Motion, period, phases, part of time in stick, exponent and its error; empty where there is none.
    pub(super) fn fields(&self) -> [String; 6] {
        let period = match self.motion {
            Motion::Periodic { period, .. } => exact(known(period, self.period_uncertainty)),
            _ => String::new(),
        };
        let [value, std_error] = self.largest.fields();
        [
            self.motion.word().to_owned(),
            period,
            self.phases.clone(),
            self.in_stick.map(exact).unwrap_or_default(),
            value,
            std_error,
        ]
    }
}
