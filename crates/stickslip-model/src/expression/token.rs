//! The tokens of an expression.

use std::ops::Range;

use super::SyntaxError;

/// A token.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Token {
    Number(f64),
    Name(String),
    Plus,
    Minus,
    Times,
    Over,
    Power,
    /// `²` or `³`, a superscript power.
    SmallPower(u8),
    Open,
    Close,
    Comma,
    /// `<`, `>`, `<=` or `>=`, between the two sides of a condition.
    Comparison(Comparison),
}

/// A comparison of two numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Comparison {
    /// Whether the first is asked to be the larger.
    pub is_larger: bool,
    /// Whether equal numbers count.
    pub with_equal: bool,
}

impl Comparison {
    fn text(self) -> &'static str {
        match (self.is_larger, self.with_equal) {
            (false, false) => "<",
            (true, false) => ">",
            (false, true) => "<=",
            (true, true) => ">=",
        }
    }
}

/// Reports a comparison outside a condition.
pub(super) fn no_condition(comparison: Comparison, place: Range<usize>) -> SyntaxError {
    let message = format!("`{}` does not belong into an expression", comparison.text());
    SyntaxError::new(message, place).help(
        "what differs from side to side of a contact is `by_side(contact, below, above)`; bounds \
         are `min` and `max`; comparisons belong to jumps: `if(a < b, then, else)` in what one \
         sets, and its `if = \"a < b\"`",
    )
}

impl Token {
    /// The token as messages name it.
    pub(super) fn description(&self) -> String {
        match self {
            Token::Number(value) => format!("the number {value}"),
            Token::Name(name) => format!("the name `{name}`"),
            Token::Plus => "`+`".into(),
            Token::Minus => "`-`".into(),
            Token::Times => "`*`".into(),
            Token::Over => "`/`".into(),
            Token::Power => "`^`".into(),
            Token::SmallPower(_) => "a power".into(),
            Token::Open => "`(`".into(),
            Token::Close => "`)`".into(),
            Token::Comma => "`,`".into(),
            Token::Comparison(comparison) => format!("`{}`", comparison.text()),
        }
    }
}

/// Whether a name can begin with this character.
pub fn begins_name(c: char) -> bool {
    c.is_alphabetic() || c == '_'
}

/// Whether a name can continue with this character: a letter, a digit or a subscript digit.
pub fn is_in_name(c: char) -> bool {
    begins_name(c) || c.is_ascii_digit() || ('₀'..='₉').contains(&c)
}

/// A name in the form used for comparison. The micro sign is replaced by the Greek letter, which
/// looks the same.
pub fn normal(name: &str) -> String {
    name.replace('\u{b5}', "μ")
}

/// Splits a text into tokens with their positions.
pub(super) fn tokens(text: &str) -> Result<Vec<(Token, Range<usize>)>, SyntaxError> {
    let mut found = Vec::new();
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let at = text.len() - rest.len();
        let length = match c {
            _ if c.is_whitespace() => {
                rest = &rest[c.len_utf8()..];
                continue;
            }
            _ if c.is_ascii_digit() || c == '.' => number_length(rest),
            _ if begins_name(c) => dotted_length(rest),
            '<' | '>' if rest[1..].starts_with('=') => 2,
            _ => c.len_utf8(),
        };
        let place = at..at + length;
        let (word, after) = rest.split_at(length);
        let token = match c {
            _ if c.is_ascii_digit() || c == '.' => {
                let value = word.parse().ok().filter(|value: &f64| value.is_finite());
                let no_number =
                    || SyntaxError::new(format!("`{word}` is no number"), place.clone());
                Token::Number(value.ok_or_else(no_number)?)
            }
            _ if begins_name(c) => Token::Name(normal(word)),
            '+' => Token::Plus,
            '-' | '−' => Token::Minus,
            '*' if after.starts_with('*') => {
                let both = at..at + 2;
                return Err(
                    SyntaxError::new("`**` is no operator", both).help("write a power as `^`: x^2")
                );
            }
            '*' | '·' | '×' => Token::Times,
            '/' => Token::Over,
            '^' => Token::Power,
            '²' => Token::SmallPower(2),
            '³' => Token::SmallPower(3),
            '(' => Token::Open,
            ')' => Token::Close,
            ',' => Token::Comma,
            '<' | '>' => Token::Comparison(Comparison {
                is_larger: c == '>',
                with_equal: length == 2,
            }),
            _ => {
                let help = match c {
                    '|' => Some(
                        "the magnitude of a slip speed is the contact's sign times the speed; an \
                        absolute value is `abs(…)`",
                    ),
                    '&' | '!' => Some(
                        "comparisons in the condition of a jump are joined by `and`, `or` and \
                         `not`",
                    ),
                    '=' | '?' => Some(
                        "what differs from side to side of a contact is `by_side(contact, below, \
                            above)`; bounds are `min` and `max`",
                    ),
                    '[' | '{' => Some("group by round brackets: (…)"),
                    _ => None,
                };
                let message = format!("`{c}` does not belong into an expression");
                return Err(SyntaxError {
                    help: help.map(str::to_owned),
                    ..SyntaxError::new(message, place)
                });
            }
        };
        found.push((token, place));
        rest = after;
    }
    Ok(found)
}

/// Length of the name at the beginning of a text: one name, or the names of an entry and its part
/// with a point between them.
fn dotted_length(text: &str) -> usize {
    let length = |text: &str| text.find(|c| !is_in_name(c)).unwrap_or(text.len());
    let first = length(text);
    let part = text[first..].strip_prefix('.');
    match part.filter(|part| part.starts_with(begins_name)) {
        Some(part) => first + 1 + length(part),
        None => first,
    }
}

/// Length of the number at the beginning of a text: digits, a point, an exponent.
fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits = |from: usize| {
        let count = bytes[from..]
            .iter()
            .take_while(|b| b.is_ascii_digit())
            .count();
        from + count
    };
    let mut end = digits(0);
    if bytes.get(end) == Some(&b'.') {
        end = digits(end + 1);
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        let exponent = digits(end + 1 + sign);
        if exponent > end + 1 + sign {
            end = exponent;
        }
    }
    end
}
