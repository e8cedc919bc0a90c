//! The analyses. Each calls the library and returns numbers, texts and arrays.

use std::ops::ControlFlow;
use std::sync::Mutex;

use numpy::{Complex64, IntoPyArray, PyArray1, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use rayon::prelude::*;
use stickslip::analysis::{
    BranchPoint, ContinuationSettings, Exponent, PartialBranch, PeriodicOrbit, PoincareMap,
    SpectrumOptions, Stability, attractor_of_many, basin_while, multipliers, periodic_orbit_forced,
};
use stickslip::dynamics::{DynamicsRef, Section, Vector};
use stickslip::{Ending, Error, Options};
use stickslip_kernels::file::System as Ready;
use stickslip_kernels::kernel::{Change, Motion, Outcome, Run, follow};
use stickslip_kernels::study::{Diagram, Largest, PeriodicSearch, SearchError, recurrence};
use stickslip_series::{DataSettings, Series, data_spectrum};

use crate::task::{Report, Task, Tells, computed};
use crate::{Settings, System, failed, numbers, rows, told, wrong};

/// Settings of the search for a periodic orbit: duration of the transient, period if given, maximum
/// time of return, and number of periods of a drive if given.
type Search = (f64, Option<f64>, f64, Option<u32>);

/// The state after a transient.
fn after(
    system: &DynamicsRef<'_>,
    (t, x): (f64, &[f64]),
    span: f64,
    options: &Options,
) -> Result<(f64, Vector), Error> {
    if span <= 0.0 {
        return Ok((t, Vector::from_column_slice(x)));
    }
    let t_end = t + span;
    let run = Run {
        t,
        x,
        t_end,
        options,
    };
    let ended = follow(system, &run, &Section::None, &mut ())?;
    let (t, x) = (ended.t, ended.x);
    match ended.ending {
        Ending::EndTime => Ok((t, x)),
        Ending::Shrunk => Err(Error::Shrunk { t, x: (&x).into() }),
        _ => Err(Error::NoUniqueFuture { t, x: (&x).into() }),
    }
}

/// The periodic orbit that the orbit from `start` approaches.
fn orbit_found(
    system: &Ready,
    (t, x): (f64, &[f64]),
    (transient, period, longest, periods): Search,
    options: &Options,
) -> Result<PeriodicOrbit, SearchError> {
    let dynamics = system.dynamics();
    Ok(match period {
        Some(period) if system.built.depends_on_time => {
            let wait = (transient / period).ceil() * period;
            let (t, x) = after(dynamics, (t, x), wait, options)?;
            periodic_orbit_forced(dynamics, t, &x, period, options)?
        }
        Some(period) => {
            let (_, x) = after(dynamics, (t, x), transient, options)?;
            stickslip::analysis::periodic_orbit(dynamics, &x, period, options)?
        }
        None => {
            let search = PeriodicSearch {
                transient,
                longest,
                periods,
            };
            search.found(system, (t, x), options)?.0
        }
    })
}

/// The Python exception for a failed search for a periodic orbit.
fn not_found(error: SearchError) -> PyErr {
    match error {
        SearchError::Failed(error) => failed(error),
        SearchError::NoPeriods | SearchError::Setting { .. } => {
            pyo3::exceptions::PyValueError::new_err(error.to_string())
        }
        SearchError::Period(error) => wrong(error),
        other => told("NotFound", &other, (None, None)),
    }
}

/// Adds the exception that ended a computation early to its results.
fn with_raised<'py>(
    py: Python<'py>,
    result: Bound<'py, PyDict>,
    raised: Option<PyErr>,
) -> PyResult<Bound<'py, PyDict>> {
    if let Some(raised) = raised {
        result.set_item("raised", raised.into_value(py))?;
    }
    Ok(result)
}

