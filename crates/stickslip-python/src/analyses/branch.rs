//! The branch of periodic orbits along a parameter.

use std::ops::ControlFlow;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use stickslip::Options;
use stickslip::analysis::{
    ContinuationSettings, CycleBifurcation, PartialBranch, PeriodicOrbit, SpecialPoint,
};
use stickslip::dynamics::Vector;
use stickslip_kernels::file::System as CompiledSystem;
use stickslip_kernels::kernel::Change;
use stickslip_kernels::study::{Along, BranchEnd, DirectedBranch, WholeBranch, only_once};

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
    (orbit, x): (&PeriodicOrbit, &[f64]),
    is_upwards: bool,
    (settings, options): (&ContinuationSettings, &Options),
    task: &Task,
) -> Result<DirectedBranch, Failure> {
    let (mut extremes, mut failure) = (Vec::new(), None);
    let observe = |branch: &PartialBranch| {
        for point in &branch.points()[extremes.len()..] {
            let found = along.extremes::<Failure>(point, options);
            match found {
                _ if task.is_stopped() => return ControlFlow::Break(()),
                Ok(found) => extremes.push(found),
                Err(error) => {
                    failure = Some(error);
                    return ControlFlow::Break(());
                }
            }
        }
        task.count();
        ControlFlow::Continue(())
    };
    let dynamics = &along.dynamics;
    let begun = PartialBranch::begin(dynamics, x, orbit.period, is_upwards, settings, options)?;
    let mut branch = begun.follow(dynamics, settings, options, observe)?;
    if let Some(failure) = failure {
        return Err(failure);
    }
    // The observer does not see the last orbit.
    for point in &branch.points[extremes.len()..] {
        match along.extremes::<Failure>(point, options) {
            _ if task.is_stopped() => break,
            found => extremes.push(found?),
        }
    }
    if task.is_stopped() {
        branch.points.truncate(extremes.len());
        branch.special.retain(|at| at.behind < extremes.len());
    }
    Ok((branch, extremes))
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
    let (step, most_points) = how;
    let (compiled, options) = (&system.compiled, settings.options()?);
    let outcome = computed(py, 2, (&report, ProgressKind::Count), |task| {
        let system = task.system(compiled)?;
        let along = Along::new(&system, &parameter, (low, high))?;
        let mut settings = ContinuationSettings {
            step,
            most_points,
            ..ContinuationSettings::over(low, high)
        };
        settings.check()?;
        let orbit = approached(&system, (t, &x), search, &options)?;
        settings.forced = system.built.depends_on_time.then_some(orbit.period);
        let x = along.at_zero(&orbit, &options)?;
        let begin = (&orbit, &*[x.as_slice(), &[along.value]].concat());
        let directed =
            |is_upwards| directed_branch(&along, begin, is_upwards, (&settings, &options), task);
        let (down, up) = rayon::join(|| directed(false), || directed(true));
        let ((mut down, low), (mut up, high)) = (down?, up?);
        only_once(&mut down, &mut up);
        Ok::<_, Failure>(along.joined([(down, low), (up, high)])?)
    })?;
    let (branch, raised) = match outcome.found {
        Ok(branch) => (branch, outcome.raised),
        // Before the branch begins nothing is kept.
        Err(error) => return Err(outcome.raised.unwrap_or_else(|| error.raised(compiled))),
    };
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
    let [first, last] = branch.stops.each_ref().map(BranchEnd::from);
    fields.put("stops", (first.word, last.word))?;
    let end = |end: BranchEnd, before: usize| {
        let row = end.bifurcation.map(|end| Row {
            name: end.name.to_owned(),
            parameter: end.parameter,
            uncertainty: end.uncertainty,
            period: end.period,
            phases: [String::new(), String::new()],
            x: Vector::from_element(states, f64::NAN),
            before,
        });
        row.into_iter()
    };
    let special = branch.special.iter().map(|at| Row::of(at, system));
    let special = end(first, 0).chain(special);
    let special: Vec<Row> = special.chain(end(last, branch.points.len())).collect();
    let table = Fields::new(py);
    table.texts("name", special.iter().map(|at| &at.name))?;
    table.numbers("parameter", special.iter().map(|at| at.parameter))?;
    table.optional_numbers("uncertainty", special.iter().map(|at| at.uncertainty))?;
    table.optional_numbers("period", special.iter().map(|at| at.period))?;
    table.texts("before", special.iter().map(|at| &at.phases[0]))?;
    table.texts("after", special.iter().map(|at| &at.phases[1]))?;
    table.rows("y", special.iter().map(|at| &at.x), states)?;
    table.integers("behind", special.iter().map(|at| at.before as i64))?;
    fields.fields("special", table)?;
    Ok(fields)
}

/// A special orbit, or a bifurcation in which the branch ends.
struct Row {
    name: String,
    parameter: f64,
    uncertainty: Option<f64>,
    period: Option<f64>,
    phases: [String; 2],
    x: Vector,
    /// Number of orbits of the branch before it.
    before: usize,
}

impl Row {
    fn of(at: &SpecialPoint, system: &CompiledSystem) -> Self {
        let (name, phases) = match &at.what {
            CycleBifurcation::Sequence(change) => (
                Change::from(&**change).name(),
                [&change.before, &change.after].map(|phases| system.sequence(phases)),
            ),
            other => (other.to_string(), [String::new(), String::new()]),
        };
        Row {
            name,
            parameter: at.parameter,
            uncertainty: Some(at.uncertainty),
            period: Some(at.period),
            phases,
            x: at.x.clone(),
            before: at.behind,
        }
    }
}
