//! Parameters and starts fitted to measured motion.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use stickslip::dynamics::Modes;
use stickslip_model::file::System as CompiledSystem;
use stickslip_model::study::fit::{
    Fit, FitError, FitRequest, Observable, Record, SeenPhase, Unknown, ending, fit as fitted,
};
use stickslip_model::study::least_squares::{LeastSquaresEnd, Loss};

use crate::errors::{computation, failed, words, wrong};
use crate::fields::Fields;
use crate::task::{ProgressKind, computed};
use crate::{Settings, System};

/// Times, columns, parameters and starts of one record, its start time, and tables of its inputs.
type RecordOf = (
    Vec<f64>,
    Vec<Vec<f64>>,
    Vec<(String, f64)>,
    Vec<(String, f64)>,
    Option<f64>,
    Vec<(String, Vec<f64>, Vec<f64>)>,
);

/// Fits unknowns, each a name, a start, two bounds and whether each record has its own, to records
/// of observables, each a name, a formula and a deviation.
#[pyfunction]
#[expect(
    clippy::too_many_arguments,
    reason = "they are those of a call from Python"
)]
pub(crate) fn fit<'py>(
    py: Python<'py>,
    system: &System,
    records: Vec<RecordOf>,
    observables: Vec<(String, String, Option<f64>)>,
    unknowns: Vec<(String, Option<f64>, f64, f64, bool)>,
    extra: Vec<(String, f64)>,
    how: (String, f64, usize, usize, usize),
    settings: Settings,
) -> PyResult<Bound<'py, PyDict>> {
    let (loss, scale, search, segments, most_evaluations) = how;
    let loss = match &*loss {
        "squares" => Loss::Squares,
        "soft_l1" => Loss::SoftL1(scale),
        "huber" => Loss::Huber(scale),
        other => {
            return Err(PyValueError::new_err(format!(
                "loss = {other:?} is not allowed: it must be one of \"squares\", \"soft_l1\", \
                 \"huber\""
            )));
        }
    };
    let compiled = &system.compiled;
    let options = settings.options(compiled)?;
    let parameters = compiled.file.parameters.iter().zip(&compiled.values);
    let observables = observables.into_iter();
    let unknowns = unknowns.into_iter();
    let records = records.into_iter().enumerate();
    let mut request = FitRequest {
        file: compiled.file.as_ref().clone(),
        set: parameters
            .map(|(one, value)| (one.name.clone(), *value))
            .collect(),
        extra,
        observables: observables
            .map(|(name, formula, sigma)| Observable {
                name,
                formula,
                sigma,
            })
            .collect(),
        records: records
            .map(
                |(k, (times, columns, set, start, t_start, inputs))| Record {
                    name: format!("record {}", k + 1),
                    times,
                    columns,
                    set,
                    start,
                    t_start,
                    inputs,
                },
            )
            .collect(),
        unknowns: unknowns
            .map(|(name, start, low, high, each)| Unknown {
                name,
                start,
                bounds: (low, high),
                each,
            })
            .collect(),
        loss,
        search,
        segments,
        most_evaluations,
        options,
        interrupt: None,
    };
    let found = computed(py, 0, (&None, ProgressKind::Count), |task| {
        request.interrupt = Some(task.interrupt());
        fitted(&request)
    })?;
    let found = found.whole(|error| raised(error, compiled))?;
    described(py, compiled, &found)?.ended(None)
}

/// The Python exception for a fit that is not possible.
fn raised(error: FitError, system: &CompiledSystem) -> PyErr {
    match &error {
        FitError::Setting(_) | FitError::File(_) => wrong(error),
        FitError::Start { cause, .. }
        | FitError::NoDerivatives { cause, .. }
        | FitError::Part {
            cause: Some(cause), ..
        } => {
            let message = format!("{error}: {}", words(cause, system));
            // The kind, time and state are those of the run's own error.
            let inner = failed(cause, Some(system));
            Python::attach(|py| {
                let value = inner.value(py);
                let of = |name: &str| value.getattr(name).ok();
                let kind = of("kind").and_then(|kind| kind.extract::<String>().ok());
                computation(kind.as_deref().unwrap_or("Fit"), &message, Some(cause))
            })
        }
        FitError::Ends { .. }
        | FitError::NoStart { .. }
        | FitError::Part { .. }
        | FitError::Interrupted => computation("Fit", &error.to_string(), None),
        _ => PyValueError::new_err(error.to_string()),
    }
}

