//! The branch of periodic orbits along a parameter.

use std::ops::ControlFlow;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use stickslip::analysis::{Branch, ContinuationSettings, PartialBranch, PeriodicOrbit};
use stickslip::dynamics::Vector;
use stickslip::{Error, Options};
use stickslip_model::file::System as CompiledSystem;
use stickslip_model::study::{Along, WholeBranch};

use super::Start;
use super::orbits::{Search, approached};
use crate::errors::Failure;
use crate::fields::{Fields, complex};
use crate::task::{ProgressKind, Report, Task, computed};
use crate::{Settings, System};

/// Follows the branch through an orbit in one direction. After an interruption it is what was found
/// before, since results that are computed during one are unreliable.
fn directed_branch(
    along: &Along<'_>,
    (orbit, x): (&PeriodicOrbit, &Vector),
    is_upwards: bool,
    (settings, options): (&ContinuationSettings, &Options),
    task: &Task,
) -> Result<Branch, Error> {
    let mut reliable = 0;
    let observe = |branch: &PartialBranch| {
        if task.is_stopped() {
            return ControlFlow::Break(());
        }
        reliable = branch.points().len();
        task.count();
        ControlFlow::Continue(())
    };
    let dynamics = &along.dynamics;
    let begun = PartialBranch::begin(dynamics, x, orbit.period, is_upwards, settings, options)?;
    let mut branch = begun.follow(dynamics, settings, options, observe)?;
    if task.is_stopped() {
        branch.points.truncate(reliable);
        branch.special.retain(|at| at.behind < reliable);
    }
    Ok(branch)
}

/// Settings of a continuation over a range, with the longest step and the most points.
pub(super) fn continuation_settings(
    (low, high): (f64, f64),
    (step, most_points): (f64, usize),
) -> Result<ContinuationSettings, Error> {
    let settings = ContinuationSettings {
        step,
        most_points,
        ..ContinuationSettings::over(low, high)
    };
    settings.check()?;
    Ok(settings)
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
    start: Start,
    search: Search,
    range: (String, f64, f64),
    how: (f64, usize),
    settings: Settings,
    report: Report,
) -> PyResult<Bound<'py, PyDict>> {
    let (t, x) = start;
    let (parameter, low, high) = range;
    let (compiled, options) = (&system.compiled, settings.options()?);
    let outcome = computed(py, 2, (&report, ProgressKind::Count), |task| {
        let system = task.system(compiled)?;
        let along = Along::new(&system, &parameter, (low, high))?;
        let settings = continuation_settings((low, high), how)?;
        let orbit = approached(&system, (t, &x), search, &options)?;
        let (settings, x) = along.start(&orbit, &settings, &options, None)?;
        let begin = (&orbit, &x);
        let directed =
            |is_upwards| directed_branch(&along, begin, is_upwards, (&settings, &options), task);
        let (down, up) = rayon::join(|| directed(false), || directed(true));
        // An interruption leaves the orbits that were found.
        let whole = Along::new(compiled, &parameter, (low, high))?;
        whole.joined::<Failure>([down?, up?], &options)
    })?;
    let (branch, raised) = outcome.kept(|error| error.raised(compiled))?;
    described(py, compiled, &branch)?.ended(raised)
}

/// A branch for Python.
fn described<'py>(
    py: Python<'py>,
    system: &CompiledSystem,
    branch: &WholeBranch,
) -> PyResult<Fields<'py>> {
    let states = system.states();
    let orbits = || branch.points.iter().map(|point| &point.orbit);
    let fields = Fields::new(py);
    fields.numbers("parameter", orbits().map(|at| at.parameter))?;
    fields.numbers("period", orbits().map(|at| at.period))?;
    fields.numbers("t", orbits().map(|at| at.t))?;
    fields.rows("y", orbits().map(|at| &at.x), states)?;
    let extremes = || branch.points.iter().flat_map(|point| &point.extremes);
    fields.array("y_min", extremes().map(|at| at.0).collect(), [states])?;
    fields.array("y_max", extremes().map(|at| at.1).collect(), [states])?;
    let multipliers = orbits().map(|at| complex(py, &at.multipliers));
    fields.texts("multipliers", multipliers)?;
    fields.texts("stability", orbits().map(|at| at.stability().to_string()))?;
    fields.texts("phases", orbits().map(|at| system.sequence(&at.sequence)))?;
    let [first, last] = branch.ends();
    fields.put("stops", (first.word, last.word))?;
    let special = branch.special_rows(system);
    let table = Fields::new(py);
    table.texts("name", special.iter().map(|at| &at.name))?;
    table.numbers("parameter", special.iter().map(|at| at.parameter))?;
    table.optional_numbers("uncertainty", special.iter().map(|at| at.uncertainty))?;
    table.optional_numbers("period", special.iter().map(|at| at.period))?;
    table.texts("before", special.iter().map(|at| &at.phases[0]))?;
    table.texts("after", special.iter().map(|at| &at.phases[1]))?;
    let nowhere = vec![f64::NAN; states];
    let y = special.iter().flat_map(|at| match at.x.is_empty() {
        true => &nowhere,
        false => &at.x,
    });
    table.array("y", y.copied().collect(), [states])?;
    table.integers("behind", special.iter().map(|at| at.behind as i64))?;
    fields.fields("special", table)?;
    Ok(fields)
}
