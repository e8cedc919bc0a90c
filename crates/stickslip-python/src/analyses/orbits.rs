//! A periodic orbit, and returns to a section.

use std::ops::ControlFlow;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use stickslip::analysis::{PeriodicOrbit, PoincareMap, Stability, multipliers};
use stickslip::dynamics::{OrbitProgress, OrbitUnderWay, Section};
use stickslip::{Error, Options};
use stickslip_model::file::System as CompiledSystem;
use stickslip_model::kernel::follow;
use stickslip_model::study::{
    DerivativeError, OrbitSlopes, OrbitVariables, PeriodicSearch, SearchError, extremes,
    phases_of_period,
};

use super::Start;
use crate::errors::{Failure, computation, failed, words};
use crate::fields::{Fields, complex};
use crate::task::{ProgressKind, Report, computed};
use crate::{Settings, System};

/// Settings of the search for a periodic orbit: duration of the transient and period if given,
/// maximum time of return, and number of periods of a drive if given.
pub(super) type Search = (Option<f64>, Option<f64>, f64, Option<u32>);

/// The periodic orbit that the orbit from a start approaches.
pub(super) fn approached(
    system: &CompiledSystem,
    start: (f64, &[f64]),
    (transient, period, longest, periods): Search,
    options: &Options,
) -> Result<PeriodicOrbit, SearchError> {
    let search = PeriodicSearch {
        transient,
        period,
        longest,
        periods,
    };
    Ok(search.orbit(system, start, options)?.0)
}

/// A periodic orbit, with its derivatives by parameters if some are named.
#[pyfunction]
pub(crate) fn periodic_orbit<'py>(
    py: Python<'py>,
    system: &System,
    start: Start,
    search: Search,
    derivatives: Vec<String>,
    settings: Settings,
) -> PyResult<Bound<'py, PyDict>> {
    let (origin, x) = start;
    let compiled = &system.compiled;
    let options = settings.options(compiled)?;
    let by = OrbitVariables::named(compiled, derivatives.iter().map(String::as_str));
    let by = by.map_err(|error| {
        PyValueError::new_err(format!("derivatives = {derivatives:?}: {error}"))
    })?;
    let orbit = computed(py, 1, (&None, ProgressKind::Count), |task| {
        let system = task.system(compiled)?;
        let orbit = approached(&system, (origin, &x), search, &options)?;
        let mut phases = Vec::new();
        let mut watcher = |progress, _: &mut dyn OrbitUnderWay| {
            if let OrbitProgress::PhaseEnd(phase) = progress {
                phases.push(phase);
            }
            ControlFlow::Continue(())
        };
        let (start, t_end) = ((orbit.t, orbit.x.as_slice()), orbit.t + orbit.period);
        let dynamics = system.dynamics();
        follow(dynamics, start, t_end, &options, &[], &mut watcher)?;
        let (ranges, _) = extremes(dynamics, start, t_end, &options)?;
        let slopes = match derivatives.is_empty() {
            true => None,
            false => Some(by.of_orbit(&system, (&orbit, origin), &options)),
        };
        let is_forced = system.built.depends_on_time;
        let uncertainties = orbit.multiplier_uncertainties(dynamics, is_forced, &options);
        Ok((
            (orbit, uncertainties),
            phases_of_period(&**dynamics, &phases),
            ranges,
            slopes,
        ))
    })?;
    let ((orbit, uncertainties), (phases, stick), ranges, slopes) =
        orbit.whole(|error: Failure| error.raised(compiled))?;
    let slopes = slopes.transpose().map_err(|error| match error {
        DerivativeError::Run(error) => failed(&error, Some(compiled)),
        error => PyValueError::new_err(error.to_string()),
    })?;
    // The first multiplier of an autonomous system is trivial.
    let trivial = usize::from(!compiled.built.depends_on_time);
    let all = multipliers(&orbit.monodromy);
    let stability = Stability::of(all.get(trivial..).unwrap_or_default());
    let fields = Fields::new(py);
    fields.put("t", orbit.t)?;
    fields.numbers("y", orbit.x.iter().copied())?;
    fields.put("period", orbit.period)?;
    fields.put("residual", orbit.residual)?;
    fields.put("family", orbit.family)?;
    let by_rows = orbit.monodromy.transpose();
    fields.array("monodromy", by_rows.as_slice().to_vec(), [orbit.x.len()])?;
    fields.put("multipliers", complex(py, &all))?;
    fields.numbers("multiplier_uncertainties", uncertainties)?;
    fields.put("stability", stability.to_string())?;
    fields.put("in_stick", stick / orbit.period)?;
    fields.put("phases", compiled.sequence(&phases))?;
    fields.numbers("y_min", ranges.iter().map(|range| range.0))?;
    fields.numbers("y_max", ranges.iter().map(|range| range.1))?;
    if let Some(slopes) = slopes {
        fields.fields("derivatives", slope_fields(py, &slopes)?)?;
    }
    fields.ended(None)
}

