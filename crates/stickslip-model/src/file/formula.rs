//! An expression and its position in the file.

use std::ops::Range;

use stickslip::error::readable;

use super::problem::{Problem, Source};
use crate::expression::{Expression, ExpressionKind, SyntaxError, parse, parse_condition};

/// An expression of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Formula {
    /// The tree; positions in it refer to the text of the expression.
    pub tree: Expression,
    /// The expression as written.
    pub text: String,
    /// The text that was parsed, to which positions in the tree refer.
    parsed: Box<str>,
    place: TextPosition,
}

/// Position of the text of an expression.
#[derive(Clone, Debug, PartialEq)]
struct TextPosition {
    /// The whole value, quotes included.
    whole: Range<usize>,
    /// Start of the text; `None` if it contains escapes, so that bytes cannot be counted.
    text: Option<usize>,
}

impl Formula {
    /// An expression given as a number.
    pub(super) fn number(value: f64, whole: Range<usize>) -> Self {
        Formula {
            tree: Expression {
                kind: ExpressionKind::Number(value),
                span: 0..whole.len(),
            },
            text: value.to_string(),
            parsed: value.to_string().into(),
            place: TextPosition {
                text: Some(whole.start),
                whole,
            },
        }
    }

    /// An expression given as a text, which is the value at `whole`.
    pub(super) fn parsed(
        text: &str,
        whole: Range<usize>,
        source: &Source,
    ) -> Result<Self, Problem> {
        Formula::parsed_by(parse, text, whole, source)
    }

    /// A condition given as a text.
    pub(super) fn condition(
        text: &str,
        whole: Range<usize>,
        source: &Source,
    ) -> Result<Self, Problem> {
        Formula::parsed_by(parse_condition, text, whole, source)
    }

    fn parsed_by(
        parse: fn(&str) -> Result<Expression, SyntaxError>,
        text: &str,
        whole: Range<usize>,
        source: &Source,
    ) -> Result<Self, Problem> {
        let raw = source.text.get(whole.clone()).unwrap_or_default();
        let quotes = raw.len() - raw.trim_start_matches(['"', '\'']).len();
        // A line break directly after three quotes is not part of the text.
        let begin = raw[quotes..].find(text).filter(|&skipped| {
            raw[quotes..quotes + skipped]
                .chars()
                .all(char::is_whitespace)
        });
        let place = TextPosition {
            text: begin.map(|skipped| whole.start + quotes + skipped),
            whole,
        };
        match parse(text) {
            Ok(tree) => {
                let parsed = text.into();
                let text = in_one_line(text);
                Ok(Formula {
                    tree,
                    text,
                    parsed,
                    place,
                })
            }
            Err(error) => {
                Err(Problem::new(error.message, place.of(&error.span)).help_if(error.help))
            }
        }
    }

    /// The text of a part of the expression.
    pub fn part(&self, span: &Range<usize>) -> String {
        let part = self.parsed.get(span.clone());
        in_one_line(part.unwrap_or(&self.parsed))
    }

    /// Position in the file of a part of the text.
    pub fn at(&self, span: &Range<usize>) -> Range<usize> {
        self.place.of(span)
    }

    /// Position of the whole value.
    pub fn whole(&self) -> Range<usize> {
        self.place.whole.clone()
    }
}

/// A text with single spaces between its words.
fn in_one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<&str>>().join(" ")
}

impl TextPosition {
    fn of(&self, span: &Range<usize>) -> Range<usize> {
        match self.text {
            Some(begin) => begin + span.start..begin + span.end,
            None => self.whole.clone(),
        }
    }
}

/// A value that is not finite, in words.
pub(super) fn not_finite(value: f64) -> &'static str {
    match value.is_nan() {
        true => "not a number",
        false => "infinite",
    }
}

/// The values of operands, in words that follow "is infinite".
pub(super) fn where_operands(operands: &[(String, f64)]) -> String {
    let words = operands.iter();
    let words = words.map(|(operand, value)| format!("`{operand}` is {}", readable(*value)));
    match words.collect::<Vec<_>>().join(" and ") {
        none if none.is_empty() => none,
        words => format!(" where {words}"),
    }
}
