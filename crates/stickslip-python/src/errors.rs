//! Failures as Python exceptions, with the names of Python's arguments.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use stickslip::Error;
use stickslip::error::readable;
use stickslip_model::file::{Interface, PeriodError, SettingError, System};
use stickslip_model::study::{BOUND_OF_TIMES, SearchError};

pyo3::import_exception!(stickslip._errors, OptionError);
pyo3::import_exception!(stickslip._errors, StickslipError);
pyo3::import_exception!(stickslip._errors, SystemError);

/// Options as keywords of Python.
pub(crate) struct Keywords;

impl Interface for Keywords {
    fn name(&self, option: &str) -> String {
        let other = match option {
            "longest_step" => "max_step",
            "range" => "bounds",
            same => same,
        };
        other.to_owned()
    }

    fn choice(&self, option: &str, words: &[&str]) -> String {
        let quoted = words.iter().map(|word| format!("\"{word}\""));
        format!(
            "{}={}",
            self.name(option),
            quoted.collect::<Vec<_>>().join(" or ")
        )
    }

    fn value(&self, option: &str, value: f64) -> String {
        format!("{} = {}", self.name(option), readable(value))
    }

    fn nearer(&self) -> &'static str {
        "after a longer transient or from another y0; the motion may also be quasi-periodic or \
            chaotic, as lyapunov_spectrum shows"
    }
}

/// An error of the library in words.
pub(crate) fn words(error: &Error, system: &System) -> String {
    Keywords.words(error, Some(system))
}

/// Reason for which a computation failed.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub(crate) enum Failure {
    Run(#[from] Error),
    Setting(#[from] SettingError),
    Search(#[from] SearchError),
    Python(#[from] PyErr),
}

impl Failure {
    /// The Python exception, with the names of the system's contacts.
    pub(crate) fn raised(self, system: &System) -> PyErr {
        match self {
            Failure::Run(error) | Failure::Search(SearchError::Failed(error)) => {
                failed(&error, Some(system))
            }
            Failure::Setting(error) => wrong(error),
            Failure::Search(error) => match error {
                SearchError::Setting { name, value } => {
                    option(error.to_string(), name, value, BOUND_OF_TIMES)
                }
                SearchError::NoPeriods | SearchError::HasNoEquilibrium => {
                    PyValueError::new_err(error.to_string())
                }
                SearchError::Period(error) => no_period(error),
                SearchError::TakesLonger { .. } => computation(
                    "NotFound",
                    &format!("{error}; give a larger `longest`"),
                    None,
                ),
                other => {
                    let help = match other {
                        SearchError::Equilibrium { .. } => {
                            ", take other parameters, or follow it by equilibrium_continuation"
                        }
                        SearchError::NoEquilibrium(_) => {
                            ", or near an equilibrium without a run (transient=0)"
                        }
                        _ => ", or take other parameters",
                    };
                    let message = format!("{other}; start elsewhere (y0){help}");
                    computation("NotFound", &message, None)
                }
            },
            Failure::Python(error) => error,
        }
    }
}

/// The Python exception for an invalid system.
pub(crate) fn wrong(error: impl std::fmt::Display) -> PyErr {
    SystemError::new_err(error.to_string())
}

/// The Python exception for a drive without a valid period.
pub(crate) fn no_period(error: PeriodError) -> PyErr {
    match error {
        PeriodError::Missing => wrong(
            "the system depends on time: what is its period? Give period=… to System, or add \
                period = \"…\" to [time] of the file",
        ),
        PeriodError::Wrong { period } => wrong(format!(
            "the field, a boundary or a jump is not the same after the period {} of the \
                system; correct period=… of System, or the period in [time] of the file",
            readable(period)
        )),
    }
}

/// The Python exception for a failed computation. A wrong setting is a `ValueError`; an error
/// within a run has its time and state.
pub(crate) fn failed(error: &Error, system: Option<&System>) -> PyErr {
    let message = Keywords.words(error, system);
    match error {
        Error::Parameter { name, value, bound } | Error::Option { name, value, bound } => {
            option(message, &Keywords.name(name), *value, bound)
        }
        Error::Interval { .. } => PyValueError::new_err(message),
        _ => {
            // The name of the variant, which is what `Debug` begins with.
            let debug = match error {
                Error::Contacts { fault, .. } => format!("{fault:?}"),
                other => format!("{other:?}"),
            };
            let kind = debug.split(|letter: char| !letter.is_alphanumeric()).next();
            computation(kind.unwrap_or_default(), &message, Some(error))
        }
    }
}

/// The Python exception for a setting that is not allowed.
pub(crate) fn option(message: String, name: &str, value: f64, bound: &str) -> PyErr {
    OptionError::new_err((message, name.to_owned(), value, bound.to_owned()))
}

/// A Python exception of a given kind, with time and state of an error of a run.
pub(crate) fn computation(kind: &str, message: &str, error: Option<&Error>) -> PyErr {
    let (t, x) = error.map_or((None, None), place);
    StickslipError::new_err((message.to_owned(), kind.to_owned(), t, x))
}

/// Time and state of a failure, as far as it has them.
fn place(error: &Error) -> (Option<f64>, Option<Vec<f64>>) {
    match error {
        Error::NotFound { t, .. } | Error::OutsideOrbit { t, .. } => (Some(*t), None),
        _ => error.place().map(|(t, x)| (t, x.0)).unzip(),
    }
}
