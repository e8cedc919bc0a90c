//! What a computation shows of a misprint.

use crate::figures::rows::Value;

/// What a computation shows of a misprint.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// What it is.
    pub what: String,
    /// A number, a count or a word.
    pub value: Value,
    /// Its unit: `1` for a pure number, empty for a word.
    pub unit: String,
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

/// A misprint's proof by values, whose words are in the table.
pub(in crate::report) fn proof<V: Into<Value>>(
    misprint: &'static str,
    values: impl IntoIterator<Item = V>,
    holds: bool,
) -> Proof {
    let shown = values.into_iter().map(|value| Shown {
        what: String::new(),
        value: value.into(),
        unit: String::new(),
    });
    Proof {
        misprint,
        shown: shown.collect(),
        holds,
    }
}

/// A misprint's proof by what brings its own words.
pub(super) fn told(misprint: &'static str, shown: Vec<Shown>, holds: bool) -> Proof {
    Proof {
        misprint,
        shown,
        holds,
    }
}

/// What brings its own words.
pub(super) fn shown(what: impl Into<String>, value: impl Into<Value>, unit: &str) -> Shown {
    Shown {
        what: what.into(),
        value: value.into(),
        unit: unit.to_owned(),
    }
}
