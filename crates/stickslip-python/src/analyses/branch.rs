//! The branch of periodic orbits along a parameter.

use std::num::NonZeroUsize;
use std::ops::ControlFlow;

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use stickslip::analysis::{
    Branch, ContinuationSettings, Curve, PartialBranch, PeriodicOrbit, SpecialPoint,
};
use stickslip::dynamics::Vector;
use stickslip::{Error, Options};
use stickslip_model::file::System as CompiledSystem;
use stickslip_model::study::{
    Followed, ParameterLine, SideBranch, TwoSidedBranch, word_of_curve_stop,
};

use super::Start;
use super::orbits::{Search, approached};
use crate::errors::Failure;
use crate::fields::{Fields, complex};
use crate::task::{ProgressKind, Report, Task, computed};
use crate::{Settings, System};

/// Follows the branch through an orbit in one direction. After an interruption it is what was found
/// before, since results that are computed during one are unreliable.
fn directed_branch(
    along: &ParameterLine<'_>,
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
    also: Option<(String, f64, f64)>,
    branches: Option<NonZeroUsize>,
    settings: Settings,
    report: Report,
) -> PyResult<Bound<'py, PyDict>> {
    let (t, x) = start;
    let (parameter, low, high) = range;
    let compiled = &system.compiled;
    let options = settings.options(compiled)?;
    // A branch has two directions, and what begins on it may take all threads.
    let threads = if also.is_some() || branches.is_some() {
        0
    } else {
        2
    };
    let outcome = computed(py, threads, (&report, ProgressKind::Count), |task| {
        let system = task.system(compiled)?;
        let along = ParameterLine::new(&system, &parameter, (low, high))?;
        let settings = continuation_settings((low, high), how)?;
        let orbit = approached(&system, (t, &x), search, &options)?;
        let (forced, x) = along.start(&orbit, &settings, &options, None)?;
        let begin = (&orbit, &x);
        let directed =
            |is_upwards| directed_branch(&along, begin, is_upwards, (&forced, &options), task);
        let (down, up) = rayon::join(|| directed(false), || directed(true));
        // An interruption leaves the orbits that were found.
        let whole = ParameterLine::new(compiled, &parameter, (low, high))?;
        let mut branch = whole.joined::<Failure>([down?, up?], &options)?;
        along.find_uncertainties(&mut branch, &options);
        let mut begun = Begun {
            branch,
            others: Vec::new(),
            curves: Vec::new(),
        };
        if let Some(depth) = branches
            && !task.is_stopped()
        {
            let how = (&forced, depth, &options);
            begun.others = others(&along, &begun.branch, how, begin)?;
        }
        if let Some((name, low, high)) = &also
            && !task.is_stopped()
        {
            let second = Second {
                name,
                range: (*low, *high),
                system: &system,
            };
            begun.curves = curves(
                &along,
                &begun.branch,
                (&settings, &options),
                &orbit,
                &second,
            )?;
        }
        Ok::<_, Failure>(begun)
    })?;
    let (begun, raised) = outcome.kept(|error| error.raised(compiled))?;
    let fields = described(py, compiled, &begun.branch)?;
    let others = begun.others.iter().map(|one| {
        let other = described(py, compiled, &one.branch)?;
        other.put("parent", one.parent)?;
        other.put("begins", one.from)?;
        other.put("to", one.to)?;
        other.ended(None)
    });
    fields.put("branches", others.collect::<PyResult<Vec<_>>>()?)?;
    let curves = begun.curves.iter();
    let curves = curves.map(|(from, curve)| described_curve(py, compiled, *from, curve.as_ref()));
    fields.put("curves", curves.collect::<PyResult<Vec<_>>>()?)?;
    fields.ended(raised)
}

/// A branch, and what begins at its special orbits: curves with the row of that orbit.
struct Begun {
    branch: TwoSidedBranch,
    others: Vec<SideBranch>,
    curves: Vec<(usize, Option<Curve>)>,
}

/// A second parameter.
struct Second<'a> {
    name: &'a str,
    range: (f64, f64),
    system: &'a CompiledSystem,
}

