//! Lyapunov exponents, from the equations and from a series.

use std::borrow::Cow;
use std::ops::ControlFlow;

use numpy::{PyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use stickslip::analysis::{Exponent, SpectrumOptions};
use stickslip_series::{
    Balance, DataError, DataSettings, DataSpectrum, Degree, Divergence, DivergenceCurve, Embedding,
    EmbeddingSettings, Estimator, Given, Neighbourhood, Reversal, SURROGATE_SEED, Series,
    SurrogateTest, check_surrogates, data_spectrum_with, divergence, needed_embedding, reversal,
    status_word, surrogate_test,
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
    let settings = SpectrumOptions::over(transient, duration).solver(settings.options(compiled)?);
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
    /// `None` where there are too few points for it; a spectrum needs fewer.
    diverging: Option<Divergence>,
    surrogates: Option<SurrogateTest>,
}

/// Options of a spectrum of a series.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(super) struct SeriesOptions {
    delay: Option<usize>,
    dimension: Option<usize>,
    estimator: String,
    degree: Option<String>,
    eps: Option<f64>,
    neighbours: Option<(usize, Option<usize>)>,
    step: Option<usize>,
    theiler: Option<usize>,
    affine: bool,
    rank_tolerance: Option<f64>,
    ridge: f64,
    rank: Option<usize>,
    stride: Option<usize>,
    references: Option<usize>,
    surrogates: Option<usize>,
}

impl SeriesOptions {
    fn settings(&self) -> DataSettings {
        let degree = self.degree.as_deref().map(|degree| match degree {
            "linear" => Degree::Linear,
            _ => Degree::Quadratic,
        });
        let plain = DataSettings::default();
        let neighbours = match (self.neighbours, plain.neighbours) {
            (Some((count, None)), _) => Neighbourhood::Nearest(count),
            (given, Neighbourhood::Ball { eps, min, max }) => {
                let (min, max) = match given {
                    Some((fewest, Some(most))) => (fewest, most),
                    _ => (min, max),
                };
                let eps = self.eps.unwrap_or(eps);
                Neighbourhood::Ball { eps, min, max }
            }
            (_, nearest) => nearest,
        };
        DataSettings {
            estimator: match self.estimator.as_str() {
                "sano-sawada" => Estimator::SanoSawada,
                _ => Estimator::Extrapolated { degree },
            },
            neighbours,
            theiler: self.theiler,
            step: self.step.unwrap_or(plain.step),
            affine: self.affine,
            rank_tolerance: self.rank_tolerance.unwrap_or(plain.rank_tolerance),
            ridge: self.ridge,
            fixed_rank: self.rank,
            stride: self.stride.unwrap_or(plain.stride),
            references: self.references,
            ..plain
        }
    }

