//! Basins in numbers: boundaries, pushes out of basins, edge states, shares along a parameter.

use std::ops::ControlFlow;

use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use stickslip::analysis::{
    Attractor, EdgeKind, EdgeSettings, EdgeState, Push, PushSettings, SharesAt,
};
use stickslip::dynamics::Vector;
use stickslip_model::file::System as CompiledSystem;
use stickslip_model::study::{recurrence, reported};

use super::attractors::{check, outcomes};
use crate::errors::{Failure, failed, words};
use crate::fields::Fields;
use crate::task::{ProgressKind, Report, computed};
use crate::{Settings, System};

/// Rows of starts as vectors.
fn rows(starts: &PyReadonlyArray2<'_, f64>) -> Vec<Vector> {
    let starts = starts.as_array();
    let states = starts.ncols();
    let each = starts.rows().into_iter();
    each.map(|row| Vector::from_iterator(states, row.iter().copied()))
        .collect()
}

/// Basin entropies of a grid of numbers of attractors, with their standard errors.
#[pyfunction]
pub(crate) fn basin_entropy<'py>(
    py: Python<'py>,
    reached: Vec<usize>,
    shape: Vec<usize>,
    side: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let found = stickslip::analysis::BasinEntropy::of(&reached, &shape, side);
    let found = found.map_err(|error| failed(&error, None))?;
    let fields = Fields::new(py);
    fields.put("boxes", found.boxes)?;
    fields.put("boundary_boxes", found.boundary_boxes)?;
    fields.put("sb", found.entropy)?;
    fields.put("sb_std_error", found.entropy_error)?;
    fields.put("sbb", found.boundary_entropy.unwrap_or(f64::NAN))?;
    let error = found.boundary_entropy_error.unwrap_or(f64::NAN);
    fields.put("sbb_std_error", error)?;
    fields.put("shows_fractal", found.shows_fractal())?;
    fields.ended(None)
}

/// The uncertainty exponent of a grid of numbers of attractors; NaN without a boundary.
#[pyfunction]
pub(crate) fn uncertainty_exponent<'py>(
    py: Python<'py>,
    reached: Vec<usize>,
    shape: Vec<usize>,
) -> PyResult<Bound<'py, PyDict>> {
    let found = stickslip::analysis::UncertaintyExponent::of(&reached, &shape);
    let found = found.map_err(|error| failed(&error, None))?;
    let fields = Fields::new(py);
    let number = |of: Option<f64>| of.unwrap_or(f64::NAN);
    let one = found.as_ref();
    fields.put("exponent", number(one.map(|one| one.exponent)))?;
    fields.put("std_error", number(one.map(|one| one.std_error)))?;
    fields.put("dimension", number(one.map(|one| one.dimension)))?;
    let fractions = || one.iter().flat_map(|one| &one.fractions);
    fields.integers("steps", fractions().map(|(step, _)| *step as i64))?;
    fields.numbers("uncertain", fractions().map(|(_, fraction)| *fraction))?;
    fields.ended(None)
}

/// Least pushes from a state along directions, with what lies beyond.
#[pyfunction]
pub(crate) fn least_push<'py>(
    py: Python<'py>,
    system: &System,
    x: Vec<f64>,
    directions: PyReadonlyArray2<'py, f64>,
    how: (f64, usize, f64, usize),
    settings: Settings,
    report: Report,
) -> PyResult<Bound<'py, PyDict>> {
    let (largest, parts, longest, workers) = how;
    let compiled = &system.compiled;
    let options = settings.options(compiled)?;
    check(compiled, longest)?;
    let settings = recurrence(compiled, longest);
    let directions = rows(&directions);
    let how = PushSettings { largest, parts };
    let outcome = computed(py, workers, (&report, ProgressKind::Count), |task| {
        let system = task.system(compiled)?;
        let each = directions.par_iter().map(|direction| {
            let along = [direction.clone()];
            let found = Push::least(system.dynamics(), &*x, along, &how, &settings, &options)?;
            task.count();
            Ok(found)
        });
        let found = each.collect::<Result<Vec<_>, stickslip::Error>>()?;
        Ok(found.into_iter().flatten().collect::<Vec<_>>())
    })?;
    let found = outcome.whole(|error: Failure| error.raised(compiled))?;
    let fields = Fields::new(py);
    let all = || found.iter().map(Option::as_ref);
    // A ray that ends at a stop leads out of no basin.
    let out = || all().map(|one| one.filter(|one| !one.ends_at_stop));
    fields.optional_numbers("size", out().map(|one| Some(one?.size)))?;
    fields.optional_numbers("uncertainty", out().map(|one| Some(one?.uncertainty)))?;
    let kind = |one: &Push| match one.ends_at_stop {
        true => "stop",
        false => one.beyond.kind.word(),
    };
    let kinds = all().map(|one| one.map_or("", kind));
    fields.texts("beyond", kinds)?;
    let nowhere = Vector::from_element(compiled.states(), f64::NAN);
    let state = |one: Option<&Push>| {
        let state = one.and_then(|one| Some(one.beyond.points.first()?.x.clone()));
        state.unwrap_or_else(|| nowhere.clone())
    };
    let states: Vec<Vector> = all().map(state).collect();
    fields.rows("y_beyond", &states, compiled.states())?;
    fields.ended(None)
}

