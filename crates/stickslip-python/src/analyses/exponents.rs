//! Lyapunov exponents, from the equations and from a series.

use std::borrow::Cow;
use std::ops::ControlFlow;

use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use stickslip::analysis::{Exponent, SpectrumOptions};
use stickslip_series::{
    DataError, DataSettings, DataSpectrum, Embedding, EmbeddingSettings, Reversal, Series,
    data_spectrum_with, needed_embedding, reversal, status_word,
};

use super::Start;
use crate::errors::{Failure, computation, option, words};
use crate::fields::Fields;
use crate::task::{ProgressKind, Report, Task, computed};
use crate::{Settings, System};

/// The spectrum of Lyapunov exponents.
#[pyfunction]
pub(crate) fn lyapunov_spectrum<'py>(
    py: Python<'py>,
    system: &System,
    start: Start,
    span: (f64, f64),
    settings: Settings,
    report: Report,
) -> PyResult<Bound<'py, PyDict>> {
    let (t, x) = start;
    let (transient, duration) = span;
    let compiled = &system.compiled;
    let settings = SpectrumOptions::over(transient, duration).solver(settings.options()?);
    let spectrum = computed(py, 1, (&report, ProgressKind::Time), |task| {
        let system = task.system(compiled)?;
        let start = (t, x.as_slice());
        let found = stickslip::analysis::lyapunov_spectrum(system.dynamics(), start, &settings);
        Ok(found?)
    })?;
    let spectrum = spectrum.whole(|error: Failure| error.raised(compiled))?;
    let (exponents, duration) = (&spectrum.exponents, spectrum.duration);
    let fields = Fields::new(py);
    fields.numbers("exponents", exponents.iter().map(Exponent::value))?;
    fields.optional_numbers("std_errors", exponents.iter().map(Exponent::std_error))?;
    let pairs = exponents.iter().zip(&spectrum.uncertainties);
    let uncertainties = pairs.map(|(one, uncertainty)| match one {
        Exponent::Finite { .. } => *uncertainty,
        Exponent::Annihilated => f64::NAN,
    });
    fields.numbers("uncertainties", uncertainties)?;
    fields.put("duration", duration)?;
    let ended = spectrum.ended.as_ref();
    fields.put("ended", ended.map(|error| words(error, compiled)))?;
    fields.put("defect", spectrum.defect())?;
    fields.put("stick_entries", spectrum.stick_entries)?;
    fields.put("stick_fraction", spectrum.stick_fraction)?;
    let running = &spectrum.convergence;
    fields.numbers("elapsed", running.iter().map(|at| at.elapsed))?;
    let values = running.iter().flat_map(|at| at.exponents.iter().copied());
    fields.array("running", values.collect(), [exponents.len()])?;
    fields.ended(None)
}

/// The spectrum of a series, of its columns or of delayed values of them.
struct OfSeries {
    spectrum: DataSpectrum,
    embedded: Option<(Embedding, Reversal)>,
}

/// What the program computes without further options, in three parts that report progress. One
/// delayed value leaves the columns as they are.
fn of_series(
    series: &Series,
    embedding: &EmbeddingSettings,
    task: &Task,
) -> Result<OfSeries, DataError> {
    let part = |number: usize| {
        move |done: usize, total: usize| {
            task.set_done(PART * number + PART * done / total.max(1));
            match task.is_stopped() {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            }
        }
    };
    let embedding = match embedding.dimension {
        Some(1) => None,
        _ => needed_embedding(series, embedding, &part(0))?.map(|choice| choice.embedding),
    };
    let settings = DataSettings::default();
    let (vectors, settings) = match embedding {
        Some(embedding) => {
            let vectors = embedding.of(series)?;
            let settings = settings.delayed(embedding.delay, &vectors);
            (Cow::Owned(vectors), settings)
        }
        None => (Cow::Borrowed(series), settings),
    };
    let spectrum = data_spectrum_with(&vectors, &settings, &part(1))
        .map_err(|error| error.in_rows(series.len() - vectors.len()))?;
    let embedded = match embedding {
        Some(embedding) => Some((embedding, reversal(&vectors, &spectrum, &part(2))?)),
        None => None,
    };
    Ok(OfSeries { spectrum, embedded })
}

/// Progress of a part of [`of_series`] when it is done.
const PART: usize = 1000;

/// The spectrum of a measured series, with one row for each point.
#[pyfunction]
pub(crate) fn lyapunov_from_data<'py>(
    py: Python<'py>,
    series: PyReadonlyArray2<'py, f64>,
    dt: f64,
    embedding: (Option<usize>, Option<usize>),
    report: Report,
) -> PyResult<Bound<'py, PyDict>> {
    let (delay, dimension) = embedding;
    let series = series.as_array();
    let values = series.iter().copied().collect();
    let series = Series::new(values, series.ncols(), dt).map_err(refused)?;
    let embedding = EmbeddingSettings {
        delay,
        dimension,
        theiler: None,
    };
    let found = computed(py, 0, (&report, ProgressKind::Count), |task| {
        of_series(&series, &embedding, task)
    })?;
    let OfSeries { spectrum, embedded } = found.whole(refused)?;
    let exponents = &spectrum.exponents;
    let fields = Fields::new(py);
    fields.numbers("exponents", exponents.iter().map(|one| one.value))?;
    fields.numbers("std_errors", exponents.iter().map(|one| one.stderr))?;
    let reversal = embedded.as_ref().map(|(_, reversal)| reversal);
    let status = (0..exponents.len()).map(|number| status_word(&spectrum, reversal, number));
    fields.texts("status", status)?;
    fields.put("dimension", spectrum.dimension)?;
    let embedding = embedded.map(|(embedding, _)| (embedding.delay, embedding.dimension));
    fields.put("embedding", embedding)?;
    fields.ended(None)
}

/// The Python exception for a series or a setting that cannot be used.
fn refused(error: DataError) -> PyErr {
    match &error {
        DataError::Setting { name, value, bound } => option(error.to_string(), name, *value, bound),
        _ => computation("Series", &error.to_string(), None),
    }
}