    /// Computes the spectrum as the program does, in parts that report progress. One delayed value
    /// leaves the columns as they are.
    fn spectrum(&self, series: &Series, task: &Task) -> Result<OfSeries, DataError> {
        let part = |number: usize| {
            move |done: usize, total: usize| {
                task.set_done(PART * number + PART * done / total.max(1));
                match task.is_stopped() {
                    true => ControlFlow::Break(()),
                    false => ControlFlow::Continue(()),
                }
            }
        };
        self.surrogates.map_or(Ok(()), check_surrogates)?;
        let embedding = match self.dimension {
            Some(1) => None,
            dimension => {
                let embedding = EmbeddingSettings {
                    delay: self.delay,
                    dimension,
                    theiler: self.theiler,
                };
                needed_embedding(series, &embedding, &part(0))?.map(|choice| choice.embedding)
            }
        };
        let settings = self.settings();
        let (vectors, settings) = match embedding {
            Some(embedding) => {
                let vectors = embedding.of(series)?;
                let given = Given {
                    neighbours: self.neighbours.is_some(),
                    step: self.step.is_some(),
                    stride: self.stride.is_some(),
                };
                let settings = settings.delayed_but(embedding.delay, &vectors, given);
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
        let diverging = match divergence(&vectors, settings.theiler, &part(3)) {
            Err(DataError::TooFew { .. }) => None,
            found => Some(found?),
        };
        let surrogates = self.surrogates.map(|count| {
            let seed = SURROGATE_SEED;
            surrogate_test(series, embedding, &settings, count, seed, &part(4))
        });
        Ok(OfSeries {
            spectrum,
            embedded,
            diverging,
            surrogates: surrogates.transpose()?,
        })
    }
}

/// Progress of a part of [`SeriesOptions::spectrum`] when it is done.
const PART: usize = 1000;

/// The spectrum of a measured series, with one row for each point.
#[pyfunction]
pub(crate) fn lyapunov_from_data<'py>(
    py: Python<'py>,
    series: PyReadonlyArray2<'py, f64>,
    dt: f64,
    sum_of_all: Option<f64>,
    options: SeriesOptions,
    report: Report,
) -> PyResult<Bound<'py, PyDict>> {
    let series = series.as_array();
    let values = series.iter().copied().collect();
    let series = Series::new(values, series.ncols(), dt).map_err(refused)?;
    let found = computed(py, 0, (&report, ProgressKind::Count), |task| {
        options.spectrum(&series, task)
    })?;
    let OfSeries {
        spectrum,
        embedded,
        diverging,
        surrogates,
    } = found.whole(refused)?;
    let exponents = &spectrum.exponents;
    let fields = Fields::new(py);
    fields.numbers("exponents", exponents.iter().map(|one| one.value))?;
    fields.numbers("std_errors", exponents.iter().map(|one| one.stderr))?;
    fields.numbers(
        "eps_sensitivity",
        exponents.iter().map(|one| one.eps_sensitivity),
    )?;
    let by_rank = exponents
        .iter()
        .map(|one| one.fixed_rank.map(|value| value.0));
    fields.optional_numbers("by_rank", by_rank)?;
    let reversal = embedded.as_ref().map(|(_, reversal)| reversal);
    let status = (0..exponents.len()).map(|number| status_word(&spectrum, reversal, number));
    fields.texts("status", status)?;
    fields.put("dimension", spectrum.dimension)?;
    fields.put("residual_ratio", spectrum.residual_ratio)?;
    // Some exponents of delayed values may be spurious, so their sum is not compared.
    let balance = sum_of_all.filter(|_| embedded.is_none());
    let balance = balance.map(|sum| match spectrum.balance(sum) {
        Balance::Whole { excess, stderr, .. } => (0, excess, stderr),
        Balance::Rest {
            exponents,
            sum,
            stderr,
        } => (exponents, sum, stderr),
        Balance::Unknown => (0, f64::NAN, f64::NAN),
    });
    fields.put("balance", balance)?;
    let test = surrogates.as_ref();
    fields.put("surrogate_p", test.map(|test| test.p))?;
    let residuals = test.map(|test| {
        let all = test.surrogates.iter().map(|one| one.residual);
        PyArray1::from_iter(py, all)
    });
    fields.put("surrogate_residuals", residuals)?;
    let embedding = embedded.map(|(embedding, _)| (embedding.delay, embedding.dimension));
    fields.put("embedding", embedding)?;
    let curves = diverging.map(|diverging| described(py, &diverging));
    match curves.transpose()? {
        Some(curves) => fields.fields("diverging_neighbours", curves)?,
        None => fields.put("diverging_neighbours", py.None())?,
    }
    fields.ended(None)
}

/// The divergence of neighbours, with the keys that the program writes.
fn described<'py>(py: Python<'py>, diverging: &Divergence) -> PyResult<Fields<'py>> {
    let curve = |curve: &DivergenceCurve| -> PyResult<Bound<'py, PyDict>> {
        let fields = Fields::new(py);
        fields.put("radius", curve.radius)?;
        fields.put("references", curve.references)?;
        fields.numbers("t", curve.points.iter().map(|point| point.0))?;
        fields.numbers("log_distance", curve.points.iter().map(|point| point.1))?;
        let straight = curve.straight.as_ref().map(|straight| {
            let fields = Fields::new(py);
            fields.put("from", curve.points[straight.from].0)?;
            fields.put("to", curve.points[straight.to].0)?;
            fields.put("slope", straight.slope)?;
            fields.put("stderr", straight.stderr)?;
            fields.put("scatter", straight.scatter)?;
            fields.ended(None)
        });
        fields.put("straight", straight.transpose()?)?;
        fields.ended(None)
    };
    let fields = Fields::new(py);
    fields.put("rosenstein", diverging.by_rosenstein())?;
    fields.put("kantz", diverging.by_kantz())?;
    fields.put("saturation", diverging.saturation)?;
    fields.put("rosenstein_curve", curve(&diverging.rosenstein)?)?;
    let kantz = diverging.kantz.iter().map(curve);
    fields.put("kantz_curves", kantz.collect::<PyResult<Vec<_>>>()?)?;
    Ok(fields)
}

/// The Python exception for a series or a setting that cannot be used.
fn refused(error: DataError) -> PyErr {
    match &error {
        DataError::Setting { name, value, bound } => option(error.to_string(), name, *value, bound),
        _ => computation("Series", &error.to_string(), None),
    }
}
