//! Mathematical expressions: from text to a tape that runs on any [`stickslip::Scalar`].
//!
//! # Why not an existing crate
//! The library evaluates a system on a dozen number types: `f64`, dual numbers, Taylor
//! coefficients, and dual numbers over those. Some are private to it, and a Taylor coefficient
//! borrows from its pass. Existing expression crates fix one number type when they parse (exmex
//! requires `FromStr` and `Default`; evalexpr, meval and fasteval support `f64` only). So the text
//! is parsed here, once and for no number type in particular.
//!
//! # Stages
//! [`parse()`] builds a tree from the text, and every node knows its position there. A [`Graph`]
//! takes trees with all names resolved, and shares common subexpressions. It holds what depends on
//! parameters alone as [`HeldNumbers`], which are computed anew for other values. A [`Tape`] is the
//! graph in order of evaluation, with few registers.

mod curve;
mod derivative;
mod functions;
mod graph;
mod held;
mod parse;
mod same;
mod tape;
mod token;
mod tree;

pub use curve::{Between, Beyond, NoCurve, PiecewisePolynomial};
pub use derivative::GraphInput;
pub use functions::{FUNCTIONS, Function};
pub use graph::{Graph, Id, NotANumber};
pub use held::{HeldNumbers, HeldProbe, Place, Test};
pub use parse::{CHOICE, parse, parse_condition};
pub use tape::{MOST_REGISTERS, Tape, TooLarge};
pub use token::{begins_name, is_in_name, normal};
pub use tree::{Binary, Condition, Expression, ExpressionKind};

use std::ops::Range;

/// A text that is not an expression: the fault and its position.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct SyntaxError {
    /// The fault.
    pub message: String,
    /// A suggested replacement, if there is one.
    pub help: Option<String>,
    /// Position in bytes of the text.
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
