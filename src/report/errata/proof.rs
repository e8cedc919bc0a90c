//! Results of a computation that shows a misprint.

use crate::figures::rows::Value;

/// One result of a computation that shows a misprint.
#[derive(Clone, Debug, PartialEq)]
pub struct ProofResult {
    /// Description. If empty, the table of misprints has the description and the unit.
    pub what: String,
    /// A number, a count or a word.
    pub value: Value,
    /// Unit: `1` for a pure number, empty for a word.
    pub unit: String,
}

impl ProofResult {
    /// A value with its own description.
    pub(super) fn new(what: impl Into<String>, value: impl Into<Value>, unit: &str) -> ProofResult {
        ProofResult {
            what: what.into(),
            value: value.into(),
            unit: unit.to_owned(),
        }
    }
}

impl<V: Into<Value>> From<V> for ProofResult {
    fn from(value: V) -> ProofResult {
        ProofResult::new("", value, "")
    }
}

/// Results of a computation that shows a misprint in `data/errata.csv`.
#[derive(Clone, Debug, PartialEq)]
pub struct Proof {
    /// Name of the misprint in the table.
    pub misprint: &'static str,
    /// Results of the computation.
    pub shown: Vec<ProofResult>,
    /// Whether they confirm the misprint.
    pub holds: bool,
}

impl Proof {
    /// A proof from results with their own descriptions, or from values that the table describes.
    pub(in crate::report) fn new<S: Into<ProofResult>>(
        misprint: &'static str,
        shown: impl IntoIterator<Item = S>,
        holds: bool,
    ) -> Proof {
        Proof {
            misprint,
            shown: shown.into_iter().map(Into::into).collect(),
            holds,
        }
    }
}
