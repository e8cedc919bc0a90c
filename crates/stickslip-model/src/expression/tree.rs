//! The tree of an expression.

use std::ops::Range;

use stickslip::math;

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
    /// A first operand, and operators of one precedence with the operands behind them, which group
    /// to the left. They are a list, so that the depth of a tree does not grow with its terms.
    Chain(Box<Expression>, Vec<(Binary, Expression)>),
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

impl Binary {
    /// Value of the operation.
    pub fn of(self, a: f64, b: f64) -> f64 {
        match self {
            Binary::Sum => a + b,
            Binary::Difference => a - b,
            Binary::Product => a * b,
            Binary::Quotient => a / b,
            Binary::Power => math::pow(a, b),
        }
    }
}
