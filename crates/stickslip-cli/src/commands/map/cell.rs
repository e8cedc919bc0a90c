//! What is found at one pair of parameters.

use serde::{Deserialize, Serialize};
use stickslip::Options;
use stickslip::analysis::{Exponent, RecurrenceSettings, SpectrumOptions};
use stickslip_kernels::kernel::{Motion, Outcome};

use super::super::attractors;
use super::super::tables::exact;
use crate::system::System;

/// Exponents of an orbit nearer to zero than so many of their standard errors are zero.
const ERRORS: f64 = 3.0;

/// An exponent of a periodic orbit is zero to about this, whatever its standard error.
const ROUNDING: f64 = 1e-6;

/// A largest Lyapunov exponent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Largest {
    /// A number.
    Finite { value: f64, std_error: f64 },
    /// Stick takes all directions to zero.
    Annihilated,
    /// There is no orbit to measure, or it could not be followed.
    Unmeasured,
}

impl Largest {
    /// Whether it is zero within its error.
    pub(super) fn is_zero(&self) -> bool {
        match *self {
            Largest::Finite { value, std_error } => {
                value.abs() <= (ERRORS * std_error).max(ROUNDING)
            }
            _ => false,
        }
    }
}

/// What is found at one pair of parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Cell {
    pub(super) motion: Motion,
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
    ) -> Result<Self, stickslip::Error> {
        let outcome = system.kernel().attractor(start, settings, options)?;
        let is_there = !outcome.points.is_empty();
        let phases = match outcome.motion {
            Motion::Periodic { .. } => attractors::cycle(&outcome),
            Motion::Equilibrium | Motion::EquilibriumSet => attractors::sequence(&outcome),
            _ => String::new(),
        };
        Ok(Self {
            phases,
            in_stick: is_there.then_some(outcome.in_stick),
            largest: if is_there {
                largest(system, &outcome, duration, options)
            } else {
                Largest::Unmeasured
            },
            motion: outcome.motion,
        })
    }

    /// What it is called in the legend.
    pub(super) fn class(&self) -> String {
        let word = self.motion.word();
        if self.phases.is_empty() {
            return word.to_owned();
        }
        // Long sequences would be wider than the figure; their number of phases tells most of them apart.
        let number = self.phases.split(' ').count();
        if number > 8 {
            format!("{word}, {number} phases")
        } else {
            format!("{word}, {}", self.phases.replace('-', "−"))
        }
    }

    /// Motion, period, phases, part of time in stick, exponent and its error; empty where there is none.
    pub(super) fn fields(&self) -> [String; 6] {
        let period = match self.motion {
            Motion::Periodic { period, .. } => exact(period),
            _ => String::new(),
        };
        let (value, std_error) = match self.largest {
            Largest::Finite { value, std_error } => (exact(value), exact(std_error)),
            Largest::Annihilated => ("-inf".to_owned(), String::new()),
            Largest::Unmeasured => (String::new(), String::new()),
        };
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

/// The largest exponent on the attractor, measured from where the orbit has come to it.
fn largest(system: &System, outcome: &Outcome, duration: f64, options: &Options) -> Largest {
    let (t, x) = &outcome.left_at;
    // On the attractor already: only the frame has to turn to it.
    let settings = SpectrumOptions::over(0.1 * duration, duration).solver(*options);
    match system.kernel().spectrum(*t, x, &settings) {
        Ok(spectrum) => match spectrum.exponents.first() {
            Some(&Exponent::Finite { value, std_error }) => Largest::Finite { value, std_error },
            Some(Exponent::Annihilated) => Largest::Annihilated,
            None => Largest::Unmeasured,
        },
        Err(_) => Largest::Unmeasured,
    }
}
