//! Records in parts with starts of their own, which have to meet: multiple shooting.

use crate::study::least_squares::Residuals;
use stickslip::dynamics::{Matrix, Vector};

use super::problem::{FitProblem, Sequence};
use super::record_run::{Failed, RecordAt, RecordRun};
use super::statistics::spread;
use super::unknowns::{Kind, Sought};
use super::{FitError, Record};

/// Most states along the first run from which a part may begin.
const CANDIDATES: usize = 40;

/// Rows with a value that each part has at least.
const LEAST_ROWS: usize = 2;

/// The start of a part of a record that is not its first.
#[derive(Clone)]
pub(super) struct PartStart {
    /// Number of the part. The one before it ends where it begins.
    pub(super) part: usize,
    /// First unknown of its start.
    pub(super) first: usize,
    /// States from which it may begin.
    pub(super) candidates: Vec<Vector>,
}

/// Starts of the parts, and the spread of each state.
#[derive(Default)]
pub(super) struct Parts {
    pub(super) nodes: Vec<PartStart>,
    spreads: Vec<f64>,
}

impl Parts {
    /// Number of residuals that are mismatches.
    pub(super) fn mismatches(&self) -> usize {
        self.nodes.len() * self.spreads.len()
    }

    /// Whether a part continues the one before it.
    pub(super) fn continues(&self, part: usize) -> bool {
        self.nodes.iter().any(|node| node.part == part)
    }

    /// Joins what parts have to what records have.
    pub(super) fn joined<T>(&self, of: Vec<T>, extend: impl Fn(&mut T, T)) -> Vec<T> {
        let mut whole: Vec<T> = Vec::new();
        for (part, own) in of.into_iter().enumerate() {
            match whole.last_mut().filter(|_| self.continues(part)) {
                Some(known) => extend(known, own),
                None => whole.push(own),
            }
        }
        whole
    }

    /// Adds the mismatches over the spreads at a point, and their derivatives by all unknowns.
    pub(super) fn add_rows(
        &self,
        (records, runs): (&[RecordRun], &[RecordAt]),
        x: &Vector,
        (residuals, slopes): (&mut Vec<f64>, &mut Vec<f64>),
    ) {
        let pairs = records.iter().zip(runs);
        let pairs: Vec<(&RecordRun, &RecordAt)> = pairs.collect();
        for node in &self.nodes {
            let Some((record, run)) = node.part.checked_sub(1).and_then(|k| pairs.get(k)) else {
                continue;
            };
            let (end, by_local) = &run.end;
            for (state, scale) in self.spreads.iter().enumerate() {
                let (weight, own) = (scale.recip(), node.first + state);
                residuals.push(weight * (end[state] - x[own]));
                let mut row = vec![0.0; x.len()];
                for (column, &(_, place)) in record.local.iter().enumerate() {
                    row[place] = weight * by_local[(state, column)];
                }
                row[own] -= weight;
                slopes.extend(row);
            }
        }
    }
}

