//! Attractors: along a parameter, over a plane of two, and from many starts.

use std::ops::ControlFlow;

use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use rayon::prelude::*;
use stickslip::Error;
use stickslip::analysis::{attractor_of_many, basin_while};
use stickslip::dynamics::Vector;
use stickslip_kernels::file::System as CompiledSystem;
use stickslip_kernels::kernel::{Change, Motion, Outcome};
use stickslip_kernels::study::{ChangeBetween, Diagram, Largest, recurrence};

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
fn check(system: &CompiledSystem, longest: f64) -> PyResult<()> {
    system.checked_period().map_err(no_period)?;
    let settings = recurrence(system, longest);
    settings
        .check()
        .map_err(|error| failed(&error, Some(system)))
}

/// The motion that an orbit reaches.
struct ReachedMotion {
    motion: Motion,
    phases: String,
    in_stick: f64,
}

impl ReachedMotion {
    fn of(outcome: &Outcome, system: &CompiledSystem) -> Self {
        ReachedMotion {
            motion: outcome.motion.clone(),
            phases: system.phases(outcome),
            in_stick: match outcome.points.is_empty() {
                true => f64::NAN,
                false => outcome.in_stick,
            },
        }
    }
}

impl ReachedMotion {
    /// Why the run failed, if it did.
    fn reason(&self) -> &str {
        match &self.motion {
            Motion::Failure(reason) => reason,
            _ => "",
        }
    }
}

/// Adds motions, with the reason of each failure. Where an interruption left one out, the texts are
/// empty.
fn motions(fields: &Fields<'_>, found: &[Option<ReachedMotion>]) -> PyResult<()> {
    let text = |of: fn(&ReachedMotion) -> &str| {
        let texts = found.iter().map(|one| one.as_ref().map_or("", of));
        texts.collect::<Vec<_>>()
    };
    fields.texts("kind", text(|one| one.motion.word()))?;
    fields.texts("phases", text(|one| &one.phases))?;
    fields.texts("reason", text(ReachedMotion::reason))?;
    let cycles = found.iter().map(|one| match one.as_ref()?.motion {
        Motion::Periodic { period, returns } => Some((period, returns)),
        _ => None,
    });
    fields.optional_numbers("period", cycles.clone().map(|one| Some(one?.0)))?;
    fields.integers(
        "returns",
        cycles.map(|one| one.map_or(0, |one| one.1 as i64)),
    )?;
    let in_stick = found.iter().map(|one| Some(one.as_ref()?.in_stick));
    fields.optional_numbers("in_stick", in_stick)
}

/// Adds outcomes of orbits, with the points of their attractors.
fn outcomes(fields: &Fields<'_>, system: &CompiledSystem, found: &[Outcome]) -> PyResult<()> {
    let reached = found.iter().map(|one| Some(ReachedMotion::of(one, system)));
    motions(fields, &reached.collect::<Vec<_>>())?;
    let points = PyList::empty(fields.py());
    for one in found {
        let flat: Vec<f64> = one.points.iter().flat_map(|(_, x)| x.clone()).collect();
        points.append(array(fields.py(), flat, [system.states()])?)?;
    }
    fields.put("points", points)
}

