//! The analyses: each calls the library and hands back numbers, texts and arrays.

use std::ops::ControlFlow;

use numpy::{Complex64, IntoPyArray, PyArray1, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use stickslip::analysis::{
    BranchPoint, ContinuationSettings, Exponent, PartialBranch, PeriodicOrbit, PoincareMap,
    Reached, RecurrenceSettings, SpectrumOptions, Stability, SweepSettings, basin,
    find_periodic_orbit, multipliers, periodic_orbit_forced, sweep,
};
use stickslip::dynamics::{DynamicsRef, Moment, Section, Vector};
use stickslip::{Ending, Error, Options};
use stickslip_kernels::file::System as Ready;
use stickslip_kernels::kernel::{Run, follow};
use stickslip_series::{DataSettings, Series, data_spectrum};

use crate::interrupt::{Interrupt, computed};
use crate::{Settings, StickslipError, System, failed, numbers, rows, wrong};

/// How a periodic orbit is looked for: how long the run before it is, its period if that is given,
/// or how long it may take to come back.
type Search = (f64, Option<f64>, f64);

/// The state behind a time that is a transient.
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

/// The periodic orbit that the orbit from `start` comes to. Of a driven system the period is given.
fn orbit_found(
    system: &Ready,
    (t, x): (f64, &[f64]),
    (transient, period, longest): Search,
    options: &Options,
    interrupt: &Interrupt,
) -> Result<PeriodicOrbit, Error> {
    let dynamics = interrupt.guarded(&**system.dynamics());
    match period {
        Some(period) if system.built.depends_on_time => {
            let wait = (transient / period).ceil() * period;
            let (t, x) = after(&dynamics, (t, x), wait, options)?;
            periodic_orbit_forced(&dynamics, t, &x, period, options)
        }
        Some(period) => {
            let (_, x) = after(&dynamics, (t, x), transient, options)?;
            stickslip::analysis::periodic_orbit(&dynamics, &x, period, options)
        }
        None => find_periodic_orbit(&dynamics, x, transient, longest, options),
    }
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
    let orbit = computed(py, 1, |interrupt| {
        orbit_found(ready, (t, &x), search, &options, interrupt)
    })?;
    let orbit = orbit.map_err(failed)?;
    // The first multiplier of a system that does not depend on time is trivial.
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

/// Returns to a section, given by its function and direction, or to that of the system.
#[pyfunction]
pub(crate) fn poincare_map<'py>(
    py: Python<'py>,
    system: &System,
    start: (f64, Vec<f64>),
    section: (String, i32),
    how: (usize, f64, bool),
    settings: Settings,
) -> PyResult<Bound<'py, PyDict>> {
    let (returns, longest, with_derivative) = how;
    let options = settings.options()?;
    let with_section = system.with_section(&section.0, section.1)?;
    let (t, x) = start;
    let states = x.len();
    let found = computed(py, 1, |interrupt| {
        let dynamics = interrupt.guarded(&**with_section.dynamics());
        let start = (t, x.as_slice());
        let mut map = PoincareMap::at_run_time(&*dynamics, Section::Own, start, longest, &options)?;
        let mut found = Vec::new();
        for _ in 0..returns {
            found.push(match with_derivative {
                true => map
                    .step_with_derivative()
                    .map(|(at, derivative)| (at, Some(derivative)))?,
                false => (map.step()?, None),
            });
        }
        Ok(found)
    })?;
    let found = found.map_err(failed)?;
    let result = PyDict::new(py);
    result.set_item("t", numbers(py, found.iter().map(|(at, _)| at.t)))?;
    result.set_item("y", rows(py, found.iter().map(|(at, _)| &at.x), states)?)?;
    let modes: Vec<String> = found.iter().map(|(at, _)| at.mode.to_string()).collect();
    result.set_item("mode", modes)?;
    let flat: Vec<f64> = found
        .iter()
        .filter_map(|(_, derivative)| derivative.as_ref())
        .flat_map(|derivative| derivative.transpose().iter().copied().collect::<Vec<_>>())
        .collect();
    let count = flat.len() / (states * states);
    let derivatives = flat.into_pyarray(py).reshape([count, states, states])?;
    result.set_item("derivatives", derivatives)?;
    Ok(result)
}

