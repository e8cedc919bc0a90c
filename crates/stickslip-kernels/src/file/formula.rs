//! An expression and where in the file it stands.

use std::ops::Range;

use super::problem::{Problem, Source};
use crate::expression::{Expression, Kind, parse};

/// An expression of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Formula {
    /// Its tree; places in it are those of its own text.
    pub tree: Expression,
    /// As it is written.
    pub text: String,
    place: Place,
}

/// Where the text of an expression stands.
#[derive(Clone, Debug, PartialEq)]
struct Place {
    /// The whole value, quotes included.
    whole: Range<usize>,
    /// Where its text begins; `None` where the file has it with escapes, so that bytes cannot be
    /// counted.
    text: Option<usize>,
}

impl Formula {
    /// A number written as one.
    pub(super) fn number(value: f64, whole: Range<usize>) -> Self {
        Formula {
            tree: Expression {
                kind: Kind::Number(value),
                span: 0..whole.len(),
            },
            text: value.to_string(),
            place: Place {
                text: Some(whole.start),
                whole,
            },
        }
    }

    /// A text, which is the value at `whole`.
    pub(super) fn parsed(
        text: &str,
        whole: Range<usize>,
        source: &Source,
    ) -> Result<Self, Problem> {
        let raw = source.text.get(whole.clone()).unwrap_or_default();
        let quotes = raw.len() - raw.trim_start_matches(['"', '\'']).len();
        // Behind three quotes the first end of line does not belong to the text.
        let begin = raw[quotes..].find(text).filter(|&skipped| {
            raw[quotes..quotes + skipped]
                .chars()
                .all(char::is_whitespace)
        });
        let place = Place {
            text: begin.map(|skipped| whole.start + quotes + skipped),
            whole,
        };
        match parse(text) {
            Ok(tree) => {
                let words: Vec<&str> = text.split_whitespace().collect();
                let text = words.join(" ");
                Ok(Formula { tree, text, place })
            }
            Err(error) => {
                Err(Problem::new(error.message, place.of(&error.span)).help_if(error.help))
            }
        }
    }

    /// The place in the file of a part of the text.
    pub fn at(&self, span: &Range<usize>) -> Range<usize> {
        self.place.of(span)
    }

    /// The place of the whole.
    pub fn whole(&self) -> Range<usize> {
        self.place.whole.clone()
    }
}

impl Place {
    fn of(&self, span: &Range<usize>) -> Range<usize> {
        match self.text {
            Some(begin) => begin + span.start..begin + span.end,
            None => self.whole.clone(),
        }
    }
}
