//! Attractors: along a parameter, over a plane of two, and from many starts.

use std::ops::ControlFlow;

use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use rayon::prelude::*;
use stickslip::Options;
use stickslip::analysis::{
    Attractor, AttractorChange, AttractorKind, Basin, Exponent, RecurrenceSettings, WhatChanges,
};
use stickslip::dynamics::Vector;
use stickslip_model::file::System as CompiledSystem;
use stickslip_model::study::{AtValue, Diagram, Locates, largest, recurrence, reported, shares};

use crate::errors::{Failure, failed, no_period, words, wrong};
use crate::fields::{Fields, array};
use crate::task::{ProgressKind, Report, Task, computed};
use crate::{Settings, System};

/// Start state of the orbit: as given, or that of the system.
fn start_state(system: &CompiledSystem, given: Option<&[f64]>) -> Result<Vec<f64>, Failure> {
    let start = given.map(<[f64]>::to_vec);
    let start = start.or_else(|| system.start());
    start.ok_or_else(|| wrong("the system has no start: give y0").into())
}

/// Checks whether attractors can be searched.
pub(super) fn check(system: &CompiledSystem, longest: f64) -> PyResult<()> {
    system.checked_period().map_err(no_period)?;
    let settings = recurrence(system, longest);
    settings
        .check()
        .map_err(|error| failed(&error, Some(system)))
}

/// The motion that an orbit reaches.
struct ReachedMotion {
    kind: AttractorKind,
    phases: String,
    /// NaN if there is no attractor.
    in_stick: f64,
    /// Reason for which its exponent could not be measured.
    unmeasured: Option<String>,
}

impl ReachedMotion {
    fn of(reached: &Attractor, system: &CompiledSystem) -> Self {
        ReachedMotion {
            kind: reached.kind.clone(),
            phases: system.phases(reached),
            in_stick: match reached.kind.is_attractor() {
                true => reached.in_stick,
                false => f64::NAN,
            },
            unmeasured: None,
        }
    }

    /// Error of the run or of the measurement of its exponent, in words, if one failed.
    fn reason(&self) -> String {
        match (&self.kind, &self.unmeasured) {
            (AttractorKind::Failure(reason), _) => reason.to_string(),
            (_, Some(reason)) => format!("no exponent: {reason}"),
            _ => String::new(),
        }
    }
}

/// Adds motions, with the reason of each failure. Where an interruption left one out, the texts are
/// empty.
fn motions(fields: &Fields<'_>, found: &[Option<ReachedMotion>]) -> PyResult<()> {
    let all = || found.iter().map(Option::as_ref);
    fields.texts(
        "kind",
        all().map(|one| one.map_or("", |one| one.kind.word())),
    )?;
    fields.texts("phases", all().map(|one| one.map_or("", |one| &one.phases)))?;
    fields.texts(
        "reason",
        all().map(|one| one.map(ReachedMotion::reason).unwrap_or_default()),
    )?;
    let cycles = all().map(|one| match one?.kind {
        AttractorKind::Periodic { period, returns } => Some((period, returns)),
        _ => None,
    });
    fields.optional_numbers("period", cycles.clone().map(|one| Some(one?.0)))?;
    fields.integers(
        "returns",
        cycles.map(|one| one.map_or(0, |one| one.1 as i64)),
    )?;
    fields.optional_numbers("in_stick", all().map(|one| Some(one?.in_stick)))
}

/// Adds what orbits have reached, with the points of their attractors.
pub(super) fn outcomes<'a>(
    fields: &Fields<'_>,
    system: &CompiledSystem,
    found: impl Iterator<Item = &'a Attractor> + Clone,
) -> PyResult<()> {
    outcomes_measured(fields, system, found.map(|one| (one, None)))
}

