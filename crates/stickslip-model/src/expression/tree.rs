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
    /// A condition, which can stand only where a choice or a jump is made by it.
    Condition(Box<Condition>),
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

/// A condition on numbers.
#[derive(Clone, Debug, PartialEq)]
pub enum Condition {
    /// Whether one number is larger than another.
    Comparison {
        /// The number that is asked to be larger.
        larger: Expression,
        /// The number that is asked to be smaller.
        smaller: Expression,
        /// Whether equal numbers count.
        with_equal: bool,
    },
    /// Whether all of these hold.
    All(Vec<Condition>),
    /// Whether one of these holds.
    Any(Vec<Condition>),
    /// Whether this does not hold.
    Not(Box<Condition>),
}

impl Condition {
    /// The numbers that are compared.
    pub fn numbers(&self) -> Vec<&Expression> {
        match self {
            Condition::Comparison {
                larger, smaller, ..
            } => vec![larger, smaller],
            Condition::All(parts) | Condition::Any(parts) => {
                parts.iter().flat_map(Condition::numbers).collect()
            }
            Condition::Not(part) => part.numbers(),
        }
    }
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
