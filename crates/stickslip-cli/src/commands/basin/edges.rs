//! Edge states between basins.

use plot::{Curve, Markers, Panel, Shape};
use rayon::prelude::*;
use serde_json::{Value, json};
use stickslip::analysis::{EdgeKind, EdgeSettings, EdgeState};
use stickslip::dynamics::{Moment, Vector};
use stickslip::error::readable;

use super::measures::{Measured, name_of, states_of};
use crate::failure::Failure;
use crate::render::{Report, Table, by_state, state_words};

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

/// Computes an edge state of each pair of attractors, and reports them. Returns what the figure
/// shows.
pub(super) fn edges(of: &Measured<'_>, report: &mut Report) -> Result<Vec<EdgeShown>, Failure> {
    let states = states_of(of)?;
    let pairs = states.iter().enumerate().flat_map(|(k, one)| {
        let others = states[k + 1..].iter();
        others.map(move |other| (one, other))
    });
    let pairs: Vec<_> = pairs.collect();
    let dynamics = of.system.dynamics();
    let how = EdgeSettings::within(of.settings.longest);
    let row = |((one, from), (other, to)): (&(usize, Vector), &(usize, Vector))| {
        let state = EdgeState::between(dynamics, from, to, &how, &of.settings, &of.options)?;
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
