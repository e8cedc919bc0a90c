//! Parses the text of an expression into a tree.

use std::ops::Range;

use super::SyntaxError;
use super::token::{Comparison, Token, no_condition, tokens};
use super::tree::{Binary, Expression, ExpressionKind};

/// Most levels of nesting, so that recursion does not overflow the stack. It is chosen: formulas
/// written by hand have far fewer.
const MOST_NESTING: usize = 100;

/// The function that chooses by a condition.
pub const CHOICE: &str = "if";

/// Parses a text into its tree.
///
/// The operator `^` binds most tightly and is right-associative: `-x^2` is the negative of a
/// square, and `2^3^2` is 2⁹. Then come `*` and `/`, then `+` and `-`. The arguments of a function
/// stand in parentheses. The characters `·`, `×` and `−` are operators too, and `x²` is `x^2`.
///
/// # Errors
/// [`SyntaxError`] with the position of the first part that cannot be parsed.
pub fn parse(text: &str) -> Result<Expression, SyntaxError> {
    let tokens = tokens(text)?;
    let mut parser = Parser {
        tokens: &tokens,
        next: 0,
        end: text.trim_end().len(),
        depth: 0,
    };
    let expression = parser.sum()?;
    match parser.peek() {
        None => Ok(expression),
        Some((token, place)) => Err(left_over(&expression, token, place)),
    }
}

/// Reports what follows a complete expression.
fn left_over(before: &Expression, token: &Token, place: &Range<usize>) -> SyntaxError {
    if let Token::Comparison(comparison) = token {
        return no_condition(*comparison, place.clone());
    }
    let error = SyntaxError::new(
        format!("{} is not expected here", token.description()),
        place.clone(),
    );
    match (token, &before.kind) {
        (Token::Close, _) => error.help("no bracket is open here"),
        (Token::Comma, _) => {
            error.help("a decimal point is `.`; `,` stands between a function's arguments")
        }
        _ => error.help("a product needs its sign: 2*x"),
    }
}

struct Parser<'a> {
    tokens: &'a [(Token, Range<usize>)],
    next: usize,
    /// Position of the end of the text.
    end: usize,
    depth: usize,
}

type Parsed = Result<Expression, SyntaxError>;