/// Derivatives of a periodic orbit for Python.
fn slope_fields<'py>(py: Python<'py>, slopes: &OrbitSlopes) -> PyResult<Fields<'py>> {
    let fields = Fields::new(py);
    let columns = slopes.names.len();
    fields.numbers("dperiod", slopes.orbit.period.iter().copied())?;
    let by_rows = slopes.orbit.x.transpose();
    fields.array("dy", by_rows.as_slice().to_vec(), [columns])?;
    for (k, name) in ["dy_min", "dy_max"].into_iter().enumerate() {
        let of_states = slopes.orbit.extremes.iter().flat_map(|pair| &pair[k].by);
        fields.array(name, of_states.copied().collect(), [columns])?;
    }
    let of_multipliers = slopes.multipliers.iter().map(|of| complex(py, of));
    fields.texts("dmultipliers", of_multipliers)?;
    let missing = slopes.missing.iter().flatten();
    fields.texts("missing", missing.map(ToString::to_string))?;
    Ok(fields)
}

/// Returns to the section of the system.
#[pyfunction]
pub(crate) fn poincare_map<'py>(
    py: Python<'py>,
    system: &System,
    start: Start,
    how: (usize, f64, bool),
    settings: Settings,
    report: Report,
) -> PyResult<Bound<'py, PyDict>> {
    let (t, x) = start;
    let (returns, longest, with_derivative) = how;
    let compiled = &system.compiled;
    let options = settings.options(compiled)?;
    let states = x.len();
    let outcome = computed(py, 1, (&report, ProgressKind::Count), |task| {
        let mut found = Vec::new();
        let mut follow = || -> Result<(), Failure> {
            let system = task.system(compiled)?;
            let start = (t, x.as_slice());
            let dynamics = &**system.dynamics();
            let mut map =
                PoincareMap::at_run_time(dynamics, Section::OfSystem(0), start, longest, &options)?;
            for _ in 0..returns {
                found.push(match with_derivative {
                    true => {
                        let (at, derivative) = map.step_with_derivative()?;
                        (at, Some(derivative))
                    }
                    false => (map.step()?, None),
                });
                task.count();
            }
            Ok(())
        };
        let ended = follow();
        (found, ended)
    })?;
    let (found, raised) = outcome.partial(|error: Failure| match error {
        Failure::Run(error @ Error::NotFound { .. }) => {
            let words = words(&error, compiled);
            let message = format!("{words}; give a larger `longest`, or another section");
            computation("NotFound", &message, Some(&error))
        }
        error => error.raised(compiled),
    })?;
    let fields = Fields::new(py);
    fields.numbers("t", found.iter().map(|(at, _)| at.t))?;
    fields.rows("y", found.iter().map(|(at, _)| &at.x), states)?;
    fields.texts(
        "mode",
        found.iter().map(|(at, _)| compiled.letters(&at.mode)),
    )?;
    let derivatives = found
        .iter()
        .filter_map(|(_, derivative)| derivative.as_ref());
    let by_rows = derivatives.map(|derivative| derivative.transpose());
    let flat = by_rows.flat_map(|matrix| matrix.as_slice().to_vec());
    fields.array("derivatives", flat.collect(), [states, states])?;
    fields.ended(raised)
}
