//! The tree of an expression.

use std::ops::Range;

/// An expression, or a branch of one.
#[derive(Clone, Debug, PartialEq)]
pub struct Expression {
    /// What it is.
    pub kind: Kind,
    /// Where it stands, in bytes of its text.
    pub span: Range<usize>,
}

/// What an expression is.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// A number.
    Number(f64),
    /// A name.
    Name(String),
    /// The negative.
    Negative(Box<Expression>),
    /// Two joined by an operator.
    Binary(Binary, Box<Expression>, Box<Expression>),
    /// A function of arguments.
    Call {
        /// Name of the function.
        function: String,
        /// Where that stands.
        place: Range<usize>,
        /// The arguments.
        arguments: Vec<Expression>,
    },
}

/// What joins two expressions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Binary {
    /// `a + b`
    Sum,
    /// `a - b`
    Difference,
    /// `a * b`
    Product,
    /// `a / b`
    Quotient,
    /// `a ^ b`
    Power,
}