/// The branch of periodic orbits through the one that a search finds, both ways.
#[pyfunction]
pub(crate) fn continuation<'py>(
    py: Python<'py>,
    system: &System,
    start: (f64, Vec<f64>),
    search: Search,
    range: (String, f64, f64),
    how: (f64, usize),
    settings: Settings,
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
    let along = ready.along(number).map_err(wrong)?;
    let (t, x) = start;
    let found = computed(py, 2, |interrupt| {
        let orbit = orbit_found(ready, (t, &x), search, &options, interrupt)?;
        let settings = ContinuationSettings {
            step,
            most_points,
            forced: ready.built.depends_on_time.then_some(orbit.period),
            ..ContinuationSettings::over(low, high)
        };
        // A branch of a driven system begins at a whole number of periods.
        let x = match ready.built.depends_on_time {
            true => {
                let rest = (orbit.t / orbit.period).ceil() * orbit.period - orbit.t;
                let system = interrupt.guarded(&**ready.dynamics());
                after(&system, (orbit.t, orbit.x.as_slice()), rest, &options)?.1
            }
            false => orbit.x.clone(),
        };
        let x = [x.as_slice(), &[value]].concat();
        let along = interrupt.guarded(&*along);
        let observe = |_: &PartialBranch| match interrupt.is_raised() {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        let way = |upwards| {
            let period = orbit.period;
            PartialBranch::begin(&along, &*x, period, upwards, &settings, &options)?
                .follow(&along, &settings, &options, observe)
        };
        let (down, up) = rayon::join(|| way(false), || way(true));
        Ok((down?, up?))
    })?;
    let (down, up) = found.map_err(failed)?;
    let states = ready.states();
    // Both begin with the same orbit.
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
    let sequence = |at: &&BranchPoint| {
        let modes = at.sequence.iter().map(ToString::to_string);
        modes.collect::<Vec<_>>().join(" ")
    };
    result.set_item("phases", points.iter().map(sequence).collect::<Vec<_>>())?;
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
    Ok(result)
}

/// The spectrum of Lyapunov exponents.
#[pyfunction]
pub(crate) fn lyapunov_spectrum<'py>(
    py: Python<'py>,
    system: &System,
    start: (f64, Vec<f64>),
    span: (f64, f64),
    settings: Settings,
) -> PyResult<Bound<'py, PyDict>> {
    let (transient, duration) = span;
    let ready = &system.ready;
    let settings = SpectrumOptions::over(transient, duration).solver(settings.options()?);
    let (t, x) = start;
    let spectrum = computed(py, 1, |interrupt| {
        let dynamics = interrupt.guarded(&**ready.dynamics());
        stickslip::analysis::lyapunov_spectrum(&dynamics, (t, x.as_slice()), &settings)
    })?;
    let spectrum = spectrum.map_err(failed)?;
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
    Ok(result)
}

/// Attractors as lists, one entry for each.
fn attractors<'py>(
    py: Python<'py>,
    found: &[&Reached],
    states: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let result = PyDict::new(py);
    let kinds: Vec<String> = found.iter().map(|one| one.kind.to_string()).collect();
    result.set_item("kind", kinds)?;
    let phases = |one: &&Reached| {
        let modes = one.sequence();
        let modes = modes.iter().map(ToString::to_string);
        modes.collect::<Vec<_>>().join(" ")
    };
    result.set_item("phases", found.iter().map(phases).collect::<Vec<_>>())?;
    let in_stick = found.iter().map(|one| one.in_stick);
    result.set_item("in_stick", numbers(py, in_stick))?;
    let points = found.iter().map(|one| {
        let points = one.points.iter().map(|Moment { x, .. }| x);
        rows(py, points, states)
    });
    result.set_item("points", points.collect::<PyResult<Vec<_>>>()?)?;
    Ok(result)
}