/// A periodic orbit.
#[pyfunction]
pub(crate) fn periodic_orbit<'py>(
    py: Python<'py>,
    system: &System,
    start: (f64, Vec<f64>),
    search: Search,
    settings: Settings,
) -> PyResult<Bound<'py, PyDict>> {
    let (ready, options) = (&system.ready, settings.options()?);
    let (t, x) = start;
    let orbit = computed(py, 1, (&None, Tells::Count), |task| {
        let system = task.system(ready)?;
        orbit_found(&system, (t, &x), search, &options).map_err(not_found)
    })?;
    let orbit = orbit.whole(|error| error)?;
    // The first multiplier of an autonomous system is trivial.
    let trivial = usize::from(!ready.built.depends_on_time);
    let all = multipliers(&orbit.monodromy);
    let stability = Stability::of(all.get(trivial..).unwrap_or_default());
    let result = PyDict::new(py);
    result.set_item("t", orbit.t)?;
    result.set_item("y", numbers(py, orbit.x.iter().copied()))?;
    result.set_item("period", orbit.period)?;
    result.set_item("residual", orbit.residual)?;
    result.set_item("family", orbit.family)?;
    let n = orbit.x.len();
    let by_rows = orbit.monodromy.transpose();
    let matrix = numbers(py, by_rows.iter().copied()).reshape([n, n])?;
    result.set_item("monodromy", matrix)?;
    result.set_item("multipliers", complex(py, &all))?;
    result.set_item("stability", stability.to_string())?;
    Ok(result)
}

fn complex<'py>(
    py: Python<'py>,
    values: &[stickslip::nalgebra::Complex<f64>],
) -> Bound<'py, PyArray1<Complex64>> {
    let values = values
        .iter()
        .map(|value| Complex64::new(value.re, value.im));
    values.collect::<Vec<_>>().into_pyarray(py)
}

/// Returns to the section of the system.
#[pyfunction]
pub(crate) fn poincare_map<'py>(
    py: Python<'py>,
    system: &System,
    start: (f64, Vec<f64>),
    how: (usize, f64, bool),
    settings: Settings,
    report: Report,
) -> PyResult<Bound<'py, PyDict>> {
    let (returns, longest, with_derivative) = how;
    let options = settings.options()?;
    let ready = &system.ready;
    let (t, x) = start;
    let states = x.len();
    let outcome = computed(py, 1, (&report, Tells::Count), |task| {
        let mut found = Vec::new();
        let mut go = || {
            let system = task.system(ready)?;
            let (start, options) = ((t, x.as_slice()), &options);
            let map = PoincareMap::at_run_time(
                &**system.dynamics(),
                Section::Own,
                start,
                longest,
                options,
            );
            let mut map = map.map_err(failed)?;
            for _ in 0..returns {
                let next = match with_derivative {
                    true => map
                        .step_with_derivative()
                        .map(|(at, derivative)| (at, Some(derivative))),
                    false => map.step().map(|at| (at, None)),
                };
                found.push(next.map_err(failed)?);
                task.count();
            }
            Ok::<_, PyErr>(())
        };
        let ended = go();
        (found, ended)
    })?;
    let (found, ended) = outcome.found;
    if outcome.raised.is_none() {
        ended?;
    }
    let result = PyDict::new(py);
    result.set_item("t", numbers(py, found.iter().map(|(at, _)| at.t)))?;
    result.set_item("y", rows(py, found.iter().map(|(at, _)| &at.x), states)?)?;
    let modes: Vec<String> = found
        .iter()
        .map(|(at, _)| system.ready.letters(&at.mode))
        .collect();
    result.set_item("mode", modes)?;
    let flat: Vec<f64> = found
        .iter()
        .filter_map(|(_, derivative)| derivative.as_ref())
        .flat_map(|derivative| derivative.transpose().iter().copied().collect::<Vec<_>>())
        .collect();
    let count = flat.len() / (states * states);
    let derivatives = flat.into_pyarray(py).reshape([count, states, states])?;
    result.set_item("derivatives", derivatives)?;
    with_raised(py, result, outcome.raised)
}

