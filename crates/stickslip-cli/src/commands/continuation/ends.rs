//! Ends of a branch in words, and as values for programs.

use serde_json::{Value, json};
use stickslip::analysis::Stop;
use stickslip::error::readable;
use stickslip_model::file::System;
use stickslip_model::study::BranchEnd;

use crate::failure::in_words;
use crate::render::within;

/// The end of a branch.
pub(super) struct EndDescription {
    /// Name for programs.
    pub(super) stop: &'static str,
    /// Words that follow "it ends".
    pub(super) words: String,
    /// A value for programs, with its name.
    pub(super) detail: Option<(&'static str, Value)>,
}

impl EndDescription {
    pub(super) fn of(stop: &Stop, system: &System, name: &str) -> Self {
        let located = |what: &str, parameter, uncertainty| {
            format!("in {what}: at {name} = {}", within(parameter, uncertainty))
        };
        let (words, key) = match *stop {
            Stop::Range => ("at an end of the range".to_owned(), None),
            Stop::Points => (
                "after the largest number of orbits (--points)".to_owned(),
                None,
            ),
            Stop::Closed => ("where it began: the branch is closed".to_owned(), None),
            Stop::Flip {
                parameter,
                uncertainty,
            } => {
                let what = "a flip of the orbit of half the period";
                (located(what, parameter, uncertainty), Some("flip"))
            }
            Stop::Equilibrium {
                parameter,
                frequency,
            } => (
                format!(
                    "in an equilibrium: Hopf bifurcation at {name} = {}, frequency {}",
                    readable(parameter),
                    readable(frequency)
                ),
                Some("hopf"),
            ),
            Stop::BoundaryEquilibrium { parameter } => (
                format!(
                    "in an equilibrium on the boundary or at a jump: boundary-equilibrium \
                     bifurcation at {name} = {}",
                    readable(parameter)
                ),
                Some("boundary_equilibrium"),
            ),
            Stop::TwoFold {
                parameter,
                uncertainty,
            } => {
                let what = "a two-fold, to which it shrinks";
                (located(what, parameter, uncertainty), Some("two_fold"))
            }
            Stop::Homoclinic {
                parameter,
                uncertainty,
                saddles,
                leaves,
                comes,
            } => {
                let orbit = match saddles.get() {
                    1 => "a homoclinic orbit of a saddle".to_owned(),
                    number => format!("a heteroclinic cycle of {number} saddles"),
                };
                let place = located(&orbit, parameter, uncertainty);
                let [comes, leaves] = [comes, leaves].map(readable);
                let words = format!("{place}, rates {comes} and {leaves}");
                (words, Some("homoclinic"))
            }
            Stop::HeldByFriction => (
                "at rest: its motion has fallen to a thousandth of the first orbit's".to_owned(),
                None,
            ),
            Stop::Refused(ref error) => {
                (format!("where {}", in_words(error, system)), Some("error"))
            }
            Stop::SequenceEnds => (
                "where its phases change: no orbit with other phases was found next to it"
                    .to_owned(),
                None,
            ),
            Stop::NoConvergence => (
                "where no further orbit was found; a shorter --step or a smaller --tol may help"
                    .to_owned(),
                None,
            ),
        };
        // The values of the library's variant, by its fields.
        let value = match (stop, serde_json::to_value(stop)) {
            (Stop::Refused(error), _) => json!(in_words(error, system)),
            (Stop::BoundaryEquilibrium { parameter }, _) => json!(parameter),
            (_, Ok(Value::Object(variant))) => variant.into_values().next().unwrap_or_default(),
            _ => Value::Null,
        };
        EndDescription {
            stop: BranchEnd::from(stop).word,
            words,
            detail: key.map(|key| (key, value)),
        }
    }
}