impl<'r> FitProblem<'r> {
    /// The problem of records in parts, each of which begins at a state of its own, and the point
    /// that has the present orbit.
    ///
    /// # Errors
    /// [`FitError::Request`] for a record with too few rows, and those of the present run.
    pub(super) fn in_parts(
        &self,
        x: &Vector,
        segments: usize,
    ) -> Result<(FitProblem<'r>, Vector), FitError> {
        let mut whole: Vec<f64> = x.iter().copied().collect();
        let mut orbits = Vec::new();
        for (number, run) in self.records.iter().enumerate() {
            let at = run.at(number, x, (self.unknowns.len(), false));
            orbits.push(at.map_err(|error| self.failed(error))?.points);
        }
        let states = self.records.first().map_or(0, |run| run.system.states());
        let of = |state: usize| spread(orbits.iter().flatten().map(|point| point[state]));
        let mut parts = Parts {
            spreads: (0..states).map(of).collect(),
            ..Parts::default()
        };
        let (mut unknowns, mut runs) = (self.unknowns.clone(), Vec::new());
        let records = self.request.records.iter().zip(&self.records);
        for ((record, base), points) in records.zip(&orbits) {
            let every = points.len().div_ceil(CANDIDATES).max(1);
            let mut from: usize = 0;
            for to in cuts(record, segments)? {
                let mut local = base.local.clone();
                let before = from.checked_sub(1).and_then(|row| points.get(row));
                if let Some(begin) = before {
                    local.retain(|(kind, _)| matches!(kind, Kind::Parameter(_)));
                    let first = unknowns.len();
                    for (state, start) in begin.iter().enumerate() {
                        local.push((Kind::State(state), first + state));
                        whole.push(*start);
                        unknowns.0.push(Sought {
                            name: String::new(),
                            start: *start,
                            bounds: (f64::NEG_INFINITY, f64::INFINITY),
                        });
                    }
                    let others = points.iter().step_by(every);
                    parts.nodes.push(PartStart {
                        part: runs.len(),
                        first,
                        candidates: std::iter::once(begin).chain(others).cloned().collect(),
                    });
                }
                let part = part_of(record, from..to);
                let system = self.system(&part)?;
                runs.push(RecordRun::new(self.request, system, &part, local)?);
                from = to;
            }
        }
        let problem = FitProblem {
            request: self.request,
            base: self.base.clone(),
            unknowns,
            records: runs,
            parts: Some(parts),
            sigmas: self.sigmas.clone(),
        };
        Ok((problem, Vector::from_vec(whole)))
    }

    /// Residuals of one part alone, by the unknowns of its start.
    pub(super) fn of_part(
        &self,
        node: &PartStart,
        x: &Vector,
    ) -> Result<Residuals<Sequence>, Failed> {
        let record = &self.records[node.part];
        let run = record.at(node.part, x, (self.unknowns.len(), false))?;
        let (mut residuals, mut slopes) = (Vec::new(), Vec::new());
        self.add_rows(record, &run, &mut residuals, &mut slopes);
        let all = Matrix::from_row_slice(residuals.len(), self.unknowns.len(), &slopes);
        let states = record.system.states();
        Ok(Residuals {
            values: Vector::from_vec(residuals),
            jacobian: all.columns(node.first, states).into_owned(),
            piece: vec![run.phases.iter().map(|phase| phase.2).collect()],
            constraints: 0,
        })
    }

    /// Number of residuals that are mismatches of parts.
    pub(super) fn mismatches(&self) -> usize {
        self.parts.as_ref().map_or(0, Parts::mismatches)
    }

    /// The largest mismatch of parts among residuals, over the spread of the state; none without
    /// parts.
    pub(super) fn largest_mismatch(&self, residuals: &Vector) -> Option<f64> {
        let parts = self.parts.as_ref()?;
        let from = residuals.len().saturating_sub(parts.mismatches());
        Some(residuals.rows_range(from..).amax())
    }
}

/// Ends of so many parts of a record, as rows. Each part has its share of the rows with a value.
fn cuts(record: &Record, segments: usize) -> Result<Vec<usize>, FitError> {
    let has_value = |row: &usize| record.columns.iter().any(|column| !column[*row].is_nan());
    let rows: Vec<usize> = (0..record.times.len()).filter(has_value).collect();
    let most = rows.len() / LEAST_ROWS;
    if segments > most {
        return Err(FitError::Request(format!(
            "{}: {segments} segments need {LEAST_ROWS} rows with a value each, and there are {}: \
             take at most {most} segments",
            record.name,
            rows.len()
        )));
    }
    let end = |segment: usize| match segment == segments {
        true => record.times.len(),
        false => rows[segment * rows.len() / segments],
    };
    Ok((1..=segments).map(end).collect())
}

/// Rows of a record as a record that begins where the row before them is.
fn part_of(record: &Record, rows: std::ops::Range<usize>) -> Record {
    let before = rows.start.checked_sub(1).map(|row| record.times[row]);
    Record {
        name: record.name.clone(),
        times: record.times[rows.clone()].to_vec(),
        columns: {
            let columns = record.columns.iter();
            columns
                .map(|column| column[rows.clone()].to_vec())
                .collect()
        },
        set: record.set.clone(),
        start: match before {
            None => record.start.clone(),
            Some(_) => Vec::new(),
        },
        t_start: before.or(record.t_start),
        inputs: record.inputs.clone(),
    }
}