/// The branches that begin at flips and branch points, and at their flips to a depth.
fn others(
    along: &ParameterLine<'_>,
    branch: &TwoSidedBranch,
    (settings, depth, options): (&ContinuationSettings, NonZeroUsize, &Options),
    (orbit, x): (&PeriodicOrbit, &Vector),
) -> Result<Vec<SideBranch>, Failure> {
    let junctions: Vec<usize> = branch.junctions().map(|(from, _)| from).collect();
    let switched = junctions.par_iter().enumerate().map(|(k, &from)| {
        let how = (settings, depth);
        let switched = along.switched((orbit.period, x), (branch, k), how, options)?;
        Ok::<_, Failure>(switched.map(|switched| (from, switched)))
    });
    let switched = switched.collect::<Result<Vec<_>, Failure>>()?;
    along.side_branches(branch, switched.into_iter().flatten().collect(), options)
}

/// The curves of the special orbits in two parameters, except branch points, and of homoclinic and
/// two-fold ends, with their rows in the table of special orbits.
fn curves(
    along: &ParameterLine<'_>,
    branch: &TwoSidedBranch,
    (settings, options): (&ContinuationSettings, &Options),
    orbit: &PeriodicOrbit,
    second: &Second<'_>,
) -> Result<Vec<(usize, Option<Curve>)>, Failure> {
    let number = second.system.file.parameter(second.name)?;
    let value = second.system.values[number];
    let both = second.system.with_states_of(&[number, along.number])?;
    let (settings, x) = along.start(orbit, settings, options, Some(value))?;
    let curve = |(which, _): (Followed, SpecialPoint)| {
        let both = (&both, second.range);
        let from = (orbit.period, &x);
        let curve = along.curve(both, from, (branch, which), &settings, options)?;
        Ok((branch.row_of(which), curve))
    };
    branch.followed().into_par_iter().map(curve).collect()
}

/// A curve for Python.
fn described_curve<'py>(
    py: Python<'py>,
    system: &CompiledSystem,
    begins: usize,
    curve: Option<&Curve>,
) -> PyResult<Bound<'py, PyDict>> {
    let states = system.states();
    let points = curve.map_or(&[][..], |curve| &curve.points);
    let fields = Fields::new(py);
    fields.put("begins", begins)?;
    fields.numbers("other", points.iter().map(|at| at.parameters[0]))?;
    fields.numbers("parameter", points.iter().map(|at| at.parameters[1]))?;
    fields.optional_numbers("uncertainty", points.iter().map(|at| at.uncertainty))?;
    fields.numbers("period", points.iter().map(|at| at.period))?;
    fields.numbers("t", points.iter().map(|at| at.t))?;
    let own = points
        .iter()
        .flat_map(|at| at.x.iter().take(states).copied());
    fields.array("y", own.collect(), [states])?;
    let special = curve.map_or(&[][..], |curve| &curve.special);
    let table = Fields::new(py);
    table.texts("name", special.iter().map(|at| at.what.to_string()))?;
    table.numbers("parameter", special.iter().map(|at| at.parameters[1]))?;
    table.numbers("other", special.iter().map(|at| at.parameters[0]))?;
    table.numbers("uncertainty", special.iter().map(|at| at.uncertainties[1]))?;
    table.numbers(
        "other_uncertainty",
        special.iter().map(|at| at.uncertainties[0]),
    )?;
    table.numbers("period", special.iter().map(|at| at.period))?;
    table.numbers("t", special.iter().map(|at| at.t))?;
    let y = special
        .iter()
        .flat_map(|at| at.x.iter().take(states).copied());
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
    branch: &TwoSidedBranch,
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
    let uncertainties = branch.points.iter().map(|point| &point.uncertainties);
    let uncertainties = uncertainties.map(|all| PyArray1::from_slice(py, all));
    fields.texts("multiplier_uncertainties", uncertainties)?;
    fields.texts("stability", orbits().map(|at| at.stability().to_string()))?;
    fields.texts("phases", orbits().map(|at| system.sequence(&at.sequence)))?;
    let [first, last] = branch.ends();
    fields.put("stops", (first.word, last.word))?;
    let special = branch.special_rows(system);
    // The first row may be an end of the branch.
    fields.put("first_special", usize::from(first.bifurcation.is_some()))?;
    let table = Fields::new(py);
    table.texts("name", special.iter().map(|at| &at.name))?;
    table.numbers("parameter", special.iter().map(|at| at.parameter))?;
    table.optional_numbers("uncertainty", special.iter().map(|at| at.uncertainty))?;
    table.optional_numbers("period", special.iter().map(|at| at.period))?;
    table.texts("contacts", special.iter().map(|at| &at.contacts))?;
    table.optional_numbers("angle", special.iter().map(|at| at.angle))?;
    table.texts("criticality", special.iter().map(|at| &at.criticality))?;
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
