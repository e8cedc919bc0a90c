//! What a branch has shown, as tables and in words.

use std::f64::consts::TAU;
use std::fmt::Write;

use serde_json::{Value, json};
use stickslip::analysis::Stop;
use stickslip_kernels::kernel::{Change, SpecialKind, SpecialThere};

use super::super::attractors::family_words;
use super::super::range::ParameterRange;
use super::super::told::told;
use super::super::{Failure, Found, tables};
use super::branch::{Branch, Point};
use super::figure;
use crate::output::{Artifact, OutputError, csv_table};
use stickslip_kernels::file::System;

/// A branch, and what it is of.
pub(super) struct Told<'a> {
    pub(super) system: &'a System,
    pub(super) range: &'a ParameterRange,
    pub(super) branch: &'a Branch,
    /// Dimension of the family of orbits that the one it was begun with is of.
    pub(super) family: usize,
}

/// What a special orbit is called.
fn what(kind: &SpecialKind) -> String {
    match kind {
        SpecialKind::Fold => "fold".to_owned(),
        SpecialKind::BranchPoint => "branch point".to_owned(),
        SpecialKind::Flip => "flip".to_owned(),
        SpecialKind::NeimarkSacker { .. } => "Neimark-Sacker".to_owned(),
        SpecialKind::Sequence(change) => tables::change_name(change),
    }
}

/// Why a branch ends, after "it ends".
fn why(stop: &Stop, parameter: &str, system: &System) -> String {
    match *stop {
        Stop::Range => "at an end of the range".to_owned(),
        Stop::Points => "after as many orbits as were asked for (--points)".to_owned(),
        Stop::Closed => "where it began: the branch is closed".to_owned(),
        Stop::Equilibrium {
            parameter: value,
            frequency,
        } => format!(
            "in an equilibrium: Hopf bifurcation at {parameter} = {}, frequency {}",
            tables::rounded(value),
            tables::rounded(frequency)
        ),
        Stop::BoundaryEquilibrium { parameter: value } => format!(
            "in an equilibrium on the boundary: boundary-equilibrium bifurcation at {parameter} = {}",
            tables::rounded(value)
        ),
        Stop::Homoclinic {
            parameter: value,
            uncertainty,
            saddles,
            leaves,
            comes,
        } => format!(
            "in {}: at {parameter} = {}, rates {} and {}",
            match saddles.get() {
                1 => "a homoclinic orbit of a saddle".to_owned(),
                number => format!("a heteroclinic cycle of {number} saddles"),
            },
            tables::within(value, uncertainty),
            tables::rounded(comes),
            tables::rounded(leaves)
        ),
        Stop::Rest => "where it comes to rest: it moves a thousandth of what it did".to_owned(),
        Stop::Refused(ref error) => format!("where {}", told(error, system)),
        Stop::SequenceEnds => {
            "where its phases change: no orbit with other phases was found next to it".to_owned()
        }
        Stop::NoConvergence => {
            "where no further orbit was found; a shorter --step or a smaller --tol may lead on"
                .to_owned()
        }
    }
}

/// The same in a word.
fn why_in_short(stop: &Stop) -> &'static str {
    match stop {
        Stop::Range => "range",
        Stop::Points => "points",
        Stop::Closed => "closed",
        Stop::Equilibrium { .. } => "equilibrium",
        Stop::BoundaryEquilibrium { .. } => "boundary equilibrium",
        Stop::Homoclinic { .. } => "homoclinic",
        Stop::Rest => "rest",
        Stop::Refused(_) => "friction",
        Stop::SequenceEnds => "sequence ends",
        Stop::NoConvergence => "no convergence",
    }
}

/// The row of `special.csv` for the end of a branch behind so many orbits, if it is at a bifurcation. Its orbit has no phases of its own, and a
/// homoclinic one no period.
fn end_row(stop: &Stop, behind: usize, columns: usize) -> Option<Vec<String>> {
    let (parameter, what, uncertainty, period) = match *stop {
        Stop::Equilibrium {
            parameter,
            frequency,
        } => (parameter, "Hopf", None, Some(TAU / frequency)),
        Stop::BoundaryEquilibrium { parameter } => (parameter, "boundary equilibrium", None, None),
        Stop::Homoclinic {
            parameter,
            uncertainty,
            saddles,
            ..
        } => {
            let what = match saddles.get() {
                1 => "homoclinic",
                _ => "heteroclinic",
            };
            (parameter, what, Some(uncertainty), None)
        }
        _ => return None,
    };
    let number = |value: Option<f64>| value.map(tables::exact).unwrap_or_default();
    let mut row = vec![behind.to_string(), tables::exact(parameter)];
    // Contacts and angle, then the phases.
    row.extend([what.to_owned(), String::new(), String::new()]);
    row.extend([number(uncertainty), String::new(), String::new()]);
    row.push(number(period));
    row.resize(columns, String::new());
    Some(row)
}

