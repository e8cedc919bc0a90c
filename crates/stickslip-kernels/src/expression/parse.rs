//! Parses the text of an expression into a tree.

use std::ops::Range;

use super::SyntaxError;
use super::token::{Token, tokens};
use super::tree::{Binary, Expression, Kind};

/// Greatest depth of nesting.
const DEEPEST: usize = 100;

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

    fn sum(&mut self) -> Parsed {
        let mut left = self.product()?;
        loop {
            let operator = if self.take(&Token::Plus).is_some() {
                Binary::Sum
            } else if self.take(&Token::Minus).is_some() {
                Binary::Difference
            } else {
                return Ok(left);
            };
            let right = self.product()?;
            left = joined(operator, left, right);
        }
    }

    fn product(&mut self) -> Parsed {
        let mut left = self.signed()?;
        loop {
            let operator = if self.take(&Token::Times).is_some() {
                Binary::Product
            } else if self.take(&Token::Over).is_some() {
                Binary::Quotient
            } else {
                return Ok(left);
            };
            let right = self.signed()?;
            left = joined(operator, left, right);
        }
    }

    fn signed(&mut self) -> Parsed {
        self.deeper()?;
        let found = if let Some(sign) = self.take(&Token::Minus) {
            let inner = self.signed()?;
            let span = sign.start..inner.span.end;
            let kind = Kind::Negative(Box::new(inner));
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
                kind: Kind::Number(f64::from(*n)),
                span: place.clone(),
            };
            return Ok(joined(Binary::Power, base, exponent));
        }
        if self.take(&Token::Power).is_none() {
            return Ok(base);
        }
        let exponent = self.signed()?;
        Ok(joined(Binary::Power, base, exponent))
    }

    fn atom(&mut self) -> Parsed {
        let Some((token, place)) = self.peek() else {
            return Err(self.unfinished());
        };
        self.next += 1;
        match token {
            Token::Number(value) => Ok(Expression {
                kind: Kind::Number(*value),
                span: place.clone(),
            }),
            Token::Name(name) if self.take(&Token::Open).is_some() => self.call(name, place),
            Token::Name(name) => Ok(Expression {
                kind: Kind::Name(name.clone()),
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
            arguments.push(self.sum()?);
            while self.take(&Token::Comma).is_some() {
                arguments.push(self.sum()?);
            }
            self.close(&open)?;
        }
        let end = self.tokens[self.next - 1].1.end;
        Ok(Expression {
            kind: Kind::Call {
                function: function.to_owned(),
                place: place.clone(),
                arguments,
            },
            span: place.start..end,
        })
    }

    /// Reads the parenthesis that closes the one at `open` and returns its end.
    fn close(&mut self, open: &Range<usize>) -> Result<usize, SyntaxError> {
        if let Some(place) = self.take(&Token::Close) {
            return Ok(place.end);
        }
        Err(match self.peek() {
            None => SyntaxError::new("this bracket is not closed", open.clone()),
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
        if self.depth <= DEEPEST {
            return Ok(());
        }
        let at = self
            .peek()
            .map_or(self.end..self.end, |(_, place)| place.clone());
        Err(
            SyntaxError::new(format!("nested deeper than {DEEPEST} levels"), at)
                .help("give parts of it names in [definitions]"),
        )
    }
}

fn joined(operator: Binary, left: Expression, right: Expression) -> Expression {
    let span = left.span.start..right.span.end;
    Expression {
        kind: Kind::Binary(operator, Box::new(left), Box::new(right)),
        span,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The expression with all parentheses written.
    fn printed(expression: &Expression) -> String {
        match &expression.kind {
            Kind::Number(value) => value.to_string(),
            Kind::Name(name) => name.clone(),
            Kind::Negative(inner) => format!("(-{})", printed(inner)),
            Kind::Binary(operator, a, b) => {
                let sign = match operator {
                    Binary::Sum => "+",
                    Binary::Difference => "-",
                    Binary::Product => "*",
                    Binary::Quotient => "/",
                    Binary::Power => "^",
                };
                format!("({}{sign}{})", printed(a), printed(b))
            }
            Kind::Call {
                function,
                arguments,
                ..
            } => {
                let arguments: Vec<String> = arguments.iter().map(printed).collect();
                format!("{function}[{}]", arguments.join(","))
            }
        }
    }

    #[test]
    fn operators_bind_as_in_mathematics() {
        for (text, wanted) in [
            ("a + b*c", "(a+(b*c))"),
            ("a - b - c", "((a-b)-c)"),
            ("a/b/c", "((a/b)/c)"),
            ("a/b*c", "((a/b)*c)"),
            ("-x^2", "(-(x^2))"),
            ("(-x)^2", "((-x)^2)"),
            ("2^3^2", "(2^(3^2))"),
            ("x^-1", "(x^(-1))"),
            ("2*-x", "(2*(-x))"),
            ("--x", "(-(-x))"),
            ("+x", "x"),
            ("a - -b", "(a-(-b))"),
            ("sin(x)^2", "(sin[x]^2)"),
            ("min(a, b + 1)", "min[a,(b+1)]"),
            ("f()", "f[]"),
            ("μ₀·x² − ½", ""),
            ("μ₀·x² − 1", "((μ₀*(x^2))-1)"),
            ("µ", "μ"),
            ("1e-3*x", "(0.001*x)"),
            (".5 + 5.", "(0.5+5)"),
            ("1.5E+2", "150"),
            ("Δθ_1", "Δθ_1"),
        ] {
            let parsed = parse(text);
            if wanted.is_empty() {
                assert!(parsed.is_err(), "{text}");
            } else {
                assert_eq!(parsed.map(|e| printed(&e)), Ok(wanted.to_owned()), "{text}");
            }
        }
    }

    #[test]
    fn every_branch_knows_its_place() {
        let text = "a + (b - θ)*2";
        let whole = parse(text).unwrap();
        assert_eq!(whole.span, 0..text.len());
        let Kind::Binary(_, _, product) = &whole.kind else {
            panic!("a sum")
        };
        assert_eq!(&text[product.span.clone()], "(b - θ)*2");
    }

    #[test]
    fn what_cannot_be_read_is_told_with_its_place() {
        for (text, place, message) in [
            ("", 0..0, "no expression"),
            ("a +", 3..3, "something is missing"),
            ("(a", 0..1, "not closed"),
            ("sin(a", 3..4, "not closed"),
            ("a)", 1..2, "`)` is not expected"),
            ("2x", 1..2, "the name `x` is not expected"),
            ("(2 x)", 3..4, "not expected"),
            ("a**2", 1..3, "no operator"),
            ("1.2.3", 3..5, "the number 0.3 is not expected"),
            ("1e999", 0..5, "is no number"),
            (".", 0..1, "is no number"),
            ("a $ b", 2..3, "does not belong"),
            ("|v|", 0..1, "does not belong"),
            ("v > 0", 2..3, "does not belong"),
            ("* a", 0..1, "is expected here, not `*`"),
            ("3,5", 1..2, "`,` is not expected"),
        ] {
            let error = parse(text).unwrap_err();
            assert_eq!(error.span, place, "{text}: {error}");
            assert!(error.message.contains(message), "{text}: {error}");
        }
    }

    #[test]
    fn depth_is_bounded_before_the_stack_is() {
        let nested = |depth: usize| format!("{}x{}", "(".repeat(depth), ")".repeat(depth));
        assert!(parse(&nested(50)).is_ok());
        assert!(
            parse(&nested(100_000))
                .unwrap_err()
                .message
                .contains("deeper")
        );
        assert!(parse(&"-".repeat(100_000)).is_err());
    }
}