/// A fit for Python.
fn described<'py>(py: Python<'py>, system: &CompiledSystem, fit: &Fit) -> PyResult<Fields<'py>> {
    let fields = Fields::new(py);
    let count = fit.values.len();
    let none = f64::NAN;
    fields.texts("names", fit.values.iter().map(|one| one.name.clone()))?;
    fields.numbers("x", fit.values.iter().map(|one| one.value))?;
    fields.numbers("start", fit.values.iter().map(|one| one.start))?;
    fields.optional_numbers("std_errors", fit.values.iter().map(|one| one.std_error))?;
    let interval =
        |one: &stickslip_model::study::fit::FittedValue| one.interval.unwrap_or((none, none));
    let ends = fit
        .values
        .iter()
        .map(interval)
        .flat_map(|(low, high)| [low, high]);
    fields.array("intervals", ends.collect(), [2])?;
    let bounds = fit.values.iter().map(|one| one.bounds);
    let bounds = bounds.flat_map(|(low, high)| [low, high]);
    fields.array("bounds", bounds.collect(), [2])?;
    fields.texts("at_bound", fit.values.iter().map(|one| one.is_at_bound))?;
    for (name, matrix) in [
        ("covariance", fit.uncertainty.covariance.clone()),
        ("correlations", fit.uncertainty.correlations()),
    ] {
        fields.array(name, matrix.transpose().as_slice().to_vec(), [count])?;
    }
    fields.put("undetermined", fit.uncertainty.undetermined.clone())?;
    fields.put("no_errors", fit.uncertainty.none.clone())?;
    fields.put("bend", fit.uncertainty.bend)?;
    fields.put("doubtful", fit.uncertainty.is_doubtful())?;
    fields.texts("records", fit.columns.iter().map(|one| one.record))?;
    fields.texts("observables", fit.columns.iter().map(|one| one.observable))?;
    let columns = || fit.columns.iter();
    let array = |values: &Vec<f64>| numpy::PyArray1::from_slice(py, values);
    fields.texts("model", columns().map(|one| array(&one.model)))?;
    fields.texts("residuals", columns().map(|one| array(&one.residuals)))?;
    fields.numbers("rms", columns().map(|one| one.rms))?;
    fields.numbers("sigma", columns().map(|one| one.sigma))?;
    let p_values = columns().map(|one| one.runs.map(|runs| runs.p_value));
    fields.optional_numbers("p_values", p_values)?;
    let phases = fit.phases.iter().map(|phases| {
        let phases = phases.iter();
        let phases = phases.map(|(from, to, modes)| (*from, *to, system.letters(modes)));
        phases.collect::<Vec<_>>()
    });
    fields.texts("phases", phases)?;
    let off = columns().map(|one| {
        let off = one.off.iter();
        let off = off.map(|of| (of.phase, of.count, of.ratio, of.p_value));
        off.collect::<Vec<_>>()
    });
    fields.texts("phases_off", off)?;
    let letters = |phases: &[SeenPhase]| {
        let phases = phases.iter();
        let phases = phases.map(|(from, to, mode)| (*from, *to, Modes::from(*mode).to_string()));
        phases.collect::<Vec<_>>()
    };
    let seen = fit.seen.iter().map(|one| {
        let contact = system.contact_name(one.contact);
        let of = (one.record, contact, one.observable);
        (of, letters(&one.data), letters(&one.fit))
    });
    fields.texts("seen", seen)?;
    fields.put("cost", fit.cost)?;
    fields.put("mismatch", fit.mismatch)?;
    fields.put("freedom", fit.freedom)?;
    let failed = [LeastSquaresEnd::Evaluations, LeastSquaresEnd::NotFinite];
    fields.put("success", !failed.contains(&fit.end))?;
    fields.put("end", format!("{:?}", fit.end).to_lowercase())?;
    fields.put("ending", ending(fit.end))?;
    fields.put("work", (fit.steps, fit.evaluations, fit.failures))?;
    fields.put("changes", (fit.crossings, fit.jumps, fit.grazes))?;
    let others = fit.others.iter().map(|one| (one.values.clone(), one.cost));
    fields.texts("others", others)?;
    Ok(fields)
}