impl Told<'_> {
    pub(super) fn found(&self) -> Result<Found, Failure> {
        let svg = figure::diagram(self)?;
        Ok(Found {
            summary: self.summary(),
            json: self.json(),
            tables: vec![self.branch_table()?, self.special_table()?],
            figures: vec![("continue".to_owned(), svg)],
            failure: None,
        })
    }

    fn states(&self) -> impl Iterator<Item = &str> {
        let states = self.system.file.states.iter();
        states.map(|state| state.name.as_str())
    }

    /// `branch.csv`: an orbit a row, from the branch's end downwards to its end upwards.
    fn branch_table(&self) -> Result<Artifact, OutputError> {
        let points = &self.branch.points;
        let multipliers = points.iter().map(|at| at.orbit.multipliers.len()).max();
        let multipliers = multipliers.unwrap_or(0);
        let mut heading =
            tables::strings(&[&self.range.name, "period", "stability", "phases", "t"]);
        heading.extend(self.states().map(str::to_owned));
        for name in self.states() {
            heading.extend([format!("{name}_low"), format!("{name}_high")]);
        }
        for k in 1..=multipliers {
            heading.extend([format!("multiplier{k}_re"), format!("multiplier{k}_im")]);
        }
        let rows = points.iter().map(|Point { orbit, extremes }| {
            let mut row: Vec<String> = [orbit.parameter, orbit.period].map(tables::exact).into();
            row.extend([orbit.stability.to_string(), tables::sequence(&orbit.phases)]);
            row.push(tables::exact(orbit.t));
            row.extend(orbit.x.iter().map(|&x| tables::exact(x)));
            for &(low, high) in extremes {
                row.extend([low, high].map(tables::exact));
            }
            for multiplier in &orbit.multipliers {
                row.extend([multiplier.re, multiplier.im].map(tables::exact));
            }
            row.resize(heading.len(), String::new());
            row
        });
        csv_table("branch.csv", &heading, rows)
    }

    /// `special.csv`: the special orbits, each behind so many rows of `branch.csv`, and the ends that are bifurcations.
    fn special_table(&self) -> Result<Artifact, OutputError> {
        let columns = [
            "what",
            "contacts",
            "angle",
            "uncertainty",
            "before",
            "after",
            "period",
        ];
        let mut heading = tables::strings(&["behind", &self.range.name]);
        heading.extend(tables::strings(&columns));
        heading.extend(self.states().map(str::to_owned));
        let rows = self.branch.special.iter().map(|at| {
            let mut row = vec![at.behind.to_string(), tables::exact(at.parameter)];
            row.push(what(&at.what));
            row.push(match &at.what {
                SpecialKind::Sequence(change) => tables::changed_contacts(self.system, change),
                _ => String::new(),
            });
            row.push(match &at.what {
                SpecialKind::NeimarkSacker { angle } => tables::exact(*angle),
                _ => String::new(),
            });
            row.push(tables::exact(at.uncertainty));
            row.extend(match &at.what {
                SpecialKind::Sequence(Change::Sequence { before, after, .. }) => {
                    [before, after].map(|modes| tables::sequence(modes))
                }
                _ => [String::new(), String::new()],
            });
            row.push(tables::exact(at.period));
            row.extend(at.x.iter().map(|&x| tables::exact(x)));
            row
        });
        let [down, up] = &self.branch.stops;
        let first = end_row(down, 0, heading.len());
        let last = end_row(up, self.branch.points.len(), heading.len());
        let rows: Vec<_> = first.into_iter().chain(rows).chain(last).collect();
        csv_table("special.csv", &heading, rows)
    }

    fn summary(&self) -> String {
        let (range, branch) = (self.range, self.branch);
        let mut text = format!(
            "{}: {} periodic orbits over {} from {} to {}\n",
            self.system.file.name,
            branch.points.len(),
            range.name,
            range.low,
            range.high
        );
        // Writing into a text cannot fail.
        if let Some(Point { orbit, .. }) = branch.points.get(branch.first) {
            let _ = writeln!(
                text,
                "  begun at {} = {}: period {}, {}, phases {}  (- below, + above, S stick)",
                range.name,
                tables::rounded(orbit.parameter),
                tables::rounded(orbit.period),
                orbit.stability,
                tables::sequence(&orbit.phases)
            );
        }
        if self.family > 0 {
            let _ = writeln!(
                text,
                "  it is {}; at each value the one nearest to that before is followed",
                family_words(self.family)
            );
        }
        for at in &branch.special {
            let _ = writeln!(
                text,
                "  at {} = {}: {}",
                range.name,
                tables::place(at.parameter, at.uncertainty),
                self.special(at)
            );
        }
        let ends = [branch.points.first(), branch.points.last()];
        for ((end, stop), way) in ends
            .into_iter()
            .zip(&branch.stops)
            .zip(["begun downwards", "begun upwards"])
        {
            if let Some(Point { orbit, .. }) = end {
                let _ = writeln!(
                    text,
                    "  {way}, {} at its last orbit ({} = {}), it ends {}",
                    orbit.stability,
                    range.name,
                    tables::rounded(orbit.parameter),
                    why(stop, &range.name, self.system)
                );
            }
        }
        text
    }

    fn json(&self) -> Value {
        let (range, branch) = (self.range, self.branch);
        let special: Vec<Value> = branch
            .special
            .iter()
            .map(|at| self.special_json(at))
            .collect();
        let ends = [branch.points.first(), branch.points.last()];
        let ends: Vec<Value> = ends
            .into_iter()
            .zip(&branch.stops)
            .map(|(end, stop)| {
                json!({
                    "parameter": end.map(|end| end.orbit.parameter),
                    "stop": why_in_short(stop),
                    "error": match stop {
                        Stop::Refused(error) => json!(told(error, self.system)),
                        _ => Value::Null,
                    },
                    "hopf": match *stop {
                        Stop::Equilibrium { parameter, frequency } => json!({ "parameter": parameter, "frequency": frequency }),
                        _ => Value::Null,
                    },
                    "boundary_equilibrium": match *stop {
                        Stop::BoundaryEquilibrium { parameter } => json!(parameter),
                        _ => Value::Null,
                    },
                    "homoclinic": match *stop {
                        Stop::Homoclinic { parameter, uncertainty, saddles, leaves, comes } => json!({ "parameter": parameter, "uncertainty": uncertainty, "saddles": saddles, "leaves": leaves, "comes": comes }),
                        _ => Value::Null,
                    },
                })
            })
            .collect();
        json!({
            "system": tables::system_json(self.system),
            "parameter": range,
            "points": branch.points.len(),
            "family_dimension": self.family,
            "special": special,
            "ends": ends,
        })
    }
}