impl<'a> Parser<'a> {
    fn peek(&self) -> Option<&'a (Token, Range<usize>)> {
        self.tokens.get(self.next)
    }

    fn take(&mut self, wanted: &Token) -> Option<Range<usize>> {
        let (token, place) = self.peek()?;
        if token != wanted {
            return None;
        }
        self.next += 1;
        Some(place.clone())
    }

    /// Operands joined by operators of one precedence, which group to the left.
    fn chain(
        &mut self,
        operand: fn(&mut Self) -> Parsed,
        operators: [(Token, Binary); 2],
    ) -> Parsed {
        let first = operand(self)?;
        let mut rest = Vec::new();
        loop {
            let mut operators = operators.iter();
            let Some((_, operator)) = operators.find(|(token, _)| self.take(token).is_some())
            else {
                return Ok(joined(first, rest));
            };
            rest.push((*operator, operand(self)?));
        }
    }

    fn sum(&mut self) -> Parsed {
        let operators = [
            (Token::Plus, Binary::Sum),
            (Token::Minus, Binary::Difference),
        ];
        self.chain(Self::product, operators)
    }

    fn product(&mut self) -> Parsed {
        let operators = [
            (Token::Times, Binary::Product),
            (Token::Over, Binary::Quotient),
        ];
        self.chain(Self::signed, operators)
    }

    fn signed(&mut self) -> Parsed {
        self.deeper()?;
        let found = if let Some(sign) = self.take(&Token::Minus) {
            let inner = self.signed()?;
            let span = sign.start..inner.span.end;
            let kind = ExpressionKind::Negative(Box::new(inner));
            Ok(Expression { kind, span })
        } else if self.take(&Token::Plus).is_some() {
            self.signed()
        } else {
            self.power()
        };
        self.depth -= 1;
        found
    }

    fn power(&mut self) -> Parsed {
        let base = self.atom()?;
        if let Some((Token::SmallPower(n), place)) = self.peek() {
            self.next += 1;
            let exponent = Expression {
                kind: ExpressionKind::Number(f64::from(*n)),
                span: place.clone(),
            };
            return Ok(joined(base, vec![(Binary::Power, exponent)]));
        }
        if self.take(&Token::Power).is_none() {
            return Ok(base);
        }
        let exponent = self.signed()?;
        Ok(joined(base, vec![(Binary::Power, exponent)]))
    }

    fn atom(&mut self) -> Parsed {
        let Some((token, place)) = self.peek() else {
            return Err(self.unfinished());
        };
        self.next += 1;
        match token {
            Token::Number(value) => Ok(Expression {
                kind: ExpressionKind::Number(*value),
                span: place.clone(),
            }),
            Token::Name(name) if self.take(&Token::Open).is_some() => self.call(name, place),
            Token::Name(name) => Ok(Expression {
                kind: ExpressionKind::Name(name.clone()),
                span: place.clone(),
            }),
            Token::Open => {
                let inner = self.sum()?;
                let end = self.close(place)?;
                Ok(Expression {
                    kind: inner.kind,
                    span: place.start..end,
                })
            }
            other => {
                let message = format!(
                    "a number, a name or `(` is expected here, not {}",
                    other.description()
                );
                Err(SyntaxError::new(message, place.clone()))
            }
        }
    }

    fn call(&mut self, function: &str, place: &Range<usize>) -> Parsed {
        let open = place.end..place.end + 1;
        let mut arguments = Vec::new();
        if self.take(&Token::Close).is_none() {
            let first = self.sum()?;
            let comparison = self.comparison().filter(|_| function == CHOICE);
            match comparison {
                Some(comparison) => {
                    let second = self.sum()?;
                    return self.choice((place, &open), [first, second], comparison);
                }
                None => arguments.push(first),
            }
            while self.take(&Token::Comma).is_some() {
                arguments.push(self.sum()?);
            }
            self.close(&open)?;
        }
        let end = self.tokens[self.next - 1].1.end;
        Ok(Expression {
            kind: ExpressionKind::Call {
                function: function.to_owned(),
                place: place.clone(),
                arguments,
            },
            span: place.start..end,
        })
    }

    /// A comparison that comes next.
    fn comparison(&mut self) -> Option<Comparison> {
        match self.peek()? {
            (Token::Comparison(comparison), _) => {
                self.next += 1;
                Some(*comparison)
            }
            _ => None,
        }
    }

    /// The rest of a choice behind its condition: a call with the number that is positive where the
    /// condition holds, the expression there, and the other.
    fn choice(
        &mut self,
        (place, open): (&Range<usize>, &Range<usize>),
        [first, second]: [Expression; 2],
        comparison: Comparison,
    ) -> Parsed {
        let mut branches = Vec::new();
        while self.take(&Token::Comma).is_some() {
            branches.push(self.sum()?);
        }
        let end = self.close(open)?;
        // Where equal numbers count, the opposite condition is asked for.
        let (larger, smaller) = match comparison.is_larger != comparison.with_equal {
            true => (first, second),
            false => (second, first),
        };
        if comparison.with_equal {
            branches.reverse();
        }
        let lead = joined(larger, vec![(Binary::Difference, smaller)]);
        let arguments = std::iter::once(lead).chain(branches).collect();
        let (function, place) = (CHOICE.to_owned(), place.clone());
        Ok(Expression {
            span: place.start..end,
            kind: ExpressionKind::Call {
                function,
                place,
                arguments,
            },
        })
    }

    /// Reads the parenthesis that closes the one at `open` and returns its end.
    fn close(&mut self, open: &Range<usize>) -> Result<usize, SyntaxError> {
        if let Some(place) = self.take(&Token::Close) {
            return Ok(place.end);
        }
        Err(match self.peek() {
            None => SyntaxError::new("this bracket is not closed", open.clone())
                .help("it ends with `)`"),
            Some((Token::Comparison(comparison), place)) => {
                no_condition(*comparison, place.clone())
            }
            Some((token, place)) => SyntaxError::new(
                format!("{} is not expected here", token.description()),
                place.clone(),
            )
            .help("a product needs its sign, `2*x`, and a bracket its end, `)`"),
        })
    }

    fn unfinished(&self) -> SyntaxError {
        let message = if self.tokens.is_empty() {
            "there is no expression here"
        } else {
            "the expression ends here, but something is missing"
        };
        SyntaxError::new(message, self.end..self.end)
    }

    /// Parentheses and signs are parsed recursively, and the depth is bounded to protect the stack.
    fn deeper(&mut self) -> Result<(), SyntaxError> {
        self.depth += 1;
        if self.depth <= MOST_NESTING {
            return Ok(());
        }
        let at = self
            .peek()
            .map_or(self.end..self.end, |(_, place)| place.clone());
        Err(
            SyntaxError::new(format!("nested deeper than {MOST_NESTING} levels"), at)
                .help("give parts of it names in [definitions]"),
        )
    }
}

fn joined(first: Expression, rest: Vec<(Binary, Expression)>) -> Expression {
    let Some((_, last)) = rest.last() else {
        return first;
    };
    Expression {
        span: first.span.start..last.span.end,
        kind: ExpressionKind::Chain(Box::new(first), rest),
    }
}
