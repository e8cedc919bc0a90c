//! The paper's misprints, each with the computation that shows it: a run of the solver or of the listing that could have come out
//! otherwise.

mod bracket;
mod captions;
mod estimator;
mod listing;
mod section_four;
mod sections_two_three;

use super::accuracy::Accuracy;
use super::evidence::EvidenceError;
use super::matrix::Matrix;
use super::statements::Statements;
use crate::figures::rows::Value;

/// What a computation shows of a misprint.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// What it is.
    pub what: String,
    /// A number, a count or a word.
    pub value: Value,
    /// Its unit: `1` for a pure number, empty for a word.
    pub unit: &'static str,
}

/// A misprint or defect.
#[derive(Clone, Debug, PartialEq)]
pub struct Erratum {
    /// Where.
    pub place: String,
    /// What stands there, in our words.
    pub printed: String,
    /// What should.
    pub correct: String,
    /// The computation's results.
    pub shown: Vec<Shown>,
    /// Whether they bear it out.
    pub holds: bool,
}

/// All of them, in the order of the paper, some by what has been computed already.
///
/// # Errors
/// [`EvidenceError`].
pub fn errata(
    matrix: &Matrix,
    accuracy: &Accuracy,
    statements: &Statements,
) -> Result<Vec<Erratum>, EvidenceError> {
    let mut all = sections_two_three::errata(accuracy)?;
    all.extend(section_four::errata(statements)?);
    all.extend(estimator::errata());
    all.extend(bracket::errata()?);
    all.extend(captions::errata()?);
    all.extend(listing::errata(matrix)?);
    Ok(all)
}

fn number(what: impl Into<String>, value: f64, unit: &'static str) -> Shown {
    Shown {
        what: what.into(),
        value: Value::Number(value),
        unit,
    }
}

fn count(what: impl Into<String>, value: usize) -> Shown {
    Shown {
        what: what.into(),
        value: Value::Count(value as u64),
        unit: "1",
    }
}

fn word(what: impl Into<String>, value: impl Into<String>) -> Shown {
    Shown {
        what: what.into(),
        value: Value::Word(value.into()),
        unit: "",
    }
}

fn erratum(place: &str, printed: &str, correct: &str, shown: Vec<Shown>, holds: bool) -> Erratum {
    Erratum {
        place: place.to_owned(),
        printed: printed.to_owned(),
        correct: correct.to_owned(),
        shown,
        holds,
    }
}