/// The branch of periodic orbits through the one that a search returns, in both directions.
#[pyfunction]
#[expect(
    clippy::too_many_arguments,
    reason = "they are those of a call from Python"
)]
pub(crate) fn continuation<'py>(
    py: Python<'py>,
    system: &System,
    start: (f64, Vec<f64>),
    search: Search,
    range: (String, f64, f64),
    how: (f64, usize),
    settings: Settings,
    report: Report,
) -> PyResult<Bound<'py, PyDict>> {
    let (step, most_points) = how;
    let (parameter, low, high) = range;
    let (ready, options) = (&system.ready, settings.options()?);
    let known = &ready.file.parameters;
    let number = known.iter().position(|one| one.name == parameter);
    let number = number.ok_or_else(|| wrong(format!("there is no parameter `{parameter}`")))?;
    let value = ready.values[number];
    if ready.built.depends_on_time && start.0 != 0.0 {
        return Err(pyo3::exceptions::PyValueError::new_err(
            "a branch of a system that depends on time begins at t = 0",
        ));
    }
    let (t, x) = start;
    let outcome = computed(py, 2, (&report, Tells::Count), |task| {
        let system = task.system(ready)?;
        let along = system.along(number).map_err(wrong)?;
        let orbit = orbit_found(&system, (t, &x), search, &options).map_err(not_found)?;
        let settings = ContinuationSettings {
            step,
            most_points,
            forced: system.built.depends_on_time.then_some(orbit.period),
            ..ContinuationSettings::over(low, high)
        };
        // A branch of a driven system begins at a whole number of periods.
        let x = match system.built.depends_on_time {
            true => {
                let rest = (orbit.t / orbit.period).ceil() * orbit.period - orbit.t;
                let start = (orbit.t, orbit.x.as_slice());
                after(system.dynamics(), start, rest, &options)
                    .map_err(failed)?
                    .1
            }
            false => orbit.x.clone(),
        };
        let x = [x.as_slice(), &[value]].concat();
        let way = |upwards| {
            // Results that are computed during an interruption are unreliable. Only those from
            // before it are kept.
            let mut found = 0;
            let observe = |branch: &PartialBranch| match task.is_stopped() {
                true => ControlFlow::Break(()),
                false => {
                    found = branch.points().len();
                    task.count();
                    ControlFlow::Continue(())
                }
            };
            let period = orbit.period;
            PartialBranch::begin(&along, &*x, period, upwards, &settings, &options)
                .and_then(|branch| branch.follow(&along, &settings, &options, observe))
                .map(|mut branch| {
                    if task.is_stopped() {
                        branch.points.truncate(found);
                        let reached = branch.points.last().map_or(value, |at| at.parameter);
                        let last = branch
                            .special
                            .iter()
                            .rposition(|at| at.parameter == reached);
                        branch.special.truncate(last.map_or(0, |last| last + 1));
                    }
                    branch
                })
                .map_err(failed)
        };
        let (down, up) = rayon::join(|| way(false), || way(true));
        Ok((down?, up?))
    })?;
    let Ok((down, up)) = outcome.found else {
        return outcome.whole(|error| error).map(|_| PyDict::new(py));
    };
    let states = ready.states();
    // Both directions begin with the same orbit.
    let points: Vec<&BranchPoint> = down.points.iter().skip(1).rev().chain(&up.points).collect();
    let result = PyDict::new(py);
    result.set_item(
        "parameter",
        numbers(py, points.iter().map(|at| at.parameter)),
    )?;
    result.set_item("period", numbers(py, points.iter().map(|at| at.period)))?;
    result.set_item("t", numbers(py, points.iter().map(|at| at.t)))?;
    let x: Vec<Vector> = points
        .iter()
        .map(|at| at.x.rows(0, states).into())
        .collect();
    result.set_item("y", rows(py, &x, states)?)?;
    let multipliers = points.iter().map(|at| complex(py, &at.multipliers));
    result.set_item("multipliers", multipliers.collect::<Vec<_>>())?;
    let stability: Vec<String> = points.iter().map(|at| at.stability().to_string()).collect();
    result.set_item("stability", stability)?;
    let phases = points.iter().map(|at| system.ready.sequence(&at.sequence));
    result.set_item("phases", phases.collect::<Vec<_>>())?;
    let special: Vec<_> = down.special.iter().rev().chain(&up.special).collect();
    let names: Vec<String> = special.iter().map(|at| at.what.to_string()).collect();
    result.set_item("special_name", names)?;
    let values = special.iter().map(|at| at.parameter);
    result.set_item("special_parameter", numbers(py, values))?;
    let values = special.iter().map(|at| at.uncertainty);
    result.set_item("special_uncertainty", numbers(py, values))?;
    let values = special.iter().map(|at| at.period);
    result.set_item("special_period", numbers(py, values))?;
    let stops = [&down.stop, &up.stop].map(|stop| format!("{stop:?}"));
    result.set_item("stops", stops.to_vec())?;
    with_raised(py, result, outcome.raised)
}

