//! The paper's misprints, each with the computation that shows it: a run of the solver or of the
//! listing that could have come out otherwise.

mod bracket;
mod listing;
mod section_four;
mod sections_two_three;

use super::ReportError;
use super::accuracy::Accuracy;
use super::matrix::Matrix;
use crate::figures::rows::Value;
use crate::paper::listing::Defect;

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
/// [`ReportError`].
pub fn errata(
    matrix: &Matrix,
    accuracy: &Accuracy,
    of_statements: &[Erratum],
) -> Result<Vec<Erratum>, ReportError> {
    let mut all = vec![
        sections_two_three::unit_of_mu0(),
        sections_two_three::critical_points()?,
        sections_two_three::negative_friction()?,
        sections_two_three::wrong_reference()?,
        sections_two_three::step_from_above(accuracy),
        sections_two_three::time_in_stick(accuracy),
        section_four::sign_of_friction()?,
        section_four::spring_signs()?,
    ];
    all.extend_from_slice(of_statements);
    all.extend([
        listing::shifts(),
        bracket::signs()?,
        bracket::friction_counted_twice()?,
        bracket::unit_of_time()?,
        bracket::four_states()?,
        bracket::order_of_captions()?,
        bracket::caption_of_fig10()?,
    ]);
    for defect in Defect::ALL {
        all.push(listing::defect(matrix, defect)?);
    }
    Ok(all)
}

pub(super) fn number(what: impl Into<String>, value: f64, unit: &'static str) -> Shown {
    Shown {
        what: what.into(),
        value: Value::Number(value),
        unit,
    }
}

pub(super) fn count(what: impl Into<String>, value: usize) -> Shown {
    Shown {
        what: what.into(),
        value: Value::Count(value as u64),
        unit: "1",
    }
}

pub(super) fn word(what: impl Into<String>, value: impl Into<String>) -> Shown {
    Shown {
        what: what.into(),
        value: Value::Word(value.into()),
        unit: "",
    }
}

pub(super) fn erratum(
    place: &str,
    printed: &str,
    correct: &str,
    shown: Vec<Shown>,
    holds: bool,
) -> Erratum {
    Erratum {
        place: place.to_owned(),
        printed: printed.to_owned(),
        correct: correct.to_owned(),
        shown,
        holds,
    }
}
