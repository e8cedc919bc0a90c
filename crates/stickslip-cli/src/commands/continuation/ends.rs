//! Ends of a branch in words, as values for programs, and as rows of a table.

use serde_json::{Value, json};
use stickslip::analysis::Stop;
use stickslip::error::readable;
use stickslip_kernels::file::System;
use stickslip_kernels::study::BranchEnd;

use super::special::SpecialRow;
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
    /// The row of `special.csv`, if the end is a bifurcation. It has no phases, and a homoclinic
    /// orbit has no period.
    row: Option<SpecialRow>,
}

impl EndDescription {
    pub(super) fn of(stop: &Stop, system: &System, name: &str) -> Self {
        let BranchEnd { word, bifurcation } = stop.into();
        let (words, detail) = match *stop {
            Stop::Range => ("at an end of the range".to_owned(), None),
            Stop::Points => (
                "after the largest number of orbits (--points)".to_owned(),
                None,
            ),
            Stop::Closed => ("where it began: the branch is closed".to_owned(), None),
            Stop::Flip {
                parameter,
                uncertainty,
            } => (
                format!(
                    "in a flip of the orbit of half the period: at {name} = {}",
                    within(parameter, uncertainty)
                ),
                Some((
                    "flip",
                    json!({ "parameter": parameter, "uncertainty": uncertainty }),
                )),
            ),
            Stop::Equilibrium {
                parameter,
                frequency,
            } => (
                format!(
                    "in an equilibrium: Hopf bifurcation at {name} = {}, frequency {}",
                    readable(parameter),
                    readable(frequency)
                ),
                Some((
                    "hopf",
                    json!({ "parameter": parameter, "frequency": frequency }),
                )),
            ),
            Stop::BoundaryEquilibrium { parameter } => (
                format!(
                    "in an equilibrium on the boundary or at a jump: boundary-equilibrium \
                     bifurcation at {name} = {}",
                    readable(parameter)
                ),
                Some(("boundary_equilibrium", json!(parameter))),
            ),
            Stop::TwoFold {
                parameter,
                uncertainty,
            } => (
                format!(
                    "in a two-fold, to which it shrinks: at {name} = {}",
                    within(parameter, uncertainty)
                ),
                Some((
                    "two_fold",
                    json!({ "parameter": parameter, "uncertainty": uncertainty }),
                )),
            ),
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
                (
                    format!(
                        "in {orbit}: at {name} = {}, rates {} and {}",
                        within(parameter, uncertainty),
                        readable(comes),
                        readable(leaves)
                    ),
                    Some((
                        "homoclinic",
                        json!({
                            "parameter": parameter,
                            "uncertainty": uncertainty,
                            "saddles": saddles,
                            "leaves": leaves,
                            "comes": comes,
                        }),
                    )),
                )
            }
            Stop::Rest => (
                "at rest: its motion has fallen to a thousandth of the first orbit's".to_owned(),
                None,
            ),
            Stop::Refused(ref error) => {
                let words = in_words(error, system);
                (format!("where {words}"), Some(("error", json!(words))))
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
        EndDescription {
            stop: word,
            words,
            detail,
            row: bifurcation.map(|end| SpecialRow {
                parameter: end.parameter,
                what: end.name.to_owned(),
                uncertainty: end.uncertainty,
                period: end.period,
                ..SpecialRow::default()
            }),
        }
    }

    /// The row of the end, `behind` orbits after the first.
    pub(super) fn row(&self, behind: usize) -> Option<SpecialRow> {
        let row = self.row.clone()?;
        Some(SpecialRow { behind, ..row })
    }
}
