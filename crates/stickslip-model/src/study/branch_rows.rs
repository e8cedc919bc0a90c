//! Special orbits and ends of branches as rows of tables and in words.

use std::f64::consts::TAU;

use stickslip::analysis::{Criticality, CurveStop, CycleBifurcation, SpecialPoint, Stop};

use super::TwoSidedBranch;
use crate::file::System;

/// A special orbit of a branch, or a bifurcation in which it ends, as a row of a table.
#[derive(Clone, Debug, Default)]
pub struct SpecialRow {
    /// Name.
    pub name: String,
    /// The parameter.
    pub parameter: f64,
    /// Uncertainty, if it is known.
    pub uncertainty: Option<f64>,
    /// The period, if it is finite and known.
    pub period: Option<f64>,
    /// The angle of the multipliers at a Neimark–Sacker bifurcation.
    pub angle: Option<f64>,
    /// Whether a flip or Neimark–Sacker bifurcation is super- or subcritical; empty where that is
    /// not determined, and of others.
    pub criticality: String,
    /// The contacts whose event functions vanish at a change of the phases.
    pub contacts: String,
    /// The phases before and after it.
    pub phases: [String; 2],
    /// The state; empty at an end.
    pub x: Vec<f64>,
    /// Number of orbits of the branch before it.
    pub behind: usize,
}

/// Whether a flip or Neimark–Sacker bifurcation is super- or subcritical; `None` where that is not
/// determined, and of others.
pub fn criticality_of(at: &SpecialPoint) -> Option<Criticality> {
    at.normal_form.as_ref()?.criticality()
}

impl SpecialRow {
    fn of(at: &SpecialPoint, system: &System) -> Self {
        let row = SpecialRow {
            name: at.what.to_string(),
            parameter: at.parameter,
            uncertainty: Some(at.uncertainty),
            period: Some(at.period),
            criticality: criticality_of(at).map_or(String::new(), |side| side.to_string()),
            x: at.x.as_slice().to_vec(),
            behind: at.behind,
            ..SpecialRow::default()
        };
        match &at.what {
            CycleBifurcation::NeimarkSacker { angle } => SpecialRow {
                angle: Some(*angle),
                ..row
            },
            CycleBifurcation::Sequence(change) => SpecialRow {
                contacts: system.contact_names(&change.contacts),
                phases: [&change.before, &change.after].map(|phases| system.sequence(phases)),
                ..row
            },
            _ => row,
        }
    }
}

impl TwoSidedBranch {
    /// Why the branch ends, downwards and upwards.
    pub fn ends(&self) -> [BranchEnd; 2] {
        self.stops.each_ref().map(BranchEnd::from)
    }

    /// The special orbits, and the ends that are bifurcations, from the lower to the upper end.
    pub fn special_rows(&self, system: &System) -> Vec<SpecialRow> {
        let [first, last] = self.ends().map(|end| end.bifurcation);
        let last = last.map(|row| SpecialRow {
            behind: self.points.len(),
            ..row
        });
        let special = self.special.iter().map(|at| SpecialRow::of(at, system));
        first.into_iter().chain(special).chain(last).collect()
    }
}

/// Why a curve in two parameters ends, in a word.
pub fn word_of_curve_stop(stop: CurveStop) -> &'static str {
    match stop {
        CurveStop::Range => "range",
        CurveStop::Points => "points",
        CurveStop::Closed => "closed",
        CurveStop::Flip => "flip",
        CurveStop::Resonance => "resonance",
        CurveStop::BogdanovTakens => "Bogdanov-Takens",
        CurveStop::AnotherChange => "another change",
        CurveStop::NoConvergence => "no convergence",
    }
}

/// The end of a branch, for programs.
#[derive(Clone, Debug)]
pub struct BranchEnd {
    /// Why it ends.
    pub word: &'static str,
    /// The bifurcation in which it ends, if it does.
    pub bifurcation: Option<SpecialRow>,
}

impl From<&Stop> for BranchEnd {
    fn from(stop: &Stop) -> Self {
        let plain = |word| BranchEnd {
            word,
            bifurcation: None,
        };
        let located = |word, name: &str, parameter, uncertainty, period| BranchEnd {
            word,
            bifurcation: Some(SpecialRow {
                name: name.to_owned(),
                parameter,
                uncertainty,
                period,
                ..SpecialRow::default()
            }),
        };
        match *stop {
            Stop::Range => plain("range"),
            Stop::Points => plain("points"),
            Stop::Closed => plain("closed"),
            Stop::HeldByFriction => plain("rest"),
            Stop::Refused(_) => plain("friction"),
            Stop::SequenceEnds => plain("sequence ends"),
            Stop::NoConvergence => plain("no convergence"),
            Stop::Flip {
                parameter,
                uncertainty,
            } => located("flip", "flip", parameter, Some(uncertainty), None),
            Stop::Equilibrium {
                parameter,
                frequency,
            } => located(
                "equilibrium",
                "Hopf",
                parameter,
                None,
                Some(TAU / frequency),
            ),
            Stop::BoundaryEquilibrium { parameter } => {
                let word = "boundary equilibrium";
                located(word, word, parameter, None, None)
            }
            Stop::TwoFold {
                parameter,
                uncertainty,
            } => located("two-fold", "two-fold", parameter, Some(uncertainty), None),
            Stop::Homoclinic {
                parameter,
                uncertainty,
                saddles,
                ..
            } => {
                let name = match saddles.get() {
                    1 => "homoclinic",
                    _ => "heteroclinic",
                };
                located("homoclinic", name, parameter, Some(uncertainty), None)
            }
        }
    }
}