/// [`outcomes`] of which exponents were measured, each with the reason where that failed.
fn outcomes_measured<'a>(
    fields: &Fields<'_>,
    system: &CompiledSystem,
    found: impl Iterator<Item = (&'a Attractor, Option<String>)> + Clone,
) -> PyResult<()> {
    let reached = found.clone().map(|(one, unmeasured)| {
        Some(ReachedMotion {
            unmeasured,
            ..ReachedMotion::of(one, system)
        })
    });
    motions(fields, &reached.collect::<Vec<_>>())?;
    let points = PyList::empty(fields.py());
    for (one, _) in found {
        let flat = one.points.iter().flat_map(|at| at.x.iter().copied());
        points.append(array(fields.py(), flat.collect(), [system.states()])?)?;
    }
    fields.put("points", points)
}

/// Adds largest exponents with their standard errors and uncertainties, NaN where there are none.
fn exponents(
    fields: &Fields<'_>,
    duration: Option<f64>,
    exponents: impl Iterator<Item = Option<Exponent>>,
) -> PyResult<()> {
    let duration = duration.unwrap_or(f64::NAN);
    let numbers: Vec<_> = exponents
        .map(|one| largest::numbers(one, duration))
        .collect();
    for (k, name) in ["exponent", "std_error", "uncertainty"]
        .into_iter()
        .enumerate()
    {
        fields.optional_numbers(name, numbers.iter().map(|one| one[k]))?;
    }
    Ok(())
}

/// The attractor at each of some values of a parameter, followed from one to the next.
#[pyfunction]
pub(crate) fn bifurcation_diagram<'py>(
    py: Python<'py>,
    system: &System,
    x: Option<Vec<f64>>,
    along: (String, Vec<f64>),
    how: (f64, Option<f64>, String),
    settings: Settings,
    report: Report,
) -> PyResult<Bound<'py, PyDict>> {
    let (parameter, values) = along;
    let (longest, duration, which) = how;
    let locates = Locates::named(&which).unwrap_or_default();
    let compiled = &system.compiled;
    let options = settings.options(compiled)?;
    check(compiled, longest)?;
    let outcome = computed(py, 0, (&report, ProgressKind::Count), |task| {
        let (mut found, mut changes) = (Vec::new(), Vec::new());
        let follow = || -> Result<(), Failure> {
            let system = task.system(compiled)?;
            let diagram = Diagram {
                system: &system,
                parameter: &parameter,
                until: longest,
                duration,
                locates,
                values: values.len() as u64,
                options: &options,
            };
            for value in values {
                let start = |here: &CompiledSystem| start_state(here, x.as_deref());
                let (at, between) = diagram.at(value, found.last(), start, &words)?;
                if task.is_stopped() {
                    break;
                }
                found.push(at);
                changes.extend(between);
                task.count();
            }
            Ok(())
        };
        let ended = follow();
        ((found, changes), ended)
    })?;
    let ((found, changes), raised) = outcome.partial(|error: Failure| error.raised(compiled))?;
    let fields = Fields::new(py);
    fields.numbers("parameter", found.iter().map(|at| at.value))?;
    exponents(&fields, duration, found.iter().map(|at| at.largest))?;
    let measured = found.iter().map(|at| (&at.reached, at.unmeasured.clone()));
    outcomes_measured(&fields, compiled, measured)?;
    let changes = AttractorChange::merged(changes);
    fields.fields("changes", located(py, compiled, &changes)?)?;
    fields.fields("sticks", sticks(py, compiled, &found)?)?;
    fields.ended(raised)
}

/// The sticks of the periodic orbits as a table: how long they are, in time and in each state.
fn sticks<'py>(
    py: Python<'py>,
    system: &CompiledSystem,
    found: &[AtValue],
) -> PyResult<Fields<'py>> {
    let all = || {
        let each = found.iter();
        each.flat_map(|at| at.sticks().map(move |phase| (at.value, phase)))
    };
    let table = Fields::new(py);
    table.numbers("parameter", all().map(|(value, _)| value))?;
    table.numbers("duration", all().map(|(_, phase)| phase.duration()))?;
    let lengths: Vec<Vector> = all().map(|(_, phase)| phase.displacement()).collect();
    table.rows("length", &lengths, system.states())?;
    Ok(table)
}