impl Told<'_> {
    /// A special orbit in words.
    fn special(&self, at: &SpecialThere) -> String {
        match &at.what {
            kind @ SpecialKind::NeimarkSacker { angle } => {
                format!("{}, angle {}", what(kind), tables::rounded(*angle))
            }
            SpecialKind::Sequence(change) => {
                let name = tables::change_words(self.system, change);
                match change {
                    Change::Sequence { before, after, .. }
                        if !before.is_empty() && !after.is_empty() =>
                    {
                        format!(
                            "{name}, between phases {} and {}",
                            tables::sequence(before),
                            tables::sequence(after)
                        )
                    }
                    _ => name,
                }
            }
            kind => what(kind),
        }
    }

    fn special_json(&self, at: &SpecialThere) -> Value {
        let change = match &at.what {
            SpecialKind::Sequence(change) => tables::change_json(self.system, change),
            _ => Value::Null,
        };
        let angle = match at.what {
            SpecialKind::NeimarkSacker { angle } => Some(angle),
            _ => None,
        };
        json!({
            "parameter": at.parameter,
            "uncertainty": at.uncertainty,
            "what": what(&at.what),
            "behind": at.behind,
            "period": at.period,
            "x": at.x,
            "angle": angle,
            "change": change,
        })
    }
}
