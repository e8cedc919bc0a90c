//! Derivatives of expressions as expressions.

use std::sync::Arc;

use stickslip::scalar::Dual;
use stickslip_model::expression::{
    Between, Beyond, Expression, ExpressionKind, Function, Graph, GraphInput, Id,
    PiecewisePolynomial, Tape, parse,
};

/// Adds an expression of `x`, `y` and `t` to a graph.
fn number(graph: &mut Graph, tree: &Expression) -> Id {
    let built = match &tree.kind {
        ExpressionKind::Number(value) => graph.constant(*value),
        ExpressionKind::Name(name) => Ok(match name.as_str() {
            "t" => graph.time(),
            "x" => graph.state(0),
            _ => graph.state(1),
        }),
        ExpressionKind::Negative(inner) => {
            let inner = number(graph, inner);
            graph.negative(inner)
        }
        ExpressionKind::Condition(_) => unreachable!("no text has one"),
        ExpressionKind::Chain(first, rest) => {
            let mut id = number(graph, first);
            for (operator, operand) in rest {
                let next = number(graph, operand);
                id = graph.binary(*operator, id, next).expect("finite");
            }
            Ok(id)
        }
        ExpressionKind::Call {
            function,
            arguments,
            ..
        } => {
            let ids: Vec<Id> = arguments.iter().map(|of| number(graph, of)).collect();
            match function.as_str() {
                "atan2" => graph.angle(ids[0], ids[1]),
                "erf" => graph.call(Function::Erf, ids[0]),
                "curve" => graph.curve(&Arc::new(curve()), ids[0]),
                "if" => graph.chosen(ids[0], ids[1], ids[2]),
                "max" => graph.larger(ids[0], ids[1]),
                "min" => graph.smaller(ids[0], ids[1]),
                "where" => graph.where_positive(ids[0], ids[1]),
                name => graph.call(Function::named(name).expect("known"), ids[0]),
            }
        }
    };
    built.expect("finite")
}

fn curve() -> PiecewisePolynomial {
    let (xs, ys) = ([0.0, 0.5, 1.0, 1.5], [1.0, 0.5, 2.0, 2.5]);
    PiecewisePolynomial::new(&xs, &ys, Between::Monotone, Beyond::Hold).expect("a curve")
}

/// Derivatives as expressions are those of dual numbers, to rounding.
#[test]
fn agrees_with_dual_numbers() {
    for text in [
        "x*y - t^2*x + 3",
        "sin(x*t)*cos(y) - tan(x/4)",
        "exp(-x)*ln(2 + y^2) + sqrt(x^2 + t)",
        "(x - y)/(1 + x^2*y^2) - 2/(t + 3)",
        "atan(x*y)*sinh(x/3) + cosh(y/2)*tanh(x - t)",
        "x^-3 + (1 + y^2)^1.7 - (2 + x)^y",
        "max(x, y)*min(x*y, t) + abs(x - 2*y)",
        "where(x - y, x^2) + where(y - x, y^3)",
        "atan2(x*y - 1, t - x)*erf(x - y)",
        "x*curve(x*y) + if(x - y, x^2, y^3)",
    ] {
        let mut graph = Graph::new();
        let root = number(&mut graph, &parse(text).expect("text"));
        let (one, half) = (graph.constant(1.0).unwrap(), graph.constant(0.5).unwrap());
        let direction = |of: GraphInput| match of {
            GraphInput::Time => Some(half),
            GraphInput::State(0) => Some(one),
            GraphInput::State(_) => None,
        };
        let derivative = graph.along(root, direction).expect("finite").expect("some");
        let tape = Tape::new(&graph, &[root, derivative], 2).expect("short");
        for (t, x, y) in [(0.3, 0.7, 1.1), (1.2, 1.9, 0.4), (2.0, 0.2, 0.9)] {
            let mut plain = [0.0; 2];
            tape.evaluate(t, &[x, y], &mut plain);
            let mut dual = [Dual::new(0.0, 0.0); 1];
            let at = [Dual::new(x, 1.0), Dual::new(y, 0.0)];
            tape.evaluate(Dual::new(t, 0.5), &at, &mut dual);
            let error = (plain[1] - dual[0].eps).abs();
            assert!(
                error < 1e-13 * (1.0 + dual[0].eps.abs()),
                "{text}: {plain:?} {dual:?}"
            );
        }
    }
}