/// Changes of an attractor as a table.
fn located<'py>(
    py: Python<'py>,
    system: &CompiledSystem,
    changes: &[AttractorChange],
) -> PyResult<Fields<'py>> {
    let all = || changes.iter().map(|at| &at.what);
    let table = Fields::new(py);
    table.texts("name", all().map(ToString::to_string))?;
    table.optional_numbers("parameter", all().map(WhatChanges::parameter))?;
    table.optional_numbers("uncertainty", all().map(WhatChanges::uncertainty))?;
    let contacts = |change: &WhatChanges| match change {
        WhatChanges::Sequence(change) => system.contact_names(&change.contacts),
        _ => String::new(),
    };
    table.texts("contacts", all().map(contacts))?;
    table.numbers("from_value", changes.iter().map(|at| at.between.0))?;
    table.numbers("to_value", changes.iter().map(|at| at.between.1))?;
    table.optional_numbers("period", all().map(WhatChanges::period))?;
    let side = |change: &WhatChanges| {
        change
            .criticality()
            .map_or(String::new(), |of| of.to_string())
    };
    table.texts("criticality", all().map(side))?;
    let phases = |change: &WhatChanges| match change {
        WhatChanges::Sequence(change) => (
            system.sequence(&change.before),
            system.sequence(&change.after),
        ),
        _ => (String::new(), String::new()),
    };
    table.texts("before", all().map(|change| phases(change).0))?;
    table.texts("after", all().map(|change| phases(change).1))?;
    let states = system.states();
    let nowhere = Vector::from_element(states, f64::NAN);
    table.rows(
        "y",
        all().map(|change| change.state().unwrap_or(&nowhere)),
        states,
    )?;
    Ok(table)
}

/// The attractor of the orbit from a start, over a plane of two parameters, row by row. Cells that
/// an interruption left out have the motion "".
#[pyfunction]
pub(crate) fn parameter_map<'py>(
    py: Python<'py>,
    system: &System,
    x: Option<Vec<f64>>,
    plane: [(String, Vec<f64>); 2],
    how: (f64, Option<f64>, usize),
    settings: Settings,
    report: Report,
) -> PyResult<Bound<'py, PyDict>> {
    let (longest, duration, workers) = how;
    let compiled = &system.compiled;
    let options = settings.options(compiled)?;
    check(compiled, longest)?;
    let [(name, columns), (other, rows)] = &plane;
    // The memory for a cell must not grow with the number of its points.
    type Cell = Option<(ReachedMotion, Option<Exponent>)>;
    let cell = |system: &CompiledSystem, task: &Task, index: usize| -> Result<Cell, Failure> {
        if task.is_stopped() {
            return Ok(None);
        }
        let (column, row) = (columns[index % columns.len()], rows[index / columns.len()]);
        let here = system.driven_with(&[(name, column), (other, row)])?;
        let start = start_state(&here, x.as_deref())?;
        let recurrence = recurrence(&here, longest);
        let reached = Attractor::of_any(here.dynamics(), &*start, &recurrence, &options)?;
        let reached = reached.by_shooting(here.dynamics(), &recurrence, &options);
        let reached = reported(reached, |error| words(error, &here));
        let measured = duration.map(|time| largest::on(&here, &reached, time, &options));
        let measured = measured.unwrap_or(Ok(None));
        if task.is_stopped() {
            return Ok(None);
        }
        task.count();
        let motion = ReachedMotion {
            unmeasured: measured.as_ref().err().map(|error| words(error, &here)),
            ..ReachedMotion::of(&reached, system)
        };
        Ok(Some((motion, measured.unwrap_or(None))))
    };
    let outcome = computed(py, workers, (&report, ProgressKind::Count), |task| {
        let system = task.system(compiled)?;
        let cells = (0..columns.len() * rows.len()).into_par_iter();
        let cells = cells
            .with_max_len(1)
            .map(|index| cell(&system, task, index));
        cells.collect::<Result<Vec<Cell>, Failure>>()
    })?;
    let (cells, raised) = outcome.kept(|error| error.raised(compiled))?;
    let (reached, largest): (Vec<_>, Vec<_>) = cells.into_iter().map(Option::unzip).unzip();
    let fields = Fields::new(py);
    motions(&fields, &reached)?;
    exponents(&fields, duration, largest.into_iter().map(Option::flatten))?;
    fields.ended(raised)
}

