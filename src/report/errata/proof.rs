//! What a computation shows of a misprint.

use crate::figures::rows::Value;

/// One result of a computation that shows a misprint.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// What it is. Where this is empty, the table of misprints has the words and the unit.
    pub what: String,
    /// A number, a count or a word.
    pub value: Value,
    /// Its unit: `1` for a pure number, empty for a word.
    pub unit: String,
}

impl Shown {
    /// With words of its own.
    pub(super) fn new(what: impl Into<String>, value: impl Into<Value>, unit: &str) -> Shown {
        Shown {
            what: what.into(),
            value: value.into(),
            unit: unit.to_owned(),
        }
    }
}

impl<V: Into<Value>> From<V> for Shown {
    fn from(value: V) -> Shown {
        Shown::new("", value, "")
    }
}

/// What a computation shows of a misprint in `data/errata.csv`.
#[derive(Clone, Debug, PartialEq)]
pub struct Proof {
    /// Its name there.
    pub misprint: &'static str,
    /// The computation's results.
    pub shown: Vec<Shown>,
    /// Whether they bear it out.
    pub holds: bool,
}

impl Proof {
    /// By results with words of their own, or by values with words in the table.
    pub(in crate::report) fn new<S: Into<Shown>>(
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
