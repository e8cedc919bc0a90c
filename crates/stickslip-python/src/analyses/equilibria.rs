//! The branch of equilibria along a parameter.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use stickslip_model::file::System as CompiledSystem;
use stickslip_model::study::{
    Along, BranchEnd, EquilibriaOfBranch, boundary_of, equilibrium, frequency_of,
};

use super::branch::continuation_settings;
use crate::errors::Failure;
use crate::fields::{Fields, complex};
use crate::task::{ProgressKind, computed};
use crate::{Settings, System};

/// The branch of equilibria through the one that the orbit from a start approaches, in both
/// directions.
#[pyfunction]
pub(crate) fn equilibrium_continuation<'py>(
    py: Python<'py>,
    system: &System,
    x: Vec<f64>,
    transient: Option<f64>,
    range: (String, f64, f64),
    how: (f64, usize),
    settings: Settings,
) -> PyResult<Bound<'py, PyDict>> {
    let (parameter, low, high) = range;
    let compiled = &system.compiled;
    let options = settings.options(compiled)?;
    let branch = computed(py, 1, (&None, ProgressKind::Count), |task| {
        let system = task.system(compiled)?;
        let along = Along::new(&system, &parameter, (low, high))?;
        let settings = continuation_settings((low, high), how)?;
        let x = equilibrium(&system, &x, transient, &options)?;
        Ok(along.equilibria(&x, &settings, &options)?)
    })?;
    let branch = branch.whole(|error: Failure| error.raised(compiled))?;
    described(py, compiled, &branch)?.ended(None)
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
