//! Parses the text of an expression into a tree.

use std::ops::Range;

use super::SyntaxError;
use super::token::{Comparison, Token, no_condition, tokens};
use super::tree::{Binary, Condition, Expression, ExpressionKind};

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
    whole(text, |parser| parser.sum())
}

/// Parses a text into the tree of a condition: comparisons by `<`, `<=`, `>` and `>=`, and `not`,
/// `and` and `or`, which bind in this order.
///
/// # Errors
/// See [`parse()`]. The text must be a condition.
pub fn parse_condition(text: &str) -> Result<Expression, SyntaxError> {
    let expression = whole(text, |parser| parser.condition())?;
    match expression.kind {
        ExpressionKind::Condition(_) => Ok(expression),
        _ => Err(no_comparison(&expression)),
    }
}

fn whole(text: &str, part: fn(&mut Parser<'_>) -> Parsed) -> Parsed {
    let tokens = tokens(text)?;
    let mut parser = Parser {
        tokens: &tokens,
        next: 0,
        end: text.trim_end().len(),
        depth: 0,
    };
    let expression = part(&mut parser)?;
    match parser.peek() {
        None => Ok(expression),
        Some((token, place)) => Err(left_over(&expression, token, place)),
    }
}

/// Reports a number where a condition is expected.
fn no_comparison(number: &Expression) -> SyntaxError {
    SyntaxError::new("this is a number, not a condition", number.span.clone())
        .help("a condition compares two numbers, as in v < 0.1")
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
            arguments.push(match function {
                CHOICE => self.condition()?,
                _ => self.sum()?,
            });
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

    /// A condition, or a number where none is compared.
    fn condition(&mut self) -> Parsed {
        self.conditions("or", Self::conjunction, Condition::Any)
    }

    fn conjunction(&mut self) -> Parsed {
        self.conditions("and", Self::negation, Condition::All)
    }

    /// Conditions that a word joins.
    fn conditions(
        &mut self,
        word: &str,
        part: fn(&mut Self) -> Parsed,
        joined: fn(Vec<Condition>) -> Condition,
    ) -> Parsed {
        let first = part(self)?;
        if !self.is_word(word) {
            return Ok(first);
        }
        let start = first.span.start;
        let mut parts = vec![condition_of(first)?];
        let mut end = start;
        while self.is_word(word) {
            self.next += 1;
            let next = part(self)?;
            end = next.span.end;
            parts.push(condition_of(next)?);
        }
        Ok(Expression {
            kind: ExpressionKind::Condition(Box::new(joined(parts))),
            span: start..end,
        })
    }

    fn negation(&mut self) -> Parsed {
        self.deeper()?;
        let found = match self.peek() {
            Some((Token::Name(name), place)) if name == "not" => {
                self.next += 1;
                let inner = self.negation()?;
                let span = place.start..inner.span.end;
                let condition = Condition::Not(Box::new(condition_of(inner)?));
                let kind = ExpressionKind::Condition(Box::new(condition));
                Ok(Expression { kind, span })
            }
            Some((Token::Open, place)) if self.opens_condition() => {
                self.next += 1;
                let inner = self.condition()?;
                let end = self.close(place)?;
                Ok(Expression {
                    span: place.start..end,
                    ..inner
                })
            }
            _ => self.compared(),
        };
        self.depth -= 1;
        found
    }

    /// Two numbers that are compared, or one.
    fn compared(&mut self) -> Parsed {
        let first = self.sum()?;
        let Some(comparison) = self.comparison() else {
            return Ok(first);
        };
        let second = self.sum()?;
        let span = first.span.start..second.span.end;
        if let Some((token @ Token::Comparison(_), place)) = self.peek() {
            let message = format!("{} is not expected here", token.description());
            return Err(SyntaxError::new(message, place.clone())
                .help("two comparisons are joined by `and`: a < b and b < c"));
        }
        let (larger, smaller) = match comparison.is_larger {
            true => (first, second),
            false => (second, first),
        };
        let condition = Condition::Comparison {
            larger,
            smaller,
            with_equal: comparison.with_equal,
        };
        Ok(Expression {
            kind: ExpressionKind::Condition(Box::new(condition)),
            span,
        })
    }

    fn is_word(&self, word: &str) -> bool {
        matches!(self.peek(), Some((Token::Name(name), _)) if name == word)
    }

    /// Whether a bracket that comes next is one around a condition, not around a number: what
    /// follows it is no operator.
    fn opens_condition(&self) -> bool {
        let mut open = 0_usize;
        let rest = self.tokens[self.next..].iter();
        let mut behind = rest.skip_while(|(token, _)| {
            match token {
                Token::Open => open += 1,
                Token::Close => open -= 1,
                _ => {}
            }
            open > 0
        });
        // The bracket that closes it.
        behind.next();
        match behind.next() {
            None | Some((Token::Comma | Token::Close, _)) => true,
            Some((Token::Name(name), _)) => name == "and" || name == "or",
            Some(_) => false,
        }
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

fn condition_of(expression: Expression) -> Result<Condition, SyntaxError> {
    match expression.kind {
        ExpressionKind::Condition(condition) => Ok(*condition),
        _ => Err(no_comparison(&expression)),
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
