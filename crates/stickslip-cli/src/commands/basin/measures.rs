//! Measures of basins beside their shares: entropy and dimension of boundaries, times to return,
//! pushes out of basins, edge states.

use std::num::NonZeroUsize;

use plot::{Curve, Markers, Panel, Shape};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use stickslip::Options;
use stickslip::analysis::{
    Attractor, AttractorKind, Attractors, EdgeKind, EdgeSettings, EdgeState, Push, PushSettings,
    RecurrenceSettings, basin_entropy, carried_on, edge_state, least_pushes, uncertainty_exponent,
};
use stickslip::dynamics::{Moment, Vector};
use stickslip::error::readable;

use super::OutcomeShare;
use super::starts::Points;
use crate::commands::arguments::{count, position};
use crate::commands::range::StateRange;
use crate::failure::Failure;
use crate::render::{Report, Table, by_state, state_words, within};
use stickslip_model::file::{System, number};

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

/// A direction in the plane.
struct Direction {
    text: String,
    parts: Vec<(usize, f64)>,
}

impl Direction {
    /// Reads `v`, `-v` or `x=1,v=-0.5`.
    fn new(text: &str, plane: &[StateRange; 2], system: &System) -> Result<Self, Failure> {
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
    /// Largest push that was tried; not positive from outside the plane.
    largest: f64,
    push: Option<Push>,
    /// Number of the attractor beyond, if it is one, and its motion.
    beyond: Option<(Option<usize>, &'static str)>,
}

/// An edge state between two attractors.
struct EdgeRow {
    between: [usize; 2],
    state: EdgeState,
    /// Number of the attractor on the other side, if it is one, and its motion.
    beyond: (Option<usize>, &'static str),
}

impl EdgeRow {
    fn motion(&self) -> &'static str {
        match self.state.kind {
            EdgeKind::Equilibrium => "equilibrium",
            EdgeKind::Periodic { .. } => "periodic",
            EdgeKind::Undecided => "undecided",
        }
    }

    fn period(&self) -> Option<f64> {
        match self.state.kind {
            EdgeKind::Periodic { period } => Some(period),
            _ => None,
        }
    }
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

/// A track to draw in the plane, and the edge state, if it is in the range.
pub(super) struct EdgeShown {
    track: Vec<(f64, f64)>,
    state: Option<(f64, f64)>,
}

impl EdgeShown {
    /// Draws edge states with their tracks.
    pub(super) fn draw(all: &[EdgeShown], panel: &mut Panel) {
        for (k, one) in all.iter().enumerate() {
            let track = Curve::new(one.track.iter().copied()).width(1.4);
            let legend = "tracks along boundaries";
            panel.add(if k == 0 { track.legend(legend) } else { track });
        }
        let states: Vec<(f64, f64)> = all.iter().filter_map(|one| one.state).collect();
        if !states.is_empty() {
            let states = Markers::new(states).shape(Shape::Square).size(4.0);
            panel.add(states.legend("edge states"));
        }
    }
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
            self.pushes(of, report)?;
        }
        match self.edges {
            true => edges(of, report),
            false => Ok(Vec::new()),
        }
    }

    fn pushes(&self, of: &Measured<'_>, report: &mut Report) -> Result<(), Failure> {
        let directions = self.directions(of.plane, of.system)?;
        let cases = states_of(of).into_iter().flat_map(|(attractor, from)| {
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
                let found = least_pushes(dynamics, &from, along, &how, &of.settings, &of.options)?;
                found.into_iter().flatten().next()
            } else {
                None
            };
            let beyond = push.as_ref().map(|push| of.numbered(&push.beyond));
            Ok(PushRow {
                attractor,
                direction: direction.text.clone(),
                from,
                largest,
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
                    format!("none up to {}, where the plane ends", readable(row.largest))
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
}

impl Measured<'_> {
    /// Number of an attractor, if it is one of these, and its motion.
    fn numbered(&self, reached: &Attractor) -> (Option<usize>, &'static str) {
        let distinct = Attractors::new(self.system.dynamics(), &self.settings, &self.options);
        let mut all = self.attractors.iter();
        let known = all.find(|one| distinct.is_same(&one.reached, reached));
        (known.and_then(|one| one.number), reached.kind.word())
    }
}

/// An attractor in words.
fn name_of((number, motion): (Option<usize>, &'static str)) -> String {
    number.map_or_else(|| motion.to_owned(), |number| format!("attractor {number}"))
}

/// The numbers of the attractors, with a state of each at time 0. Orbits are followed only to the
/// neighbourhood of an equilibrium, whose point is more accurate.
fn states_of(of: &Measured<'_>) -> Vec<(usize, Vector)> {
    let each = of.attractors.iter().filter_map(|one| {
        let state = match one.reached.kind {
            AttractorKind::Equilibrium => &one.reached.points.first()?.x,
            _ => carried_on(&one.reached, &of.settings)?,
        };
        Some((one.number?, state.clone()))
    });
    each.collect()
}

fn entropy(
    reached: &[usize],
    shape: &[usize],
    side: usize,
    report: &mut Report,
) -> Result<(), Failure> {
    let found = basin_entropy(reached, shape, side)?;
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
    let Some(found) = uncertainty_exponent(reached, shape)? else {
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

fn edges(of: &Measured<'_>, report: &mut Report) -> Result<Vec<EdgeShown>, Failure> {
    let states = states_of(of);
    let pairs = states.iter().enumerate().flat_map(|(k, one)| {
        let others = states[k + 1..].iter();
        others.map(move |other| (one, other))
    });
    let pairs: Vec<_> = pairs.collect();
    let dynamics = of.system.dynamics();
    let how = EdgeSettings::within(of.settings.longest);
    let row = |((one, from), (other, to)): (&(usize, Vector), &(usize, Vector))| {
        let state = edge_state(dynamics, from, to, &how, &of.settings, &of.options)?;
        let beyond = of.numbered(&state.beside[1]);
        Ok(EdgeRow {
            between: [*one, *other],
            state,
            beyond,
        })
    };
    let rows: Result<Vec<EdgeRow>, stickslip::Error> = pairs.into_par_iter().map(row).collect();
    let rows = rows.map_err(|error| Failure::from(error).of(of.system))?;
    for row in &rows {
        let [one, other] = row.between;
        let beyond = match row.beyond.0 {
            Some(number) if number == other => String::new(),
            _ => format!(" (towards {other}, {} comes first)", name_of(row.beyond)),
        };
        let words = match (row.state.kind, row.period()) {
            (EdgeKind::Undecided, _) => "not found in the time of --until".to_owned(),
            (_, period) => format!(
                "{}{} through {}, with unstable directions: {}",
                row.motion(),
                period.map_or(String::new(), |period| format!(
                    ", period {}",
                    readable(period)
                )),
                state_words(row.state.x.as_slice()),
                row.state.unstable
            ),
        };
        report.note(format!(
            "edge of attractor {one} towards {other}{beyond}: {words}"
        ));
    }
    let json = rows.iter().map(|row| {
        json!({
            "between": row.between,
            "beyond": row.beyond.0,
            "beyond_motion": row.beyond.1,
            "motion": row.motion(),
            "period": row.period(),
            "unstable": row.state.unstable,
            "x": by_state(of.system, row.state.x.as_slice()),
            "bisections": row.state.bisections,
        })
    });
    report.field("edges", json.collect::<Value>());
    let table = Table::new()
        .column("attractor", |row: &&EdgeRow| row.between[0])
        .column("towards", |row| row.between[1])
        .column("beyond", |row| row.beyond.0)
        .column("beyond_motion", |row| row.beyond.1)
        .column("motion", |row| row.motion())
        .column("period", |row| row.period())
        .column("unstable", |row| row.state.unstable)
        .column("bisections", |row| row.state.bisections)
        .state(of.system, "", |row| row.state.x.clone());
    report.table(table.csv("edges", &rows)?);
    type Tracked<'r> = (&'r EdgeRow, &'r Moment);
    let table = Table::new()
        .column("attractor", |row: &Tracked<'_>| row.0.between[0])
        .column("towards", |row| row.0.between[1])
        .column("t", |row| row.1.t)
        .state(of.system, "", |row| row.1.x.clone());
    let tracked = rows
        .iter()
        .flat_map(|row| row.state.track.iter().map(move |at| (row, at)));
    report.table(table.csv("tracks", tracked)?);
    let place = |x: &Vector| {
        let [first, second] = of.plane.map(|range| x[range.state]);
        (first, second)
    };
    let is_inside = |&(x, y): &(f64, f64)| {
        let [first, second] = of.plane;
        (first.low..=first.high).contains(&x) && (second.low..=second.high).contains(&y)
    };
    let shown = rows.iter().map(|row| EdgeShown {
        track: row.state.track.iter().map(|at| place(&at.x)).collect(),
        state: Some(place(&row.state.x)).filter(is_inside),
    });
    Ok(shown.collect())
}

/// Times to return of the starts of one attractor.
#[derive(Clone, Debug, Default)]
pub(super) struct Returns {
    /// Number of starts with a time.
    starts: usize,
    mean: f64,
    /// Sum of the squares of the distances from the mean.
    squares: f64,
    largest: f64,
    /// The start with the largest time.
    slowest: Vec<f64>,
}

impl Returns {
    pub(super) fn add(&mut self, start: &[f64], time: f64) {
        self.starts += 1;
        // Welford's update: no difference of large sums.
        let off = time - self.mean;
        self.mean += off / self.starts as f64;
        self.squares += off * (time - self.mean);
        if time > self.largest || self.starts == 1 {
            self.largest = time;
            self.slowest = start.to_vec();
        }
    }

    pub(super) fn mean(&self) -> Option<f64> {
        (self.starts > 0).then_some(self.mean)
    }

    /// Standard error of the mean, as of random starts.
    pub(super) fn std_error(&self) -> Option<f64> {
        let n = self.starts as f64;
        (self.starts > 1).then(|| (self.squares / (n - 1.0) / n).sqrt())
    }

    pub(super) fn largest(&self) -> Option<f64> {
        (self.starts > 0).then_some(self.largest)
    }

    /// Time to return in words.
    pub(super) fn words(&self, distance: f64) -> Option<String> {
        Some(format!(
            "returns within {} after {} on average, {} at most, from {}",
            readable(distance),
            within(self.mean()?, self.std_error().unwrap_or(f64::INFINITY)),
            readable(self.largest),
            state_words(&self.slowest)
        ))
    }

    pub(super) fn json(&self, distance: f64) -> Value {
        json!({
            "within": distance,
            "starts": self.starts,
            "mean": self.mean(),
            "std_error": self.std_error(),
            "largest": self.largest(),
            "slowest": self.slowest,
        })
    }
}
