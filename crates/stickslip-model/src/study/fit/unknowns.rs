//! Sought numbers: parameters, start values and times of the start, by record.

use stickslip::dynamics::Vector;
use stickslip::error::readable;

use super::{FitError, FitRequest, Record, Unknown};
use crate::expression::normal;
use crate::file::{Meaning, System};
use crate::study::Variables;

/// Minima closer than this part of the bounds are one.
const SAME_MINIMUM: f64 = 1e-3;

/// Kind of an unknown in a record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    Parameter(usize),
    State(usize),
    StartTime,
}

/// Numbers that are sought in one record, each with its index among all unknowns.
pub(super) type Local = Vec<(Kind, usize)>;

/// A number that is sought.
#[derive(Clone)]
pub(super) struct Sought {
    /// Empty for the start of a part.
    pub(super) name: String,
    pub(super) start: f64,
    pub(super) bounds: (f64, f64),
}

/// All numbers that are sought.
#[derive(Clone, Default)]
pub(super) struct Unknowns(pub(super) Vec<Sought>);

impl Unknowns {
    /// The unknowns of a request, and for each record what of it is there.
    pub(super) fn of(
        request: &FitRequest,
        systems: &[System],
    ) -> Result<(Self, Vec<Local>), FitError> {
        let mut unknowns = Unknowns::default();
        let mut locals = vec![Vec::new(); systems.len()];
        let Some(first) = systems.first() else {
            return Err(FitError::NoData);
        };
        let names = request.unknowns.iter().map(|one| &*one.name);
        // Names the first that is wrong.
        Variables::named(first, names)?;
        for unknown in &request.unknowns {
            let (low, high) = unknown.bounds;
            if low.is_nan() || high.is_nan() || low >= high {
                return Err(FitError::Request(format!(
                    "the bounds of `{}` from {} to {} contain nothing: the lower one comes first",
                    unknown.name,
                    readable(low),
                    readable(high)
                )));
            }
            let name = normal(&unknown.name);
            let kind = match first.file.names.get(&name) {
                Some(Meaning::Parameter(number)) => Kind::Parameter(number),
                Some(Meaning::State(state)) => Kind::State(state),
                _ => Kind::StartTime,
            };
            let is_local = unknown.each || !matches!(kind, Kind::Parameter(_));
            if !is_local {
                check_shared(request, &name)?;
            }
            let several = systems.len() > 1;
            for (k, (system, record)) in systems.iter().zip(&request.records).enumerate() {
                if k > 0 && !is_local {
                    if let Some(&shared) = locals.first().and_then(|local: &Local| local.last()) {
                        locals[k].push(shared);
                    }
                    continue;
                }
                locals[k].push((kind, unknowns.0.len()));
                let (start, bounds) = begun(unknown, kind, (system, record))?;
                unknowns.0.push(Sought {
                    name: match is_local && several {
                        true => format!("{name}@{}", k + 1),
                        false => name.clone(),
                    },
                    start,
                    bounds,
                });
            }
        }
        Ok((unknowns, locals))
    }

    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    /// Number of those that are results: all but the starts of parts, which come last.
    pub(super) fn named(&self) -> usize {
        self.0.iter().filter(|one| !one.name.is_empty()).count()
    }

    pub(super) fn start(&self) -> Vector {
        Vector::from_iterator(self.len(), self.0.iter().map(|one| one.start))
    }

    pub(super) fn bounds(&self) -> Vec<(f64, f64)> {
        self.0.iter().map(|one| one.bounds).collect()
    }

    pub(super) fn name(&self, number: usize) -> &str {
        self.0.get(number).map_or("", |one| &one.name)
    }

    /// Whether two minima are one.
    pub(super) fn is_same(&self, one: &Vector, other: &Vector) -> bool {
        let mut pairs = one.iter().zip(other).zip(&self.0);
        pairs.all(|((a, b), sought)| {
            let width = sought.bounds.1 - sought.bounds.0;
            let scale = if width.is_finite() {
                width
            } else {
                a.abs().max(1.0)
            };
            (a - b).abs() <= SAME_MINIMUM * scale
        })
    }
}

/// Refuses a value that one record sets and that is fitted for all.
fn check_shared(request: &FitRequest, name: &str) -> Result<(), FitError> {
    let setting = request.records.iter().find_map(|record| {
        let mut own = record.set.iter();
        let (_, value) = own.find(|(own, _)| normal(own) == name)?;
        Some((record, *value))
    });
    match setting {
        Some((record, value)) => Err(FitError::Request(format!(
            "{}: `{name}` is set to {} in this record and fitted for all: fit it in each record \
             (each), or set it in none",
            record.name,
            readable(value)
        ))),
        None => Ok(()),
    }
}

/// The value with which an unknown begins in a record, and its bounds there.
fn begun(
    unknown: &Unknown,
    kind: Kind,
    (system, record): (&System, &Record),
) -> Result<(f64, (f64, f64)), FitError> {
    let name = normal(&unknown.name);
    let (low, high) = unknown.bounds;
    let (start, (low, high)) = match kind {
        Kind::Parameter(number) => {
            let entry = system.file.parameters.get(number);
            let range = entry.and_then(|entry| entry.range);
            let (from, to) = range.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
            let value = system.values.get(number).copied();
            (value, (low.max(from), high.min(to)))
        }
        Kind::State(state) => {
            let mut starts = record.start.iter();
            let given = starts.find(|(own, _)| normal(own) == name);
            let of_file = system.built.starts.get(state).copied().flatten();
            (given.map(|(_, value)| *value).or(of_file), (low, high))
        }
        Kind::StartTime => {
            let start = record.t_start.unwrap_or(system.built.t_start);
            // The run cannot begin after the first value.
            let first = record.times.first().copied().unwrap_or(f64::INFINITY);
            (Some(start), (low, high.min(first)))
        }
    };
    let start = unknown.start.or(start).ok_or_else(|| {
        FitError::Request(format!(
            "the start has no value of `{name}`: give one to begin with"
        ))
    })?;
    if !(low..=high).contains(&start) {
        return Err(FitError::Request(format!(
            "`{name}` begins with {}, outside its bounds from {} to {}: begin within them, or \
             widen them",
            readable(start),
            readable(low),
            readable(high)
        )));
    }
    // Both zeros are one bound.
    Ok((start, (low + 0.0, high + 0.0)))
}
