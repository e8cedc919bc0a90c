//! Expressions of mathematics: from text to a tape that runs on any [`stickslip::Scalar`].
//!
//! # Why no kept crate
//! The library evaluates a system on a dozen number types: on `f64`, on dual numbers, on Taylor
//! coefficients and on dual numbers of those. Some are private to it, and a Taylor coefficient
//! borrows from the pass that it belongs to. What the expression crates make of a text is tied to
//! one number type when it is parsed (exmex wants `FromStr` and `Default` of it, evalexpr, meval
//! and fasteval have `f64` only). So the text is parsed here, once and to no number type at all.
//!
//! # The way of an expression
//! [`parse()`] makes a tree of the text, and every branch knows its place there. A [`Graph`] takes
//! trees with all names resolved, shares what they have in common and folds what is constant. A
//! [`Tape`] is the graph in the order of evaluation, with few registers.

mod functions;
mod graph;
mod parse;
mod tape;
mod token;
mod tree;

pub use functions::{FUNCTIONS, Function};
pub use graph::{Graph, Id, NotANumber};
pub use parse::parse;
pub use tape::{MOST_REGISTERS, Tape, TooLarge};
pub use token::{begins_name, is_in_name, normal};
pub use tree::{Binary, Expression, Kind};

use std::ops::Range;

/// A text that is no expression: what is wrong, and where in it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct SyntaxError {
    /// What is wrong.
    pub message: String,
    /// What to write instead, if that is known.
    pub help: Option<String>,
    /// Where, in bytes of the text.
    pub span: Range<usize>,
}

impl SyntaxError {
    fn new(message: impl Into<String>, span: Range<usize>) -> Self {
        SyntaxError {
            message: message.into(),
            help: None,
            span,
        }
    }

    fn help(self, help: impl Into<String>) -> Self {
        SyntaxError {
            help: Some(help.into()),
            ..self
        }
    }
}