/// The spectrum of Lyapunov exponents.
#[pyfunction]
pub(crate) fn lyapunov_spectrum<'py>(
    py: Python<'py>,
    system: &System,
    start: (f64, Vec<f64>),
    span: (f64, f64),
    settings: Settings,
    report: Report,
) -> PyResult<Bound<'py, PyDict>> {
    let (transient, duration) = span;
    let ready = &system.ready;
    let settings = SpectrumOptions::over(transient, duration).solver(settings.options()?);
    let (t, x) = start;
    let spectrum = computed(py, 1, (&report, Tells::Time), |task| {
        let system = task.system(ready)?;
        let start = (t, x.as_slice());
        stickslip::analysis::lyapunov_spectrum(system.dynamics(), start, &settings).map_err(failed)
    })?;
    let spectrum = spectrum.whole(|error| error)?;
    let (exponents, duration) = (&spectrum.exponents, spectrum.duration);
    let result = PyDict::new(py);
    result.set_item(
        "exponents",
        numbers(py, exponents.iter().map(Exponent::value)),
    )?;
    let errors = exponents
        .iter()
        .map(|one| one.std_error().unwrap_or(f64::NAN));
    result.set_item("std_errors", numbers(py, errors))?;
    let uncertainties = exponents.iter().map(|one| match one {
        Exponent::Finite { .. } => one.uncertainty(duration),
        Exponent::Annihilated => f64::NAN,
    });
    result.set_item("uncertainties", numbers(py, uncertainties))?;
    result.set_item("duration", duration)?;
    result.set_item("defect", spectrum.defect())?;
    result.set_item("stick_entries", spectrum.stick_entries)?;
    result.set_item("stick_fraction", spectrum.stick_fraction)?;
    let running = &spectrum.convergence;
    let elapsed = running.iter().map(|at| at.elapsed);
    result.set_item("elapsed", numbers(py, elapsed))?;
    let values = running.iter().flat_map(|at| at.exponents.iter().copied());
    let values = numbers(py, values).reshape([running.len(), exponents.len()])?;
    result.set_item("running", values)?;
    Ok(result)
}

/// Outcomes of orbits, as lists with one entry for each orbit.
fn outcomes<'py>(
    py: Python<'py>,
    system: &Ready,
    found: &[&Outcome],
    states: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let result = PyDict::new(py);
    let kinds = found.iter().map(|one| one.motion.word());
    result.set_item("kind", kinds.collect::<Vec<_>>())?;
    let periods = found.iter().map(|one| match one.motion {
        Motion::Periodic { period, .. } => period,
        _ => f64::NAN,
    });
    result.set_item("period", numbers(py, periods))?;
    let returns = found.iter().map(|one| match one.motion {
        Motion::Periodic { returns, .. } => returns as i64,
        _ => 0,
    });
    let returns: Vec<i64> = returns.collect();
    result.set_item("returns", returns.into_pyarray(py))?;
    let phases = found.iter().map(|one| system.phases(one));
    result.set_item("phases", phases.collect::<Vec<_>>())?;
    let in_stick = found.iter().map(|one| match one.points.is_empty() {
        true => f64::NAN,
        false => one.in_stick,
    });
    result.set_item("in_stick", numbers(py, in_stick))?;
    let points = PyList::empty(py);
    for one in found {
        let flat: Vec<f64> = one.points.iter().flat_map(|(_, x)| x.clone()).collect();
        points.append(flat.into_pyarray(py).reshape([one.points.len(), states])?)?;
    }
    result.set_item("points", points)?;
    Ok(result)
}

