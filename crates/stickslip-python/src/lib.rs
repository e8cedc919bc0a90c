//! The engine as the extension module `stickslip._core`.
//!
//! The interface is narrow: a system from its text, and each computation as one call that takes and
//! returns numbers, texts and arrays. The public interface is written in Python, in
//! `python/stickslip`.

mod analyses;
mod errors;
mod fields;
mod run;
mod task;

use pyo3::prelude::*;
use stickslip::{AbsoluteTolerance, AtPileUp, AtRepelling, Direction, Method, Options};
use stickslip_model::file::{PeriodError, Source, SystemFile};
use stickslip_model::study;

use errors::{Keywords, failed, no_period, wrong};

/// A compiled system.
#[pyclass(frozen, module = "stickslip._core")]
struct System {
    compiled: stickslip_model::file::System,
}

#[pymethods]
impl System {
    /// The system of a text, with some of its parameters set to other values. `name` is what
    /// messages call the text, and files that it names lie beside that.
    #[new]
    fn new(name: String, text: String, settings: Vec<(String, f64)>) -> PyResult<Self> {
        let file = SystemFile::parse(Source { name, text }).map_err(wrong)?;
        let compiled = file.with(&settings).map_err(wrong)?;
        Ok(System { compiled })
    }

    /// The text of a shipped model, or of a file.
    #[staticmethod]
    fn text_of(path: &str) -> PyResult<String> {
        Ok(SystemFile::open(path).map_err(wrong)?.source.text)
    }

    /// Compiles the system with other sections, each of a direction given by its sign.
    fn with_sections(&self, sections: Vec<(String, i32)>) -> PyResult<System> {
        let direction = |sign: i32| match sign.signum() {
            1 => Direction::Rising,
            -1 => Direction::Falling,
            _ => Direction::Both,
        };
        let sections = sections.iter();
        let sections: Vec<_> = sections
            .map(|(function, sign)| (function.as_str(), direction(*sign)))
            .collect();
        let compiled = self.compiled.with_sections(&sections).map_err(wrong)?;
        Ok(System { compiled })
    }

    /// Refuses values of parameters that the system cannot have, which are rows of orbits.
    fn check_values(
        &self,
        names: Vec<String>,
        values: numpy::PyReadonlyArray2<'_, f64>,
    ) -> PyResult<()> {
        for (number, row) in values.as_array().rows().into_iter().enumerate() {
            let pairs = names.iter().map(String::as_str).zip(row.iter().copied());
            let with = self.compiled.with_values(&pairs.collect::<Vec<_>>());
            with.map_err(|error| wrong(format!("orbit {number}: {error}")))?;
        }
        Ok(())
    }

    /// Compiles the system with time that runs backwards.
    fn reversed(&self) -> PyResult<System> {
        study::past::check(&self.compiled)
            .map_err(|error| pyo3::exceptions::PyValueError::new_err(error.to_string()))?;
        let compiled = self.compiled.reversed().map_err(wrong)?;
        Ok(System { compiled })
    }

    #[getter]
    fn name(&self) -> &str {
        &self.compiled.file.name
    }

    #[getter]
    fn states(&self) -> Vec<&str> {
        let states = self.compiled.file.states.iter();
        states.map(|state| state.name.as_str()).collect()
    }

    #[getter]
    fn parameters(&self) -> Vec<(&str, f64)> {
        let names = self.compiled.file.parameters.iter();
        let values = self.compiled.values.iter();
        names
            .zip(values)
            .map(|(parameter, &value)| (parameter.name.as_str(), value))
            .collect()
    }

    /// The contacts, followed by the jumps.
    #[getter]
    fn contacts_and_jumps(&self) -> (Vec<&str>, Vec<&str>) {
        let file = &self.compiled.file;
        let contacts = file.contacts.iter().map(|contact| contact.name.as_str());
        let jumps = file.jumps.iter().map(|jump| jump.name.as_str());
        (contacts.collect(), jumps.collect())
    }

    /// Names of the discrete states, which follow the others.
    #[getter]
    fn discrete(&self) -> Vec<&str> {
        let states = self.compiled.file.states.iter();
        let discrete = states.filter(|state| state.is_discrete);
        discrete.map(|state| state.name.as_str()).collect()
    }