/// Adds largest exponents with their standard errors and uncertainties, NaN where there are none.
fn exponents(
    fields: &Fields<'_>,
    duration: Option<f64>,
    exponents: impl Iterator<Item = Largest>,
) -> PyResult<()> {
    let numbers = exponents.map(|one| one.numbers(duration.unwrap_or(f64::NAN)));
    let numbers: Vec<_> = numbers.collect();
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
    how: (f64, Option<f64>, bool),
    settings: Settings,
    report: Report,
) -> PyResult<Bound<'py, PyDict>> {
    let (parameter, values) = along;
    let (longest, duration, locates) = how;
    let (compiled, options) = (&system.compiled, settings.options()?);
    check(compiled, longest)?;
    let outcome = computed(py, 0, (&report, ProgressKind::Count), |task| {
        let (mut found, mut changes, mut last) = (Vec::new(), Vec::new(), None);
        let follow = || -> Result<(), Failure> {
            let system = task.system(compiled)?;
            let diagram = Diagram {
                system: &system,
                parameter: &parameter,
                until: longest,
                duration,
                locates,
                options: &options,
            };
            for value in values {
                let start = |here: &CompiledSystem| start_state(here, x.as_deref());
                let (at, between, end) = diagram.at(value, last.as_ref(), start, &words)?;
                if task.is_stopped() {
                    break;
                }
                found.push(at);
                changes.extend(between);
                last = Some(end);
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
    let all: Vec<Outcome> = found.into_iter().map(|at| at.outcome).collect();
    outcomes(&fields, compiled, &all)?;
    let changes = ChangeBetween::along(changes);
    fields.fields("changes", located(py, compiled, &changes)?)?;
    fields.ended(raised)
}

/// Changes of an attractor as a table.
fn located<'py>(
    py: Python<'py>,
    system: &CompiledSystem,
    changes: &[ChangeBetween],
) -> PyResult<Fields<'py>> {
    let all = || changes.iter().map(|at| &at.change);
    let table = Fields::new(py);
    table.texts("name", all().map(Change::name))?;
    table.optional_numbers("parameter", all().map(Change::parameter))?;
    table.optional_numbers("uncertainty", all().map(Change::uncertainty))?;
    table.numbers("from_value", changes.iter().map(|at| at.values.0))?;
    table.numbers("to_value", changes.iter().map(|at| at.values.1))?;
    table.optional_numbers("period", all().map(Change::period))?;
    let phases = |change: &Change| match change {
        Change::Sequence { before, after, .. } => (system.sequence(before), system.sequence(after)),
        _ => (String::new(), String::new()),
    };
    table.texts("before", all().map(|change| phases(change).0))?;
    table.texts("after", all().map(|change| phases(change).1))?;
    let states = system.states();
    let x = all().flat_map(|change| change.state().unwrap_or_else(|| vec![f64::NAN; states]));
    table.array("y", x.collect(), [states])?;
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
    let (compiled, options) = (&system.compiled, settings.options()?);
    check(compiled, longest)?;
    let [(name, columns), (other, rows)] = &plane;
    // The memory for a cell must not grow with the number of its points.
    type Cell = Option<(ReachedMotion, Largest)>;
    let cell = |system: &CompiledSystem, task: &Task, index: usize| -> Result<Cell, Failure> {
        if task.is_stopped() {
            return Ok(None);
        }
        let (column, row) = (columns[index % columns.len()], rows[index / columns.len()]);
        let here = system.with_values(&[(name, column), (other, row)])?;
        let start = start_state(&here, x.as_deref())?;
        let recurrence = recurrence(&here, longest);
        let reached = attractor_of_many(here.dynamics(), &*start, &recurrence, &options)?;
        let outcome = Outcome::of(&reached, &|error| words(error, &here));
        let largest = match duration {
            Some(duration) => Largest::on(&here, &outcome, duration, &options),
            None => Largest::Unmeasured,
        };
        if task.is_stopped() {
            return Ok(None);
        }
        task.count();
        Ok(Some((ReachedMotion::of(&outcome, system), largest)))
    };
    let outcome = computed(py, workers, (&report, ProgressKind::Count), |task| {
        let system = task.system(compiled)?;
        let cells = (0..columns.len() * rows.len()).into_par_iter();
        let cells = cells
            .with_max_len(1)
            .map(|index| cell(&system, task, index));
        cells.collect::<Result<Vec<Cell>, Failure>>()
    })?;
    let raised = outcome.raised;
    let cells = match outcome.found {
        Ok(cells) => cells,
        Err(error) => return Err(raised.unwrap_or_else(|| error.raised(compiled))),
    };
    let (reached, largest): (Vec<_>, Vec<_>) = cells.into_iter().map(Option::unzip).unzip();
    let fields = Fields::new(py);
    motions(&fields, &reached)?;
    let largest = largest.into_iter();
    exponents(
        &fields,
        duration,
        largest.map(|one| one.unwrap_or(Largest::Unmeasured)),
    )?;
    fields.ended(raised)
}

/// Index of the attractor of each start; -1 for starts that an interruption left out.
#[pyfunction]
pub(crate) fn basins<'py>(
    py: Python<'py>,
    system: &System,
    starts: PyReadonlyArray2<'py, f64>,
    how: (f64, usize),
    settings: Settings,
    report: Report,
) -> PyResult<Bound<'py, PyDict>> {
    let (longest, workers) = how;
    let (compiled, options) = (&system.compiled, settings.options()?);
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
        let found = basin_while(system.dynamics(), starts, &settings, &options, go_on);
        Ok(found?)
    })?;
    let found = outcome.found;
    let (attractors, reached) = found.map_err(|error: Failure| error.raised(compiled))?;
    let attractors = attractors.iter();
    let attractors =
        attractors.map(|one| Outcome::of(one, &|error: &Error| words(error, compiled)));
    let fields = Fields::new(py);
    outcomes(&fields, compiled, &attractors.collect::<Vec<_>>())?;
    let reached = reached.iter().map(|one| one.map_or(-1, |one| one as i64));
    fields.integers("reached", reached)?;
    fields.ended(outcome.raised)
}