/// The attractor at each of some values of a parameter, followed from one to the next.
#[pyfunction]
pub(crate) fn bifurcation_diagram<'py>(
    py: Python<'py>,
    system: &System,
    x: Vec<f64>,
    along: (String, Vec<f64>),
    longest: f64,
    settings: Settings,
) -> PyResult<Bound<'py, PyDict>> {
    let (parameter, values) = along;
    let (ready, options) = (&system.ready, settings.options()?);
    // Where the period depends on the parameter, time is measured in that of the system given.
    let at = |&value: &f64| {
        let system = ready_with(ready, &parameter, value)?;
        system.in_period(ready.built.period).map_err(wrong)
    };
    let systems: Vec<DynamicsRef<'_>> = values.iter().map(at).collect::<PyResult<_>>()?;
    let states = x.len();
    let sweep_settings = SweepSettings {
        recurrence: recurrence(ready, longest),
        spectrum: None,
        // Changes are located by systems at values between these, of which none is made here.
        locating: None,
    };
    let found = computed(py, 0, |interrupt| {
        let family = |value: f64| {
            let number = values.iter().position(|one| *one == value);
            let at = number.map_or(&**ready.dynamics(), |number| &*systems[number]);
            interrupt.guarded(at)
        };
        sweep(
            family,
            values.iter().copied(),
            x.as_slice(),
            &sweep_settings,
            &options,
        )
    })?;
    let found = found.map_err(failed)?;
    let reached: Vec<&Reached> = found.points.iter().map(|point| &point.reached).collect();
    let result = attractors(py, &reached, states)?;
    let values = found.points.iter().map(|point| point.parameter);
    result.set_item("parameter", numbers(py, values))?;
    Ok(result)
}

/// A system with one more parameter set.
fn ready_with(ready: &Ready, parameter: &str, value: f64) -> PyResult<Ready> {
    let known = ready.file.parameters.iter().zip(&ready.values);
    let others = known.filter(|(one, _)| one.name != parameter);
    let others = others.map(|(one, &value)| (one.name.clone(), value));
    let all: Vec<_> = others.chain([(parameter.to_owned(), value)]).collect();
    ready.file.with(&all).map_err(wrong)
}

fn recurrence(system: &Ready, longest: f64) -> RecurrenceSettings {
    RecurrenceSettings {
        forcing: system.built.period,
        ..RecurrenceSettings::within(longest)
    }
}

/// Which attractor each start leads to.
#[pyfunction]
pub(crate) fn basins<'py>(
    py: Python<'py>,
    system: &System,
    starts: PyReadonlyArray2<'py, f64>,
    how: (f64, usize),
    settings: Settings,
) -> PyResult<Bound<'py, PyDict>> {
    let (longest, workers) = how;
    let (ready, options) = (&system.ready, settings.options()?);
    let settings = recurrence(ready, longest);
    let starts = starts.as_array();
    let states = starts.ncols();
    let starts: Vec<Vector> = starts
        .rows()
        .into_iter()
        .map(|row| Vector::from_iterator(states, row.iter().copied()))
        .collect();
    let found = computed(py, workers, |interrupt| {
        let dynamics = interrupt.guarded(&**ready.dynamics());
        basin(&dynamics, starts, &settings, &options)
    })?;
    let found = found.map_err(failed)?;
    let reached: Vec<&Reached> = found.attractors.iter().collect();
    let result = attractors(py, &reached, states)?;
    let numbers: Vec<i64> = found.reached.iter().map(|&number| number as i64).collect();
    result.set_item("reached", numbers.into_pyarray(py))?;
    Ok(result)
}

/// The spectrum of a measured series, a row for each point.
#[pyfunction]
pub(crate) fn lyapunov_from_data<'py>(
    py: Python<'py>,
    series: PyReadonlyArray2<'py, f64>,
    dt: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let series = series.as_array();
    let values = series.iter().copied().collect();
    let columns = series.ncols();
    let refused = |error: &dyn std::fmt::Display| {
        let (t, x): (Option<f64>, Option<Vec<f64>>) = (None, None);
        StickslipError::new_err((error.to_string(), t, x))
    };
    let series = Series::new(values, columns, dt).map_err(|error| refused(&error))?;
    let found = computed(py, 0, |_| data_spectrum(&series, &DataSettings::default()))?;
    let found = found.map_err(|error| refused(&error))?;
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
