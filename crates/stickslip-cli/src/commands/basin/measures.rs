//! Measures of basins beside their shares, among them entropy and dimension of boundaries.

use std::num::NonZeroUsize;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use stickslip::Options;
use stickslip::analysis::{
    Attractor, AttractorKind, Attractors, BasinEntropy, RecurrenceSettings, UncertaintyExponent,
};
use stickslip::dynamics::Vector;
use stickslip_model::file::System;

use super::OutcomeShare;
use super::edges::{EdgeShown, edges};
use super::pushes::{Direction, pushes};
use super::starts::Points;
use crate::commands::arguments::count;
use crate::commands::range::StateRange;
use crate::failure::Failure;
use crate::render::{Report, Table, within};

/// Measures beside the shares.
#[derive(Clone, Debug, clap::Args, Serialize, Deserialize)]
pub(in crate::commands) struct Measures {
    /// Basin entropy in boxes of so many starts along each side (Daza et al. 2016); needs a grid
    /// that they divide
    #[arg(long, value_name = "STARTS", value_parser = count)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    entropy: Option<NonZeroUsize>,

    /// Dimension of the boundaries of basins, by the uncertainty exponent (Grebogi et al. 1983);
    /// needs a grid of 64x64 starts or more
    #[arg(long)]
    #[serde(default, skip_serializing_if = "is_false")]
    dimension: bool,

    /// Time until each orbit stays within this distance of its attractor: mean and largest
    #[arg(long, value_name = "DISTANCE")]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) return_within: Option<f64>,

    /// Least push out of the basin from a state of each attractor, as far as the plane goes; a
    /// state with or without a sign, or several with factors; can be repeated
    #[arg(long, value_name = "DIRECTION", allow_hyphen_values = true)]
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    push: Vec<String>,

    /// Edge states between the basins of each two attractors, by bisection and tracking (Skufca et
    /// al. 2006)
    #[arg(long)]
    #[serde(default, skip_serializing_if = "is_false")]
    edges: bool,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde gives a reference")]
fn is_false(given: &bool) -> bool {
    !given
}

/// A basin and its system, ready to be measured.
pub(super) struct Measured<'a> {
    pub(super) system: &'a System,
    pub(super) settings: RecurrenceSettings,
    pub(super) options: Options,
    pub(super) plane: &'a [StateRange; 2],
    pub(super) points: Points,
    /// Attractors and other outcomes.
    pub(super) attractors: &'a [OutcomeShare],
    /// Index of the outcome of each start.
    pub(super) reached: &'a [u32],
}

impl Measures {
    /// Reports errors before the sweep.
    pub(super) fn check(
        &self,
        points: &Points,
        plane: &[StateRange; 2],
        system: &System,
    ) -> Result<(), Failure> {
        let shape = match *points {
            Points::Grid { columns, rows } => Some([rows.get(), columns.get()]),
            Points::Random { .. } => None,
        };
        let needs_grid = |option: &str| {
            Failure::Usage(format!(
                "{option} needs starts on a grid; leave --random out"
            ))
        };
        if let Some(side) = self.entropy {
            let shape = shape.ok_or_else(|| needs_grid("--entropy"))?;
            let divides = |n: &usize| n.is_multiple_of(side.get()) && n / side.get() >= 2;
            if side.get() < 2 || !shape.iter().all(divides) {
                return Err(Failure::Usage(format!(
                    "--entropy {side}: boxes have 2 starts along each side or more, and divide \
                     the {} columns and {} rows into 2 boxes or more; choose --grid to fit",
                    shape[1], shape[0]
                )));
            }
        }
        if self.dimension {
            let shape = shape.ok_or_else(|| needs_grid("--dimension"))?;
            if shape.iter().any(|n| *n < 64) {
                return Err(Failure::Usage(format!(
                    "--dimension: {} x {} starts are too few; give --grid 64x64 or more",
                    shape[1], shape[0]
                )));
            }
        }
        if let Some(distance) = self.return_within
            && !(distance > 0.0 && distance.is_finite())
        {
            return Err(Failure::Usage(format!(
                "--return-within {distance}: a distance is positive and finite"
            )));
        }
        self.directions(plane, system).map(|_| ())
    }

    fn directions(
        &self,
        plane: &[StateRange; 2],
        system: &System,
    ) -> Result<Vec<Direction>, Failure> {
        let each = self.push.iter();
        each.map(|text| Direction::new(text, plane, system))
            .collect()
    }