/// Largest exponents with their standard errors, NaN where there are none.
fn exponents(result: &Bound<'_, PyDict>, found: &[Largest]) -> PyResult<()> {
    let py = result.py();
    let both = found.iter().map(Largest::numbers);
    let (values, errors): (Vec<_>, Vec<_>) = both.unzip();
    let of = |values: Vec<Option<f64>>| {
        numbers(py, values.into_iter().map(|one| one.unwrap_or(f64::NAN)))
    };
    result.set_item("exponent", of(values))?;
    result.set_item("std_error", of(errors))
}

/// Start state of the orbit: as given, or that of the system.
fn begins(system: &Ready, given: Option<&[f64]>) -> PyResult<Vec<f64>> {
    let start = given.map(<[f64]>::to_vec);
    let start = start.or_else(|| system.built.start.clone());
    start.ok_or_else(|| wrong("the system has no start: give y0"))
}

/// Checks whether attractors can be searched.
fn check(system: &Ready, longest: f64) -> PyResult<()> {
    system.checked_period().map_err(wrong)?;
    recurrence(system, longest).check().map_err(failed)
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
    let (ready, options) = (&system.ready, settings.options()?);
    check(ready, longest)?;
    let outcome = computed(py, 0, (&report, Tells::Count), |task| {
        let (mut found, mut changes, mut last) = (Vec::new(), Vec::new(), None);
        let go = || {
            let system = task.system(ready)?;
            let diagram = Diagram {
                system: &system,
                parameter: &parameter,
                until: longest,
                duration,
                locates,
                options: &options,
            };
            for value in values {
                let start = |here: &Ready| begins(here, x.as_deref()).map_err(Failure);
                let at = diagram.at(value, last.as_ref(), start, &Error::to_string);
                let (at, between, end) = at.map_err(|error: Failure| error.0)?;
                if task.is_stopped() {
                    break;
                }
                found.push(at);
                changes.extend(between);
                last = Some(end);
                task.count();
            }
            Ok::<_, PyErr>(())
        };
        let ended = go();
        (found, changes, ended)
    })?;
    let (found, changes, ended) = outcome.found;
    if outcome.raised.is_none() {
        ended?;
    }
    let states = ready.states();
    let all: Vec<&Outcome> = found.iter().map(|at| &at.outcome).collect();
    let result = outcomes(py, ready, &all, states)?;
    let largest: Vec<Largest> = found.iter().map(|at| at.largest).collect();
    exponents(&result, &largest)?;
    result.set_item("value", numbers(py, found.iter().map(|at| at.value)))?;
    let located = changes.iter().map(|at| Located::of(ready, &at.change));
    let located: Vec<Located> = located.collect();
    let table = PyDict::new(py);
    let texts = |of: fn(&Located) -> &String| located.iter().map(of).collect::<Vec<_>>();
    let column = |of: fn(&Located) -> f64| numbers(py, located.iter().map(of));
    table.set_item("name", texts(|at| &at.name))?;
    table.set_item("parameter", column(|at| at.parameter))?;
    table.set_item("uncertainty", column(|at| at.uncertainty))?;
    let between = |of: fn(&(f64, f64)) -> f64| numbers(py, changes.iter().map(|at| of(&at.values)));
    table.set_item("from_value", between(|values| values.0))?;
    table.set_item("to_value", between(|values| values.1))?;
    table.set_item("period", column(|at| at.period))?;
    table.set_item("before", texts(|at| &at.before))?;
    table.set_item("after", texts(|at| &at.after))?;
    let x = located.iter().map(|at| match &at.x {
        Some(x) => Vector::from_column_slice(x),
        None => Vector::from_element(states, f64::NAN),
    });
    let x: Vec<Vector> = x.collect();
    table.set_item("y", rows(py, &x, states)?)?;
    result.set_item("changes", table)?;
    with_raised(py, result, outcome.raised)
}

