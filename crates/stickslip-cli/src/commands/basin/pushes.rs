//! Least pushes out of basins.

use rayon::prelude::*;
use stickslip::Error;
use stickslip::analysis::{AttractorKind, Push, PushSettings};
use stickslip::dynamics::Vector;
use stickslip::error::readable;
use stickslip_model::file::{System, number};

use super::measures::{Measured, name_of, states_of};
use crate::commands::arguments::position;
use crate::commands::range::StateRange;
use crate::failure::Failure;
use crate::render::{Report, Table, within};

/// A direction in the plane.
pub(super) struct Direction {
    text: String,
    parts: Vec<(usize, f64)>,
}

impl Direction {
    /// Reads `v`, `-v` or `x=1,v=-0.5`.
    pub(super) fn new(
        text: &str,
        plane: &[StateRange; 2],
        system: &System,
    ) -> Result<Self, Failure> {
        let states = || system.file.states.iter().map(|state| state.name.as_str());
        let mut parts: Vec<(usize, f64)> = Vec::new();
        for part in text.split(',').map(str::trim) {
            let (name, factor) = match part.split_once('=') {
                Some((name, factor)) => {
                    let factor = number(factor).map_err(|message| {
                        Failure::Usage(format!("--push {text}: the factor of {name}: {message}"))
                    })?;
                    (name, factor)
                }
                None => match part.strip_prefix('-') {
                    Some(name) => (name, -1.0),
                    None => (part.trim_start_matches('+'), 1.0),
                },
            };
            let state = position("state", name.trim(), states())?;
            if plane.iter().all(|range| range.state != state) {
                let names = plane.map(|range| system.file.states[range.state].name.clone());
                return Err(Failure::Usage(format!(
                    "--push {text}: a push stays in the plane of starts, {}; choose another \
                     plane with --x and --y",
                    names.join(" and ")
                )));
            }
            if parts.iter().any(|(known, _)| *known == state) {
                let name = &system.file.states[state].name;
                return Err(Failure::Usage(format!(
                    "--push {text}: the state `{name}` stands twice; take one out"
                )));
            }
            parts.push((state, factor));
        }
        if !(parts.iter().all(|part| part.1.is_finite()) && parts.iter().any(|part| part.1 != 0.0))
        {
            return Err(Failure::Usage(format!(
                "--push {text}: a direction has finite factors, and one at least is not 0"
            )));
        }
        Ok(Self {
            text: text.to_owned(),
            parts,
        })
    }

    fn vector(&self, states: usize) -> Vector {
        let mut vector = Vector::zeros(states);
        for &(state, factor) in &self.parts {
            vector[state] = factor;
        }
        vector
    }

    /// The push that leads to the edge of the plane; not positive from outside of it.
    fn largest(&self, from: &Vector, plane: &[StateRange; 2]) -> f64 {
        let is_inside =
            |range: &StateRange| range.low <= from[range.state] && from[range.state] <= range.high;
        if !plane.iter().all(is_inside) {
            return 0.0;
        }
        let ends = self.parts.iter().filter(|part| part.1 != 0.0);
        let ends = ends.filter_map(|&(state, factor)| {
            let range = plane.iter().find(|range| range.state == state)?;
            let end = if factor > 0.0 { range.high } else { range.low };
            Some((end - from[state]) / factor)
        });
        ends.fold(f64::INFINITY, f64::min)
    }
}

/// A least push from an attractor.
struct PushRow {
    /// Number of the attractor.
    attractor: usize,
    direction: String,
    /// State that is pushed.
    from: Vector,
    /// Largest push that can be tried; not positive from outside the plane.
    largest: f64,
    /// Stop behind which larger pushes lead.
    stop: Option<String>,
    push: Option<Push>,
    /// Number of the attractor beyond, if it is one, and its motion.
    beyond: Option<(Option<usize>, &'static str)>,
}

/// Computes the least push from each attractor along each direction, and reports them.
pub(super) fn pushes(
    directions: &[Direction],
    of: &Measured<'_>,
    report: &mut Report,
) -> Result<(), Failure> {
    let cases = states_of(of)?.into_iter().flat_map(|(attractor, from)| {
        let each = directions.iter();
        each.map(move |direction| (attractor, from.clone(), direction))
    });
    let cases: Vec<(usize, Vector, &Direction)> = cases.collect();
    let dynamics = of.system.dynamics();
    let row = |(attractor, from, direction): (usize, Vector, &Direction)| {
        let largest = direction.largest(&from, of.plane);
        let push = if largest > 0.0 {
            let how = PushSettings::up_to(largest);
            let along = [direction.vector(from.len())];
            let found = Push::least(dynamics, &from, along, &how, &of.settings, &of.options)?;
            found.into_iter().flatten().next()
        } else {
            None
        };
        let stopped = push.as_ref().filter(|push| push.ends_at_stop);
        let stop = stopped.and_then(|push| match &push.beyond.kind {
            AttractorKind::Failure(Error::BehindStop { number, .. }) => {
                let impact = of.system.contact_name(*number);
                impact.rsplit_once('.').map(|(stop, _)| stop.to_owned())
            }
            _ => None,
        });
        let largest = stopped.map_or(largest, |push| push.size);
        let push = push.filter(|push| !push.ends_at_stop);
        let beyond = push.as_ref().map(|push| of.numbered(&push.beyond));
        Ok(PushRow {
            attractor,
            direction: direction.text.clone(),
            from,
            largest,
            stop,
            push,
            beyond,
        })
    };
    let rows: Result<Vec<PushRow>, stickslip::Error> = cases.into_par_iter().map(row).collect();
    let rows = rows.map_err(|error| Failure::from(error).of(of.system))?;
    for row in &rows {
        let words = match (&row.push, &row.beyond) {
            (Some(push), Some(beyond)) => {
                format!(
                    "{}, to {}",
                    within(push.size, push.uncertainty),
                    name_of(*beyond)
                )
            }
            _ if row.largest > 0.0 => {
                let largest = readable(row.largest);
                match &row.stop {
                    Some(stop) => format!(
                        "none up to {largest}, where it comes to the stop `{stop}`: a start must \
                         not be behind it"
                    ),
                    None => format!("none up to {largest}, where the plane ends"),
                }
            }
            _ => "not tried, as the attractor lies outside the plane".to_owned(),
        };
        report.note(format!(
            "push from attractor {} along {}: {words}",
            row.attractor, row.direction
        ));
    }
    let size = |row: &&PushRow| row.push.as_ref().map(|push| push.size);
    let table = Table::new()
        .column("attractor", |row: &&PushRow| row.attractor)
        .column("direction", |row| row.direction.clone())
        .column("push", size)
        .column("uncertainty", |row| Some(row.push.as_ref()?.uncertainty))
        .column("beyond", |row| row.beyond?.0)
        .column("beyond_motion", |row| Some(row.beyond?.1))
        .column("largest", |row| row.largest)
        .state(of.system, "", |row| row.from.clone());
    report.field("pushes", table.json(&rows));
    report.table(table.csv("pushes", &rows)?);
    Ok(())
}
