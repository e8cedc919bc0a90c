//! The tree of an expression.

use std::ops::Range;

/// An expression, or a subexpression.
#[derive(Clone, Debug, PartialEq)]
pub struct Expression {
    /// Operation and operands.
    pub kind: ExpressionKind,
    /// Position in bytes of the text.
    pub span: Range<usize>,
}

/// The kinds of expressions.
#[derive(Clone, Debug, PartialEq)]
pub enum ExpressionKind {
    /// A number.
    Number(f64),
    /// A name.
    Name(String),
    /// The negative of an expression.
    Negative(Box<Expression>),
    /// Two expressions joined by an operator.
    Binary(Binary, Box<Expression>, Box<Expression>),
    /// A function call.
    Call {
        /// Name of the function.
        function: String,
        /// Position of the name.
        place: Range<usize>,
        /// The arguments.
        arguments: Vec<Expression>,
    },
}

/// The operators between two expressions.
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