/// Standard error of the share of an attractor among the starts of a grid with so many columns, or
/// among random ones.
#[pyfunction]
pub(crate) fn share_error(reached: Vec<u32>, columns: Option<usize>, number: u32) -> f64 {
    match columns {
        Some(columns) => shares::error_of_grid(&reached, columns, number),
        None => shares::error_of_random(&reached, number),
    }
}

/// The time in which the orbit from a start returns to its attractor; `None` also where an
/// interruption ends it.
fn returned(
    system: &CompiledSystem,
    start: &Vector,
    distance: f64,
    settings: &RecurrenceSettings,
    options: &Options,
) -> Result<Option<f64>, stickslip::Error> {
    let dynamics = system.dynamics();
    let reached = Attractor::of_any(dynamics, start, settings, options)?;
    match reached.return_time(dynamics, start, distance, settings, options) {
        Err(stickslip::Error::Interrupted { .. }) => Ok(None),
        time => time,
    }
}

/// Index of the attractor of each start; -1 for starts that an interruption left out.
#[pyfunction]
pub(crate) fn basins<'py>(
    py: Python<'py>,
    system: &System,
    starts: PyReadonlyArray2<'py, f64>,
    how: (f64, Option<f64>, usize),
    settings: Settings,
    report: Report,
) -> PyResult<Bound<'py, PyDict>> {
    let (longest, return_within, workers) = how;
    let compiled = &system.compiled;
    let options = settings.options(compiled)?;
    check(compiled, longest)?;
    let settings = recurrence(compiled, longest);
    let starts = starts.as_array();
    let states = starts.ncols();
    let starts: Vec<Vector> = starts
        .rows()
        .into_iter()
        .map(|row| Vector::from_iterator(states, row.iter().copied()))
        .collect();
    let outcome = computed(py, workers, (&report, ProgressKind::Count), |task| {
        let system = task.system(compiled)?;
        let go_on = || match task.is_stopped() {
            true => ControlFlow::Break(()),
            false => {
                task.count();
                ControlFlow::Continue(())
            }
        };
        let found = Basin::found_while(
            system.dynamics(),
            starts.clone(),
            &settings,
            &options,
            go_on,
        )?;
        let time = |(start, number): (&Vector, &Option<usize>)| match (return_within, number) {
            (Some(distance), Some(_)) if !task.is_stopped() => {
                returned(&system, start, distance, &settings, &options)
            }
            _ => Ok(None),
        };
        let each = starts.par_iter().zip(&found.1);
        let times = each
            .map(time)
            .collect::<Result<Vec<_>, stickslip::Error>>()?;
        Ok((found, times))
    })?;
    let (found, raised) = outcome.kept(|error: Failure| error.raised(compiled))?;
    let ((attractors, reached), times) = found;
    let attractors = attractors.into_iter();
    let attractors = attractors.map(|one| reported(one, |error| words(error, compiled)));
    let attractors: Vec<_> = attractors.collect();
    let fields = Fields::new(py);
    outcomes(&fields, compiled, attractors.iter())?;
    let reached = reached.iter().map(|one| one.map_or(-1, |one| one as i64));
    fields.integers("reached", reached)?;
    if return_within.is_some() {
        fields.optional_numbers("return_time", times)?;
    }
    fields.ended(raised)
}
