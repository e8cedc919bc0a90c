//! The branch of equilibria along a parameter.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use stickslip::analysis::{
    ContinuationSettings, EquilibriumBifurcation, SpecialEquilibrium, continue_equilibrium,
};
use stickslip_kernels::file::System as CompiledSystem;
use stickslip_kernels::study::{Along, BranchEnd, EquilibriaOfBranch, equilibrium};

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
    let (step, most_points) = how;
    let (compiled, options) = (&system.compiled, settings.options()?);
    let branch = computed(py, 2, (&None, ProgressKind::Count), |task| {
        let system = task.system(compiled)?;
        let along = Along::new(&system, &parameter, (low, high))?;
        let settings = ContinuationSettings {
            step,
            most_points,
            ..ContinuationSettings::over(low, high)
        };
        settings.check()?;
        let x = equilibrium(&system, &x, transient, &options)?;
        let x = [x.as_slice(), &[along.value]].concat();
        let direction = |is_upwards| {
            continue_equilibrium(&along.dynamics, &*x, is_upwards, &settings, &options)
        };
        let (down, up) = rayon::join(|| direction(false), || direction(true));
        Ok(EquilibriaOfBranch::joined([down?, up?]))
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
    let boundaries = || special.iter().map(|at| Boundary::of(at, system));
    let table = Fields::new(py);
    table.texts("name", special.iter().map(|at| at.what.to_string()))?;
    table.numbers("parameter", special.iter().map(|at| at.parameter))?;
    table.numbers("uncertainty", special.iter().map(|at| at.uncertainty))?;
    let frequencies = special.iter().map(|at| match at.what {
        EquilibriumBifurcation::Hopf { frequency } => Some(frequency),
        _ => None,
    });
    table.optional_numbers("frequency", frequencies)?;
    table.texts("contact", boundaries().map(|at| at.contact))?;
    table.texts("before", boundaries().map(|at| at.modes[0].clone()))?;
    table.texts("after", boundaries().map(|at| at.modes[1].clone()))?;
    let y = special.iter().flat_map(|at| own(at.x.as_slice()));
    table.array("y", y.collect(), [states])?;
    table.integers("behind", special.iter().map(|at| at.behind as i64))?;
    fields.fields("special", table)?;
    Ok(fields)
}

/// The contact on whose boundary a special equilibrium lies, and the modes on both sides of it; all
/// empty for another one.
#[derive(Default)]
struct Boundary {
    contact: String,
    modes: [String; 2],
}

impl Boundary {
    fn of(at: &SpecialEquilibrium, system: &CompiledSystem) -> Self {
        match &at.what {
            EquilibriumBifurcation::Boundary {
                contact,
                before,
                after,
                ..
            } => Boundary {
                contact: system.contact_name(*contact),
                modes: [
                    system.letters(before),
                    after.map_or_else(String::new, |after| system.letters(&after)),
                ],
            },
            _ => Boundary::default(),
        }
    }
}