/// Any error of a value of a diagram, as a Python exception.
struct Failure(PyErr);

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Failure(failed(error))
    }
}

impl From<stickslip_kernels::file::SettingError> for Failure {
    fn from(error: stickslip_kernels::file::SettingError) -> Self {
        Failure(wrong(error))
    }
}

/// A change of an attractor as a row.
struct Located {
    name: String,
    parameter: f64,
    uncertainty: f64,
    period: f64,
    before: String,
    after: String,
    x: Option<Vec<f64>>,
}

impl Located {
    fn of(system: &Ready, change: &Change) -> Self {
        let mut row = Located {
            name: change.name(),
            parameter: f64::NAN,
            uncertainty: f64::NAN,
            period: f64::NAN,
            before: String::new(),
            after: String::new(),
            x: None,
        };
        match change {
            Change::Sequence {
                parameter,
                uncertainty,
                x,
                period,
                before,
                after,
                ..
            } => {
                (row.parameter, row.uncertainty) = (*parameter, *uncertainty);
                (row.before, row.after) = (system.sequence(before), system.sequence(after));
                (row.period, row.x) = (*period, Some(x.clone()));
            }
            Change::Multiplier {
                parameter,
                uncertainty,
                x,
                period,
                ..
            } => {
                (row.parameter, row.uncertainty) = (*parameter, *uncertainty);
                (row.period, row.x) = (*period, Some(x.clone()));
            }
            Change::Equilibrium { parameter, x, .. }
            | Change::BoundaryEquilibrium { parameter, x } => {
                (row.parameter, row.x) = (*parameter, Some(x.clone()));
            }
            Change::Unlocated => {}
        }
        row
    }
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
    let (ready, options) = (&system.ready, settings.options()?);
    check(ready, longest)?;
    let [(name, columns), (other, rows)] = &plane;
    let cell = |system: &Ready, task: &Task, index: usize| {
        let (column, row) = (columns[index % columns.len()], rows[index / columns.len()]);
        let here = system
            .with_values(&[(name, column), (other, row)])
            .map_err(wrong)?;
        let start = begins(&here, x.as_deref())?;
        let recurrence = recurrence(&here, longest);
        let reached = attractor_of_many(here.dynamics(), &*start, &recurrence, &options);
        let mut outcome = Outcome::of(&reached.map_err(failed)?, &Error::to_string);
        let largest = match duration {
            Some(duration) => Largest::on(&here, &outcome, duration, &options),
            None => Largest::Unmeasured,
        };
        // The memory for a cell must not grow with the number of its points.
        outcome.in_stick = match outcome.points.is_empty() {
            true => f64::NAN,
            false => outcome.in_stick,
        };
        let phases = system.phases(&outcome);
        Ok(match task.is_stopped() {
            true => None,
            false => {
                task.count();
                Some((outcome.motion, phases, outcome.in_stick, largest))
            }
        })
    };
    let first_error = Mutex::new(None);
    let outcome = computed(py, workers, (&report, Tells::Count), |task| {
        let system = task.system(ready)?;
        let cells = (0..columns.len() * rows.len()).into_par_iter();
        let cells: Result<Vec<_>, ()> = cells
            .with_max_len(1)
            .map(|index| match task.is_stopped() {
                true => Ok(None),
                false => cell(&system, task, index).map_err(|error: PyErr| {
                    if let Ok(mut first) = first_error.lock() {
                        first.get_or_insert(error);
                    }
                }),
            })
            .collect();
        Ok::<_, PyErr>(cells.unwrap_or_default())
    })?;
    let raised = outcome.raised;
    let cells = outcome.found?;
    if cells.is_empty()
        && let Some(raised) = raised
    {
        return Err(raised);
    }
    if let (None, Some(error)) = (&raised, first_error.into_inner().ok().flatten()) {
        return Err(error);
    }
    let result = PyDict::new(py);
    let kinds = cells.iter().map(|cell| match cell {
        Some((motion, ..)) => motion.word(),
        None => "",
    });
    result.set_item("kind", kinds.collect::<Vec<_>>())?;
    let periods = cells.iter().map(|cell| match cell {
        Some((Motion::Periodic { period, .. }, ..)) => *period,
        _ => f64::NAN,
    });
    result.set_item("period", numbers(py, periods))?;
    let phases = cells.iter().map(|cell| match cell {
        Some((_, phases, ..)) => phases.as_str(),
        None => "",
    });
    result.set_item("phases", phases.collect::<Vec<_>>())?;
    let in_stick = cells.iter().map(|cell| match cell {
        Some((_, _, in_stick, _)) => *in_stick,
        None => f64::NAN,
    });
    result.set_item("in_stick", numbers(py, in_stick))?;
    let largest = cells.iter().map(|cell| match cell {
        Some((.., largest)) => *largest,
        None => Largest::Unmeasured,
    });
    exponents(&result, &largest.collect::<Vec<_>>())?;
    with_raised(py, result, raised)
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
    let (ready, options) = (&system.ready, settings.options()?);
    check(ready, longest)?;
    let settings = recurrence(ready, longest);
    let starts = starts.as_array();
    let states = starts.ncols();
    let starts: Vec<Vector> = starts
        .rows()
        .into_iter()
        .map(|row| Vector::from_iterator(states, row.iter().copied()))
        .collect();
    let outcome = computed(py, workers, (&report, Tells::Count), |task| {
        let system = task.system(ready)?;
        let asked = || match task.is_stopped() {
            true => ControlFlow::Break(()),
            false => {
                task.count();
                ControlFlow::Continue(())
            }
        };
        basin_while(system.dynamics(), starts, &settings, &options, asked).map_err(failed)
    })?;
    let (attractors, reached) = outcome.found?;
    let attractors = attractors.iter();
    let attractors: Vec<Outcome> = attractors
        .map(|one| Outcome::of(one, &Error::to_string))
        .collect();
    let result = outcomes(py, ready, &attractors.iter().collect::<Vec<_>>(), states)?;
    let numbers = reached.iter().map(|one| one.map_or(-1, |one| one as i64));
    let numbers: Vec<i64> = numbers.collect();
    result.set_item("reached", numbers.into_pyarray(py))?;
    with_raised(py, result, outcome.raised)
}

/// The spectrum of a measured series, with one row for each point.
#[pyfunction]
pub(crate) fn lyapunov_from_data<'py>(
    py: Python<'py>,
    series: PyReadonlyArray2<'py, f64>,
    dt: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let series = series.as_array();
    let values = series.iter().copied().collect();
    let columns = series.ncols();
    let refused = |error: &dyn std::fmt::Display| told("Series", error, (None, None));
    let series = Series::new(values, columns, dt).map_err(|error| refused(&error))?;
    let found = computed(py, 0, (&None, Tells::Count), |_| {
        data_spectrum(&series, &DataSettings::default())
    })?;
    let found = found.whole(|error| refused(&error))?;
    let exponents = &found.exponents;
    let result = PyDict::new(py);
    result.set_item(
        "exponents",
        numbers(py, exponents.iter().map(|one| one.value)),
    )?;
    result.set_item(
        "std_errors",
        numbers(py, exponents.iter().map(|one| one.stderr)),
    )?;
    let status: Vec<&str> = exponents.iter().map(|one| one.status.word()).collect();
    result.set_item("status", status)?;
    result.set_item("dimension", found.dimension)?;
    Ok(result)
}
