//! The branch of equilibria along a parameter.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use stickslip::analysis::EquilibriumCurve;
use stickslip_model::file::System as CompiledSystem;
use stickslip_model::study::{
    BranchEnd, EquilibriaOfBranch, ParameterLine, boundary_of, equilibrium, frequency_of,
    word_of_curve_stop,
};

use super::branch::continuation_settings;
use crate::errors::Failure;
use crate::fields::{Fields, complex};
use crate::task::{ProgressKind, computed};
use crate::{Settings, System};

/// The branch of equilibria through the one that the orbit from a start approaches, in both
/// directions.
#[pyfunction]
#[expect(
    clippy::too_many_arguments,
    reason = "they are those of a call from Python"
)]
pub(crate) fn equilibrium_continuation<'py>(
    py: Python<'py>,
    system: &System,
    x: Vec<f64>,
    transient: Option<f64>,
    range: (String, f64, f64),
    how: (f64, usize),
    also: Option<(String, f64, f64)>,
    settings: Settings,
) -> PyResult<Bound<'py, PyDict>> {
    let (parameter, low, high) = range;
    let compiled = &system.compiled;
    let options = settings.options(compiled)?;
    let threads = if also.is_some() { 0 } else { 1 };
    let branch = computed(py, threads, (&None, ProgressKind::Count), |task| {
        let system = task.system(compiled)?;
        let along = ParameterLine::new(&system, &parameter, (low, high))?;
        let settings = continuation_settings((low, high), how)?;
        let x = equilibrium(&system, &x, transient, &options)?;
        let branch = along.equilibria(&x, &settings, &options)?;
        let curves = match &also {
            Some((name, low, high)) => {
                let number = system.file.parameter(name)?;
                let both = system.with_states_of(&[number, along.number])?;
                let second = (&both, system.values[number], (*low, *high));
                branch.curves(second, &settings)?
            }
            None => Vec::new(),
        };
        Ok((branch, curves))
    })?;
    let (branch, curves) = branch.whole(|error: Failure| error.raised(compiled))?;
    let fields = described(py, compiled, &branch)?;
    let states = compiled.states();
    let curves = curves
        .iter()
        .map(|(k, curve)| described_curve(py, states, (*k, curve.as_ref())));
    fields.put("curves", curves.collect::<PyResult<Vec<_>>>()?)?;
    fields.ended(None)
}

/// A curve for Python.
fn described_curve<'py>(
    py: Python<'py>,
    states: usize,
    (begins, curve): (usize, Option<&EquilibriumCurve>),
) -> PyResult<Bound<'py, PyDict>> {
    let points = curve.map_or(&[][..], |curve| &curve.points);
    let own = |x: &[f64]| x.iter().take(states).copied().collect::<Vec<f64>>();
    let fields = Fields::new(py);
    fields.put("begins", begins)?;
    fields.numbers("other", points.iter().map(|at| at.parameters[0]))?;
    fields.numbers("parameter", points.iter().map(|at| at.parameters[1]))?;
    fields.optional_numbers("frequency", points.iter().map(|at| at.frequency))?;
    let y = points.iter().flat_map(|at| own(at.x.as_slice()));
    fields.array("y", y.collect(), [states])?;
    let special = curve.map_or(&[][..], |curve| &curve.special);
    let table = Fields::new(py);
    table.texts("name", special.iter().map(|at| at.what.to_string()))?;
    table.numbers("parameter", special.iter().map(|at| at.parameters[1]))?;
    table.numbers("other", special.iter().map(|at| at.parameters[0]))?;
    table.numbers("uncertainty", special.iter().map(|at| at.uncertainties[1]))?;
    let of_other = special.iter().map(|at| at.uncertainties[0]);
    table.numbers("other_uncertainty", of_other)?;
    let y = special.iter().flat_map(|at| own(at.x.as_slice()));
    table.array("y", y.collect(), [states])?;
    table.integers("behind", special.iter().map(|at| at.behind as i64))?;
    fields.fields("special", table)?;
    let stops = curve.map(|curve| curve.stops.map(word_of_curve_stop));
    fields.put("stops", stops.map(|[first, last]| (first, last)))?;
    fields.ended(None)
}

/// A branch for Python.
fn described<'py>(
    py: Python<'py>,
    system: &CompiledSystem,
    branch: &EquilibriaOfBranch,
) -> PyResult<Fields<'py>> {
    let states = system.states();
    let EquilibriaOfBranch {
        points,
        special,
        stops,
        ..
    } = branch;
    // The last component is the parameter.
    let own = |x: &[f64]| x.iter().take(states).copied().collect::<Vec<f64>>();
    let fields = Fields::new(py);
    fields.numbers("parameter", points.iter().map(|at| at.parameter))?;
    let y = points.iter().flat_map(|at| own(at.x.as_slice()));
    fields.array("y", y.collect(), [states])?;
    fields.texts("mode", points.iter().map(|at| system.letters(&at.mode)))?;
    let eigenvalues = points.iter().map(|at| complex(py, &at.eigenvalues));
    fields.texts("eigenvalues", eigenvalues)?;
    let stability = points.iter().map(|at| at.stability().to_string());
    fields.texts("stability", stability)?;
    let words = stops.each_ref().map(|stop| BranchEnd::from(stop).word);
    fields.put("stops", (words[0], words[1]))?;
    let boundaries = || special.iter().map(|at| boundary_of(at, system));
    let table = Fields::new(py);
    table.texts("name", special.iter().map(|at| at.what.to_string()))?;
    table.numbers("parameter", special.iter().map(|at| at.parameter))?;
    table.numbers("uncertainty", special.iter().map(|at| at.uncertainty))?;
    table.optional_numbers("frequency", special.iter().map(frequency_of))?;
    table.texts("contact", boundaries().map(|(contact, _)| contact))?;
    table.texts("before", boundaries().map(|(_, [before, _])| before))?;
    table.texts("after", boundaries().map(|(_, [_, after])| after))?;
    let y = special.iter().flat_map(|at| own(at.x.as_slice()));
    table.array("y", y.collect(), [states])?;
    table.integers("behind", special.iter().map(|at| at.behind as i64))?;
    fields.fields("special", table)?;
    Ok(fields)
}
