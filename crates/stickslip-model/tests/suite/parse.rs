//! Parsing of text into trees of expressions.

use stickslip_model::expression::{
    Binary, Condition, Expression, ExpressionKind, parse, parse_condition,
};

/// The expression with all parentheses written.
fn printed(expression: &Expression) -> String {
    match &expression.kind {
        ExpressionKind::Number(value) => value.to_string(),
        ExpressionKind::Name(name) => name.clone(),
        ExpressionKind::Condition(condition) => condition_printed(condition),
        ExpressionKind::Negative(inner) => format!("(-{})", printed(inner)),
        ExpressionKind::Chain(first, rest) => {
            rest.iter().fold(printed(first), |left, (operator, right)| {
                let sign = match operator {
                    Binary::Sum => "+",
                    Binary::Difference => "-",
                    Binary::Product => "*",
                    Binary::Quotient => "/",
                    Binary::Power => "^",
                };
                format!("({left}{sign}{})", printed(right))
            })
        }
        ExpressionKind::Call {
            function,
            arguments,
            ..
        } => {
            let arguments: Vec<String> = arguments.iter().map(printed).collect();
            format!("{function}[{}]", arguments.join(","))
        }
    }
}

fn condition_printed(condition: &Condition) -> String {
    let joined = |parts: &[Condition], word: &str| {
        let parts: Vec<String> = parts.iter().map(condition_printed).collect();
        format!("({})", parts.join(word))
    };
    match condition {
        Condition::Comparison {
            larger,
            smaller,
            with_equal,
        } => {
            let sign = if *with_equal { ">=" } else { ">" };
            format!("{}{sign}{}", printed(larger), printed(smaller))
        }
        Condition::All(parts) => joined(parts, " and "),
        Condition::Any(parts) => joined(parts, " or "),
        Condition::Not(part) => format!("not {}", condition_printed(part)),
    }
}

#[test]
fn comparisons_are_joined_by_words() {
    for (text, wanted) in [
        ("a < b", "b>a"),
        ("a >= b + 1", "a>=(b+1)"),
        ("a < b and b <= c or d > e", "((b>a and c>=b) or d>e)"),
        ("a < b and (b < c or d > e)", "(b>a and (c>b or d>e))"),
        ("not a < b and c > d", "(not b>a and c>d)"),
        ("not (a < b and c > d)", "not (b>a and c>d)"),
        ("((a + b)*2 < (c))", "c>((a+b)*2)"),
        ("(a) < b", "b>a"),
        ("not not (a < 1)", "not not 1>a"),
        ("if(a < 1 or a > 2, 1, 2) < 3", "3>if[(1>a or a>2),1,2]"),
    ] {
        let parsed = parse_condition(text);
        assert_eq!(parsed.map(|e| printed(&e)), Ok(wanted.to_owned()), "{text}");
    }
    for (text, place, message) in [
        ("a", 0..1, "a number, not a condition"),
        ("a < b and c", 10..11, "a number, not a condition"),
        ("not a", 4..5, "a number, not a condition"),
        ("a < b < c", 6..7, "`<` is not expected here"),
        ("a < b and", 9..9, "something is missing"),
        ("(a < b", 0..1, "not closed"),
        ("(a < b)*2 > 1", 3..4, "does not belong into an expression"),
        ("a < b & c", 6..7, "does not belong into an expression"),
        ("", 0..0, "no expression"),
    ] {
        let error = parse_condition(text).unwrap_err();
        assert!(error.message.contains(message), "{text}: {error}");
        assert_eq!(error.span, place, "{text}: {error}");
    }
    let deep = format!("{}a < b{}", "not (".repeat(5000), ")".repeat(5000));
    assert!(parse_condition(&deep).is_err());
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
    let ExpressionKind::Chain(_, rest) = &whole.kind else {
        panic!("a sum")
    };
    assert_eq!(&text[rest[0].1.span.clone()], "(b - θ)*2");
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