    /// Value of each state at the start, as far as the text specifies it.
    #[getter]
    fn starts(&self) -> Vec<Option<f64>> {
        self.compiled.built.starts.clone()
    }

    /// Period in time, if the text specifies it.
    #[getter]
    fn period(&self) -> Option<f64> {
        self.compiled.built.period
    }

    #[getter]
    fn depends_on_time(&self) -> bool {
        self.compiled.built.depends_on_time
    }

    /// Warnings about the system from a start, as the program's `check` prints them.
    fn check(&self, py: Python<'_>, start: Option<Vec<f64>>) -> Vec<String> {
        let period = match self.compiled.checked_period() {
            Err(error @ PeriodError::Wrong { .. }) => Some(no_period(error).value(py).to_string()),
            _ => None,
        };
        let t = self.compiled.built.t_start;
        let start = start.as_deref().map(|x| (t, x));
        let others = study::warnings(&self.compiled, start, &Keywords);
        period.into_iter().chain(others).collect()
    }
}

/// Absolute tolerance: one number for all states, or a list with one for each.
#[derive(FromPyObject)]
enum Absolute {
    All(f64),
    Each(Vec<f64>),
}

/// Options of runs.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Settings {
    rtol: f64,
    atol: Option<Absolute>,
    method: String,
    max_step: f64,
    escape: f64,
    at_repelling: String,
    at_pile_up: String,
    most_events: u64,
    most_steps: u64,
}

impl Settings {
    /// The absolute tolerance for a system. The states that only jumps change may be left out.
    fn absolute(&self, system: &stickslip_model::file::System) -> PyResult<AbsoluteTolerance> {
        let each = match &self.atol {
            Some(Absolute::All(atol)) => return Ok((*atol).into()),
            Some(Absolute::Each(values)) => values.iter().copied().map(Some).collect(),
            None => Vec::new(),
        };
        let states = &system.file.states;
        let moving = states.iter().filter(|state| !state.is_discrete).count();
        let given = each.len();
        if self.atol.is_some() && given != states.len() && given != moving {
            let names: Vec<&str> = states[..moving].iter().map(|state| &*state.name).collect();
            return Err(pyo3::exceptions::PyValueError::new_err(format!(
                "atol has {given} values: give one number for all states, or one for each of {}",
                names.join(", ")
            )));
        }
        let found = system.absolute_tolerance(self.rtol, &each);
        found.map_err(|error| failed(&error, None))
    }

    /// The options for a system.
    fn options(&self, system: &stickslip_model::file::System) -> PyResult<Options> {
        let of = |name: &str, value: &str, known: &str| {
            pyo3::exceptions::PyValueError::new_err(format!(
                "{name} = {value:?} is not allowed: it must be one of {known}"
            ))
        };
        let options = Options {
            rtol: self.rtol,
            atol: self.absolute(system)?,
            longest_step: self.max_step,
            escape: self.escape,
            most_events: self.most_events,
            most_steps: self.most_steps,
            method: match self.method.to_lowercase().as_str() {
                "taylor" => Method::Taylor,
                "dop853" => Method::Dop853,
                _ => return Err(of("method", &self.method, "\"taylor\", \"dop853\"")),
            },
            at_repelling: match self.at_repelling.to_lowercase().as_str() {
                "stop" => AtRepelling::Stop,
                "below" => AtRepelling::GoBelow,
                "above" => AtRepelling::GoAbove,
                _ => {
                    return Err(of(
                        "at_repelling",
                        &self.at_repelling,
                        "\"stop\", \"below\", \"above\"",
                    ));
                }
            },
            at_pile_up: match self.at_pile_up.to_lowercase().as_str() {
                "stop" => AtPileUp::Stop,
                "rest" => AtPileUp::Rest,
                _ => return Err(of("at_pile_up", &self.at_pile_up, "\"stop\", \"rest\"")),
            },
            ..Options::default()
        };
        options.check().map_err(|error| failed(&error, None))?;
        Ok(options)
    }
}

/// The engine of stickslip.
#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<System>()?;
    module.add_class::<run::Dense>()?;
    module.add_function(wrap_pyfunction!(task::unwind, module)?)?;
    module.add_function(wrap_pyfunction!(run::solve, module)?)?;
    module.add_function(wrap_pyfunction!(run::end_of, module)?)?;
    module.add_function(wrap_pyfunction!(run::ensemble, module)?)?;
    analyses::add(module)
}