    /// Computes the measures that are wanted and reports them. Returns what the figure shows.
    pub(super) fn report(
        &self,
        of: &Measured<'_>,
        report: &mut Report,
    ) -> Result<Vec<EdgeShown>, Failure> {
        let reached: Vec<usize> = of.reached.iter().map(|one| *one as usize).collect();
        if let Points::Grid { columns, rows } = of.points {
            let shape = [rows.get(), columns.get()];
            if let Some(side) = self.entropy {
                entropy(&reached, &shape, side.get(), report)?;
            }
            if self.dimension {
                dimension(&reached, &shape, report)?;
            }
        }
        if !self.push.is_empty() {
            pushes(&self.directions(of.plane, of.system)?, of, report)?;
        }
        match self.edges {
            true => edges(of, report),
            false => Ok(Vec::new()),
        }
    }
}

impl Measured<'_> {
    /// Number of an attractor, if it is one of these, and its motion.
    pub(super) fn numbered(&self, reached: &Attractor) -> (Option<usize>, &'static str) {
        let distinct = Attractors::new(self.system.dynamics(), &self.settings, &self.options);
        let mut all = self.attractors.iter();
        let known = all.find(|one| distinct.is_same(&one.reached, reached));
        (known.and_then(|one| one.number), reached.kind.word())
    }
}

/// An attractor in words.
pub(super) fn name_of((number, motion): (Option<usize>, &'static str)) -> String {
    number.map_or_else(|| motion.to_owned(), |number| format!("attractor {number}"))
}

/// The numbers of the attractors, with a state of each at time 0. Orbits are followed only to the
/// neighbourhood of an equilibrium, whose point is more accurate.
pub(super) fn states_of(of: &Measured<'_>) -> Result<Vec<(usize, Vector)>, Failure> {
    let (dynamics, mut states) = (of.system.dynamics(), Vec::new());
    for one in of.attractors {
        let Some(number) = one.number else { continue };
        let reached = one.reached.settled(dynamics, &of.settings, &of.options);
        let reached = reached.map_err(|error| Failure::from(error).of(of.system))?;
        let state = match reached.kind {
            AttractorKind::Equilibrium => reached.points.first().map(|point| &point.x),
            _ => reached.next_start(&of.settings),
        };
        states.extend(state.map(|x| (number, x.clone())));
    }
    Ok(states)
}

fn entropy(
    reached: &[usize],
    shape: &[usize],
    side: usize,
    report: &mut Report,
) -> Result<(), Failure> {
    let found = BasinEntropy::of(reached, shape, side)?;
    let boundary = found.boundary_entropy.map(|entropy| {
        let error = found.boundary_entropy_error.unwrap_or(f64::INFINITY);
        let fractal = match found.shows_fractal() {
            true => "; above ln 2: the boundary is fractal at this scale",
            false => "",
        };
        format!(
            ", Sbb {} in {} of them{fractal}",
            within(entropy, error),
            found.boundary_boxes
        )
    });
    report.note(format!(
        "basin entropy in {} boxes of {side} x {side} starts: Sb {}{}",
        found.boxes,
        within(found.entropy, found.entropy_error),
        boundary.as_deref().unwrap_or(", no boundary")
    ));
    report.field(
        "entropy",
        json!({
            "side": side,
            "boxes": found.boxes,
            "boundary_boxes": found.boundary_boxes,
            "sb": found.entropy,
            "sb_std_error": found.entropy_error,
            "sbb": found.boundary_entropy,
            "sbb_std_error": found.boundary_entropy_error,
            "shows_fractal": found.shows_fractal(),
        }),
    );
    Ok(())
}

fn dimension(reached: &[usize], shape: &[usize], report: &mut Report) -> Result<(), Failure> {
    let Some(found) = UncertaintyExponent::of(reached, shape)? else {
        report.note("dimension of the boundary: no boundary between starts was seen");
        report.field("boundary", Value::Null);
        return Ok(());
    };
    report.note(format!(
        "dimension of the boundary: {}; uncertainty exponent {}",
        within(found.dimension, found.std_error),
        within(found.exponent, found.std_error)
    ));
    report.field(
        "boundary",
        json!({
            "exponent": found.exponent,
            "dimension": found.dimension,
            "std_error": found.std_error,
            "fractions": found.fractions,
        }),
    );
    let table = Table::new()
        .column("steps", |row: &&(usize, f64)| row.0)
        .column("uncertain", |row| row.1);
    report.table(table.csv("uncertain", &found.fractions)?);
    Ok(())
}