/// The edge state between the basins of two states.
#[pyfunction]
pub(crate) fn edge_state<'py>(
    py: Python<'py>,
    system: &System,
    states: [Vec<f64>; 2],
    how: (f64, f64, f64, f64),
    settings: Settings,
    report: Report,
) -> PyResult<Bound<'py, PyDict>> {
    let (near, apart, track, longest) = how;
    let compiled = &system.compiled;
    let options = settings.options(compiled)?;
    check(compiled, longest)?;
    let settings = recurrence(compiled, longest);
    let how = EdgeSettings {
        near,
        apart,
        longest: track,
    };
    let outcome = computed(py, 1, (&report, ProgressKind::Count), |task| {
        let system = task.system(compiled)?;
        let [one, other] = &states;
        let dynamics = system.dynamics();
        Ok(EdgeState::between(
            dynamics, &**one, &**other, &how, &settings, &options,
        )?)
    })?;
    let found = outcome.whole(|error: Failure| error.raised(compiled))?;
    let fields = Fields::new(py);
    let (kind, period) = match found.kind {
        EdgeKind::Equilibrium => ("equilibrium", f64::NAN),
        EdgeKind::Periodic { period } => ("periodic", period),
        EdgeKind::Undecided => ("undecided", f64::NAN),
    };
    fields.put("kind", kind)?;
    fields.put("period", period)?;
    fields.numbers("y", found.x.iter().copied())?;
    fields.put("unstable", found.unstable)?;
    fields.put("bisections", found.bisections)?;
    fields.numbers("t", found.track.iter().map(|at| at.t))?;
    let track = found.track.iter().map(|at| &at.x);
    fields.rows("track", track, compiled.states())?;
    let beside: Vec<&str> = found.beside.iter().map(|one| one.kind.word()).collect();
    fields.put("beside", (beside[0], beside[1]))?;
    fields.ended(None)
}

/// Shares of basins at values of a parameter, from the same starts.
#[pyfunction]
pub(crate) fn basin_shares<'py>(
    py: Python<'py>,
    system: &System,
    starts: PyReadonlyArray2<'py, f64>,
    along: (String, Vec<f64>),
    how: (f64, usize),
    settings: Settings,
    report: Report,
) -> PyResult<Bound<'py, PyDict>> {
    let ((parameter, values), (longest, workers)) = (along, how);
    let compiled = &system.compiled;
    let options = settings.options(compiled)?;
    check(compiled, longest)?;
    let starts = rows(&starts);
    let outcome = computed(py, workers, (&report, ProgressKind::Count), |task| {
        let mut found: Vec<SharesAt> = Vec::new();
        let follow = || -> Result<(), Failure> {
            let system = task.system(compiled)?;
            let mut earlier: Option<CompiledSystem> = None;
            for value in values {
                let here = system.driven_with(&[(&parameter, value)])?;
                let settings = recurrence(&here, longest);
                let before = earlier
                    .as_ref()
                    .map(CompiledSystem::dynamics)
                    .zip(found.last());
                let go_on = || match task.is_stopped() {
                    true => ControlFlow::Break(()),
                    false => ControlFlow::Continue(()),
                };
                let next = SharesAt::of(
                    here.dynamics(),
                    value,
                    &starts,
                    before,
                    (&settings, &options),
                    go_on,
                )?;
                let Some(next) = next.filter(|_| !task.is_stopped()) else {
                    break;
                };
                found.push(next);
                earlier = Some(here);
                task.count();
            }
            Ok(())
        };
        let ended = follow();
        (found, ended)
    })?;
    let (found, raised) = outcome.partial(|error: Failure| error.raised(compiled))?;
    let fields = Fields::new(py);
    fields.numbers("parameter", found.iter().map(|at| at.parameter))?;
    let all = || {
        let each = found.iter().enumerate();
        each.flat_map(|(k, at)| (0..at.attractors.len()).map(move |number| (k, at, number)))
    };
    fields.integers("value", all().map(|(k, ..)| k as i64))?;
    fields.integers("band", all().map(|(_, at, number)| at.bands[number] as i64))?;
    fields.integers(
        "starts",
        all().map(|(_, at, number)| at.starts[number] as i64),
    )?;
    let share = |(_, at, number): (usize, &SharesAt, usize)| at.share(number);
    fields.numbers("share", all().map(share).map(|share| share.part))?;
    fields.numbers("std_error", all().map(share).map(|share| share.std_error))?;
    let reached = |(_, at, number): (usize, &SharesAt, usize)| at.attractors[number].clone();
    let attractors = all().map(reached);
    let attractors = attractors.map(|one| reported(one, |error| words(error, compiled)));
    let attractors: Vec<Attractor> = attractors.collect();
    outcomes(&fields, compiled, attractors.iter())?;
    fields.ended(raised)
}
