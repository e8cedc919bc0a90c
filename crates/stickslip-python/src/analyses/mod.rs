//! The analyses, a module for each family. Each function calls the library and returns numbers,
//! texts and arrays.

mod attractors;
mod basins;
mod branch;
mod equilibria;
mod exponents;
mod fits;
mod orbits;
mod tangents;

use pyo3::prelude::*;

/// Time and state at the start.
type Start = (f64, Vec<f64>);

/// Adds the functions to the module.
pub(crate) fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(orbits::periodic_orbit, module)?)?;
    module.add_function(wrap_pyfunction!(orbits::poincare_map, module)?)?;
    module.add_function(wrap_pyfunction!(branch::continuation, module)?)?;
    module.add_function(wrap_pyfunction!(
        equilibria::equilibrium_continuation,
        module
    )?)?;
    module.add_function(wrap_pyfunction!(tangents::tangents, module)?)?;
    module.add_function(wrap_pyfunction!(fits::fit, module)?)?;
    module.add_function(wrap_pyfunction!(exponents::lyapunov_spectrum, module)?)?;
    module.add_function(wrap_pyfunction!(exponents::lyapunov_from_data, module)?)?;
    module.add_function(wrap_pyfunction!(attractors::bifurcation_diagram, module)?)?;
    module.add_function(wrap_pyfunction!(attractors::parameter_map, module)?)?;
    module.add_function(wrap_pyfunction!(attractors::share_error, module)?)?;
    module.add_function(wrap_pyfunction!(attractors::basins, module)?)?;
    module.add_function(wrap_pyfunction!(basins::basin_entropy, module)?)?;
    module.add_function(wrap_pyfunction!(basins::uncertainty_exponent, module)?)?;
    module.add_function(wrap_pyfunction!(basins::least_push, module)?)?;
    module.add_function(wrap_pyfunction!(basins::edge_state, module)?)?;
    module.add_function(wrap_pyfunction!(basins::basin_shares, module)?)
}
